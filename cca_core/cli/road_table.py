"""Roads and routes described in TOML: a file, or straight lines and arcs."""

import math
from functools import cache
from pathlib import Path as FilePath
from types import NoneType
from typing import Any, NamedTuple

import numpy as np

from cca_core._checks import shown
from cca_core.adapters.local_origin import Origin, find_origin
from cca_core.cli.maps import is_map, read_map_road, track_origin
from cca_core.cli.tables import Table, named
from cca_core.errors import InputError
from cca_core.path import Lane, Path, Road, interpolate_path, read_waypoints

__all__ = ["Frame", "read_path", "read_road"]

_SPACING = 5.0  # of the nodes of a straight line [m]
_ARC = 0.02  # turn between two nodes of an arc [rad]
_MIN_RADIUS = 3.0  # [m]
_MAX_LENGTH = 200_000.0  # [m]
_LINE = "pieces", "start", "heading"
_FILE = "file", "part", "max_gap", "tolerance"
_MAP = "file", "along", "lane", "speed_limit"
_ROAD = "lanes", "speed_limit", "speed_limits", "stop_lines"


class Frame(NamedTuple):
    """What x = y = 0 is: x and y in the files, or latitude and longitude."""

    origin: Origin
    is_geodetic: bool = False


def read_road(table: Table, folder: FilePath) -> tuple[Road, Frame]:
    """Return the road of a table, and the frame of its file."""
    if "file" in table.content and is_map(folder / table.text("file")):
        return _from_map(table, folder, None)
    table.check_keys([*_LINE, *_FILE, *_ROAD])
    lanes = [_lane(each) for each in table.tables("lanes")] or None
    speed_limit = table.number("speed_limit", 36.0, gt=0.0)
    path, frame = _path(table, folder, None)
    with named(table.where):
        road = Road(
            path, lanes, speed_limit, stop_lines=table.content.get("stop_lines", ()),
            speed_limits=table.content.get("speed_limits"),
        )  # fmt: skip
    return road, frame


def _lane(table: Table) -> Lane:
    """Return a lane, whose nominal offset and width follow from its boundaries."""
    if "boundaries" not in table.content:
        return table.record(Lane)
    table.check_keys(("boundaries", "direction"))
    with named(table.where):
        return Lane.from_boundaries(table.content["boundaries"], table.content.get("direction", 1))


def read_path(table: Table, folder: FilePath, frame: Frame) -> Path:
    """Return the route of a table, in the frame of the road."""
    if "file" in table.content and is_map(folder / table.text("file")):
        return _from_map(table, folder, frame)[0].path
    table.check_keys([*_LINE, *_FILE])
    return _path(table, folder, frame)[0]


def _path(table: Table, folder: FilePath, frame: Frame | None) -> tuple[Path, Frame]:
    given = [key for key in ("file", "pieces") if key in table.content]
    if len(given) != 1:
        raise InputError(f"{table.where} must have file or pieces, had {' and '.join(given) or 'neither'}")
    others = [key for key in table.content if key in (_LINE if given == ["file"] else _FILE)]
    if others:
        raise InputError(f"{table.position(others[0])} must not be given with {given[0]}")
    return _from_file(table, folder, frame) if given == ["file"] else _from_pieces(table, frame)


def _from_file(table: Table, folder: FilePath, frame: Frame | None) -> tuple[Path, Frame]:
    """Return the fitted route in a file."""
    options: dict[str, Any] = {}
    if "part" in table.content:
        options["part"] = table.whole("part", 0)
    if "tolerance" in table.content:
        options["tolerance"] = table.number("tolerance", ge=0.0)
    max_gap = table.number("max_gap", 100.0, gt=0.0)
    try:
        return _fitted(folder / table.text("file"), max_gap, tuple(options.items()), frame)
    except InputError as error:
        raise InputError(f"{table.position('file')}: {error}") from None


@cache
def _fitted(
    file: FilePath, max_gap: float, options: tuple[tuple[str, Any], ...], frame: Frame | None
) -> tuple[Path, Frame]:
    """Return the path of a file and its frame, fitted once for all runs of a study."""
    origin = track_origin(read_waypoints(file))
    if frame is not None and frame.is_geodetic == (origin is None):
        origin = frame.origin
    road = Road.from_file(file, max_gap=max_gap, origin=origin, **dict(options))
    if road.frame is not None:
        return road.path, Frame((road.frame.lat0, road.frame.lon0), True)
    return road.path, Frame(origin or (0.0, 0.0))


