"""Two tunings on one axis, as driven: the counterpart of Fig 15."""

from typing import TYPE_CHECKING

import numpy as np

from cca_core.plot.labels import escape_figure_text
from cca_core.plot.style import COLORS, COLUMN_WIDTH, TEXT, draw_lanes, new_figure, set_text_sizes
from cca_core.sim import Log
from cca_core.sim.outcome import first_lane_change

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_tunings(fast: Log, smooth: Log) -> "Figure":
    """Draw the paths of two tunings on one axis.

    Parameters
    ----------
    fast, smooth : Log
        Runs on the same road, in both of which the ego changes lane.

    Returns
    -------
    figure : Figure
        Both paths in path coordinates, with the length of the first lane change and the peak lateral
        acceleration of each.

    Raises
    ------
    InputError
        If the ego stays in its lane in one of them.
    MissingExtraError
        If matplotlib is not installed.
    """
    figure = new_figure(3.4, COLUMN_WIDTH)
    axis = figure.subplots()
    road = fast.scenario.road
    draw_lanes(axis, road)
    view = []
    styles = ((fast, COLORS.ego, "-", "fast"), (smooth, COLORS.second, "--", "smooth"))
    for i, (log, color, line, name) in enumerate(styles):
        s, d = log.ego_frenet.T
        start, end = first_lane_change(log)
        height = road.left_edge + 0.6 + 0.9 * i
        aim, peak = log.scenario.evasion.lateral_acceleration, np.abs(log.a_y).max()
        label = f"{name}: comfort limit {aim:g} m/s², peak |a_y| {peak:.2f} m/s²"
        axis.plot(s, d, line, color=color, label=label, linewidth=1.8)
        axis.vlines((start, end), np.interp((start, end), s, d), height, color=color, linewidth=0.8)
        axis.annotate("", (start, height), (end, height), arrowprops={"arrowstyle": "<->", "color": color})
        axis.annotate(
            f"{name}: {end - start:.0f} m for the lane change", (end, height), (6, 0),
            textcoords="offset points", color=color, va="center", fontsize=TEXT.legend,
        )  # fmt: skip
        view += np.interp([log.decisions[1][0], log.decisions[-1][0]], log.t, s).tolist()
    axis.set_xlim(min(view) - 20.0, max(view) + 20.0)
    axis.set_ylim(road.right_edge - 0.5, road.left_edge + 2.2)
    axis.set_xlabel("distance along the route [m]\n(a lane change is counted from 5 % to 95 % of its width)")
    axis.set_ylabel("left of the route [m]")
    axis.set_title("The same traffic, two tunings", loc="left", weight="bold", fontsize=TEXT.title)
    figure.legend(loc="outside lower left", ncols=1, frameon=False, fontsize=TEXT.legend)
    set_text_sizes(figure)
    return escape_figure_text(figure)
