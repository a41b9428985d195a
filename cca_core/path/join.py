"""A route over several roads, joined end to end."""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from cca_core._checks import Array, check_real
from cca_core.errors import InputError
from cca_core.geometry import wrap_angle
from cca_core.path.lane import Lane
from cca_core.path.path import Path
from cca_core.path.road import Road

__all__ = ["Strip", "join_roads", "join_strips"]

_SAME_LANE = 0.5  # largest distance between the boundaries of one lane on two roads [m]
_STEP = 1e-3  # length within which boundaries and heights step from one road to the next [m]
_ROUNDING = 1e-6  # [m]

_Row = tuple[float, float, float]  # station, right and left boundary


class Strip(NamedTuple):
    """A lane over a part of a route; its rows are on the stations of the route."""

    direction: int
    is_ego: bool
    rows: list[_Row]


def join_roads(roads: Sequence[Road], *, max_gap: float = 0.02, max_kink: float = 0.02) -> Road:
    """Make a route over several roads, end to end.

    Parameters
    ----------
    roads : sequence of Road
        Roads in driving order. Each begins where the one before ends.
    max_gap : float
        Largest distance between the end of a path and the start of the next one [m].
    max_kink : float
        Largest change of heading between them [rad].

    Returns
    -------
    road : Road
        Its stations are those of the first road, continued. The ego lanes become one. Another lane goes on in
        the next road as the lane of the same direction whose boundaries are at most 0.5 m away, or ends
        there. Speed limits, stop lines and heights are kept; a road without heights is level.

    Raises
    ------
    InputError
        If there is no road, an item is not a `Road`, two roads do not meet, or an argument is out of range.

    Examples
    --------
    >>> from cca_core import Path
    >>> town = Road(Path([0.0, 100.0], [[[0, 0, 100, 0], [0, 0, 0, 0]]]), speed_limit=14.0)
    >>> country = Road(Path([0.0, 100.0], [[[0, 0, 100, 100], [0, 0, 0, 0]]]), speed_limit=28.0)
    >>> road = join_roads([town, country])
    >>> road.path.length, road.speed_limits.tolist()
    (200.0, [[0.0, 14.0], [100.0, 28.0]])
    """
    given: object = roads
    parts = tuple(given) if isinstance(given, Iterable) else ()
    if not parts or not all(isinstance(road, Road) for road in parts):
        raise InputError(f"roads must be a sequence of Road, was {given!r}")
    max_gap, max_kink = check_real("max_gap", max_gap, ge=0.0), check_real("max_kink", max_kink, ge=0.0)
    path, shifts = _join_paths([road.path for road in parts], max_gap, max_kink)
    shifted = list(zip(parts, shifts, strict=True))
    limits = _join_limits([_limits(road) + np.array((shift, 0.0)) for road, shift in shifted])
    heights = None
    if any(road.elevation is not None for road in parts):
        heights = _join_heights([_heights(road) + np.array((shift, 0.0)) for road, shift in shifted])
    road = Road(
        path, join_strips([_strips(part, shift) for part, shift in shifted]), float(limits[0, 1]),
        [s + shift for part, shift in shifted for s in part.stop_lines], heights,
        max(road.sigma_elevation for road in parts), limits if len(limits) > 1 else None,
    )  # fmt: skip
    frame = parts[0].frame
    road.frame = frame if all(part.frame == frame for part in parts) else None
    return road


def _join_paths(paths: Sequence[Path], max_gap: float, max_kink: float) -> tuple[Path, list[float]]:
    """Return the joined path, and by how much each path's stations are moved [m]."""
    shifts = [0.0]
    for i, (path, after) in enumerate(pairwise(paths)):
        gap = float(np.hypot(*(after.position(after.start) - path.position(path.end))))
        kink = abs(float(wrap_angle(after.heading(after.start) - path.heading(path.end))))
        for name, unit, value, limit in (("gap", "m", gap, max_gap), ("turn", "rad", kink, max_kink)):
            if value > limit:
                where = f"{name} between roads {i} and {i + 1}"
                raise InputError(f"{where} must be at most {limit:g} {unit}, was {value:.3g} {unit}")
        shifts.append(shifts[-1] + path.end - after.start)
    breaks = [paths[0].breaks]
    breaks += [path.breaks[1:] + shift for path, shift in zip(paths[1:], shifts[1:], strict=True)]
    return Path(np.concatenate(breaks), np.concatenate([path.coefficients for path in paths])), shifts


