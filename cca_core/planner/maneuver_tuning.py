"""Groups of settings: last resort, replanning and abort of maneuvers; certificates and costs."""

from dataclasses import dataclass

from cca_core._repr import short_repr
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
        Peak lateral acceleration at which a sharp maneuver aims [m/s^2]; at most half the grip counts.
    walking_pace : float
        Speed below which the ego may pull out from behind a vehicle as sharply as it can steer [m/s].
    pull_out_stiffness : float
        Contact stiffness of that band [N/m^2], as `BandStiffness.k_e`. It yields over 2 m, the default over
        4 m.
    pull_out_steering : float
        Fraction of the sharpest turn that it may use [-].

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    grip_fraction: float = 0.8
    clearance: float = 0.2
    min_ttc: float = 0.1
    lateral_acceleration: float = 3.5
    walking_pace: float = 2.0
    pull_out_stiffness: float = 0.02
    pull_out_steering: float = 0.85

    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_fields(self, positive=("grip_fraction", "lateral_acceleration", "pull_out_stiffness"))


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplanSettings:
    """How an ongoing maneuver is replanned.

    Parameters
    ----------
    committed_time : float
        Time in which the path no longer changes [s].
    min_clearance : float
        Clearance to the vehicles passed and met that the maneuver being driven must keep [m].

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    committed_time: float = 0.5
    min_clearance: float = 0.5

    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class AbortSettings:
    """How the ego returns before the maneuver is complete.

    Parameters
    ----------
    max_hold_time : float
        Latest begin of a return [s].

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    max_hold_time: float = 5.0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class CertificateSettings:
    """What a plan must keep to be certified.

    Parameters
    ----------
    reaction_time : float
        Time that a plan is driven before its braking tail begins [s]: two decisions and the brakes' delay.
    comfortable_braking : float
        Deceleration of the tail up to which a safe end is comfortable [m/s^2].
    touch : float
        Gap that a new plan keeps to every nominal motion [m].
    touch_kept : float
        The same of the plan that is being driven [m]: less, so that it is kept.
    foresight : float
        Time constant with which the weight of a predicted impact falls [s]. If the ego brakes fully, the time
        until the vehicle is met at the present speeds counts.
    full_overlap : float
        Predicted overlap of two bodies from which on their impact counts in full [m]: less may be a miss.
    exposure : float
        Weight of an impact speed in the worst case, added to the lack of a nominal gap [s].
    response : float
        Least braking of a proper response, over what the present speed of the lead vehicle needs [-].
    mild_impact, severe_impact : float
        Impact speed [m/s] into a lead vehicle that brakes at once, if the ego brakes fully after the reaction
        time. Up to the first one it asks for no more than a comfortable proper response, from the second one
        on for full braking.
    margin : float
        Distance along the road that a new plan keeps beyond the worst case [m].
    duty_delay : float
        Time after the return from which on vehicles behind the ego keep their distance [s].
    silence_time : float
        Time after a vehicle became stale from which on it is answered by full braking, if no comfortable end
        is safe [s]; the answer grows from comfort, because one or two lost messages more are no danger yet.
    look_time : float
        Time for which a vehicle is followed before it is in the path [s].
    lag : float
        Time constant of brakes and engine [s].
    side_speed, side_angle : float
        Lateral speed [m/s], or angle to the route [rad], above which a vehicle is expected to change lanes.
    side_offset : float
        Distance from the middle of its lane [m] up to which lateral speed is no lane change, because drivers
        correct their course within a lane, and a heading is known to one or two degrees.
    heading_error : float
        Angle to the route of two reports [rad] up to which lateral speed is no lane change: the error of a
        heading, and of one report alone.
    return_speed : float
        Lateral speed with which an oncoming vehicle returns that drives in the middle of a wrong lane [m/s].
    acceleration_time, braking_time : float
        Time for which a reported acceleration or deceleration is expected to last [s].

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    reaction_time: float = 0.4
    comfortable_braking: float = 3.0
    touch: float = 0.3
    touch_kept: float = 0.1
    foresight: float = 2.0
    full_overlap: float = 0.5
    exposure: float = 0.05
    response: float = 1.5
    mild_impact: float = 4.0
    severe_impact: float = 28.0
    margin: float = 1.0
    duty_delay: float = 1.0
    silence_time: float = 2.0
    look_time: float = 1.6
    lag: float = 0.15
    side_speed: float = 0.3
    side_angle: float = 0.1
    side_offset: float = 0.25
    heading_error: float = 0.02
    return_speed: float = 1.5
    acceleration_time: float = 1.0
    braking_time: float = 4.0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_fields(self, positive=("lag", "foresight", "full_overlap", "silence_time"))


@dataclass(frozen=True, slots=True, kw_only=True)
class CostSettings:
    """What the terms of the cost weigh; a cost is a time [s].

    Parameters
    ----------
    progress : float
        Of the time lost within the horizon [-].
    speed : float
        Of the speed missing at the horizon, as a fraction of the cruise speed [s].
    a_x, a_y : float
        Of the squared accelerations over time [s^3/m^2]; speeding up counts less than braking.
    jerk : float
        Of the squared longitudinal jerk over time [s^5/m^2]: of two plans that are as fast, the one that
        brakes and releases less often.
    change_of_acceleration : float
        Of the squared change of acceleration at once [s^3/m^2].
    outside : float
        Of the time outside the ego lane [-].
    right : float
        Of passing on the inner side [s]: on the right in right-hand traffic, on the left in left-hand traffic
        (`EvasionSettings.traffic_side`).
    lane : float
        Of not changing to a lane that was requested, and of changing to another one [s].
    change, replan, abort : float
        Of another intention, of a new path of the same, and of returning before a pass is complete [s].
    delay : float
        Of the time until a return is complete [-]: without a reason to wait the ego returns at once.
    narrow, hard : float
        Of the levels beyond comfort [s].
    sharp, sharp_from : float
        Of a maneuver whose peak lateral acceleration exceeds `sharp_from` times the one at which
        it aims; of the square of the excess [s], [-].
    safe_end : float
        Of a safe end that needs full braking [s]; it grows with the square of the deceleration.
    silence : float
        The same of a safe end behind a vehicle that has been silent for `CertificateSettings.silence_time`
        [s], in addition: what it does will not be seen in time to begin later.
    uncertified : float
        Of going on with a maneuver that has lost its certificate but not its nominal one [s].
    exposure : float
        Of a plan without certificate: of its impact speed in the worst case [s^2/m].
    severity, at_stake : float
        Of a plan that comes too close: of its severity if the ego brakes fully after the reaction time [s],
        and of its impact without that, which counts less if it comes later [s^3/m^2].
    astray : float
        Of a path that does not end in the ego lane, or in the one that it changes to [s].
    risk : float
        Of following so closely that a lead vehicle's hardest braking would need more than `risk_braking`,
        over time [-]; it grows with the square of the excess.
    risk_braking : float
        Deceleration [m/s^2].
    horizon : float
        Time over which costs are summed [s].

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    progress: float = 1.0
    speed: float = 4.0
    a_x: float = 0.03
    a_y: float = 0.03
    jerk: float = 0.001
    change_of_acceleration: float = 0.02
    outside: float = 0.08
    right: float = 0.5
    lane: float = 20.0
    change: float = 0.4
    replan: float = 0.15
    abort: float = 1.0
    delay: float = 0.02
    narrow: float = 0.8
    hard: float = 0.4
    sharp: float = 15.0
    sharp_from: float = 1.2
    safe_end: float = 1.5
    silence: float = 40.0
    uncertified: float = 4.0
    exposure: float = 0.5
    severity: float = 50.0
    at_stake: float = 5.0
    astray: float = 2.0
    risk: float = 0.5
    risk_braking: float = 5.0
    horizon: float = 10.0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_fields(self, positive=("horizon", "risk_braking"))
