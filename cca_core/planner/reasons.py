"""Reasons: what the ego does and why, from the plan that it drives; made anew in every cycle."""

import math

import numpy as np

from cca_core._checks import Array
from cca_core.decide import Decision
from cca_core.decide.action import explained
from cca_core.frenet import FrenetVehicle
from cca_core.planner.modes import ACTIONS
from cca_core.planner.records import DrivenPlan, Mode, Observation, PathKind
from cca_core.planner.scene import TIMES
from cca_core.vehicle import VehicleParams

_NOISE = 0.1  # a smaller acceleration needs no explanation [m/s^2]


def explain(
    mode: Mode,
    plan: DrivenPlan,
    observation: Observation,
    a_x: float,
    vehicle: VehicleParams,
    cap: tuple[Array, Array],
) -> Decision:
    """Return the decision that a mode, its plan and its acceleration mean."""
    vehicles = {n.id: n for n in observation.vehicles}
    action = ACTIONS[mode]
    lead = vehicles.get(plan.limited_by)
    if mode in (Mode.EVADE_LEFT, Mode.EVADE_RIGHT):
        side = "left" if mode is Mode.EVADE_LEFT else "right"
        if plan.path.change:
            arrival = _time_at(plan, plan.path.end) - (observation.t - plan.t)
            cause = f"there in {max(arrival, 0.0):.1f} s" if math.isfinite(arrival) else "the lane is clear"
            if lead is not None:
                cause = f"behind {lead.id}, {cause}"
            return explained(
                action, f"changing to the {plan.path.change} lane", cause, lead_id=plan.limited_by or None
            )
        name = ", ".join(sorted(plan.path.overtaken)) or "the vehicle"
        back = _time_at(plan, plan.path.end) - (observation.t - plan.t)
        until = f"back in ego lane in {max(back, 0.0):.1f} s" if math.isfinite(back) else "returning"
        if a_x < -1.0 and lead is not None:
            until = f"braking for {lead.id}; {until}"
        return explained(action, f"passing {name} on the {side}", until, lead_id=_first(plan))
    if mode is Mode.RETURN:
        return explained(
            action,
            "returning to the ego lane",
            _why(plan) or "the maneuver ended",
            lead_id=plan.limited_by or None,
        )
    if plan.yields_to and plan.limited_by.startswith("yield"):
        n = vehicles.get(plan.yields_to)
        away = "" if n is None else f" ({abs(n.s - observation.s):.0f} m ahead)"
        return explained(
            action,
            f"yielding to {plan.yields_to}",
            "it crosses the route",
            numbers=away,
            lead_id=plan.yields_to,
        )
    if mode is Mode.BRAKE or (mode is Mode.FOLLOW and lead is None):
        named = (plan.impact_id, plan.limited_by, plan.yields_to)
        cause_id = next((each for each in named if each in vehicles), None)
        limit = _limit_ahead(observation, cap) if cause_id is None and a_x < -_NOISE else None
        if limit:
            return explained(action, *limit)
        verb = "braking" if a_x < -_NOISE else "releasing the brakes" if a_x < 0.0 else "following"
        activity = verb if cause_id is None else f"{verb} {'' if verb == 'following' else 'for '}{cause_id}"
        needs = f"needs {-a_x:.1f} m/s²" if a_x < -_NOISE else f"drives {observation.v:.1f} m/s"
        cause = f"{needs}; {_why(plan) or 'no faster plan is certified'}"
        return explained(action, activity, cause, lead_id=cause_id)
    if lead is not None and (mode is Mode.FOLLOW or a_x < -0.2):
        gap = lead.rear - observation.s - vehicle.front
        stands = abs(float(lead.v_s)) < 0.5
        activity = f"stopping behind {lead.id}" if stands else f"following {lead.id}"
        numbers = f" ({'stationary' if stands else f'{lead.v_s:.1f} m/s'}, gap {gap:.0f} m)"
        return explained(
            action, activity, _why(plan) or "its speed limits the ego's", numbers=numbers, lead_id=lead.id
        )
    if plan.waiting is not None:
        return explained(action, str(plan.waiting), plan.waiting.cause)
    if plan.path.kind.is_evasive and observation.s < plan.path.begin:
        side = "left" if plan.path.kind is PathKind.LEFT else "right"
        cause = f"{side} maneuver feasible, starts in {plan.path.begin - observation.s:.0f} m"
        return explained(action, f"approaching {_first(plan)}", cause, lead_id=_first(plan))
    limit = _limit_ahead(observation, cap) if a_x < -_NOISE else None
    if limit:
        return explained(action, *limit)
    if lead is not None:
        gap = lead.rear - observation.s - vehicle.front
        return explained(
            action, "keeping lane", f"{lead.id} {gap:.0f} m ahead, no action needed yet", lead_id=lead.id
        )
    nearest = _ahead(observation, vehicle)
    if nearest is not None or a_x < -_NOISE:
        cause = "releasing the brakes" if a_x < -_NOISE else "no action needed for the vehicles around"
        return explained(action, f"keeping lane at {observation.v:.1f} m/s", cause)
    return explained(action, f"keeping lane at {observation.v:.1f} m/s", "no blocking vehicle")


def _why(plan: DrivenPlan) -> str:
    """Text of the rejections of other plans."""
    if plan.waiting is not None:
        return f"{plan.waiting}: {plan.waiting.cause}"
    return "; ".join(dict.fromkeys(str(r) for r in plan.rejections))


def _first(plan: DrivenPlan) -> str | None:
    return min(plan.path.overtaken, default=None)


def _ahead(observation: Observation, vehicle: VehicleParams) -> FrenetVehicle | None:
    return next(
        (n for n in observation.vehicles if abs(n.d) < 2.0 and n.rear > observation.s + vehicle.front), None
    )


def _time_at(plan: DrivenPlan, s: float) -> float:
    """Time from the decision on at which the plan reaches a station [s]."""
    return float(np.interp(s, plan.s, TIMES, right=math.inf))


def _limit_ahead(observation: Observation, cap: tuple[Array, Array]) -> tuple[str, str] | None:
    """Return what slows the ego on the route: a curve, the end or the cruise speed."""
    stations, squared = cap
    v = observation.v
    reach = observation.s + v * v / 2.0 + 30.0
    ahead = slice(*np.searchsorted(stations, (observation.s, reach)))
    if ahead.start >= ahead.stop:
        return f"slowing to {v:.1f} m/s", "the route ends"
    x, limit = stations[ahead] - observation.s, squared[ahead]
    need = (v * v - limit) / (2.0 * np.maximum(x, 1.0))
    i = int(np.argmax(need))
    if need[i] < 0.05:
        return None
    end = float(stations[-1]) - 200.0
    low = int(np.argmin(limit))
    if limit[low] <= 0.01:
        return "stopping", f"route ends in {max(end - observation.s, 0.0):.0f} m"
    return f"slowing to {math.sqrt(limit[low]):.1f} m/s", f"curve or speed limit in {x[low]:.0f} m"
