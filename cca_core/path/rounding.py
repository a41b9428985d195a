"""Curves beyond a curvature limit, replaced by arcs and lines that a car can drive."""

import math

import numpy as np

from cca_core._checks import Array
from cca_core.path.dubins import Pose, dubins_paths
from cca_core.path.path import Path

__all__ = ["round_bends"]

_SPACING = 1.0  # of positions on arcs; a tenth of a radius where that is less [m]
_FAR_SPACING, _FAR_TURN = 8.0, 0.05  # of positions elsewhere [m], and turn between them [rad]
_MARGINS = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0)  # of path replaced next to a curve [radii]


def round_bends(path: Path, limit: float, radius: float) -> Array:
    """Positions along a path in which curves beyond the limit are arcs of a radius, shape (n, 2)."""
    spacing = min(_SPACING, 0.1 * radius)
    length = np.diff(path.breaks)
    fine = path.breaks[:-1, None] + length[:, None] * np.linspace(0.0, 1.0, 9)
    kappa = np.abs(path.curvature(fine))
    sharp = np.unique(fine[kappa > limit])
    s = _stations(path, kappa.max(axis=1) * length)
    if not len(sharp):
        return path.position(s)
    borders = np.flatnonzero(np.diff(sharp) > 3.0 * radius)
    curves = list(
        zip(sharp[np.append(0, borders + 1)].tolist(), sharp[np.append(borders, -1)].tolist(), strict=True)
    )
    pieces, done = [path.position(s[:1])], path.start
    for i, (first, last) in enumerate(curves):
        following = curves[i + 1][0] if i + 1 < len(curves) else path.end
        start, end, arcs = _nearest_arcs(path, first, last, done, following, radius, spacing)
        pieces += [path.position(s[(s > done) & (s < start)]), arcs]
        done = max(end, done)
    pieces.append(path.position(s[s > done]))
    positions = np.vstack(pieces)
    apart = np.append(True, np.hypot(*np.diff(positions, axis=0).T) > 0.2 * spacing)
    found: Array = positions[apart]
    return found


def _stations(path: Path, turn: Array) -> Array:
    """Stations from the start to the end, closer in curves, from the turn of each segment."""
    length = np.diff(path.breaks)
    parts = np.ceil(np.maximum(length / _FAR_SPACING, np.minimum(turn / _FAR_TURN, 50.0))).astype(np.intp)
    index = np.repeat(np.arange(len(parts)), parts)
    fraction = (np.arange(len(index)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[index]
    return np.append(path.breaks[index] + fraction * length[index], path.end)


def _nearest_arcs(
    path: Path, first: float, last: float, low: float, high: float, radius: float, spacing: float
) -> tuple[float, float, Array]:
    """Part of the path that is replaced, and the arcs for it that deviate least."""
    best = math.inf, low, high, np.empty((0, 2))
    for margin in _MARGINS:
        start = max(first - margin * radius, low)
        end = min(last + margin * radius, 0.5 * (last + high) if high < path.end else path.end)
        replaced = path.position(np.linspace(start, end, max(2, math.ceil((end - start) / spacing))))
        for at_ends in (_pose, _chord_pose) if end - start < 4.0 * radius else (_pose,):
            # at an end of the path the heading may be noise
            poses = [
                (at_ends if s in (path.start, path.end) else _pose)(path, s, start, end) for s in (start, end)
            ]
            for arcs in dubins_paths(poses[0], poses[1], radius, spacing):
                off = max(_farthest(arcs, replaced), _farthest(replaced, arcs))
                if off < best[0] - 0.05 * radius:
                    best = off, start, end, arcs
        if best[0] < 0.1 * radius:
            break
    return best[1:]


def _pose(path: Path, s: float, start: float, end: float) -> Pose:
    x, y = path.position(s).tolist()
    return x, y, float(path.heading(s))


def _chord_pose(path: Path, s: float, start: float, end: float) -> Pose:
    x, y = path.position(s).tolist()
    chord = path.position(end) - path.position(start)
    return x, y, math.atan2(chord[1], chord[0])


def _farthest(points: Array, others: Array) -> float:
    """Largest distance of a point from the nearest of the others."""
    from scipy.spatial import cKDTree  # slow to import

    return float(np.max(cKDTree(others).query(points)[0]))