def _limits(road: Road) -> Array:
    """Return the speed limits of a road from its start on."""
    first = np.array([(road.path.start, road.highest_limit(road.path.start, road.path.start))])
    if road.speed_limits is None:
        return first
    inside = (road.speed_limits[:, 0] > road.path.start) & (road.speed_limits[:, 0] < road.path.end)
    return np.vstack((first, road.speed_limits[inside]))


def _join_limits(tables: Sequence[Array]) -> Array:
    """Return the speed limits of all roads, one row for each change."""
    rows = np.vstack(tables)
    changes: Array = rows[np.append(True, rows[1:, 1] != rows[:-1, 1])]
    return changes


def _heights(road: Road) -> Array:
    """Return the heights of a road."""
    if road.elevation is not None:
        return road.elevation
    return np.array([(road.path.start, 0.0), (road.path.end, 0.0)])


def _join_heights(tables: Sequence[Array]) -> Array:
    """Return the heights of all roads; where two differ, they step within a millimeter."""
    rows = tables[0].tolist()
    for table in tables[1:]:
        for s, z in table.tolist():
            if s > rows[-1][0]:
                rows.append([s, z])
            elif z != rows[-1][1]:
                rows.append([rows[-1][0] + _STEP, z])
    return np.array(rows)


def join_strips(
    parts: Sequence[tuple[Sequence[Strip], float, float]], tolerance: float = _ROUNDING
) -> list[Lane]:
    """Return the lanes of a route from the strips, the start and the end of each of its parts.

    A lane whose boundaries vary by less than the tolerance [m] does not vary.
    """
    chains: list[Strip] = []
    ongoing: list[Strip] = []
    for strips, start, end in parts:
        goes_on = []
        for strip in sorted(strips, key=lambda strip: not strip.is_ego):
            here = strip
            before = next((chain for chain in ongoing if _continues(chain, strip, start)), None)
            if before is None:
                chains.append(here)
            else:
                ongoing.remove(before)
                before.rows.extend(_onward(before.rows[-1], strip.rows))
                here = before
            if strip.rows[-1][0] >= end - _STEP:
                goes_on.append(here)
        ongoing = goes_on
    return [_lane(chain, parts[0][1], parts[-1][2], tolerance) for chain in chains]


def _strips(road: Road, shift: float) -> tuple[list[Strip], float, float]:
    """Return the lanes of a road, and its start and end, on the stations of the route."""
    found = []
    for lane in road.lanes:
        rows = _rows(lane, road.path, shift)
        if rows:
            found.append(Strip(lane.direction, lane is road.ego_lane, rows))
    return found, road.path.start + shift, road.path.end + shift


def _rows(lane: Lane, path: Path, shift: float) -> list[_Row]:
    """Return the boundaries of a lane between the ends of its road."""
    start, end = max(lane.start, path.start), min(lane.end, path.end)
    first, last = lane.bounds_at(start), lane.bounds_at(end)
    if start >= end or first is None or last is None:
        return []
    inner = [(s + shift, right, left) for s, right, left in lane.boundaries if start < s < end]
    return [(start + shift, *first), *inner, (end + shift, *last)]


def _continues(before: Strip, after: Strip, start: float) -> bool:
    """Whether a lane of the road that begins at a station is the rest of one of the road before."""
    if before[:2] != after[:2] or after.rows[0][0] > start + _STEP:
        return False
    return after.is_ego or _distance(before.rows[-1], after.rows[0]) <= _SAME_LANE


def _distance(a: _Row, b: _Row) -> float:
    return max(abs(a[1] - b[1]), abs(a[2] - b[2]))


def _onward(last: _Row, rows: list[_Row]) -> list[_Row]:
    """Return the boundaries that follow a last row; where they differ, they step within a millimeter."""
    if _distance(last, rows[0]) <= _ROUNDING:
        return rows[1:]
    return [(last[0] + _STEP, *rows[0][1:]), *rows[1:]]


def _lane(chain: Strip, start: float, end: float, tolerance: float) -> Lane:
    """Return a lane; one that is as long as the route and does not vary has no boundaries."""
    rows = chain.rows
    low, high = np.array(rows)[:, 1:].min(axis=0), np.array(rows)[:, 1:].max(axis=0)
    if (high - low).max() > tolerance or rows[0][0] > start + tolerance or rows[-1][0] < end - tolerance:
        return Lane.from_boundaries(rows, chain.direction)
    right, left = (0.5 * (low + high)).tolist()
    return Lane(d=0.5 * (right + left), width=left - right, direction=chain.direction)
