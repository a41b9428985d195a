"""Whether the lane beside is free: danger zones of all that is known, and of what may not be known."""

import math
from collections.abc import Sequence

import numpy as np

from cca_core._checks import Array
from cca_core.decide import danger_zone
from cca_core.path import Lane, Road
from cca_core.planner.frenet import HORIZON, FrenetEgo, FrenetVehicle

__all__ = ["check_adjacent_lane"]

_LANE_ENTRY_TOLERANCE = 0.2  # a body this far over the line is not yet on the lane [m]


def check_adjacent_lane(
    ego: FrenetEgo,
    road: Road,
    lane: Lane | None,
    others: Sequence[FrenetVehicle],
    times: Array,
    *,
    x_safety: float,
    awareness_range: float,
    stale_after: float,
    braking: float,
    acceleration: float,
) -> tuple[tuple[float, float] | None, str]:
    """Ask whether the lane beside is free while the ego's body is on it.

    Parameters
    ----------
    ego : Ego
        The ego and how it intends to drive.
    road : Road
        Route, lanes and speed limit.
    lane : Lane or None
        The lane to be entered, None if there is none.
    others : sequence of Neighbor
        All vehicles but the one that is passed.
    times : ndarray, shape (n,)
        Times from now during which the body is on the lane [s].
    x_safety, awareness_range, stale_after : float
        Distance kept [m], distance up to which all vehicles are known [m], and age from which on a
        vehicle's messages are no longer believed [s].
    braking, acceleration : float
        Largest deceleration and acceleration of others that are provided for [m/s^2].

    Returns
    -------
    zone : tuple of float or None
        Rear and front end of the danger zone that comes nearest to the ego's body [m], relative to the ego.
    obstruction : str
        Why the lane is not free, in words; empty if it is.
    """
    if lane is None:
        return None, "there is no lane"
    if awareness_range == 0.0:
        return None, "the lane is not known to be free"
    grid = np.arange(0.0, HORIZON, 2.0)
    driven = np.interp(times, ego.arrival_times(ego.s + grid), grid)
    half = 0.5 * ego.vehicle.length
    worst: tuple[tuple[float, float] | None, str] = (None, "")
    least = math.inf
    stale = [o.remote.id for o in others if _overlaps_lane(o, lane) and o.remote.age > stale_after]
    if stale:
        return None, f"nothing is heard of {stale[0]} any more"
    for name, rear, front, v_s, age, known in _vehicles_in_lane(lane, ego, road, others, awareness_range):
        zone = danger_zone(
            rear, front, v_s, times=times, ego_travel=driven, x_safety=x_safety, age=age,
            braking=braking * known, acceleration=acceleration * known,
        )  # fmt: skip
        gap = max(float(zone[0]) - half, -half - float(zone[1]))
        if gap < least:
            least, blocked = gap, f"{name} is in the way" if gap <= 0.0 else ""
            worst = (float(zone[0]), float(zone[1])), blocked
    return worst


def _overlaps_lane(other: FrenetVehicle, lane: Lane) -> bool:
    return (
        other.d + other.half_width > lane.right + _LANE_ENTRY_TOLERANCE
        and other.d - other.half_width < lane.left - _LANE_ENTRY_TOLERANCE
    )


def _vehicles_in_lane(
    lane: Lane, ego: FrenetEgo, road: Road, others: Sequence[FrenetVehicle], awareness_range: float
) -> list[tuple[str, float, float, float, float, bool]]:
    """Name, rear and front relative to the ego, speed, age and whether it is known, of all on a lane."""
    center = ego.s + ego.vehicle.box_offset
    found = [
        (
            o.remote.id,
            o.s - o.half_length - center,
            o.s + o.half_length - center,
            o.v_s,
            o.remote.age,
            True,
        )
        for o in others
        if _overlaps_lane(o, lane)
    ]
    if math.isfinite(awareness_range):
        edge, v = (
            (awareness_range, -road.speed_limit)
            if lane.direction < 0
            else (-awareness_range, road.speed_limit)
        )
        found.append(("a vehicle out of range", edge, edge, v, 0.0, False))
    return found
