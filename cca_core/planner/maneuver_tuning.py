"""Groups of settings: last resort, replanning and abort of maneuvers."""

from dataclasses import dataclass

from cca_core.planner.tuning import check_fields


@dataclass(frozen=True, slots=True, kw_only=True)
class LastResortSettings:
    """How a maneuver is driven if comfort is not feasible.

    Parameters
    ----------
    grip_fraction : float
        Fraction of the grip that limits the lateral acceleration [-].
    clearance : float
        Clearance of the narrowest maneuver [m].
    min_ttc : float
        Time to collision of the latest maneuver [s].
    lateral_acceleration : float
        Peak lateral acceleration of the sharpest maneuver [m/s^2], at most half the grip.

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    grip_fraction: float = 0.8
    clearance: float = 0.3
    min_ttc: float = 0.1
    lateral_acceleration: float = 3.5

    def __post_init__(self) -> None:
        check_fields(self, positive=("grip_fraction", "lateral_acceleration"))


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplanSettings:
    """How an ongoing maneuver is replanned or canceled.

    Parameters
    ----------
    committed_time : float
        Time in which the reference can no longer change [s].
    recovery_time : float
        Time after that in which a missing clearance is regained [s].
    min_clearance : float
        Clearance below which a missing clearance is not relaxed [m].
    clearance_tolerance, edge_tolerance : float
        Relaxation beyond the missing clearance, and of road edges, in the committed part [m]: bounds
        between nodes are looser than at nodes.
    curvature_tolerance : float
        Fraction by which the committed part may exceed its curvature [-].
    window_hysteresis : float
        Distance by which the end must move to be moved [m]; less is rounding of messages.
    abort_clearance : float
        Clearance of the unchanged maneuver below which the ego returns [m].
    cancel_brake_fraction : float
        Fraction of the brakes up to which following is feasible instead [-].

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    committed_time: float = 0.5
    recovery_time: float = 2.0
    min_clearance: float = 0.3
    clearance_tolerance: float = 0.05
    edge_tolerance: float = 0.05
    curvature_tolerance: float = 0.002
    window_hysteresis: float = 2.0
    abort_clearance: float = 0.1
    cancel_brake_fraction: float = 0.3

    def __post_init__(self) -> None:
        check_fields(self, positive=("recovery_time",))


@dataclass(frozen=True, slots=True, kw_only=True)
class AbortSettings:
    """How the ego returns before the maneuver is complete.

    Parameters
    ----------
    deceleration : float
        Deceleration with which the ego falls back, and following vehicles slow down [m/s^2].
    brake_delay : float
        Time until it acts [s]: half the time in which brakes build up, and their lag.
    reaction_time : float
        Reaction time of drivers of following vehicles [s].
    standstill_gap : float
        Gap to the vehicles ahead and behind after the return [m].
    time_gap : float
        Time gap to the next lead vehicle after an early return [s].
    lateral_gap : float
        Lateral gap to a vehicle that is passed during an early return [m].
    lateral_acceleration : float
        Lateral acceleration of the return [m/s^2].
    min_length : float
        Least length of a return [m].
    max_overshoot_ratio : float
        Largest length of a return, as a multiple of the distance in which its slope leads back [-].
    settling_time : float
        Time in which a return that is too early is stopped [s].
    max_hold_time : float
        Latest begin of an early return [s].

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    deceleration: float = 5.0
    brake_delay: float = 0.3
    reaction_time: float = 1.0
    standstill_gap: float = 2.0
    time_gap: float = 2.0
    lateral_gap: float = 0.2
    lateral_acceleration: float = 4.0
    min_length: float = 15.0
    max_overshoot_ratio: float = 2.5
    settling_time: float = 0.6
    max_hold_time: float = 3.0

    def __post_init__(self) -> None:
        check_fields(self, positive=("deceleration", "lateral_acceleration", "min_length"))
