"""Roads of a run as SVG, in meters of the plane."""

import numpy as np

from cca_core._checks import Array
from cca_core.path import Road
from cca_core.plot.road_surface import boundary_lines, offset_line
from cca_core.sim import Log


def roads_svg(log: Log, origin: Array, margins: tuple[float, float]) -> str:
    """All roads, the route and the stop line, up to margins behind and ahead of the ego's stations [m]."""
    scenario = log.scenario
    path = scenario.road.path
    start = max(float(log.ego_frenet[:, 0].min()) - margins[0], path.start)
    end = min(float(log.ego_frenet[:, 0].max()) + margins[1], path.end)
    roads = [(road, road.path.start, road.path.end) for road in scenario.other_roads]
    parts = [part for road in (*roads, (scenario.road, start, end)) for part in _road(*road, origin)]
    parts.sort(key=lambda part: part[0])
    stop = ""
    if scenario.stop_line is not None:
        lane = scenario.road.ego_lane
        points = path.to_cartesian([scenario.stop_line] * 2, [lane.right, lane.left])
        stop = f'<polyline class="stop" points="{_points(points - origin)}"/>'
    route = offset_line(path, start, end, 0.0) - origin
    return "".join(text for _, text in parts) + f'<polyline class="route" points="{_points(route)}"/>{stop}'


def _road(road: Road, start: float, end: float, origin: Array) -> list[tuple[int, str]]:
    """Edges (level 0), surface (1) and dashes (2) of a road; surfaces cover the edges where roads join."""
    edges, between = boundary_lines(road, start, end)
    lines = [line - origin for line in (*edges, *between)]
    parts = [(1, f'<polygon class="asphalt" points="{_points(np.vstack((lines[0], lines[1][::-1])))}"/>')]
    for line, (level, style) in zip(lines, [(0, "edge")] * 2 + [(2, "dashes")] * len(between), strict=True):
        parts.append((level, f'<polyline class="{style}" points="{_points(line)}"/>'))
    return parts


def _points(xy: Array) -> str:
    return " ".join(f"{x:.2f},{y:.2f}" for x, y in xy)
