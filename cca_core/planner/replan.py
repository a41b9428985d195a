"""Replanning of an ongoing maneuver: continue, cancel, return early or abort."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from cca_core.decide import Rejection
from cca_core.errors import Status
from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.geometry import box_gap
from cca_core.path import Road
from cca_core.planner.abort import plan_abort, plan_early_return
from cca_core.planner.candidates import Levels
from cca_core.planner.maneuver import Maneuver, plan_maneuver, predicted_occupancy
from cca_core.planner.settings import EvasionSettings
from cca_core.planner.window import is_following_ego


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


def replan(
    ego: FrenetEgo,
    road: Road,
    maneuver: Maneuver,
    overtaken: Sequence[FrenetVehicle],
    others: Sequence[FrenetVehicle],
    levels: Levels,
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
    relevant = [o for o in others if not is_following_ego(o, ego, road.ego_lane)]
    if len(s) < 2 or not relevant:
        return math.inf
    t, body = ego.arrival_times(s), ego.swept_boxes(road.path, s, maneuver.displacement[remaining])
    return float(box_gap(body, predicted_occupancy(road.path, s, relevant, t, settings)).min())
