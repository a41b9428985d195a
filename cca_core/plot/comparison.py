"""Planning methods compared: time against quality, growth, and their plans for one problem."""

from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core.baselines.problems.compare import ComparisonRow
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.baselines.table1.scaling import ScalingResult
from cca_core.plot.style import COLORS, METHOD_STYLES, TEXT, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["plot_growth", "plot_plans", "plot_time_quality"]


def _styles(names: Sequence[str]) -> dict[str, dict[str, Any]]:
    spare = cycle(
        [style for name, style in METHOD_STYLES.items() if name not in names] or METHOD_STYLES.values()
    )
    chosen = {name: METHOD_STYLES.get(name) or next(spare) for name in names}
    return {name: {"color": color, "marker": marker} for name, (color, marker) in chosen.items()}


def plot_time_quality(rows: Sequence[ComparisonRow]) -> "Figure":
    """Draw time against quality.

    Parameters
    ----------
    rows : sequence of Row
        What `compare` measured.

    Returns
    -------
    figure : Figure
        Over the median processor time of a plan, a bar up to its 99th percentile: the share of solvable
        problems that are solved, and the median of the largest jerk when these plans are driven.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    names = list(dict.fromkeys(row.method for row in rows))
    styles = _styles(names)
    figure = new_figure(3.9)
    left, right = figure.subplots(1, 2, sharex=True)
    for name in names:
        own = [row for row in rows if row.method == name and np.isfinite(row.time_ms)]
        open_ = [row for row in rows if row.method == name and row.kind != "blocked"]
        solved = [row for row in open_ if row.outcome == "solved"]
        if not own:
            continue
        median, p99 = np.percentile([row.time_ms for row in own], (50, 99))
        claimed = solved or [row for row in open_ if np.isfinite(row.driven_jerk)]
        jerk = float(np.median([row.driven_jerk for row in claimed])) if claimed else np.nan
        for axis, height in ((left, 100.0 * len(solved) / max(len(open_), 1)), (right, jerk)):
            axis.plot((median, p99), (height, height), color=styles[name]["color"], linewidth=1.0, alpha=0.6)
            axis.plot(median, height, **styles[name], linestyle="", markersize=7, label=name)
    left.set(xscale="log", ylim=(-4.0, 104.0), ylabel="solvable problems solved [%]")
    right.set(ylabel="largest jerk when driven, median [m/s³]", ylim=(0.0, None))
    for axis in (left, right):
        axis.set_xlabel("time of a plan, median to 99th percentile [ms]")
        axis.grid(alpha=0.3)
    figure.legend(
        *left.get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize=TEXT.legend
    )
    return figure


def plot_growth(results: Sequence[ScalingResult], axes: Sequence[str]) -> "Figure":
    """Draw how times grow.

    Parameters
    ----------
    results : sequence of Growth
        What `grow` measured.
    axes : sequence of str
        What grows, one panel for each.

    Returns
    -------
    figure : Figure
        Median times over each quantity, in logarithmic axes; hollow where the plan was not OK.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    names = list(dict.fromkeys(r.method for r in results if r.axis in axes))
    styles = _styles(names)
    figure = new_figure(3.7)
    panels = np.atleast_1d(figure.subplots(1, len(axes), sharey=True))
    for panel, what in zip(panels, axes, strict=True):
        for name in names:
            own = sorted((r for r in results if r.axis == what and r.method == name), key=lambda r: r.value)
            if not own:
                continue
            values, times = [r.value for r in own], [r.time_ms for r in own]
            panel.plot(values, times, color=styles[name]["color"], linewidth=1.0)
            for r in own:
                fill = "full" if r.status == "OK" else "none"
                panel.plot(r.value, r.time_ms, **styles[name], linestyle="", fillstyle=fill, markersize=5)
        panel.set(xscale="log", yscale="log", xlabel=what)
        ticks = sorted({r.value for r in results if r.axis == what})
        panel.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        panel.minorticks_off()
        panel.grid(alpha=0.3)
    panels[0].set_ylabel("processor time of a plan [ms]")
    low, high = panels[0].get_ylim()
    levels = [k * 10.0**n for n in range(-1, 5) for k in (1, 2, 5) if low <= k * 10.0**n <= high]
    panels[0].set_yticks(levels, [f"{level:g}" for level in levels])
    for name in names:
        panels[0].plot([], [], **styles[name], linewidth=1.0, markersize=5, label=name)
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize=TEXT.legend
    )
    return figure


def plot_plans(problem: Problem, plans: Mapping[str, Plan], axis: Any = None) -> Any:
    """Draw the plans of several methods for one problem.

    Parameters
    ----------
    problem : Problem
        Road and others; who moves is drawn when the ego is beside it, as met at the wanted speed.
    plans : mapping of str to Plan
        By method; those without a way are left out.
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
    axis = new_figure(2.6).subplots() if axis is None else axis
    road, path = problem.road, problem.road.path
    axis.axhspan(road.right_edge, road.left_edge, color=COLORS.road)
    t = np.linspace(0.0, problem.duration, 2000)
    for box in problem.boxes_at(t):
        s, d = path.project(np.column_stack((box.x, box.y)))
        k = int(np.abs(s - problem.start - problem.v_x * t).argmin())
        x, y = (
            s[k] + 0.5 * float(box.length) * np.array([-1, 1, 1, -1]),
            d[k] + 0.5 * float(box.width) * np.array([-1, -1, 1, 1]),
        )
        axis.fill(x, y, color=COLORS.parked)
    styles = _styles(list(plans))
    for name, plan in plans.items():
        if len(plan.xy):
            s, d = path.project(plan.xy)
            axis.plot(s, d, color=styles[name]["color"], linewidth=1.2, label=name)
    axis.axhline(0.0, color=COLORS.ego, linewidth=0.5, linestyle=(0, (4, 4)))
    axis.set(xlabel="along the route [m]", ylabel="left of the route [m]", title=problem.name)
    return axis
