"""Replanning: maneuver levels, candidates of both sides, and the next step of an ongoing maneuver."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

from cca_core.band import Side
from cca_core.decide import Candidate, Rejection
from cca_core.errors import Status
from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.geometry import box_gap
from cca_core.path import Road
from cca_core.planner.abort import plan_abort, plan_early_return
from cca_core.planner.maneuver import Maneuver, plan_maneuver, predicted_occupancy
from cca_core.planner.settings import EvasionSettings
from cca_core.vehicle import GRAVITY, VehicleParams

__all__ = ["Outcome", "ReplanResult", "maneuver_levels", "plan_candidates", "replan"]

_SIDES: tuple[Side, Side] = ("left", "right")


class Outcome(Enum):
    """What becomes of an ongoing maneuver."""

    CONTINUED = "continued"
    CANCELED = "maneuver canceled"
    ABORTED = "returning behind the lead vehicle"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReplanResult:
    """The maneuver to drive now, None if it is canceled, and why it is not driven to its end."""

    maneuver: Maneuver | None
    status: Status = Status.OK
    outcome: Outcome = Outcome.CONTINUED
    rejection: Rejection | None = None

    @property
    def reason(self) -> str:
        """Outcome in words; empty if the maneuver continues."""
        return "" if self.outcome is Outcome.CONTINUED else f"{self.outcome.value}: {self.rejection}"


def maneuver_levels(
    settings: EvasionSettings, vehicle: VehicleParams
) -> tuple[tuple[EvasionSettings, Status], ...]:
    """Return the settings of each maneuver level: comfort, hard, and last resort."""
    grip, resort = vehicle.mu * GRAVITY, settings.last_resort
    hard = replace(settings, lateral_acceleration_limit=resort.grip_fraction * grip)
    last = replace(
        hard, clearance=min(resort.clearance, hard.clearance), min_ttc=resort.min_ttc,
        lateral_acceleration=min(resort.lateral_acceleration, 0.5 * grip),
    )  # fmt: skip
    return (settings, Status.OK), (hard, Status.DEGRADED), (last, Status.DEGRADED)


def plan_candidates(
    ego: FrenetEgo,
    road: Road,
    blocking: Sequence[FrenetVehicle],
    others: Sequence[FrenetVehicle],
    levels: Sequence[tuple[EvasionSettings, Status]],
    *,
    start_now: bool,
    braking_insufficient: bool = False,
    awareness_range: float = math.inf,
) -> tuple[dict[str, Maneuver], list[Candidate], Status]:
    """Plan both sides at the first level with a feasible candidate; of the best level if there is none."""
    found: list[tuple[dict[str, Maneuver], list[Candidate], Status]] = []
    attempts = [(settings, status, blocking) for settings, status in levels]
    if braking_insufficient:  # a collision is certain otherwise: pass the nominal positions
        attempts.append((*levels[-1], [b.nominal() for b in blocking]))
    for settings, status, overtaken in attempts:
        plans: dict[str, Maneuver] = {}
        candidates = []
        for side in _SIDES:
            plan = plan_maneuver(
                ego, road, overtaken, others, side, settings, start_now=start_now,
                awareness_range=awareness_range,
            )  # fmt: skip
            if isinstance(plan, Maneuver):
                plans[side] = plan
                plan = plan.candidate
            candidates.append(plan)
        found.append((plans, candidates, status))
        if not all(c.rejection for c in candidates):
            return found[-1]
    return found[0]


def replan(
    ego: FrenetEgo,
    road: Road,
    maneuver: Maneuver,
    overtaken: Sequence[FrenetVehicle],
    others: Sequence[FrenetVehicle],
    levels: Sequence[tuple[EvasionSettings, Status]],
    *,
    within_lane: bool,
    following_feasible: bool,
    awareness_range: float = math.inf,
) -> ReplanResult:
    """Replan at the first feasible level; else cancel, continue while clear, return early, or abort."""
    rejection: Rejection | None = None
    for settings, status in levels:
        plan = plan_maneuver(
            ego, road, overtaken, others, maneuver.side, settings, maneuver, cancellable=within_lane,
            awareness_range=awareness_range,
        )  # fmt: skip
        rejection = plan.candidate.rejection if isinstance(plan, Maneuver) else plan.rejection
        if isinstance(plan, Maneuver) and rejection is None:
            return ReplanResult(maneuver=plan, status=status)
        if within_lane and following_feasible:
            return ReplanResult(maneuver=None, outcome=Outcome.CANCELED, rejection=rejection)
    vehicles, settings = sorted((*overtaken, *others), key=lambda n: n.s), levels[0][0]
    clearance = math.inf if within_lane else _remaining_clearance(ego, road, maneuver, vehicles, settings)
    if clearance < settings.replan.abort_clearance:
        early = plan_early_return(ego, road, maneuver, vehicles, rejection, settings.abort)
        if early is not None:
            return ReplanResult(maneuver=early, status=Status.DEGRADED)
        back = plan_abort(ego, road, maneuver, vehicles, rejection, settings.abort)
        if back is not None:
            return ReplanResult(
                maneuver=back, status=Status.DEGRADED, outcome=Outcome.ABORTED, rejection=rejection
            )
    return ReplanResult(maneuver=maneuver, status=Status.DEGRADED)


def _remaining_clearance(
    ego: FrenetEgo, road: Road, maneuver: Maneuver, others: Sequence[FrenetVehicle], settings: EvasionSettings
) -> float:
    """Least clearance to the predicted occupancy if the maneuver is driven unchanged [m]."""
    behind = 2.0  # nodes up to this far behind the ego still count, as its body does [m]
    remaining = maneuver.stations >= ego.s_cg - behind
    s = maneuver.stations[remaining]
    lane = road.ego_lane
    relevant = [o for o in others if not ego.is_followed_by(o, lane.right, lane.left)]
    if len(s) < 2 or not relevant:
        return math.inf
    t, body = ego.arrival_times(s), ego.swept_boxes(road.path, s, maneuver.displacement[remaining])
    return float(box_gap(body, predicted_occupancy(road.path, s, relevant, t, settings)).min())
