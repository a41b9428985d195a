"""The route in a file: one part or all parts joined, cleaned and fitted, with its heights."""

import math
import warnings
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from cca_core._checks import Array, shown
from cca_core.errors import InputError
from cca_core.path.clean import clean_route
from cca_core.path.fit import fit_path
from cca_core.path.local_frame import LocalFrame
from cca_core.path.path import Path
from cca_core.path.waypoints import Waypoints, read_waypoints

__all__ = ["read_route"]


def read_route(
    file: str | FilePath,
    part: int | None,
    max_gap: float,
    origin: tuple[float, float] | None,
    skip_invalid: bool,
    fit: dict[str, Any],
) -> tuple[Path, Array | None, LocalFrame | None]:
    """Return the path, stations and heights, and the local frame; None without heights, or degrees."""
    name = FilePath(file).name
    points = read_waypoints(file, skip_invalid=skip_invalid)
    first_row = 0
    if part is not None:
        whole = points
        points, first_row = _part_of(whole, part, name)
        if origin is None and len(whole.lat):
            origin = _origin_of(whole, points)
    xy = points.to_local(origin)
    _check_joints(points, xy, max_gap, name)
    times = points.t if np.isfinite(points.t).all() else None
    route = clean_route(xy, t=times)
    if len(route.parts) > 1:
        raise InputError(
            f"file {name!r} must have no gap within a part, had {len(route.report.gaps)}, "
            f"after the points {(first_row + route.report.gaps[:5]).tolist()} of the part"
        )
    path = fit_path(route.parts[0], **fit)
    heights = _elevation_along(path, route.parts[0], xy, points.z)
    if len(points.xy):
        return path, heights, None
    lat0, lon0 = (points.lat[0], points.lon[0]) if origin is None else origin
    return path, heights, LocalFrame(lat0, lon0)


def _part_of(points: Waypoints, part: int, name: str) -> tuple[Waypoints, int]:
    """Return the waypoints of one part, and its first row."""
    starts = [*points.parts.tolist(), max(len(points.lat), len(points.xy))]
    n = len(starts) - 1
    if part not in range(n):
        raise InputError(f"part must be 0 to {n - 1} for file {name!r}, was {shown(part)}")
    rows = slice(starts[part], starts[part + 1])
    if rows.stop - rows.start < 2:
        raise InputError(f"part {part} of file {name!r} must have at least two points, had 1")
    taken = {field: getattr(points, field)[rows] for field in ("lat", "lon", "xy", "z", "t")}
    return replace(points, parts=points.parts[:1], **taken), rows.start


def _origin_of(whole: Waypoints, part: Waypoints) -> tuple[float, float]:
    """Return the first waypoint of a file, or that of the part if the part is too far away from it."""
    first, own = ((float(points.lat[0]), float(points.lon[0])) for points in (whole, part))
    try:
        part.to_local(first)
    except InputError:
        return own
    return first


def _check_joints(points: Waypoints, xy: Array, max_gap: float, name: str) -> None:
    """Raise if parts are too far apart to be joined, and warn if they are joined."""
    inner = points.parts[1:]
    if not len(inner):
        return
    gaps = np.hypot(*(xy[inner] - xy[inner - 1]).T)
    if gaps.max() > max_gap:
        far = int(np.argmax(gaps > max_gap))
        raise InputError(
            f"file {name!r} has {len(points.parts)} parts; those before and after point {inner[far]} must be "
            f"at most {max_gap:g} m apart, were {gaps[far]:.0f} m; give part=, or a larger max_gap="
        )
    text = f"file {name!r} has {len(points.parts)} parts, which were joined over gaps of up to"
    warnings.warn(f"{text} {gaps.max():.0f} m", stacklevel=4)


def _elevation_along(path: Path, nodes: Array, xy: Array, z: Array) -> Array | None:
    """Return stations of waypoints and their heights above the first one; None without heights."""
    heights = dict(zip(map(tuple, xy.tolist()), z.tolist(), strict=False))
    rows: list[tuple[float, float]] = []
    s, last = path.start, (float(nodes[0, 0]), float(nodes[0, 1]))
    for x, y in nodes.tolist():
        s = path.foot_point(x, y, s + math.dist((x, y), last))[0]
        height = heights.get((x, y), math.nan)
        if math.isfinite(height) and not (rows and s <= rows[-1][0]):
            rows.append((s, height))
        last = x, y
    if not rows:
        return None
    table = np.array(rows)
    table[:, 1] -= table[0, 1]
    return table
