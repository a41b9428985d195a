"""A road from the lines of a map: the center line of the ego's lane and the boundaries of lanes."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cca_core._checks import Array
from cca_core.geometry import arc_length
from cca_core.path import Lane, Path
from cca_core.path.join import Strip, join_strips

__all__ = ["LaneLine", "hermite_path", "lanes_along"]

_DETAIL = 1e-3  # of boundaries [m]
_SNAP = 6.0  # by which lanes of a part begin or end apart, as at the corners of a junction [m]


class LaneLine(NamedTuple):
    """A lane in one part of a route: its boundaries right and left of the route, in the route's direction."""

    right: Array  # [m], shape (n, 2)
    left: Array  # [m], shape (n, 2)
    direction: int = 1
    is_ego: bool = False


def hermite_path(points: Array, tangents: Array, lengths: Array) -> Path:
    """Return the path through points with unit tangents, over the arc lengths between them [m]."""
    h = lengths[:, None]
    step, first, last = np.diff(points, axis=0), h * tangents[:-1], h * tangents[1:]
    cubics = np.stack(
        (first + last - 2.0 * step, 3.0 * step - 2.0 * first - last, first, points[:-1]), axis=-1
    )
    return Path(np.append(0.0, np.cumsum(lengths)), cubics)


def lanes_along(path: Path, parts: Sequence[Sequence[LaneLine]], detail: float = _DETAIL) -> list[Lane]:
    """Return the lanes of a route from those of its parts, in driving order, exact to a detail [m]."""
    lengths = [max(_center_length(line) for line in part if line.is_ego) for part in parts]
    scale = path.length / sum(lengths)
    joined, start = [], path.start
    for i, (part, length) in enumerate(zip(parts, lengths, strict=True)):
        end = path.end if i == len(parts) - 1 else start + scale * length
        ego = next(line for line in part if line.is_ego)
        if i < len(parts) - 1:
            end = float(path.project(0.5 * (ego.right[-1] + ego.left[-1]), end)[0])
        strips = []
        for line in part:
            rows = _rows(path, line, start, end, detail)
            if len(rows) > 1 and np.any(rows[:, 2] > rows[:, 1] + _DETAIL):
                strips.append(Strip(line.direction, line.is_ego, [(s, r, d) for s, r, d in rows.tolist()]))
        joined.append((strips, start, end))
        start = end
    return join_strips(joined, max(detail, 2.0 * _DETAIL))


def _center_length(line: LaneLine) -> float:
    return 0.5 * float(arc_length(line.right)[-1] + arc_length(line.left)[-1])


def _rows(path: Path, line: LaneLine, start: float, end: float, detail: float) -> Array:
    """Return stations and lateral offsets of the boundaries of a lane between two stations."""
    sides = []
    for points in (line.right, line.left):
        along = arc_length(points)
        guess = start + (end - start) * along / max(float(along[-1]), 1e-9)
        s, d = path.project(points, guess)
        order = np.maximum.accumulate(s)
        kept = np.append(True, np.diff(order) > 1e-6)
        sides.append((order[kept], d[kept]))
    first, last = (min(max(float(np.mean([s[k] for s, _ in sides])), start), end) for k in (0, -1))
    first = start if line.is_ego or first - start < _SNAP else first
    last = end if line.is_ego or end - last < _SNAP else last
    if not last > first:
        return np.empty((0, 3))
    inner = np.concatenate([s for s, _ in sides])
    inner = inner[(inner > first + _DETAIL) & (inner < last - _DETAIL)]
    at = np.concatenate(((first,), np.unique(np.round(inner, 6)), (last,)))
    right, left = (np.round(np.interp(at, s, d), 6) for s, d in sides)
    left = np.maximum(left, right)
    return _simplified(np.column_stack((at, right, left)), 0.5 * detail)


def _simplified(rows: Array, tolerance: float) -> Array:
    """Return rows without those that lie between their neighbors (Ramer-Douglas-Peucker)."""
    kept, pending = {0, len(rows) - 1}, [(0, len(rows) - 1)]
    while pending:
        i, k = pending.pop()
        if k - i < 2:
            continue
        fraction = ((rows[i + 1 : k, 0] - rows[i, 0]) / (rows[k, 0] - rows[i, 0]))[:, None]
        off = np.abs(rows[i + 1 : k, 1:] - (1.0 - fraction) * rows[i, 1:] - fraction * rows[k, 1:]).max(
            axis=1
        )
        worst = int(np.argmax(off))
        if off[worst] > tolerance:
            kept.add(i + 1 + worst)
            pending += [(i, i + 1 + worst), (i + 1 + worst, k)]
    return rows[sorted(kept)]
