"""Ways around, and going on with one: in comfort, harder, narrower, as it was, or not at all."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from cca_core.band import Side
from cca_core.decide import Candidate
from cca_core.errors import Status
from cca_core.geometry import box_gap
from cca_core.path import Road
from cca_core.planner.abort import plan_abort, plan_early_return
from cca_core.planner.frenet import FrenetEgo, FrenetVehicle
from cca_core.planner.maneuver import MANEUVER_GRIP_FRACTION, Maneuver, plan_maneuver, predicted_occupancy
from cca_core.planner.settings import EvasionSettings
from cca_core.vehicle import GRAVITY, VehicleParams

__all__ = ["ReplanResult", "maneuver_levels", "plan_candidates", "replan"]

_SIDES: tuple[Side, Side] = ("left", "right")
_NARROW = 0.3  # clearance with which it is driven on then [m]
_LEAD_TIME = 0.1  # time to contact at which it must be beside the other at the latest then [s]
_SHARP = 3.5  # peak lateral acceleration that it aims at then, within half the grip [m/s^2]
_ABORT_CLEARANCE = (
    0.1  # distance to others' bounds on the old swerve below which a way back is looked for [m]
)
_BEHIND = 2.0  # nodes this far behind the ego still count [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReplanResult:
    """What has become of a swerve.

    Parameters
    ----------
    maneuver : Evasion or None
        What is driven now, None if it was given up inside the own lane.
    status : Status
        `Status.OK` while it is driven in comfort.
    reason : str
        Why it is not driven on, empty if it is.
    """

    maneuver: Maneuver | None
    status: Status = Status.OK
    reason: str = ""


def maneuver_levels(
    settings: EvasionSettings, vehicle: VehicleParams
) -> tuple[tuple[EvasionSettings, Status], ...]:
    """Ways to drive a swerve, the best first.

    Parameters
    ----------
    settings : EvasionSettings
        As it is meant to be driven.
    vehicle : VehicleParams
        The ego.

    Returns
    -------
    swerves : tuple of (EvasionSettings, Status)
        In comfort, with 80 % of the grip, and with that as narrow, late and sharp as it can be.
    """
    grip = vehicle.mu * GRAVITY
    hard = replace(settings, lateral_acceleration_limit=MANEUVER_GRIP_FRACTION * grip)
    last = replace(
        hard, clearance=min(_NARROW, hard.clearance), min_ttc=_LEAD_TIME,
        lateral_acceleration=min(_SHARP, 0.5 * grip),
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
    """Plan swerves to both sides, in the first way of driving in which one is free.

    Parameters
    ----------
    ego : Ego
        The ego on its lane.
    road : Road
        Route and lanes.
    blocking : sequence of Neighbor
        Vehicles in the way, nearest first.
    others : sequence of Neighbor
        All other vehicles.
    levels : sequence of (EvasionSettings, Status)
        Ways to drive, the best first; those that are to be tried.
    start_now : bool
        Whether a swerve begins now even if there would be time to drive on.
    braking_insufficient : bool
        Whether those in the way are hit for certain otherwise: at last they are where they most likely are.
    awareness_range : float
        Distance up to which all vehicles are known now [m].

    Returns
    -------
    plans : dict of Evasion
        Swerves that could be drawn, by side.
    candidates : list of Candidate
        The same for the choice of action; of the best way where none is free.
    status : Status
        How it would be driven.
    """
    found: list[tuple[dict[str, Maneuver], list[Candidate], Status]] = []
    tries = [(settings, status, blocking) for settings, status in levels]
    if braking_insufficient:
        tries.append((*levels[-1], [b.nominal() for b in blocking]))
    for settings, status, passed in tries:
        plans: dict[str, Maneuver] = {}
        candidates = []
        for side in _SIDES:
            plan = plan_maneuver(
                ego, road, passed, others, side, settings, at_once=start_now, awareness_range=awareness_range
            )
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
    """Bend the band of a swerve for what is known now.

    Parameters
    ----------
    ego : Ego
        The ego, on its way along the swerve.
    road : Road
        Route and lanes.
    maneuver : Evasion
        The swerve as it was.
    overtaken : sequence of Neighbor
        Vehicles that block the route from its start on, nearest first; at least one.
    others : sequence of Neighbor
        All other vehicles.
    levels : sequence of (EvasionSettings, Status)
        Ways to drive it, as `maneuver_levels` gives them.
    within_lane : bool
        Whether the ego has not left its lane yet.
    following_feasible : bool
        Whether it could go on behind what is in front instead.
    awareness_range : float
        Distance up to which all vehicles are known now [m].

    Returns
    -------
    renewal : Renewal
        The swerve in comfort; else, inside the own lane, given up if the ego can follow; else driven harder
        or narrower; else as it was while that stays clear; else back sooner, in front of those passed by
        then; else the way back behind what was to be passed; and where there is none, as it was.
    """
    obstruction = ""
    for settings, status in levels:
        plan = plan_maneuver(
            ego, road, overtaken, others, maneuver.side, settings, maneuver, at_once=within_lane,
            awareness_range=awareness_range,
        )  # fmt: skip
        obstruction = plan.candidate.rejection if isinstance(plan, Maneuver) else plan.rejection
        if isinstance(plan, Maneuver) and not obstruction:
            return ReplanResult(maneuver=plan, status=status)
        if within_lane and following_feasible:
            return ReplanResult(maneuver=None, reason=f"swerve given up: {obstruction}")
    everybody = sorted((*overtaken, *others), key=lambda n: n.s)
    if (
        not within_lane
        and _remaining_clearance(ego, road, maneuver, everybody, levels[0][0]) < _ABORT_CLEARANCE
    ):
        sooner = plan_early_return(ego, road, maneuver, everybody, obstruction)
        if sooner is not None:
            return ReplanResult(maneuver=sooner, status=Status.DEGRADED)
        back = plan_abort(ego, road, maneuver, everybody, obstruction)
        if back is not None:
            return ReplanResult(maneuver=back, status=Status.DEGRADED, reason=f"returning: {obstruction}")
    return ReplanResult(maneuver=maneuver, status=Status.DEGRADED)


def _remaining_clearance(
    ego: FrenetEgo, road: Road, maneuver: Maneuver, others: Sequence[FrenetVehicle], settings: EvasionSettings
) -> float:
    """Least distance between body and bounds [m] if a swerve is driven to its end as it is."""
    left = maneuver.stations >= ego.s - _BEHIND
    s = maneuver.stations[left]
    if len(s) < 2:
        return math.inf
    t, body = ego.arrival_times(s), ego.swept_boxes(road.path, s, maneuver.displacement[left])
    near = [o for o in others if not o.is_following_ego(ego, road.ego_lane.right, road.ego_lane.left)]
    if not near:
        return math.inf
    return float(box_gap(body, predicted_occupancy(road.path, s, near, t, settings)).min())
