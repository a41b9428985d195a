"""Lanes of OpenDRIVE, sampled along a route."""

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from cca_core._checks import Array
from cca_core.adapters.lane_lines import LaneLine, hermite_path
from cca_core.adapters.opendrive_file import DRIVABLE, FileRoad
from cca_core.adapters.reference_line import PlanarPoints, cubic_at
from cca_core.errors import InputError
from cca_core.path import Path, fit_path

__all__ = ["Line", "Piece", "path_of", "sample"]

_STEP = 1.0  # between points of a road [m]; a cubic leaves an arc of 10 m radius by 3e-6 m
_MAX_KINK = 0.02  # change of heading that is rounding of the file [rad]
_MAX_STEP = 0.02  # gap that is rounding of the file [m]
_MAX_GAP = 1.0  # [m]
_TOLERANCE = 0.1  # of a path that is fitted [m]
_MIN_WIDTH = 0.1  # of a lane that is one [m]
_GAUSS = np.polynomial.legendre.leggauss(5)


class Piece(NamedTuple):
    """A lane in one section of a road, driven in one direction."""

    road: str
    section: int
    lane: int
    is_forward: bool


class Line(NamedTuple):
    """Segments of a driven lane: their ends, tangents there, lengths, heights and speed limits."""

    first: Array
    last: Array
    first_tangent: Array
    last_tangent: Array
    length: Array
    height: Array  # at both ends, shape (n, 2)
    limit: Array


def sample(
    road: FileRoad, piece: Piece, low: float, high: float, speed_limit: float
) -> tuple[Line, list[LaneLine]]:
    """Return a piece between two stations, with all lanes there."""
    lane_id = piece.lane
    s = _stations(road, piece, low, high)
    middle = 0.5 * (s[1:] + s[:-1])
    _check_width(road, piece, s, middle)
    ends = [_sides(road, piece.section, lane_id, at, middle) for at in (s[:-1], s[1:])]
    half = 0.5 * np.diff(s)[:, None]
    inner = (s[:-1, None] + half * (1.0 + _GAUSS[0])).ravel()
    speed = _sides(road, piece.section, lane_id, inner, np.repeat(middle, len(_GAUSS[0])))[2]
    length = (half * np.hypot(*speed.T).reshape(half.shape[0], -1)) @ _GAUSS[1]
    heights = np.column_stack([cubic_at(road.heights, at, middle)[0] for at in (s[:-1], s[1:])])
    limit = _limits(road, piece, middle, speed_limit)
    tangents = [side[2] / np.maximum(np.hypot(*side[2].T), 1e-9)[:, None] for side in ends]
    line = Line(ends[0][1], ends[1][1], tangents[0], tangents[1], length, heights, limit)
    if not piece.is_forward:
        line = Line(
            line.last[::-1], line.first[::-1], -line.last_tangent[::-1], -line.first_tangent[::-1],
            line.length[::-1], line.height[::-1, ::-1], line.limit[::-1],
        )  # fmt: skip
    return line, list(_lane_lines(road, piece, s, middle))


def _check_width(road: FileRoad, piece: Piece, s: Array, middle: Array) -> None:
    """Raise where the lane of the route has no width."""
    for at in (s[:-1], s[1:]):
        (inner, _), (outer, _) = _borders(road, piece.section, piece.lane, at, middle)
        width = np.abs(outer - inner)
        i = int(np.argmin(width))
        if width[i] < _MIN_WIDTH:
            where = f"lane {piece.lane} of road {road.id!r} on the route"
            raise InputError(
                f"{where} must be at least {_MIN_WIDTH:g} m wide, was {width[i]:.2g} m at s = {at[i]:.1f} m"
            )


def _stations(road: FileRoad, piece: Piece, low: float, high: float) -> Array:
    """Return the ends of all records between two stations, and points between them."""
    lanes = road.sections[piece.section][1]
    starts = [geometry.s for geometry in road.view.geometries]
    starts += [record.s for record in (*road.offsets, *road.heights)]
    starts += [record.s for lane in lanes.values() for record in lane.widths]
    starts += [s for s, _ in (*road.limits, *lanes[piece.lane].limits)]
    at = np.unique([low, high, *(s for s in starts if low + 1e-6 < s < high - 1e-6)])
    at = at[np.append(True, np.diff(at) > 1e-6)]
    at[-1] = high
    parts = [
        np.linspace(a, b, max(math.ceil((b - a) / _STEP), 1), endpoint=False)
        for a, b in pairwise(at.tolist())
    ]
    return np.append(np.concatenate(parts), high)


