"""Lanelets: pieces of lane between two bounds, the way through them, and the center line of that way."""

import heapq
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.geometry import quintic_step, wrap_angle

__all__ = ["Lanelet", "centerline", "extend_straight", "find_route", "inside"]

_CHANGE = 50.0  # detour that is worth a lane change [m]
_LATER = 1e-3  # extra cost of a lane change per meter driven before it [-]
_CHANGE_TIME = 4.0  # duration of a lane change [s]
_STEP = 2.0  # between points of a lane change [m]
_REPEATED = 0.1  # points nearer to each other than this are one [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Lanelet:
    """A piece of one lane.

    Parameters
    ----------
    id : int
        Its name in the file [-].
    left, right : ndarray, shape (n, 2)
        Its bounds in driving direction [m], point by point beside each other.
    predecessors, successors : tuple of int
        Lanelets from which and into which it leads.
    on_left, on_right : tuple of (int, int) or None
        Lanelet beside it and that one's direction, 1 along this one and -1 against it; None for none.
    """

    id: int
    left: Array
    right: Array
    predecessors: tuple[int, ...] = ()
    successors: tuple[int, ...] = ()
    on_left: tuple[int, int] | None = None
    on_right: tuple[int, int] | None = None

    @property
    def center(self) -> Array:
        """Center line [m], shape (n, 2)."""
        middle: Array = 0.5 * (self.left + self.right)
        return middle

    @property
    def outline(self) -> Array:
        """Border as a polygon [m], shape (2 n, 2)."""
        return np.vstack((self.left, self.right[::-1]))

    @property
    def length(self) -> float:
        """Length of the center line [m]."""
        return float(_arc_length(self.center)[-1])

    @property
    def width(self) -> float:
        """Least distance between points of both bounds that lie beside each other [m]."""
        return float(np.hypot(*(self.left - self.right).T).min())

    def heading_at(self, x: float, y: float) -> float:
        """Direction of the center line beside a point.

        Parameters
        ----------
        x, y : float
            The point [m].

        Returns
        -------
        psi : float
            Heading [rad] of the nearest chord, counter-clockwise from +x.
        """
        center = self.center
        chord = np.diff(center, axis=0)
        square = np.maximum(np.sum(chord * chord, axis=1), 1e-12)
        share = np.clip(np.sum(((x, y) - center[:-1]) * chord, axis=1) / square, 0.0, 1.0)
        off = center[:-1] + share[:, None] * chord - (x, y)
        i = int(np.argmin(np.sum(off * off, axis=1) + 1e12 * (square <= 1e-12)))
        return math.atan2(chord[i, 1], chord[i, 0])


def inside(polygon: Array, x: float, y: float) -> bool:
    """Whether a point lies in a polygon.

    Parameters
    ----------
    polygon : ndarray, shape (n, 2)
        Its corners in order [m].
    x, y : float
        The point [m].

    Returns
    -------
    inside : bool
        True if a ray from the point crosses the border an odd number of times.
    """
    a, b = polygon, np.roll(polygon, -1, axis=0)
    spans = (a[:, 1] > y) != (b[:, 1] > y)
    a, b = a[spans], b[spans]
    at = a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    return bool(np.count_nonzero(at > x) % 2)


def find_route(lanelets: Mapping[int, Lanelet], start: int, goals: Sequence[int]) -> tuple[int, ...]:
    """Find the shortest way from one lanelet to one of several (Dijkstra's search).

    Parameters
    ----------
    lanelets : mapping of int to Lanelet
        The road network.
    start : int
        Where it begins.
    goals : sequence of int
        Where it may end.

    Returns
    -------
    route : tuple of int
        Lanelets in driving order, each a successor of the one before or beside it with the same direction;
        empty if there is no way. A lane change costs as much as 50 m, and a little more the later it is.
    """
    queue: list[tuple[float, tuple[int, ...]]] = [(0.0, (start,))]
    done: set[int] = set()
    while queue:
        cost, way = heapq.heappop(queue)
        here = lanelets[way[-1]]
        if here.id in goals:
            return way
        if here.id in done:
            continue
        done.add(here.id)
        steps = [(cost + here.length, after) for after in here.successors]
        change = (1.0 + _LATER) * cost + _CHANGE
        steps += [
            (change, beside[0]) for beside in (here.on_left, here.on_right) if beside and beside[1] == 1
        ]
        for total, after in steps:
            if after not in done:
                heapq.heappush(queue, (total, (*way, after)))
    return ()


