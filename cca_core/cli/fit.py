"""``cca fit``: a smooth road along a route, and how well it fits."""

import argparse
import math
import warnings
from pathlib import Path as FilePath

import numpy as np

from cca_core.adapters.local_origin import Origin
from cca_core.cli.maps import is_map, read_map_road, track_origin
from cca_core.cli.words import counted
from cca_core.errors import InputError
from cca_core.path import CleanedRoute, Path, Road, Waypoints, clean_route, read_waypoints
from cca_core.path.clean import CleaningReport
from cca_core.plot.svg import draw_fit, to_svg

__all__ = ["run"]

_DEFAULT_LIMIT = 36.0  # where a map has none [m/s]
_OTHER_MAPS = ".xml", ".osm"
_STRAIGHT = 1e4  # radius from which a road is called straight [m]
_TIGHT = 5.0  # radius below which hardly a car turns [m]
_NOISY = 0.3  # noise from which the accuracy is worth a line [m]


def run(given: argparse.Namespace) -> int:
    """Fit, print and draw; return the exit code."""
    if given.plot is not None and given.plot.name and given.plot.suffix != ".svg":
        raise InputError(f"--plot must end with .svg, was {str(given.plot)!r}")
    if is_map(given.route):
        return _show_map(given)
    if given.along is not None or given.lane is not None:
        raise InputError("--along and --lane must be given with a map (.xodr, .net.xml) alone")
    if given.route.suffix.lower() in _OTHER_MAPS:
        raise InputError(
            f"route must be a track or a map (.xodr, .net.xml), was {given.route.name!r}; a net of SUMO ends "
            "in .net.xml, cca_core.adapters.read_commonroad_map reads CommonRoad, nothing here reads Lanelet2"
        )
    limits = {} if given.tolerance is None else {"tolerance": given.tolerance}
    with warnings.catch_warnings(record=True) as noted:
        warnings.simplefilter("always")
        points = read_waypoints(given.route)
        zero = track_origin(points)
        road = Road.from_file(given.route, part=given.part, max_gap=given.max_gap, origin=zero, **limits)
    rms, route = _compare(road, points, given.part, zero)
    _print_facts(given.route, road.path, points, rms, route.report)
    _print_origin(zero)
    if road.elevation is not None:
        heights = road.elevation[:, 1]
        _print("heights", f"{np.nanmin(heights):.0f} m to {np.nanmax(heights):.0f} m above the begin")
    for each in noted:
        _print("warning", str(each.message))
    _draw(draw_fit(road.path, route.parts[0]), given)
    return 0


def _show_map(given: argparse.Namespace) -> int:
    """Print and draw a road of a map; return the exit code."""
    if given.part is not None or given.tolerance is not None:
        raise InputError("--part and --tolerance must be given with a track alone, not with a map")
    along = [each for each in (given.along or "").split(",") if each]
    try:
        road, zero = read_map_road(given.route, along, given.lane, _DEFAULT_LIMIT, "--along")
    except InputError as error:
        text = str(error)
        raise InputError(text if text.startswith("--") else f"{given.route.name}: {text}") from None
    _print("map", f"{given.route.name}: {', '.join(along)}")
    _print_origin(zero)
    _print("length", f"{road.path.length:.1f} m")
    _print("tightest curve", _tightest(road.path))
    _print("lanes", f"{len(road.lanes)}, from {road.right_edge:.1f} m to {road.left_edge:.1f} m")
    found = {road.speed_limit} if road.speed_limits is None else set(road.speed_limits[:, 1].tolist())
    default = f" ({_DEFAULT_LIMIT:g} where the map has none: set speed_limit)"
    limits = ", ".join(f"{limit:.1f} m/s" for limit in sorted(found))
    _print("speed limits", limits + (default if _DEFAULT_LIMIT in found else ""))
    _draw(to_svg(road.path), given)
    return 0


def _draw(picture: str, given: argparse.Namespace) -> None:
    """Write the picture of a road if asked for."""
    if given.plot is not None:
        file = given.plot if given.plot.name else FilePath(f"{given.route.stem}.svg")
        file.write_text(picture, encoding="utf-8")
        _print("picture", str(file))


def _print_origin(origin: Origin | None) -> None:
    """State an origin that is not that of the file."""
    if origin is not None and any(origin):
        _print("origin", f"x = {origin[0]:.0f} m, y = {origin[1]:.0f} m of the file are x = y = 0")


def _compare(
    road: Road, points: Waypoints, part: int | None, origin: Origin | None
) -> tuple[float, CleanedRoute]:
    """Return the root mean square of the waypoints' distance from the path, and the waypoints."""
    origin = origin if road.frame is None else (road.frame.lat0, road.frame.lon0)
    xy, t = points.to_local(origin), points.t
    if part is not None:
        rows = slice(points.parts[part], [*points.parts.tolist(), len(xy)][part + 1])
        xy, t = xy[rows], t[rows]
    route = clean_route(xy, t=t if len(t) == len(xy) and np.isfinite(t).all() else None)
    s, _ = road.path.project(route.parts[0])
    # beyond its ends the path continues straight, where no waypoint is near
    nearest = road.path.position(s.clip(road.path.start, road.path.end))
    return math.sqrt(np.mean(np.sum((nearest - route.parts[0]) ** 2, axis=1))), route


def _print_facts(file: FilePath, path: Path, points: Waypoints, rms: float, cleaning: CleaningReport) -> None:
    n, report = max(len(points.lat), len(points.xy)), path.fit_report
    counts = f"{counted(n, 'point')} in {counted(len(points.parts), 'part')}"
    _print("route", f"{file.name}: {counts}, {counted(points.skipped, 'row')} without a position")
    _print("cleaning", repr(cleaning).removeprefix("CleaningReport(").removesuffix(")"))
    _print("length", f"{path.length:.1f} m" + (", closed" if cleaning.closed else ""))
    if report is not None:
        noise = "" if report.noise is None else f", from a noise of {report.noise:.2g} m"
        _print("tolerance", f"{report.tolerance_text}{noise}")
        _print("max error", f"{report.max_deviation:.2f} m at s = {report.s_max_deviation:.0f} m")
    _print("rms error", f"{rms:.2f} m")
    if report is not None and report.noise is not None and report.noise >= _NOISY:
        _print("accuracy", f"in curves up to {3.0 * report.noise:.1f} m off, by the noise")
    _print("tightest curve", _tightest(path))
    if path.min_radius < _TIGHT:
        _print("warning", "a curve is tighter than cars turn; a larger --tolerance smooths noise")
    if report is not None and len(report.missed):
        _print("warning", f"{counted(len(report.missed), 'point')} farther away than the tolerance")
    if len(cleaning.reversals):
        _print("warning", f"the route turns back at {counted(len(cleaning.reversals), 'point')}")


def _tightest(path: Path) -> str:
    if path.min_radius >= _STRAIGHT:
        return "none, the road is straight"
    s = path.s_min_radius
    side = "left" if path.curvature_at(s) > 0.0 else "right"
    return f"radius {path.min_radius:.0f} m to the {side} at s = {s:.0f} m"


def _print(name: str, text: str) -> None:
    print(f"{name + ':':16}{text}")