def _borders(
    road: FileRoad, section: int, lane_id: int, s: Array, middle: Array
) -> list[tuple[Array, Array]]:
    """Return inner and outer border of a lane as offsets from the reference line, with derivatives by s."""
    lanes, sign = road.sections[section][1], 1 if lane_id > 0 else -1
    t, rate = cubic_at(road.offsets, s, middle)
    borders = [(t, rate)]
    for id_ in range(sign, lane_id + sign, sign):
        if id_ in lanes:
            width, change = cubic_at(lanes[id_].widths, s, middle)
            t, rate = t + sign * width, rate + sign * change
        borders.append((t, rate))
    return borders[-2:]


def _sides(
    road: FileRoad, section: int, lane_id: int, s: Array, middle: Array
) -> tuple[PlanarPoints, Array, Array]:
    """Return the reference line, and the center line of a lane with its derivative by s."""
    line = road.view.at(s, middle)
    (t_0, rate_0), (t_1, rate_1) = _borders(road, section, lane_id, s, middle)
    t, rate = 0.5 * (t_0 + t_1), 0.5 * (rate_0 + rate_1)
    tangent = np.column_stack((np.cos(line.heading), np.sin(line.heading)))
    normal = np.column_stack((-tangent[:, 1], tangent[:, 0]))
    along = line.speed * (1.0 - line.curvature * t)
    point = np.column_stack((line.x, line.y)) + t[:, None] * normal
    return line, point, along[:, None] * tangent + rate[:, None] * normal


def _lane_lines(road: FileRoad, piece: Piece, s: Array, middle: Array) -> Iterator[LaneLine]:
    """Yield the other lanes of the route, and its own."""
    at = np.append(s[:-1], s[-1])
    near = np.append(middle, middle[-1])
    line = road.view.at(at, near)
    xy, normal = (
        np.column_stack((line.x, line.y)),
        np.column_stack((-np.sin(line.heading), np.cos(line.heading))),
    )
    for id_, lane in road.sections[piece.section][1].items():
        is_ego = id_ == piece.lane
        if id_ == 0 or (lane.kind not in DRIVABLE and not is_ego):
            continue
        (inner, _), (outer, _) = _borders(road, piece.section, id_, at, near)
        if not is_ego and np.abs(outer - inner).max() < _MIN_WIDTH:
            continue
        right, left = (inner, outer) if id_ > 0 else (outer, inner)
        lines = [xy + t[:, None] * normal for t in (right, left)]
        if not piece.is_forward:
            lines = [points[::-1] for points in lines[::-1]]
        same = road.is_forward(id_) == road.is_forward(piece.lane)
        yield LaneLine(lines[0], lines[1], 1 if same or lane.kind == "bidirectional" else -1, is_ego)


def _limits(road: FileRoad, piece: Piece, middle: Array, otherwise: float) -> Array:
    """Return the speed limits at stations: those of the lane before those of the road."""
    limit = np.full_like(middle, math.inf)
    for records in (road.limits, road.sections[piece.section][1][piece.lane].limits):
        for s, v in records:
            limit = np.where(middle >= s, v, limit)
    return np.where(np.isfinite(limit), limit, otherwise)


def path_of(line: Line) -> Path:
    """Return the path along segments; a fitted one if they do not meet smoothly."""
    gaps = np.hypot(*(line.first[1:] - line.last[:-1]).T)
    before, after = line.last_tangent[:-1], line.first_tangent[1:]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    kinks = np.abs(np.arctan2(cross, np.sum(before * after, axis=1)))
    if gaps.max(initial=0.0) > _MAX_GAP:
        x, y = line.first[1 + int(np.argmax(gaps))].tolist()
        words = f"route must have gaps of at most {_MAX_GAP:g} m"
        raise InputError(f"{words}, had {gaps.max():.3g} m near ({x:.1f}, {y:.1f})")
    if gaps.max(initial=0.0) <= _MAX_STEP and kinks.max(initial=0.0) <= _MAX_KINK:
        points = np.vstack((line.first[:1], 0.5 * (line.first[1:] + line.last[:-1]), line.last[-1:]))
        tangents = np.vstack((line.first_tangent[:1], before + after, line.last_tangent[-1:]))
        return hermite_path(points, tangents / np.hypot(*tangents.T)[:, None], line.length)
    points = np.vstack((line.first, line.last[-1:]))
    return fit_path(
        points[np.append(True, np.hypot(*np.diff(points, axis=0).T) > 0.05)], tolerance=_TOLERANCE
    )
