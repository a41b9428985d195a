"""Groups of settings: decision, actuation, lead vehicle, lane change, yielding."""

from dataclasses import MISSING, dataclass, fields
from typing import Any

from cca_core._checks import check_real
from cca_core._repr import short_repr
from cca_core.errors import InputError

__all__ = [
    "ActuationSettings",
    "DecisionSettings",
    "LaneChangeSettings",
    "LeadSettings",
    "YieldSettings",
    "check_fields",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class DecisionSettings:
    """When the planner decides, and what it prefers.

    Parameters
    ----------
    period : float
        Time between two decisions about the same vehicles and events [s], the period of messages.
    follow_threshold : float
        Acceleration lost to other vehicles above which the ego follows [m/s^2].
    brake_threshold : float
        Deceleration above which it brakes [m/s^2].
    max_route_distance : float
        Lateral offset above which the ego is off its route and makes a safe stop [m].
    relevance_margin : float
        Distance beyond the road edges and the clearance within which vehicles are relevant [m].
    level_gap : float
        Height above or below the route, beyond both uncertainty bounds, from which on a vehicle does not
        block it [m]: the height of trucks.
    max_level_gap : float
        Greater differences of height are errors, such as ellipsoid against sea level; the vehicle blocks [m].
    max_grade : float
        Grade of roads that cross the route [-]. A vehicle off the route may be higher by this times its
        lateral offset and still be on a road that meets it.
    max_state_age : float
        Age of the ego's state above which it counts as lost [s].
    coast_fraction : float
        Fraction of the time for which a vehicle has been known, for which it is assumed to be still there
        after its last report [-].
    max_coast_time : float
        Longest such time [s].
    memory_time : float
        Time for which a vehicle that is missing from the list is assumed to be there, if the radio is not to
        be trusted or its record cannot be used [s]. While there is no list at all, none is forgotten.

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    period: float = 0.1
    follow_threshold: float = 0.3
    brake_threshold: float = 4.0
    max_route_distance: float = 15.0
    relevance_margin: float = 1.5
    level_gap: float = 4.0
    max_level_gap: float = 20.0
    max_grade: float = 0.06
    max_state_age: float = 0.1
    coast_fraction: float = 0.4
    max_coast_time: float = 1.0
    memory_time: float = 30.0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class ActuationSettings:
    """How the commanded acceleration uses the tires.

    Parameters
    ----------
    emergency_grip_fraction : float
        Fraction of the grip that plans may use [-].
    curve_acceleration : float
        Lateral acceleration that limits the speed in curves [m/s^2].
    safe_stop_deceleration : float
        Deceleration of a safe stop without a plan, or if no vehicle asks for another [m/s^2].

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    emergency_grip_fraction: float = 0.98
    curve_acceleration: float = 2.5
    safe_stop_deceleration: float = 4.0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_fields(self, positive=("emergency_grip_fraction", "curve_acceleration"))


@dataclass(frozen=True, slots=True, kw_only=True)
class LeadSettings:
    """Which vehicles are followed, and where the ego stops behind them.

    Parameters
    ----------
    blocking_gap : float
        Lateral gap to the path below which a vehicle is in its way [m], at least `CertificateSettings.touch`.
    passing_distance : float
        Distance kept, beyond the standstill gap, behind a single vehicle that comes to rest next to a clear
        lane, so that it can be passed from standstill [m].
    queue_gap : float
        Gap to the next vehicle below which a stationary vehicle is in a queue [m].
    firm_braking : float
        Deceleration up to which the ego brakes for `passing_distance` [m/s^2]: a little more than in comfort.
    opening_speed : float
        By which the ego is slower than a lead vehicle that is too close, so that the gap opens [m/s].
    creep_time : float
        Driving time within which a slow ego may come nearer than the standstill gap, by at most half of it,
        instead of braking hard [s].

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    blocking_gap: float = 0.3
    passing_distance: float = 7.0
    queue_gap: float = 15.0
    firm_braking: float = 3.5
    opening_speed: float = 2.0
    creep_time: float = 0.5

    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneChangeSettings:
    """How the ego changes to a lane that was requested, and waits for it.

    Parameters
    ----------
    gentle_fraction : float
        Lateral acceleration of a change without haste, as a fraction of `lateral_acceleration` [-].
    speed_loss : float
        By which the ego is slower than a vehicle that blocks the lane, so that it passes [m/s].
    passing_speed : float
        By which the ego must be faster than that vehicle to pass it instead [m/s].
    speed_step : float
        By which the ego slows down at once for that [m/s]; it limits the deceleration.
    braking, last_braking : float
        Deceleration behind a vehicle of the other lane up to which a change begins [m/s^2]: at first, and
        after `patience`.
    patience : float
        Time after which the ego accepts smaller gaps [s].

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    gentle_fraction: float = 0.4
    speed_loss: float = 2.5
    passing_speed: float = 3.0
    speed_step: float = 0.7
    braking: float = 1.0
    last_braking: float = 2.1
    patience: float = 20.0

    def __post_init__(self) -> None:
        check_fields(self, positive=("gentle_fraction", "patience"))


@dataclass(frozen=True, slots=True, kw_only=True)
class YieldSettings:
    """When the ego yields to crossing vehicles.

    Parameters
    ----------
    range : float
        Distance within which crossing vehicles are considered [m].
    min_pet : float
        Least post-encroachment time: between the ego and a crossing vehicle at one place [s].
    hold_pet : float
        Time after that at which a yielding ego means to arrive [s].
    assumed_braking, assumed_acceleration : float
        Assumed maximum deceleration and acceleration of crossing vehicles [m/s^2].
    acceleration_time : float
        Time for which a reported acceleration of a crossing vehicle is expected to last [s]: shorter than
        along the route, as pedestrians reach their speed at once.
    braking_time : float
        Time from its report for which a crossing vehicle that brakes goes on braking in the worst case [s].

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    range: float = 150.0
    min_pet: float = 1.0
    hold_pet: float = 0.5
    assumed_braking: float = 2.0
    assumed_acceleration: float = 2.0
    acceleration_time: float = 0.5
    braking_time: float = 1.0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_fields(self)


def check_fields(settings: Any, *, positive: tuple[str, ...] = (), infinite: str = "") -> None:
    """Check that numbers are finite and not negative, and that groups have the right type."""
    for f in fields(settings):
        value = getattr(settings, f.name)
        if isinstance(f.default, bool | str):
            continue
        if f.default_factory is MISSING:
            lower = {"gt": 0.0} if f.name in positive else {"ge": 0.0}
            check_real(f.name, value, **lower, allow_inf=f.name == infinite)
        elif not isinstance(value, group := type(f.default_factory())):
            raise InputError(f"{f.name} must be {group.__name__}, was {type(value).__name__}")