def _from_map(table: Table, folder: FilePath, frame: Frame | None) -> tuple[Road, Frame]:
    """Return a road of a map, with the map's lanes and speed limits."""
    table.check_keys(_MAP)
    along = table.content.get("along", [])
    if not isinstance(along, list) or not all(isinstance(each, str) for each in along):
        raise InputError(f"{table.position('along')} must be a list of texts, was {shown(along)}")
    lane = table.content.get("lane")
    if isinstance(lane, bool) or not isinstance(lane, int | NoneType):
        raise InputError(f"{table.position('lane')} must be a whole number, was {shown(lane)}")
    speed_limit = table.number("speed_limit", 36.0, gt=0.0)
    file, name = folder / table.text("file"), table.position("along")
    origin = None if frame is None or frame.is_geodetic else frame.origin
    try:
        road, origin = _mapped(file, tuple(along), lane, speed_limit, name, origin)
        return road, Frame(origin)
    except InputError as error:
        text = str(error)
        raise InputError(text if text.startswith(name) else f"{table.position('file')}: {text}") from None


@cache
def _mapped(
    file: FilePath,
    along: tuple[str, ...],
    lane: int | None,
    speed_limit: float,
    name: str,
    origin: Origin | None,
) -> tuple[Road, Origin]:
    """Return the road of a map and its origin, made once for all runs of a study."""
    return read_map_road(file, along, lane, speed_limit, name, origin)


def _from_pieces(table: Table, frame: Frame | None) -> tuple[Path, Frame]:
    """Return straight lines and arcs in a row, which begin in coordinates of the road's file."""
    start = table.content.get("start", [0.0, 0.0])
    if not isinstance(start, list) or len(start) != 2:
        raise InputError(f"{table.position('start')} must be x and y, was {shown(start)}")
    begin = Table({"x": start[0], "y": start[1]}, table.position("start"))
    heading = table.number("heading", 0.0, ge=-math.tau, le=math.tau)
    x, y = begin.number("x"), begin.number("y")
    frame = Frame(find_origin(x, y)) if frame is None else frame
    z = complex(x, y) - (0j if frame.is_geodetic else complex(*frame.origin))
    direction = np.exp(1j * heading)
    points, first, total = [z], direction, 0.0
    pieces = table.tables("pieces")
    if not pieces:
        raise InputError(f"{table.position('pieces')} must have at least one piece, had none")
    for piece in pieces:
        length, curvature = _piece(piece)
        total += length
        if total > _MAX_LENGTH:
            raise InputError(f"{piece.position('length')} must end within {_MAX_LENGTH / 1e3:g} km")
        n = max(math.ceil(length / _SPACING), math.ceil(abs(curvature) * length / _ARC))
        s = np.linspace(0.0, length, n + 1)[1:]
        # the integral of exp(i curvature s)
        chord = s * np.exp(0.5j * curvature * s) * np.sinc(0.5 * curvature * s / np.pi)
        points.extend(points[-1] + direction * chord)
        direction = direction * np.exp(1j * curvature * length)
    nodes = np.array(points)
    path = interpolate_path(
        np.column_stack((nodes.real, nodes.imag)), start_tangent=(first.real, first.imag),
        end_tangent=(direction.real, direction.imag),
    )  # fmt: skip
    return path, frame


def _piece(piece: Table) -> tuple[float, float]:
    """Return the length [m] and the curvature [1/m] of a piece; a left turn is positive."""
    piece.check_keys(("length", "radius"))
    length = piece.number("length", gt=0.0)
    if "radius" not in piece.content:
        return length, 0.0
    radius = piece.number("radius")
    if abs(radius) < _MIN_RADIUS:
        raise InputError(
            f"{piece.position('radius')} must be at least {_MIN_RADIUS:g} m to the left, or at most "
            f"{-_MIN_RADIUS:g} m to the right, was {radius:g}"
        )
    return length, 1.0 / radius
