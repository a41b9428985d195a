"""Alerts of the V2V applications, their thresholds, and the view of the road that the rules share."""

import math
from dataclasses import dataclass, field
from enum import Enum, IntEnum
from typing import Literal

from cca_core._checks import check_real
from cca_core.decide import Conflict, CrossingSettings
from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.path import Path
from cca_core.vehicle import GRAVITY, STANDSTILL_SPEED

__all__ = ["Alert", "AlertSettings", "Application", "Level", "VehicleInView", "WarningView"]

PARALLEL_ANGLE = 0.25 * math.pi
"""Largest angle between a heading and the route, or its opposite, that counts as parallel [rad]."""


class Application(Enum):
    """V2V application."""

    EEBL = "electronic emergency brake light"
    FCW = "forward collision warning"
    IMA = "intersection movement assist"
    LTA = "left turn assist"
    CURB_SIDE = "stationary vehicle ahead"
    BSW = "blind spot warning"
    LCW = "lane change warning"
    DNPW = "do not pass warning"


class Level(IntEnum):
    """Urgency: information, avoid the conflict now, or only hard braking still avoids it."""

    INFORM = 1
    WARN = 2
    ACT = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Alert:
    """One warning.

    Parameters
    ----------
    application : Application
        The application that warns.
    level : Level
        Urgency.
    vehicle_id : str
        Id of the vehicle that causes the conflict.
    time_to_conflict : float
        Time until the bodies collide, or until both are in the conflict area [s]; 0 for a vehicle alongside,
        infinite if they do not collide at their present speeds.
    reason : str
        Why, with numbers and limits.
    """

    application: Application
    level: Level
    vehicle_id: str
    time_to_conflict: float
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class AlertSettings:
    """Thresholds of the applications; the documentation names their sources.

    Parameters
    ----------
    fcw_decelerating, fcw_stopped, fcw_slower : float
        FCW: time to collision with a lead vehicle that brakes, is stationary, or is slower [s].
    eebl_range : float
        EEBL: distance within which hard braking is reported [m].
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
        Curb-side: time within which the ego reaches the stationary vehicle [s].
    curbside_clearance : float
        Curb-side: lateral gap below which the vehicle blocks the ego [m].
    bsw_near, bsw_far : float
        BSW: distances from the ego's side at which the zone begins and ends [m].
    bsw_behind : float
        BSW: distance behind the ego's rear at which the zone ends [m]; it begins at the center of the body.
    dnpw_time : float
        DNPW: time to collision with oncoming traffic below which the ego must not pass [s].
    braking : float
        Deceleration above which a lead vehicle brakes [m/s^2]; it then brakes to standstill.
    standstill_speed : float
        Speed below which a vehicle is stationary [m/s].
    turning_speed : float
        Least speed that is assumed of an ego that intends to turn [m/s].
    min_speed : float
        Speed below which the ego does not reach a conflict area [m/s].
    turn_angle, approach_distance : float
        LTA: change of heading above which the route turns [rad], relative to its heading this distance
        before the conflict area [m].
    act_deceleration : float
        Required deceleration above which the level is `Level.ACT` [m/s^2].
    max_age : float
        Age above which a vehicle is ignored [s].
    crossing : CrossingSettings
        What counts as crossing; its bounds on the acceleration have no effect here.

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
    min_speed: float = 0.1
    turn_angle: float = math.pi / 6.0
    approach_distance: float = 10.0
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
class VehicleInView:
    """A remote vehicle relative to the ego.

    Parameters
    ----------
    vehicle : FrenetVehicle
        The vehicle at its nominal position, without uncertainty bound.
    gap : float
        Gap from the ego's front to its rear along the route [m]; negative unless it is ahead.
    lateral_offset : float
        Lateral distance from the center of the ego to its center [m], left positive.
    conflict : Conflict, optional
        Conflict of its path with that of the ego.
    crosses_ego_turn : bool
        Whether the ego turns across its lane in this conflict.
    occluded_by : str
        Id of a vehicle in the line of sight; empty if there is none.
    """

    vehicle: FrenetVehicle
    gap: float
    lateral_offset: float
    conflict: Conflict | None = None
    crosses_ego_turn: bool = False
    occluded_by: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class WarningView:
    """The ego and the vehicles around it along the route.

    Parameters
    ----------
    path : Path
        The route.
    ego : FrenetEgo
        The ego; it keeps its speed.
    lane_width : float
        Width of its lane [m].
    intent : {"left", "right"}, optional
        Side to which the ego intends to turn or to change lanes.
    vehicles : tuple of VehicleInView
        The other vehicles.
    """

    path: Path
    ego: FrenetEgo
    lane_width: float = 3.5
    intent: Literal["left", "right"] | None = None
    vehicles: tuple[VehicleInView, ...] = ()


def make_alert(
    application: Application, level: Level, other: VehicleInView, time: float, reason: str
) -> Alert:
    """Make an alert because of a vehicle."""
    return Alert(
        application=application,
        level=level,
        vehicle_id=other.vehicle.id,
        time_to_conflict=time,
        reason=reason,
    )


def level_for(deceleration: float, settings: AlertSettings) -> Level:
    """Return the level of a conflict that a deceleration [m/s^2] avoids."""
    return Level.ACT if deceleration > settings.act_deceleration else Level.WARN


def is_ahead(view: WarningView, other: VehicleInView) -> bool:
    """Return whether the center of a vehicle is ahead of the ego's."""
    return other.gap + 0.5 * view.ego.vehicle.length + other.vehicle.half_length > 0.0


def blocks_ego(view: WarningView, other: VehicleInView, clearance: float = 0.0) -> bool:
    """Return whether a vehicle is closer to the ego's path than a lateral clearance [m]."""
    half_width = 0.5 * view.ego.vehicle.width
    return abs(other.lateral_offset) < half_width + other.vehicle.half_width + clearance
