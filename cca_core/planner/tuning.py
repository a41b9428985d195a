"""Groups of settings: decision, actuation, lead vehicle, yielding."""

from dataclasses import MISSING, dataclass, fields
from typing import Any

from cca_core._checks import check_real
from cca_core.errors import InputError

__all__ = ["ActuationSettings", "DecisionSettings", "LeadSettings", "YieldSettings", "check_fields"]


@dataclass(frozen=True, slots=True, kw_only=True)
class DecisionSettings:
    """When the planner decides, and what it prefers.

    Parameters
    ----------
    period : float
        Time between two decisions about the same vehicles and events [s], the period of messages.
    follow_threshold : float
        Deceleration asked for by the lead vehicle above which the ego follows or evades [m/s^2].
    comfort_deceleration : float
        Deceleration up to which a comfort stop is preferred to a maneuver [m/s^2].
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
    memory_time : float
        Time for which a vehicle that is missing from the list is assumed to be there, if the radio is not to
        be trusted or its record cannot be used [s]. While there is no list at all, none is forgotten.

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    period: float = 0.1
    follow_threshold: float = 0.5
    comfort_deceleration: float = 2.0
    max_route_distance: float = 15.0
    relevance_margin: float = 1.5
    level_gap: float = 4.0
    max_level_gap: float = 20.0
    max_grade: float = 0.06
    max_state_age: float = 0.1
    memory_time: float = 30.0

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class ActuationSettings:
    """How the commanded acceleration uses the tires.

    Parameters
    ----------
    grip_fraction : float
        Fraction of the grip for acceleration in normal driving [-].
    emergency_grip_fraction : float
        The same in an emergency [-]; more only if less cannot avoid the collision.
    hard_braking_fraction : float
        Fraction of `SpeedSettings.b_max` above which braking is an emergency [-], as above twice the
        comfortable deceleration.
    curve_acceleration : float
        Lateral acceleration that limits the speed in curves [m/s^2].
    safe_stop_deceleration : float
        Deceleration of a safe stop, and the least of the action BRAKE [m/s^2].

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    grip_fraction: float = 0.9
    emergency_grip_fraction: float = 0.98
    hard_braking_fraction: float = 0.7
    curve_acceleration: float = 2.5
    safe_stop_deceleration: float = 4.0

    def __post_init__(self) -> None:
        check_fields(self, positive=("grip_fraction", "emergency_grip_fraction", "curve_acceleration"))


@dataclass(frozen=True, slots=True, kw_only=True)
class LeadSettings:
    """Which vehicle is the lead vehicle, and what it demands.

    Parameters
    ----------
    blocking_gap : float
        Lateral gap to the route below which a vehicle blocks it [m].
    creep_speed : float
        Speed below which a vehicle creeps and is taken as stationary [m/s]. It is twice the standstill speed
        of reports: at that one, noise of 0.2 m/s makes the action alternate behind a downstream vehicle.
    creep_stop_time : float
        Time in which a creeping ego stops [s].
    lane_entry_horizon : float
        Time for which a stale oncoming vehicle is assumed to keep its heading across the route [s].
    downstream_braking : float
        Deceleration above which a downstream vehicle can be the lead vehicle [m/s^2].
    brake_now_deceleration : float
        Required deceleration above which the ego brakes for a braking downstream vehicle at once [m/s^2].
    follow_speed_difference : float
        Speed difference below which a vehicle before the downstream one is followed, not passed [m/s].
    fall_back_speed : float
        Speed difference with which the ego falls back from an uncertain lead vehicle [m/s].
    stop_horizon, stop_delay : float
        Time ahead at which a comfort stop is decided, and the delay of the brakes [s].
    stop_margin : float
        Distance kept in reserve for a comfort stop [m].

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    blocking_gap: float = 0.3
    creep_speed: float = 1.0
    creep_stop_time: float = 0.5
    lane_entry_horizon: float = 2.0
    downstream_braking: float = 2.0
    brake_now_deceleration: float = 1.0
    follow_speed_difference: float = 2.0
    fall_back_speed: float = 2.0
    stop_horizon: float = 5.0
    stop_delay: float = 0.3
    stop_margin: float = 5.0

    def __post_init__(self) -> None:
        check_fields(self, positive=("creep_stop_time",))


@dataclass(frozen=True, slots=True, kw_only=True)
class YieldSettings:
    """When the ego yields to crossing vehicles.

    Parameters
    ----------
    horizon : float
        Time within which conflicts are predicted [s].
    range : float
        Distance within which crossing vehicles are considered [m].
    hold_pet : float
        Post-encroachment time required in addition by an ego that yields already [s].
    sufficient_gap : float
        Predicted gap that braking must keep if the ego can no longer stop before the conflict area [m].
    brake_delay : float
        Time until the brakes act [s].
    min_braking : float
        Deceleration that remains where cornering takes all of the grip [m/s^2].

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    horizon: float = 8.0
    range: float = 150.0
    hold_pet: float = 1.0
    sufficient_gap: float = 0.5
    brake_delay: float = 0.3
    min_braking: float = 1.0

    def __post_init__(self) -> None:
        check_fields(self, positive=("horizon", "min_braking"))


def check_fields(settings: Any, *, positive: tuple[str, ...] = (), infinite: str = "") -> None:
    """Check that numbers are finite and not negative, and that groups have the right type."""
    for f in fields(settings):
        value = getattr(settings, f.name)
        if f.default_factory is MISSING:
            lower = {"gt": 0.0} if f.name in positive else {"ge": 0.0}
            check_real(f.name, value, **lower, allow_inf=f.name == infinite)
        elif not isinstance(value, group := type(f.default_factory())):
            raise InputError(f"{f.name} must be {group.__name__}, was {type(value).__name__}")
