"""Roads of a scenario from above, in meters of the plane."""

from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core.path import Path, Road
from cca_core.plot.lane_lines import road_lines
from cca_core.plot.style import COLORS, DASHES
from cca_core.sim import Scenario

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def dense_stations(path: Path, start: float, end: float) -> Array:
    """Stations between two others, as dense as the curvature needs [m]."""
    # chords leave the line by 3 cm at most, unless they are as short as 0.5 m
    kappa = float(np.abs(path.curvature(np.linspace(start, end, 200))).max())
    step = min(max(float(np.sqrt(8.0 * 0.03 / max(kappa, 1e-6))), 0.5), 20.0)
    return np.linspace(start, end, max(2, int((end - start) / step) + 2))


def offset_line(path: Path, start: float, end: float, d: float) -> Array:
    """Points between two stations at a lateral offset, as dense as the curvature needs [m]."""
    s = dense_stations(path, start, end)
    return path.to_cartesian(s, np.full_like(s, d))


def boundary_lines(road: Road, start: float, end: float) -> tuple[list[Array], list[Array]]:
    """Points of the right and left road edge, and of the boundaries between lanes [m]."""
    edges, between = road_lines(road, dense_stations(road.path, start, end))
    lines = [road.path.to_cartesian(line.s, line.d) for line in (*edges, *between)]
    return lines[:2], lines[2:]


def draw_roads(axis: "Axes", scenario: Scenario) -> None:
    """Draw all roads, the ego's route and its stop line."""
    axis.set_facecolor(COLORS.verge)
    roads = [*scenario.other_roads, scenario.road]
    for level, part in enumerate((_draw_edges, _draw_surface, _draw_dashes)):
        for road in roads:
            part(axis, road, 0.1 * level)
    path = scenario.road.path
    route = offset_line(path, path.start, path.end, 0.0)
    axis.plot(*route.T, ":", color=COLORS.route, linewidth=0.9, zorder=0.4)
    if scenario.stop_line is not None:
        lane = scenario.road.ego_lane
        ends = path.to_cartesian([scenario.stop_line] * 2, [lane.right, lane.left])
        axis.plot(*ends.T, color="white", linewidth=3.0, solid_capstyle="butt", zorder=0.5)


def _lines(road: Road) -> tuple[list[Array], list[Array]]:
    return boundary_lines(road, road.path.start, road.path.end)


def _draw_surface(axis: Any, road: Road, level: float) -> None:
    right, left = _lines(road)[0]
    axis.fill(*np.vstack((right, left[::-1])).T, color=COLORS.asphalt, linewidth=0.0, zorder=level)


def _draw_edges(axis: Any, road: Road, level: float) -> None:
    for line in _lines(road)[0]:
        axis.plot(*line.T, color=COLORS.route, linewidth=2.0, zorder=level)


def _draw_dashes(axis: Any, road: Road, level: float) -> None:
    for line in _lines(road)[1]:
        axis.plot(*line.T, color="white", linewidth=1.0, linestyle=DASHES, zorder=level)
