"""What a warning says, what sets it off, and how the applications see the ego and the others."""

import math
from dataclasses import dataclass, field
from enum import Enum, IntEnum
from typing import Literal

from cca_core._checks import check_real
from cca_core.decide.crossing import Conflict, CrossingSettings
from cca_core.path import Path
from cca_core.vehicle import GRAVITY, STANDSTILL_SPEED, RemoteVehicle

__all__ = ["Alert", "AlertSettings", "Application", "EgoView", "Level", "Sighting"]

PARALLEL_ANGLE = 0.25 * math.pi
"""Headings within this angle of the route, or of its opposite, are along it [rad]."""


class Application(Enum):
    """The application that warns."""

    EEBL = "electronic emergency brake light"
    FCW = "forward collision warning"
    IMA = "intersection movement assist"
    LTA = "left turn assist"
    CURB_SIDE = "stationary vehicle ahead"
    BSW = "blind spot warning"
    LCW = "lane change warning"
    DNPW = "do not pass warning"


class Level(IntEnum):
    """How urgent it is: good to know, to be avoided now, or only hard braking still avoids it."""

    INFORM = 1
    WARN = 2
    ACT = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Alert:
    """One warning.

    Parameters
    ----------
    application : Application
        Who warns.
    level : Level
        How urgently.
    vehicle_id : str
        Id of the vehicle that it warns of.
    time_to_conflict : float
        Time until the bodies would meet, or both would be in the same place [s]; 0 for a vehicle beside,
        infinite if they do not meet at the present speeds.
    reason : str
        Why, in words.
    """

    application: Application
    level: Level
    vehicle_id: str
    time_to_conflict: float
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class AlertSettings:
    """Thresholds of the applications; where they come from is told in the documentation.

    Parameters
    ----------
    fcw_decelerating, fcw_stopped, fcw_slower : float
        FCW: time to collision with a leader that brakes, stands, or drives more slowly [s].
    eebl_range : float
        EEBL: distance up to which hard braking is told [m].
    eebl_deceleration : float
        EEBL: deceleration that counts as hard braking without an event flag [m/s^2].
    eebl_heading : float
        EEBL: largest angle between the heading of the vehicle and the road [rad].
    ima_time : float
        IMA and LTA: the ego reaches the conflict area within this time [s].
    ima_difference : float
        IMA and LTA: largest time between the arrivals, either way [s].
    lta_gap : float
        LTA: gap in the oncoming traffic that is too short to turn [s].
    curbside_time : float
        Curb-side: time within which the standing vehicle is reached [s].
    curbside_clearance : float
        Curb-side: lateral distance at which it still is in the way [m].
    bsw_near, bsw_far : float
        BSW: distance from the ego's side at which the zone begins and ends [m].
    bsw_behind : float
        BSW: distance behind the ego's rear at which the zone ends [m]; it begins at the middle of the body.
    dnpw_time : float
        DNPW: time to collision with oncoming traffic in which a pass must not begin [s].
    braking : float
        Deceleration from which on a leader counts as braking [m/s^2]; it then brakes until it stands.
    standstill_speed : float
        Speed below which a vehicle stands [m/s].
    turning_speed : float
        Speed with which an ego that means to turn is reckoned at least [m/s].
    act_deceleration : float
        Deceleration needed from which on a warning becomes `Level.ACT` [m/s^2].
    max_age : float
        Age of what is known of a vehicle up to which it is warned of [s].
    crossing : CrossingSettings
        What counts as crossing; bounds on the acceleration do not matter here.

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    fcw_decelerating: float = 2.4
    fcw_stopped: float = 2.1
    fcw_slower: float = 2.0
    eebl_range: float = 300.0
    eebl_deceleration: float = 0.4 * GRAVITY
    eebl_heading: float = 0.25 * math.pi
    ima_time: float = 4.0
    ima_difference: float = 1.5
    lta_gap: float = 4.1
    curbside_time: float = 5.0
    curbside_clearance: float = 0.3
    bsw_near: float = 0.5
    bsw_far: float = 3.0
    bsw_behind: float = 3.0
    dnpw_time: float = 9.0
    braking: float = 1.0
    standstill_speed: float = STANDSTILL_SPEED
    turning_speed: float = 3.0
    act_deceleration: float = 4.0
    max_age: float = 3.0
    crossing: CrossingSettings = field(
        default_factory=lambda: CrossingSettings(a_max=0.0, b_max=0.0, clearance=0.0)
    )

    def __post_init__(self) -> None:
        for name in self.__slots__:
            if name != "crossing":
                check_real(name, getattr(self, name), ge=0.0)
        check_real("braking", self.braking, gt=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class EgoView:
    """The ego along its route.

    Parameters
    ----------
    path : Path
        The route.
    s, d : float
        Path coordinates of the center of its body [m], d left positive.
    v : float
        Speed along the route [m/s].
    half_length, half_width : float
        Half extents of its body [m].
    lane_width : float
        Width of its lane [m].
    intent : {"left", "right"}, optional
        Where it means to turn or to change lanes.
    """

    path: Path
    s: float
    d: float
    v: float
    half_length: float
    half_width: float
    lane_width: float = 3.5
    intent: Literal["left", "right"] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Sighting:
    """Another vehicle, along the ego's route.

    Parameters
    ----------
    remote : RemoteVehicle
        The vehicle.
    gap : float
        Distance along the route from the ego's front to its rear [m]; negative if it is not ahead.
    lateral_offset : float
        Lateral distance from the middle of the ego to the middle of the vehicle [m], left positive.
    v : float
        Its speed along the route [m/s], negative if it comes toward the ego.
    angle : float
        Its heading relative to the route [rad] in [-pi, pi), counter-clockwise.
    half_length, half_width : float
        Half extents along and across the route [m].
    conflict : Conflict, optional
        Where its way crosses that of the ego.
    crosses_ego_turn : bool
        Whether the ego turns in front of it there, and it comes toward the ego's approach.
    occluded_by : str
        Id of a vehicle in the line of sight to it; empty if there is none.
    """

    remote: RemoteVehicle
    gap: float
    lateral_offset: float
    v: float
    angle: float
    half_length: float
    half_width: float
    conflict: Conflict | None = None
    crosses_ego_turn: bool = False
    occluded_by: str = ""


def alert(what: Application, level: Level, other: Sighting, time: float, reason: str) -> Alert:
    """Make an alert of a vehicle."""
    return Alert(
        application=what, level=level, vehicle_id=other.remote.id, time_to_conflict=time, reason=reason
    )


def level_for(needed: float, settings: AlertSettings) -> Level:
    """Level of a warning that a deceleration [m/s^2] could answer."""
    return Level.ACT if needed > settings.act_deceleration else Level.WARN


def is_ahead(ego: EgoView, other: Sighting) -> bool:
    """Whether the middle of a vehicle is ahead of the ego's."""
    return other.gap + ego.half_length + other.half_length > 0.0


def blocks_ego(ego: EgoView, other: Sighting, clearance: float = 0.0) -> bool:
    """Whether a vehicle is where the ego would pass, or within a lateral clearance [m] of it."""
    return abs(other.lateral_offset) < ego.half_width + other.half_width + clearance
