"""Alerts of the V2V applications, and their thresholds."""

import math
from dataclasses import dataclass, field
from enum import Enum, IntEnum

from cca_core._checks import check_real
from cca_core._repr import short_repr
from cca_core.decide import CrossingSettings
from cca_core.vehicle import GRAVITY, STANDSTILL_SPEED


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

    __repr__ = short_repr


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

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for name in self.__slots__:
            if name != "crossing":
                check_real(name, getattr(self, name), ge=0.0)
        check_real("braking", self.braking, gt=0.0)


def level_for(deceleration: float, settings: AlertSettings) -> Level:
    """Return the level of a conflict that a deceleration [m/s^2] avoids."""
    return Level.ACT if deceleration > settings.act_deceleration else Level.WARN
