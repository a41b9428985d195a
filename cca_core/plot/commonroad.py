"""A run in a recorded world, seen from above at several times."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array, check_array
from cca_core._optional import require_extra
from cca_core.errors import InputError
from cca_core.geometry import boxes
from cca_core.plot.labels import fill_text
from cca_core.plot.style import COLORS, COLUMN_WIDTH, TEXT, assign_colors, new_figure
from cca_core.sim.commonroad.drive import CommonRoadRun

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LEFT, _BETWEEN, _LINE, _ENDS = 0.75, 0.25, 0.155, 0.7  # margins and height of a line of text [in]


def plot_commonroad(run: CommonRoadRun, *, times: Sequence[float] | None = None) -> "Figure":
    """Draw lanelets, recorded traffic and the ego at several times.

    Parameters
    ----------
    run : CommonRoadRun
        The run.
    times : sequence of float, shape (n,), optional
        Times [s]; by default four, evenly from start to end.

    Returns
    -------
    figure : Figure
        One view for each time, x to the right and y up as in the file. Each box is a polygon with the gid
        ``"id@view"``; the ego's trace is a full line where it was and a dotted one where it will be. Goal
        regions are outlined in green.

    Raises
    ------
    InputError
        If `times` are not finite or empty.
    MissingExtraError
        If matplotlib is not installed.
    """
    instants = np.linspace(run.t[0], run.t[-1], 4) if times is None else check_array("times", times, (None,))
    if not len(instants):
        raise InputError("times must hold at least one time")
    regions = [region for goal in run.problem.goals for region in goal.regions]
    moments = [int(np.argmin(np.abs(run.t - t))) for t in instants.tolist()]
    shown = np.vstack([run.ego[:, :2], *regions, *_nearest(run, moments)])
    low, high = shown.min(axis=0) - 7.0, shown.max(axis=0) + 7.0  # a margin of 7 m
    tall = bool((high - low)[1] > 0.6 * (high - low)[0])
    columns = 2 if tall else 1
    rows = -(-len(instants) // columns)
    titles = [_title(run, row, 64 // columns) for row in moments]
    lines = sum(
        max(t.count("\n") + 1 for t in titles[k : k + columns]) for k in range(0, len(titles), columns)
    )
    view = (COLUMN_WIDTH - _LEFT) / columns * float((high - low)[1] / (high - low)[0])
    figure = new_figure(rows * (view + _BETWEEN) + lines * _LINE + _ENDS, COLUMN_WIDTH)
    figure.set_layout_engine("compressed")
    figure.suptitle(f"{run.scenario.name} ({run.plant})", weight="bold", fontsize=TEXT.heading)
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
    for number, (axis, row, title) in enumerate(zip(axes, moments, titles, strict=False), start=1):
        _draw_world(axis, run, regions)
        _draw_moment(axis, run, row, number, (low, high))
        axis.set_title(title, fontsize=TEXT.legend, loc="left")
        axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    for axis in axes[len(instants) :]:
        axis.set_axis_off()
    for axis in axes[-columns:]:
        axis.set_xlabel("x [m]", fontsize=TEXT.axis)
    for axis in axes[::columns]:
        axis.set_ylabel("y [m]", fontsize=TEXT.axis)
    return figure


def _nearest(run: CommonRoadRun, rows: list[int]) -> list[Array]:
    """Center of the vehicle that is nearest to the ego in each row, if within 30 m."""
    centers = []
    for row in rows:
        if run.gaps[row].min(initial=np.inf) < 30.0:
            near = run.scenario.obstacles[int(np.argmin(run.gaps[row]))].at(float(run.t[row]))
            centers += [] if near is None else [np.array((near.x, near.y))]
    return centers


def _draw_world(axis: Any, run: CommonRoadRun, regions: list[Array]) -> None:
    for lane in run.scenario.lanelets.values():
        axis.fill(*lane.outline.T, color=COLORS.road, zorder=0)
        for bound in (lane.left, lane.right):
            axis.plot(*bound.T, color=COLORS.faint, linewidth=0.8, zorder=1)
    for region in regions:
        axis.fill(*region.T, facecolor="none", edgecolor=COLORS.goal, linewidth=1.5, zorder=2)


def _title(run: CommonRoadRun, row: int, characters: int) -> str:
    """Time, action, least gap and reason."""
    name = next(name for begin, name, _ in reversed(run.decisions) if begin <= run.t[row] + 1e-9)
    gap = run.gaps[row].min(initial=np.inf)
    min_gap = f", min gap {gap:.1f} m" if np.isfinite(gap) else ""
    texts = f"{run.t[row]:.1f} s   {name}{min_gap}", run.cycle_reasons[row]
    return "\n".join(fill_text(text, characters) for text in texts)


def _draw_moment(axis: Any, run: CommonRoadRun, row: int, number: int, limits: tuple[Array, Array]) -> None:
    axis.plot(*run.ego[: row + 1, :2].T, color=COLORS.ego, linewidth=1.4, zorder=3)
    axis.plot(*run.ego[row:, :2].T, color=COLORS.ego, linewidth=1.0, linestyle=":", zorder=3)
    halo = require_extra("matplotlib.patheffects", "plot").withStroke(linewidth=2.0, foreground="white")
    palette = assign_colors([obstacle.id for obstacle in run.scenario.obstacles])
    x, y, psi, v_x = run.ego[row, :4]
    car = run.vehicle
    bodies = [("ego", *car.center_at(x, y, psi), psi, car.length, car.width, v_x, COLORS.ego)]
    for obstacle in run.scenario.obstacles:
        other = obstacle.at(float(run.t[row]))
        if other is not None:
            motion = (other.x, other.y, other.psi, other.length, other.width, other.v_x)
            bodies.append((other.id, *motion, palette[other.id]))
    low, high = limits
    for id_, x, y, psi, length, width, v_x, color in bodies:
        corners = boxes(x, y, psi, length, width).corners()
        axis.fill(*corners.T, color=color, alpha=0.85, zorder=4, gid=f"{id_}@{number}")
        if low[0] < x < high[0] and low[1] < y < high[1]:
            axis.annotate(
                f"{id_} {v_x:.0f} m/s", (x, y), color="black", fontsize=TEXT.tiny,
                ha="center", va="center", zorder=5, clip_on=True, path_effects=[halo],
            )  # fmt: skip
    axis.tick_params(labelsize=TEXT.axis)
