"""Planning methods compared: time against quality, scaling, and plans for one problem."""

from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core.baselines.problems.compare import ComparisonRow
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.baselines.table1.scaling import ScalingResult
from cca_core.plot.legends import figure_legend
from cca_core.plot.style import (
    COLORS,
    COLUMN_WIDTH,
    METHOD_STYLES,
    TEXT,
    draw_lanes,
    new_figure,
    set_text_sizes,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def _styles(names: Sequence[str]) -> dict[str, dict[str, Any]]:
    spare = cycle(
        [style for name, style in METHOD_STYLES.items() if name not in names] or METHOD_STYLES.values()
    )
    chosen = {name: METHOD_STYLES.get(name) or next(spare) for name in names}
    return {name: {"color": color, "marker": marker} for name, (color, marker) in chosen.items()}


def plot_time_quality(rows: Sequence[ComparisonRow]) -> "Figure":
    """Draw the quality of plans over the time of a plan.

    Parameters
    ----------
    rows : sequence of ComparisonRow
        Measured outcomes.

    Returns
    -------
    figure : Figure
        Over the median processor time of a plan, a bar up to its 99th percentile: the fraction of solvable
        problems that are solved, and the median of the largest jerk when these plans are driven.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    names = list(dict.fromkeys(row.method for row in rows))
    styles = _styles(names)
    figure = new_figure(5.6, COLUMN_WIDTH)
    above, below = figure.subplots(2, 1, sharex=True)
    for name in names:
        times = [row.time_ms for row in rows if row.method == name and np.isfinite(row.time_ms)]
        solvable = [row for row in rows if row.method == name and row.kind != "blocked"]
        solved = [row for row in solvable if row.outcome == "solved"]
        if not times:
            continue
        median, p99 = np.percentile(times, (50, 99))
        claimed = solved or [row for row in solvable if np.isfinite(row.driven_jerk)]
        jerk = float(np.median([row.driven_jerk for row in claimed])) if claimed else np.nan
        for axis, height in ((above, 100.0 * len(solved) / max(len(solvable), 1)), (below, jerk)):
            axis.plot((median, p99), (height, height), color=styles[name]["color"], linewidth=1.0, alpha=0.6)
            axis.plot(median, height, **styles[name], linestyle="", markersize=7, label=name)
    above.set(xscale="log", ylim=(-4.0, 104.0), ylabel="solvable problems\nsolved [%]")
    below.set(ylabel="largest jerk when\ndriven, median [m/s³]", ylim=(0.0, None))
    below.set_xlabel("time of a plan, median to 99th percentile [ms]")
    for axis in (above, below):
        axis.grid(alpha=0.3)
    _draw_legend(figure, above)
    figure.align_ylabels()
    return figure


def plot_scaling(results: Sequence[ScalingResult], axes: Sequence[str]) -> "Figure":
    """Draw how the time of a plan scales with the size of the problem.

    Parameters
    ----------
    results : sequence of ScalingResult
        Measured times.
    axes : sequence of str
        Quantities that grow, one panel for each.

    Returns
    -------
    figure : Figure
        Median times over each quantity, in logarithmic axes; hollow if the plan was not OK.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    styles = _styles(list(dict.fromkeys(r.method for r in results if r.axis in axes)))
    figure = new_figure(0.6 + 2.2 * len(axes), COLUMN_WIDTH)
    panels = np.atleast_1d(figure.subplots(len(axes), 1, sharey=True))
    for panel, quantity in zip(panels, axes, strict=True):
        _draw_scaling(panel, [r for r in results if r.axis == quantity], styles)
        panel.set_xlabel(quantity)
        panel.set_ylabel("processor time\nof a plan [ms]")
    low, high = panels[0].get_ylim()
    levels = [k * 10.0**n for n in range(-1, 5) for k in (1, 2, 5) if low <= k * 10.0**n <= high]
    panels[0].set_yticks(levels, [f"{level:g}" for level in levels])
    for name, style in styles.items():
        panels[0].plot([], [], **style, linewidth=1.0, markersize=5, label=name)
    _draw_legend(figure, panels[0])
    return figure


def _draw_scaling(axis: Any, results: Sequence[ScalingResult], styles: dict[str, dict[str, Any]]) -> None:
    for name, style in styles.items():
        of_method = sorted((r for r in results if r.method == name), key=lambda r: r.value)
        times = [r.time_ms for r in of_method]
        axis.plot([r.value for r in of_method], times, color=style["color"], linewidth=1.0)
        for r in of_method:
            fill = "full" if r.status == "OK" else "none"
            axis.plot(r.value, r.time_ms, **style, linestyle="", fillstyle=fill, markersize=5)
    axis.set(xscale="log", yscale="log")
    ticks = sorted({r.value for r in results})
    axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.minorticks_off()
    axis.grid(alpha=0.3)


def _draw_legend(figure: "Figure", axis: Any) -> None:
    handles = axis.get_legend_handles_labels()[0]
    figure_legend(figure, handles, loc="outside lower center", ncols=3)
    set_text_sizes(figure)


def plot_plans(problem: Problem, plans: Mapping[str, Plan], axis: Any = None) -> Any:
    """Draw the plans of several methods for one problem.

    Parameters
    ----------
    problem : Problem
        Road and vehicles. A moving vehicle is drawn at the time at which the ego passes it at constant speed.
    plans : mapping of str to Plan
        Plans by method; empty ones are left out.
    axis : matplotlib axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    axis : matplotlib axes
        In path coordinates, widths stretched.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    axis = new_figure(2.4, COLUMN_WIDTH).subplots() if axis is None else axis
    road, path = problem.road, problem.road.path
    t = np.linspace(0.0, problem.duration, 2000)
    for box in problem.boxes_at(t):
        s, d = path.project(np.column_stack((box.x, box.y)))
        k = int(np.abs(s - problem.start - problem.v_x * t).argmin())
        x = s[k] + 0.5 * float(box.length) * np.array([-1, 1, 1, -1])
        y = d[k] + 0.5 * float(box.width) * np.array([-1, -1, 1, 1])
        axis.fill(x, y, color=COLORS.parked)
    styles = _styles(list(plans))
    for name, plan in plans.items():
        if len(plan.xy):
            s, d = path.project(plan.xy)
            axis.plot(s, d, color=styles[name]["color"], linewidth=1.2, label=name, zorder=3)
    draw_lanes(axis, road)
    axis.axhline(0.0, color=COLORS.ink, linewidth=1.0, linestyle=":", zorder=1)
    axis.set(xlabel="along the route [m]", ylabel="left of the\nroute [m]")
    axis.set_title(problem.name, loc="left", fontsize=TEXT.heading)
    return axis