def extend_straight(lanelets: Mapping[int, Lanelet], route: Sequence[int], length: float) -> tuple[int, ...]:
    """Go on behind a route, always into the successor that turns least.

    Parameters
    ----------
    lanelets : mapping of int to Lanelet
        The road network.
    route : sequence of int
        Lanelets so far, at least one.
    length : float
        How far to go on behind the last one [m].

    Returns
    -------
    route : tuple of int
        The longer route; it ends early where the map ends or where it would meet itself.
    """
    way = list(route)
    while length > 0.0:
        here = lanelets[way[-1]]
        onwards = [lanelets[i] for i in here.successors if i not in way]
        if not onwards:
            break
        along = _direction(here.center[-2:])
        after = min(onwards, key=lambda lane: abs(wrap_angle(_direction(lane.center[-2:]) - along)))
        way.append(after.id)
        length -= after.length
    return tuple(way)


def centerline(
    lanelets: Mapping[int, Lanelet], route: Sequence[int], start: tuple[float, float], v_x: float
) -> Array:
    """Center line of a route, with a gentle change where it goes over to the lane beside.

    Parameters
    ----------
    lanelets : mapping of int to Lanelet
        The road network.
    route : sequence of int
        Lanelets as `find_route` gives them.
    start : tuple of float
        Where the car is [m]; a change in the first lanelet begins there.
    v_x : float
        Its speed [m/s]: a change of one lane takes four seconds, or what the lanelet leaves.

    Returns
    -------
    xy : ndarray, shape (n, 2)
        Points of the line [m], no two neighbors equal.

    Raises
    ------
    InputError
        If fewer than two different points are left.
    """
    groups: list[list[Lanelet]] = []  # lanelets beside each other, in the order in which they are driven
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
            parts.append(_change(group, start if i == 0 else None, v_x))
    points = np.vstack(parts)
    kept = [points[0]]
    for point in points[1:]:
        if math.dist(point, kept[-1]) > _REPEATED:
            kept.append(point)
    if len(kept) < 2:
        raise InputError(f"route {tuple(route)} must have a length")
    return np.array(kept)


def _change(group: list[Lanelet], start: tuple[float, float] | None, v_x: float) -> Array:
    """Line from the first of some lanelets beside each other to the last."""
    length, changes = group[0].length, len(group) - 1
    share = np.linspace(0.0, 1.0, math.ceil(length / _STEP) + 1)
    lines = np.array([_resample(lane.center, share) for lane in group])
    begin = 0.0
    if start is not None:
        begin = float(share[np.argmin(np.hypot(*(lines[0] - start).T))])
    duration = max(min(changes * _CHANGE_TIME * v_x / length, 1.0 - begin), 1e-3)
    u = np.clip((share - begin) / duration, 0.0, 1.0)
    place = quintic_step(u, changes)
    lower = np.minimum(place.astype(np.intp), changes - 1)
    weight, rows = (place - lower)[:, None], np.arange(len(share))
    line: Array = (1.0 - weight) * lines[lower, rows] + weight * lines[lower + 1, rows]
    return line


def _resample(line: Array, share: Array) -> Array:
    s = _arc_length(line)
    return np.column_stack([np.interp(share * s[-1], s, line[:, i]) for i in (0, 1)])


def _arc_length(line: Array) -> Array:
    return np.append(0.0, np.cumsum(np.hypot(*np.diff(line, axis=0).T)))


def _direction(ends: Array) -> float:
    return math.atan2(ends[-1, 1] - ends[0, 1], ends[-1, 0] - ends[0, 0])
