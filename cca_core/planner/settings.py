"""Settings of evasive maneuvers, with the groups of the other subjects; defaults are assumed."""

import math
from dataclasses import dataclass, field
from typing import Self

from cca_core._checks import check_bool, shown
from cca_core._repr import short_repr
from cca_core.band import Side
from cca_core.errors import InputError
from cca_core.planner.maneuver_tuning import (
    AbortSettings,
    CertificateSettings,
    CostSettings,
    LastResortSettings,
    ReplanSettings,
)
from cca_core.planner.tuning import (
    ActuationSettings,
    DecisionSettings,
    LaneChangeSettings,
    LeadSettings,
    YieldSettings,
    check_fields,
)
from cca_core.vehicle import STALE_AGE


@dataclass(frozen=True, slots=True, kw_only=True)
class EvasionSettings:
    """How the ego passes other vehicles, and what it assumes of them.

    Parameters
    ----------
    lateral_acceleration : float
        Peak lateral acceleration at which a maneuver aims [m/s^2]: from smooth (2) to fast (3.5). A lateral
        offset of w takes sqrt(5.77 w / a) seconds.
    lateral_acceleration_limit : float
        Lateral acceleration above which a comfortable maneuver is rejected [m/s^2]; if there is no safe plan
        without, `LastResortSettings.grip_fraction` limits it.
    clearance : float
        Clearance between boxes [m].
    min_ttc : float
        Time to collision with the vehicle ahead at which the ego is out of its path [s].
    preparation_time : float
        Time before a maneuver becomes due [s].
    x_safety : float
        Distance to vehicles in the adjacent lane [m], eq 11.
    awareness_range : float
        Distance within which every vehicle is known by its messages [m]. Beyond it a vehicle at the speed
        limit is assumed in the adjacent lane. With 0 the lane is never clear; infinity trusts silence.
    stale_after : float
        Age above which a vehicle is stale and blocks its lane [s].
    min_speed_advantage : float
        Speed advantage over the overtaken vehicle [m/s], at least.
    lane_entry_tolerance : float
        Distance beyond a lane boundary up to which a body is not yet in the lane [m].
    assumed_braking : float
        Assumed maximum deceleration of other vehicles along the route [m/s^2]; `crossing` has that of
        vehicles that cross it.
    assumed_acceleration : float
        Assumed maximum acceleration of other vehicles along the route [m/s^2], up to the speed limit or to
        0.5 m/s above their speed. With this and `assumed_braking` at 0, every vehicle keeps its current
        motion (the paper's assumption).
    assumed_acceleration_passed : float
        The same of the overtaken vehicle [m/s^2].
    rear_reaction_time : float
        Time after which a driver behind in the adjacent lane reacts to an ego that enters it [s]; 0 if it is
        assumed not to react at all.
    rear_braking : float
        Deceleration with which it then keeps its distance [m/s^2].
    traffic_side : {"right", "left"}
        Side of the road on which vehicles drive. The ego prefers to pass on the other side; passing on this
        one, the inner side, costs `CostSettings.right`.
    inner_passing : bool
        Whether the ego may pass on the inner side in an adjacent lane at all.
    decision : DecisionSettings
        When the planner decides.
    lead : LeadSettings
        What is the lead vehicle.
    crossing : YieldSettings
        When the ego yields.
    last_resort : LastResortSettings
        Maneuvers beyond comfort.
    replan : ReplanSettings
        Ongoing maneuvers.
    abort : AbortSettings
        Return before the maneuver is complete.
    actuation : ActuationSettings
        Use of the tires.
    change : LaneChangeSettings
        Change to a lane that was requested.
    certificate : CertificateSettings
        What a plan must keep to be certified.
    cost : CostSettings
        What the terms of the cost weigh.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    lateral_acceleration: float = 2.0
    lateral_acceleration_limit: float = 4.0
    clearance: float = 1.0
    min_ttc: float = 1.0
    preparation_time: float = 0.25
    x_safety: float = 7.0
    awareness_range: float = 300.0
    stale_after: float = STALE_AGE
    min_speed_advantage: float = 2.0
    lane_entry_tolerance: float = 0.2
    assumed_braking: float = 8.0
    assumed_acceleration: float = 3.0
    assumed_acceleration_passed: float = 0.0
    rear_reaction_time: float = 1.5
    rear_braking: float = 2.0
    traffic_side: Side = "right"
    inner_passing: bool = True
    decision: DecisionSettings = field(default_factory=DecisionSettings)
    lead: LeadSettings = field(default_factory=LeadSettings)
    crossing: YieldSettings = field(default_factory=YieldSettings)
    last_resort: LastResortSettings = field(default_factory=LastResortSettings)
    replan: ReplanSettings = field(default_factory=ReplanSettings)
    abort: AbortSettings = field(default_factory=AbortSettings)
    actuation: ActuationSettings = field(default_factory=ActuationSettings)
    change: LaneChangeSettings = field(default_factory=LaneChangeSettings)
    certificate: CertificateSettings = field(default_factory=CertificateSettings)
    cost: CostSettings = field(default_factory=CostSettings)

    __repr__ = short_repr

    def __post_init__(self) -> None:
        positive = ("lateral_acceleration", "lateral_acceleration_limit", "rear_braking")
        check_fields(self, positive=positive, infinite="awareness_range")
        if self.traffic_side not in ("left", "right"):
            raise InputError(f"traffic_side must be 'left' or 'right', was {shown(self.traffic_side)}")
        check_bool("inner_passing", self.inner_passing)

    @property
    def keeps_motion(self) -> bool:
        """Whether every vehicle is assumed to keep its current motion, as in the paper."""
        return self.assumed_braking == self.assumed_acceleration == 0.0

    @classmethod
    def paper(cls) -> Self:
        """Return settings with the paper's assumption: every vehicle is known and keeps its motion.

        Returns
        -------
        settings : EvasionSettings
            For the paper's figures only.
        """
        return cls(assumed_braking=0.0, assumed_acceleration=0.0, awareness_range=math.inf)

    @classmethod
    def cautious(cls) -> Self:
        """Return settings that assume no reaction of other drivers.

        Returns
        -------
        settings : EvasionSettings
            Vehicles behind in the adjacent lane may accelerate with 3 m/s^2 for the whole maneuver.
        """
        return cls(rear_reaction_time=0.0)

    @classmethod
    def traffic(cls) -> Self:
        """Return settings that ordinary overtaking needs.

        Returns
        -------
        settings : EvasionSettings
            Drivers behind react within 1 s, and none brakes with more than 6 m/s^2 or accelerates with more
            than 1.5 m/s^2, the usual limits of car-following models.
        """
        return cls(
            assumed_braking=6.0, assumed_acceleration=1.5, rear_reaction_time=1.0, rear_braking=3.0,
            x_safety=5.0,
        )  # fmt: skip
