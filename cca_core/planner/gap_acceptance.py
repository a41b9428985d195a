"""Gap acceptance: danger zones of the known vehicles in the adjacent lane, and of an assumed one."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cca_core._checks import Array
from cca_core.band import Side
from cca_core.decide import Rejection, RejectionKind, danger_zone
from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.path import Lane, Road
from cca_core.planner.settings import EvasionSettings
from cca_core.planner.window import HORIZON


class _Body(NamedTuple):
    """A body in the lane: ends relative to the ego [m], speed [m/s], its rate [m/s^2], age [s], known id."""

    rear: float
    front: float
    v_s: float
    rate: float
    age: float
    vehicle_id: str | None


def check_adjacent_lane(
    ego: FrenetEgo,
    road: Road,
    lane: Lane | None,
    side: Side,
    others: Sequence[FrenetVehicle],
    settings: EvasionSettings,
    awareness_range: float,
    times: Array,
) -> tuple[tuple[float, float] | None, Rejection | None]:
    """Return the closest danger zone while the ego's body is in the lane, and why the gap is rejected."""
    if lane is None:
        return None, Rejection(kind=RejectionKind.NO_LANE, side=side)
    if awareness_range == 0.0:
        return None, Rejection(kind=RejectionKind.UNAWARE, side=side, value=0.0)
    in_lane = [o for o in others if _overlaps_lane(o, lane, settings.lane_entry_tolerance)]
    for o in in_lane:
        if o.remote.age > settings.stale_after:
            return None, Rejection(
                kind=RejectionKind.STALE, side=side, vehicle_id=o.id, value=o.remote.age,
                limit=settings.stale_after,
            )  # fmt: skip
    grid = np.arange(0.0, HORIZON, 2.0)
    traveled = np.interp(times, ego.arrival_times(ego.s_cg + grid), grid)
    half = 0.5 * ego.vehicle.length
    closest: tuple[tuple[float, float] | None, Rejection | None] = None, None
    min_gap = math.inf
    for body in _bodies_in_lane(lane, ego, road, in_lane, awareness_range):
        braking, acceleration = settings.assumed_braking, settings.assumed_acceleration
        rate = body.rate if braking or acceleration else 0.0
        if body.vehicle_id is None:  # the assumed vehicle keeps the speed limit
            braking = acceleration = 0.0
        zone = danger_zone(
            body.rear, body.front, body.v_s, times=times, ego_travel=traveled, x_safety=settings.x_safety,
            age=body.age, braking=max(braking, -rate), acceleration=max(acceleration, rate), a_reported=rate,
        )  # fmt: skip
        gap = max(float(zone[0]) - half, -half - float(zone[1]))
        if gap < min_gap:
            min_gap = gap
            rejection = None if gap > 0.0 else _reject_gap(body, side, half, awareness_range)
            closest = (float(zone[0]), float(zone[1])), rejection
    return closest


def _reject_gap(body: _Body, side: Side, half_length: float, awareness_range: float) -> Rejection:
    """Rejection of a gap because of a body in the lane."""
    if body.vehicle_id is None:
        return Rejection(
            kind=RejectionKind.BEYOND_AWARENESS, side=side, value=abs(body.v_s), limit=awareness_range
        )
    ahead, behind = body.rear - half_length, -body.front - half_length
    distance = ahead if ahead > 0.0 else min(-behind, 0.0)
    return Rejection(
        kind=RejectionKind.LANE_BLOCKED, side=side, vehicle_id=body.vehicle_id, distance=distance,
        value=abs(body.v_s),
    )  # fmt: skip


def _overlaps_lane(other: FrenetVehicle, lane: Lane, tolerance: float) -> bool:
    return (
        other.d + other.half_width > lane.right + tolerance
        and other.d - other.half_width < lane.left - tolerance
    )


def _bodies_in_lane(
    lane: Lane, ego: FrenetEgo, road: Road, vehicles: Sequence[FrenetVehicle], awareness_range: float
) -> list[_Body]:
    """Known vehicles in a lane, and the one assumed at the end of the awareness range."""
    found = [
        _Body(
            o.s - o.half_length - ego.s, o.s + o.half_length - ego.s, o.v_s, o.speed_rate, o.remote.age, o.id
        )
        for o in vehicles
    ]
    if math.isfinite(awareness_range):
        oncoming = lane.direction < 0
        s, v = (awareness_range, -road.speed_limit) if oncoming else (-awareness_range, road.speed_limit)
        found.append(_Body(s, s, v, 0.0, 0.0, None))
    return found
