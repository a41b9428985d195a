"""Roads of a scenario from above, in meters of the plane."""

from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core.path import Path, Road
from cca_core.sim import Scenario

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_GRAY, _EDGE, _VERGE = "#E3E3E3", "#777777", "#F6F7F4"
_SAGITTA = 0.03  # of a drawn line under the true one [m]


def offset_line(path: Path, start: float, end: float, d: float) -> Array:
    """Points on a line beside a path, as dense as its tightest bend needs.

    Parameters
    ----------
    path : Path
        The path.
    start, end : float
        Path coordinates between which to sample [m].
    d : float
        Lateral coordinate of the line [m], left positive.

    Returns
    -------
    xy : ndarray, shape (n, 2)
        Points; straight lines between them leave the true line by 3 cm at most, but for the shortest spacing
        of 0.5 m [m].
    """
    kappa = float(np.abs(path.curvature(np.linspace(start, end, 200))).max())
    step = min(max(float(np.sqrt(8.0 * _SAGITTA / max(kappa, 1e-6))), 0.5), 20.0)
    s = np.linspace(start, end, max(2, int((end - start) / step) + 2))
    return path.to_cartesian(s, np.full_like(s, d))


def lane_boundaries(road: Road) -> tuple[list[float], list[float]]:
    """Lateral coordinates of the lines on a road.

    Parameters
    ----------
    road : Road
        The road.

    Returns
    -------
    edges, between : list of float
        Right and left edge, and the borders between lanes [m].
    """
    edges = [road.right_edge, road.left_edge]
    lines = {lane.right for lane in road.lanes} | {lane.left for lane in road.lanes}
    return edges, sorted(lines - set(edges))


def draw_roads(axis: "Axes", scenario: Scenario) -> None:
    """Draw all roads, the ego's route and its stop line.

    Parameters
    ----------
    axis : matplotlib.axes.Axes
        Where to draw; its view is the caller's affair.
    scenario : Scenario
        Roads, route and line.
    """
    axis.set_facecolor(_VERGE)
    roads = [*scenario.other_roads, scenario.road]
    for level, part in enumerate((_edges, _surface, _dashes)):
        for road in roads:
            part(axis, road, 0.1 * level)
    path = scenario.road.path
    axis.plot(*offset_line(path, path.start, path.end, 0.0).T, ":", color=_EDGE, linewidth=0.9, zorder=0.4)
    if scenario.stop_line is not None:
        lane = scenario.road.ego_lane
        ends = path.to_cartesian([scenario.stop_line] * 2, [lane.right, lane.left])
        axis.plot(*ends.T, color="white", linewidth=3.0, solid_capstyle="butt", zorder=0.5)


def _surface(axis: Any, road: Road, level: float) -> None:
    right, left = (
        offset_line(road.path, road.path.start, road.path.end, d) for d in lane_boundaries(road)[0]
    )
    axis.fill(*np.vstack((right, left[::-1])).T, color=_GRAY, linewidth=0.0, zorder=level)


def _edges(axis: Any, road: Road, level: float) -> None:
    for d in lane_boundaries(road)[0]:
        line = offset_line(road.path, road.path.start, road.path.end, d)
        axis.plot(*line.T, color=_EDGE, linewidth=2.0, zorder=level)


def _dashes(axis: Any, road: Road, level: float) -> None:
    for d in lane_boundaries(road)[1]:
        line = offset_line(road.path, road.path.start, road.path.end, d)
        axis.plot(*line.T, color="white", linewidth=1.0, linestyle=(0, (8, 6)), zorder=level)
