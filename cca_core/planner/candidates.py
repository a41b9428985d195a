"""Candidates: maneuvers around the lead vehicle on both sides, at the first feasible level."""

import math
from collections.abc import Sequence
from dataclasses import replace

from cca_core.band import Side
from cca_core.decide import Candidate, LeadVehicle, Rejection, RejectionKind
from cca_core.errors import Status
from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.path import Road
from cca_core.planner.blocking import excluding
from cca_core.planner.lead import vehicles_to_follow
from cca_core.planner.maneuver import Maneuver, plan_maneuver
from cca_core.planner.settings import EvasionSettings
from cca_core.vehicle import GRAVITY, VehicleParams

Levels = Sequence[tuple[EvasionSettings, Status]]
"""Maneuver levels, the most comfortable first, each with the status of its maneuvers."""

Plans = tuple[dict[str, Maneuver], list[Candidate], Status]
"""Maneuvers by side, the candidates, and the status of their level."""

_SIDES: tuple[Side, Side] = ("left", "right")


def maneuver_levels(settings: EvasionSettings, vehicle: VehicleParams) -> Levels:
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
    levels: Levels,
    *,
    start_now: bool,
    braking_insufficient: bool = False,
    awareness_range: float = math.inf,
) -> Plans:
    """Plan both sides at the first level with a feasible candidate; of the best level if there is none."""
    found: list[Plans] = []
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


def plan_around_lead(
    ego: FrenetEgo,
    road: Road,
    lead: LeadVehicle,
    blocking: Sequence[FrenetVehicle],
    vehicles: Sequence[FrenetVehicle],
    levels: Levels,
    *,
    start_now: bool,
    awareness_range: float,
) -> tuple[Plans, set[str]]:
    """Plan maneuvers around the lead vehicle; also return the ids of the vehicles that the ego follows."""
    settings = levels[0][0]
    ahead = [b for b in blocking if b.s > ego.s_cg]
    followed = vehicles_to_follow(ahead, lead, ego, settings.lead)
    ids, max_speed = {n.id for n in followed}, ego.v_target - settings.min_speed_advantage
    if lead.v_x > max_speed:
        kind = RejectionKind.TOO_FAST
        rejection = Rejection(kind=kind, vehicle_id=lead.id, value=lead.v_x, limit=max_speed)
        return ({}, [Candidate(side="left", rejection=rejection)], Status.OK), ids
    grip = settings.actuation.emergency_grip_fraction * ego.vehicle.mu * GRAVITY
    insufficient = lead.required_deceleration > min(ego.speed.b_max, grip)
    plans = plan_candidates(
        ego, road, excluding(ahead, followed), excluding(vehicles, ahead),
        (levels[0], levels[-1]) if insufficient else levels[:1], start_now=start_now,
        braking_insufficient=insufficient, awareness_range=awareness_range,
    )  # fmt: skip
    return plans, ids
