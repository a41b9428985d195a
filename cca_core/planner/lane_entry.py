"""Entry into a lane for good: distance to the vehicles ahead, and how the ego waits for a gap."""

import math
from collections.abc import Sequence

import numpy as np

from cca_core.decide import Rejection, RejectionKind
from cca_core.frenet import FrenetVehicle
from cca_core.planner.candidates import lane_rejection
from cca_core.planner.paths import Surroundings
from cca_core.planner.records import LaneWish, Plan, Waiting
from cca_core.planner.scene import TIMES
from cca_core.planner.tuning import LaneChangeSettings

__all__ = ["entry_rejection", "waiting_for", "waiting_speed"]


def entry_rejection(
    around: Surroundings, plan: Plan, arrival: float, home_acceleration: float
) -> Rejection | None:
    """Return why a plan arrives too close behind a vehicle of its new lane; None if it does not.

    It keeps the distance of RSS to the nominal motion of others, and a change that has not begun brakes
    little behind them: not harder than in the ego lane, or not beyond what the settings allow.
    """
    traffic, limits, settings = around.traffic, around.limits, around.settings
    k = int(np.searchsorted(TIMES, arrival))
    if not _is_there(around, plan, k):
        return Rejection(kind=RejectionKind.NO_LANE, side=plan.path.side)
    v, front = float(plan.v[k]), float(plan.s[k]) + around.lateral.base + around.vehicle.front
    reach = traffic.half_w + 0.5 * around.vehicle.width
    ahead = (np.abs(traffic.d[:, k] - plan.d[k]) < reach) & (traffic.s[:, k] > front) & ~traffic.crosses
    gap = traffic.s[:, k] - traffic.half_l - front
    lead = np.maximum(traffic.v[:, k], 0.0)
    alone = v * settings.certificate.reaction_time + v * v / (2.0 * limits.b_max)
    need = alone - lead**2 / (2.0 * max(settings.assumed_braking, limits.b_max))
    close = gap < np.maximum(need, settings.x_safety)
    if not plan.path.is_last and float(plan.a.min()) < min(home_acceleration, -_allowed_braking(around)):
        close |= gap == np.min(gap, where=ahead, initial=math.inf)
    rows = np.flatnonzero(ahead & close)
    return lane_rejection(around, plan.path.kind, int(rows[0])) if len(rows) else None


def _is_there(around: Surroundings, plan: Plan, arrival: int) -> bool:
    """Whether the body is inside the ego lane and the new one up to the arrival."""
    lane, half = plan.path.to_lane, 0.5 * around.vehicle.width
    if lane is None or not lane.boundaries:
        return True
    at, right, left = np.array(lane.boundaries).T
    part = slice(0, arrival + 1)
    s, d = plan.s[part] + around.lateral.base + around.vehicle.front, plan.d[part]
    inside = (d - half >= around.lane.right) & (d + half <= around.lane.left)
    low, high = (np.interp(s, at, bound, left=math.nan, right=math.nan) for bound in (right, left))
    is_left = plan.path.change == "left"
    return bool(np.all(inside | ((d + half <= high) if is_left else (d - half >= low))))


def _allowed_braking(around: Surroundings) -> float:
    """Return the deceleration with which a change may begin [m/s^2]: it grows while the ego waits."""
    settings, waited = around.settings.change, 0.0 if around.wish is None else around.wish.waited
    impatience = min(waited / settings.patience, 1.0)
    return settings.braking + (settings.last_braking - settings.braking) * impatience


def waiting_for(wish: LaneWish | None, plans: Sequence[Plan], best: Plan) -> Waiting | None:
    """Return why the ego does not change to the lane that was requested; None if it does."""
    if wish is None or best.path.to_lane is not None:
        return None
    refused = [p for p in plans if p.path.to_lane is not None and p.rejection is not None]
    return Waiting(wish.side, min(refused, key=lambda p: p.cost).rejection if refused else None)


def waiting_speed(
    waiting: Waiting | None, vehicles: Sequence[FrenetVehicle], v: float, free: float,
    settings: LaneChangeSettings,
) -> float:  # fmt: skip
    """Return the speed that lets a vehicle pass that is about as fast and blocks the lane [m/s]."""
    blocking = "" if waiting is None or waiting.rejection is None else waiting.rejection.vehicle_id
    n = next((n for n in vehicles if n.id == blocking), None) if blocking else None
    if n is None or not -settings.passing_speed < n.v_s - free < settings.speed_loss:
        return math.inf  # the ego passes it, or it passes the ego
    return max(n.v_s - settings.speed_loss, v - settings.speed_step, 0.0)
