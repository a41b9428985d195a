"""The stretch of road around the ego: its lanes as narrow as they are there, and its legal speed."""

import math
from collections.abc import Callable
from dataclasses import replace

from cca_core.band import Side
from cca_core.path import Lane, Road

BEHIND, AHEAD = 60, 800
"""Part of the route around the ego on which paths are defined [m]."""

_RELEVANT_BEHIND, _RELEVANT_AHEAD = 200.0, 800.0  # in which other vehicles are relevant [m]


def varies(road: Road) -> bool:
    """Return whether a lane begins, ends or changes its width."""
    return any(lane.boundaries for lane in road.lanes)


def narrowed(lane: Lane, start: float, end: float) -> Lane | None:
    """Return a lane as narrow as it is on a stretch; None if it does not exist over the whole of it."""
    if not lane.boundaries:
        return lane
    bounds = lane.inner_bounds(start, end)
    if bounds is None or not bounds[0] < bounds[1]:
        return None
    return replace(lane, d=0.5 * (bounds[0] + bounds[1]), width=bounds[1] - bounds[0], boundaries=())


def ego_lane_near(road: Road, s: float) -> Lane:
    """Return the ego lane as narrow as it is around the ego."""
    path = road.path
    start = min(max(s - BEHIND, path.start), path.end)
    end = min(max(s + AHEAD, path.start), path.end)
    return narrowed(road.ego_lane, start, end) or road.ego_lane


def adjacent_lanes(road: Road, side: Side, s: float) -> tuple[Lane, ...]:
    """Return the lanes next to the ego lane on a side, from a station on as far as paths are defined."""
    ego_lane, is_left = road.ego_lane, side == "left"
    if not varies(road):
        lane = road.lane_at(ego_lane.left + 0.1 if is_left else ego_lane.right - 0.1)
        return () if lane is None else (lane,)
    found, s = [], max(s, road.path.start)
    for lane in road.lanes:
        first, last = max(s, lane.start), min(s + AHEAD, road.path.end, lane.end)
        middle = 0.5 * (first + last)
        bounds, own = lane.bounds_at(middle), ego_lane.bounds_at(middle)
        if lane is ego_lane or bounds is None or own is None or first >= last:
            continue
        if bounds[0] <= (own[1] + 0.1 if is_left else own[0] - 0.1) <= bounds[1]:
            found.append(lane)
    return tuple(found)


def highest_speed(road: Road, s: float, known: float = 0.0) -> float:
    """Return the highest legal speed where other vehicles are relevant, at least as far as they are known."""
    return road.highest_limit(s - max(known, _RELEVANT_BEHIND), s + max(known, _RELEVANT_AHEAD))


def road_numbers(road: Road, s: float) -> dict[str, float]:
    """Return lanes and legal speed around the ego as numbers of a scene."""
    lane = ego_lane_near(road, s)
    return {
        "lane_right": lane.right, "lane_left": lane.left, "v_limit": highest_speed(road, s),
        "edge_left": _edge(adjacent_lanes(road, "left", s), max, 1, math.inf),
        "edge_right": _edge(adjacent_lanes(road, "right", s), min, 0, -math.inf),
    }  # fmt: skip


def _edge(lanes: tuple[Lane, ...], outermost: Callable[..., float], side: int, otherwise: float) -> float:
    """Return the far boundary of adjacent lanes where they are widest."""
    return outermost((lane.outer_bounds[side] for lane in lanes), default=otherwise)
