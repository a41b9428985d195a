"""Edges of a road and boundaries of its lanes as lines along it."""

from typing import NamedTuple

import numpy as np

from cca_core._checks import Array
from cca_core.path import Lane, Road

__all__ = ["RoadLine", "lane_line", "road_lines"]

_SAME = 0.02  # distance at which two lines are one [m]


class RoadLine(NamedTuple):
    """Lateral offsets at stations [m]."""

    s: Array
    d: Array


def lane_line(lane: Lane, s: Array, side: int) -> RoadLine:
    """Return the right (0) or left (1) boundary of a lane, as far as it exists along stations."""
    start, end = max(lane.start, float(s[0])), min(lane.end, float(s[-1]))
    if start > end:
        return RoadLine(np.empty(0), np.empty(0))
    rows = np.array([row[0] for row in lane.boundaries])
    inner = np.concatenate((s, rows))
    at = np.unique(np.concatenate(((start, end), inner[(inner > start) & (inner < end)])))
    bounds = [lane.bounds_at(station) or (0.0, 0.0) for station in at.tolist()]
    return RoadLine(at, np.array(bounds)[:, side])


def road_lines(road: Road, s: Array) -> tuple[list[RoadLine], list[RoadLine]]:
    """Return the right and left edge along stations, and the boundaries between lanes."""
    if not any(lane.boundaries for lane in road.lanes):
        offsets = {lane.right for lane in road.lanes} | {lane.left for lane in road.lanes}
        edges = [road.right_edge, road.left_edge]
        lines = [RoadLine(s, np.full_like(s, d)) for d in (*edges, *sorted(offsets - set(edges)))]
        return lines[:2], lines[2:]
    rows = [row[0] for lane in road.lanes for row in lane.boundaries if s[0] < row[0] < s[-1]]
    at = np.union1d(s, rows)
    edges_at = np.array([road.edges_at(station) for station in at.tolist()])
    edges_along = [RoadLine(at, edges_at[:, side]) for side in (0, 1)]
    between: list[RoadLine] = []
    for lane in road.lanes:
        for side in (0, 1):
            line = lane_line(lane, s, side)
            if len(line.s) and not any(_covers(other, line) for other in (*edges_along, *between)):
                between.append(line)
    return edges_along, between


def _covers(line: RoadLine, other: RoadLine) -> bool:
    """Whether a line is drawn already."""
    if other.s[0] < line.s[0] - _SAME or other.s[-1] > line.s[-1] + _SAME:
        return False
    return bool(np.abs(np.interp(other.s, line.s, line.d) - other.d).max() < _SAME)
