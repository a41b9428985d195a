"""Lanelets, routes along them, and the centerlines of routes."""

import heapq
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.geometry import arc_length, quintic_step, wrap_angle

__all__ = ["Lanelet", "centerline", "extend_straight", "find_route", "inside"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Lanelet:
    """A piece of one lane."""

    id: int
    left: Array  # boundary in driving direction [m], shape (n, 2); faces `right` point by point
    right: Array
    predecessors: tuple[int, ...] = ()  # lanelets before and after it
    successors: tuple[int, ...] = ()
    on_left: tuple[int, int] | None = None  # adjacent lanelet and its direction, 1 along this one, -1 against
    on_right: tuple[int, int] | None = None
    speed_limit: float = math.inf  # legal speed by its signs [m/s]

    @property
    def center(self) -> Array:
        """Centerline [m], shape (n, 2)."""
        middle: Array = 0.5 * (self.left + self.right)
        return middle

    @property
    def outline(self) -> Array:
        """Outline as a polygon [m], shape (2 n, 2)."""
        return np.vstack((self.left, self.right[::-1]))

    @property
    def length(self) -> float:
        """Length of the centerline [m]."""
        return float(arc_length(self.center)[-1])

    @property
    def width(self) -> float:
        """Minimum distance between facing points of both boundaries [m]."""
        return float(np.hypot(*(self.left - self.right).T).min())

    def heading_at(self, x: float, y: float) -> float:
        """Return the heading [rad] of the centerline's chord that is nearest to a point."""
        center = self.center
        chord = np.diff(center, axis=0)
        square = np.maximum(np.sum(chord * chord, axis=1), 1e-12)
        fraction = np.clip(np.sum(((x, y) - center[:-1]) * chord, axis=1) / square, 0.0, 1.0)
        off = center[:-1] + fraction[:, None] * chord - (x, y)
        i = int(np.argmin(np.sum(off * off, axis=1) + 1e12 * (square <= 1e-12)))
        return math.atan2(chord[i, 1], chord[i, 0])


def inside(polygon: Array, x: float, y: float) -> bool:
    """Return whether a point lies in a polygon of corners, shape (n, 2)."""
    # a ray from the point crosses the outline an odd number of times
    a, b = polygon, np.roll(polygon, -1, axis=0)
    spans = (a[:, 1] > y) != (b[:, 1] > y)
    a, b = a[spans], b[spans]
    at = a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    return bool(np.count_nonzero(at > x) % 2)


def find_route(
    lanelets: Mapping[int, Lanelet], start: int, goals: Sequence[int], *, change_cost: float = 50.0
) -> tuple[int, ...]:
    """Find the shortest route to one of several lanelets; empty if there is none."""
    # Dijkstra's search; a lane change costs as much as some meters
    queue: list[tuple[float, tuple[int, ...]]] = [(0.0, (start,))]
    done: set[int] = set()
    while queue:
        cost, route = heapq.heappop(queue)
        here = lanelets[route[-1]]
        if here.id in goals:
            return route
        if here.id in done:
            continue
        done.add(here.id)
        steps = [(cost + here.length, after) for after in here.successors]
        change = (1.0 + 1e-3) * cost + change_cost  # an early change is cheaper
        steps += [(change, pair[0]) for pair in (here.on_left, here.on_right) if pair and pair[1] == 1]
        for total, after in steps:
            if after not in done:
                heapq.heappush(queue, (total, (*route, after)))
    return ()


def extend_straight(lanelets: Mapping[int, Lanelet], route: Sequence[int], length: float) -> tuple[int, ...]:
    """Extend a route by a length [m] along the straightest new successors, if there are any."""
    extended = list(route)
    while length > 0.0:
        here = lanelets[extended[-1]]
        onwards = [lanelets[i] for i in here.successors if i not in extended]
        if not onwards:
            break
        along = _direction(here.center[-2:])
        after = min(onwards, key=lambda lane: abs(wrap_angle(_direction(lane.center[-2:]) - along)))
        extended.append(after.id)
        length -= after.length
    return tuple(extended)


def centerline(
    lanelets: Mapping[int, Lanelet],
    route: Sequence[int],
    start: tuple[float, float],
    v_x: float,
    *,
    change_time: float = 4.0,
) -> Array:
    """Return the centerline of a route [m]; lane changes take `change_time` [s]."""
    groups: list[list[Lanelet]] = []  # adjacent lanelets, in driving order
    for id_ in route:
        lane = lanelets[id_]
        if groups and id_ not in groups[-1][-1].successors:
            groups[-1].append(lane)
        else:
            groups.append([lane])
    parts = []
    for i, group in enumerate(groups):
        if len(group) == 1:
            parts.append(group[0].center)
        else:
            parts.append(_change(group, start if i == 0 else None, v_x * change_time))
    points = np.vstack(parts)
    kept = [points[0]]
    for point in points[1:]:
        if math.dist(point, kept[-1]) > 0.1:
            kept.append(point)
    if len(kept) < 2:
        raise InputError(f"route {tuple(route)} must have a length")
    return np.array(kept)


def _change(group: list[Lanelet], start: tuple[float, float] | None, change_length: float) -> Array:
    """Return a line from the first of some adjacent lanelets to the last, a point every 2 m."""
    length, changes = group[0].length, len(group) - 1
    fraction = np.linspace(0.0, 1.0, math.ceil(length / 2.0) + 1)
    lines = np.array([_resample(lane.center, fraction) for lane in group])
    begin = 0.0
    if start is not None:
        begin = float(fraction[np.argmin(np.hypot(*(lines[0] - start).T))])
    duration = max(min(changes * change_length / length, 1.0 - begin), 1e-3)
    u = np.clip((fraction - begin) / duration, 0.0, 1.0)
    lane_number = quintic_step(u, changes)
    lower = np.minimum(lane_number.astype(np.intp), changes - 1)
    weight, rows = (lane_number - lower)[:, None], np.arange(len(fraction))
    line: Array = (1.0 - weight) * lines[lower, rows] + weight * lines[lower + 1, rows]
    return line


def _resample(line: Array, fraction: Array) -> Array:
    s = arc_length(line)
    return np.column_stack([np.interp(fraction * s[-1], s, line[:, i]) for i in (0, 1)])


def _direction(ends: Array) -> float:
    return math.atan2(ends[-1, 1] - ends[0, 1], ends[-1, 0] - ends[0, 0])
