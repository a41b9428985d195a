"""The same road with another of its lanes as the ego lane."""

import math
from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.path.interpolate import spline_through
from cca_core.path.lane import Lane
from cca_core.path.road import Road

__all__ = ["parallel_road"]

_SPACING = 2.0  # of nodes, at most [m]
_MIN_SCALE = 0.1  # length on the center line of the lane, as a fraction of that on the route [-]


def parallel_road(road: Road, lane: Lane) -> Road:
    """Return a road whose route is the center line of a lane, as far as that lane exists.

    Lanes keep their order. Stations begin where those of the route do, and differ from them in curves.
    """
    path, d = road.path, lane.d
    start, end = max(path.start, lane.start), min(path.end, lane.end)
    if not start < end:
        raise InputError(f"lane must be on the route, was from {lane.start:g} to {lane.end:g} m")
    s = np.linspace(start, end, max(8, math.ceil((end - start) / _SPACING) + 1))
    inside = np.array([_contains(lane, at, d) for at in s.tolist()])
    s = s[np.argmax(inside) : len(s) - np.argmax(inside[::-1])]
    if np.min(1.0 - d * path.curvature(s)) < _MIN_SCALE:
        raise InputError(f"d must be less than the radius of every curve, was {d:g}")
    tangents = path.derivatives(s[[0, -1]])[1]
    tangents /= np.hypot(*tangents.T)[:, None]
    first, last = ((x, y) for x, y in tangents.tolist())
    center_line = spline_through(path.to_cartesian(s, d), float(s[0]), first, last)

    def moved(table: Array) -> Array:
        """Stations in the first column of a table on the new route, increasing beyond it too."""
        at = table[:, 0]
        there = (
            np.interp(at, s, center_line.breaks) + np.minimum(at - s[0], 0.0) + np.maximum(at - s[-1], 0.0)
        )
        return np.column_stack((there, table[:, 1:]))

    lanes = []
    for each in road.lanes:
        rows = np.array(each.boundaries)
        shifted = moved(rows) - (0.0, d, d) if len(rows) else rows
        lanes.append(replace(each, d=each.d - d, boundaries=tuple(map(tuple, shifted.tolist()))))
    return Road(
        center_line, lanes, road.speed_limit, moved(np.reshape(road.stop_lines, (-1, 1)))[:, 0].tolist(),
        None if road.elevation is None else moved(road.elevation), road.sigma_elevation,
        None if road.speed_limits is None else moved(road.speed_limits),
    )  # fmt: skip


def _contains(lane: Lane, s: float, d: float) -> bool:
    """Return whether a lane contains a lateral offset at a station."""
    bounds = lane.bounds_at(s)
    return bounds is not None and bounds[0] < d < bounds[1]
