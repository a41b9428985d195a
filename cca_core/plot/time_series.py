"""A run over time."""

from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core._optional import require_extra
from cca_core.plot.crossing_times import crossing_times
from cca_core.plot.labels import action_words, escape_figure_text, gap_words, title_lines
from cca_core.plot.legends import color_patches, legend_above
from cca_core.plot.style import (
    ACTION_COLORS,
    COLORS,
    COLUMN_WIDTH,
    MIN_A_Y_RANGE,
    TEXT,
    assign_colors,
    darken,
    expand_limits,
    new_figure,
    set_text_sizes,
)
from cca_core.sim import Log
from cca_core.sim.outcome import lead_speed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FLAT = 0.5  # range of the lateral acceleration of a run in which steering is not shown [m/s^2]
_MIN_VIEW, _MAX_VIEW = 10.0, 60.0  # of gaps [m]
_VIEW_OF_GAP = 8.0  # height of the view of gaps, of the smallest one [-]


def plot_time_series(log: Log) -> "Figure":
    """Draw a run over time.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    figure : Figure
        The action as a bar; below it speed, longitudinal acceleration, steering and lateral acceleration if
        the ego steers, gaps to other vehicles, and the time to collision where it is below 10 s. The smallest
        gap is marked; the view reaches up to eight times that, but to 10 m at least and 60 m at most.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    panels = [_draw_speed, _draw_acceleration]
    if np.ptp(log.a_y) > _FLAT:
        panels += [_draw_steering, _draw_lateral]
    panels += [draw for draw, has_data in ((_draw_gaps, _near(log)[1]), (_draw_ttc, _ttc(log))) if has_data]
    figure = new_figure(1.0 + 1.12 * len(panels), COLUMN_WIDTH)
    bar, *axes = figure.subplots(
        len(panels) + 1, 1, sharex=True, squeeze=False, height_ratios=[0.16] + [1.0] * len(panels)
    )[:, 0]
    for draw, axis in zip(panels, axes, strict=True):
        draw(axis, log)
        if len(axis.get_legend_handles_labels()[1]) > (draw is not _draw_ttc):
            legend_above(axis, ncols=5)
        axis.locator_params(axis="y", nbins=4, min_n_ticks=3)
    axes[-1].set_xlabel("time [s]")
    _draw_actions(bar, axes, log)
    bar.set_xlim(log.t[0], log.t[-1])
    figure.suptitle(title_lines(log), x=0.02, ha="left", weight="bold", fontsize=TEXT.title)
    figure.align_ylabels()
    set_text_sizes(figure)
    return escape_figure_text(figure)


def _draw_speed(axis: Any, log: Log) -> None:
    lead = _without_jumps(lead_speed(log), 2.0)
    axis.plot(log.t, log.ego[:, 3], color=COLORS.ego, label="ego")
    if np.isfinite(lead).mean() > 0.05:
        axis.plot(log.t, lead, color="black", linewidth=1.0, linestyle="--", label="vehicle ahead")
    axis.set_ylabel("speed\n[m/s]")
    low, high = np.nanmin([*log.ego[:, 3], *lead]), np.nanmax([*log.ego[:, 3], *lead])
    axis.set_ylim(low - 1.0, high + 1.0)


def _draw_acceleration(axis: Any, log: Log) -> None:
    axis.axhline(0.0, color=COLORS.line, linewidth=0.8)
    axis.plot(log.t, log.ego[:, 7], color=COLORS.ego)
    axis.set_ylabel("acceleration\na_x [m/s²]")
    expand_limits(axis, 2.0)


def _draw_steering(axis: Any, log: Log) -> None:
    axis.plot(log.t, np.degrees(log.ego[:, 6]), color=COLORS.ego)
    axis.set_ylabel("road-wheel\nangle [°]")
    expand_limits(axis, 0.4)


def _draw_lateral(axis: Any, log: Log) -> None:
    axis.plot(log.t, log.a_y, color=COLORS.ego)
    axis.set_ylabel("lateral acc.\na_y [m/s²]")
    expand_limits(axis, MIN_A_Y_RANGE)


def _near(log: Log) -> tuple[float, dict[str, Array]]:
    """Return the height of the view [m], and the gaps to the vehicles that come into it."""
    gaps = {user.id: each for user, each in zip(log.scenario.road_users, log.gaps().T, strict=True)}
    smallest = min((float(each.min()) for each in gaps.values()), default=np.inf)
    if smallest >= _MAX_VIEW:
        return _MAX_VIEW, {}
    top = max(float(np.clip(_VIEW_OF_GAP * smallest, _MIN_VIEW, _MAX_VIEW)), 2.0 * smallest)
    return top, {id_: np.where(each < top, each, np.nan) for id_, each in gaps.items() if each.min() < top}


def _draw_gaps(axis: Any, log: Log) -> None:
    palette = assign_colors([user.id for user in log.scenario.road_users])
    top, near = _near(log)
    for i, (id_, gaps) in enumerate(near.items()):
        axis.plot(log.t, gaps, ("-", "--", "-.", ":")[i % 4], color=palette[id_], label=id_)
    axis.axhline(0.0, color=COLORS.line, linewidth=0.8)
    axis.set(ylim=(-0.05 * top, 1.05 * top), ylabel="gap between\nbodies [m]")
    id_, gaps = min(near.items(), key=lambda item: float(np.nanmin(item[1])))
    t, gap = log.t[np.nanargmin(gaps)], float(np.nanmin(gaps))
    axis.plot(t, gap, "o", color=palette[id_], markersize=4)
    along = float((t - log.t[0]) / (log.t[-1] - log.t[0]))
    halo = require_extra("matplotlib.patheffects", "plot").withStroke(linewidth=2.5, foreground="white")
    axis.annotate(
        gap_words(gap), (t, gap), (0, 6), textcoords="offset points", fontsize=TEXT.legend, weight="bold",
        ha="left" if along < 0.1 else "right" if along > 0.9 else "center", color=darken(palette[id_]),
        path_effects=[halo],
    )  # fmt: skip


def _ttc(log: Log, limit: float = 9.5, critical: float = 5.0) -> dict[str, tuple[Array, Array]]:
    """Return times and times to collision below a limit [s] of a critical conflict, along or crossing."""
    crossing = crossing_times(log)
    series = {"along the lane": (log.t, log.time_to_collision())}
    if crossing is not None:  # not along the lane that the other vehicle crosses
        series = {"crossing": (crossing.t, crossing.ttc)}
    near = {name: (t, np.where(ttc < limit, ttc, np.nan)) for name, (t, ttc) in series.items()}
    critical_ones = {name: (t, ttc) for name, (t, ttc) in near.items() if np.fmin.reduce(ttc) < critical}
    return {name: (t, _without_jumps(ttc, 0.5)) for name, (t, ttc) in critical_ones.items()}


def _without_jumps(values: Array, limit: float) -> Array:
    """Values with a gap wherever they jump: where another vehicle becomes the lead vehicle."""
    shown = np.array(values, dtype=float)
    shown[1:][np.abs(np.diff(shown)) > limit] = np.nan
    return shown


def _draw_ttc(axis: Any, log: Log) -> None:
    for name, (t, ttc) in _ttc(log).items():
        axis.plot(t, ttc, "-" if name == "crossing" else "--", color=COLORS.collision, label=name)
    axis.set(ylim=(0.0, 10.0), ylabel="time to\ncollision [s]")


def _draw_actions(bar: Any, axes: Any, log: Log) -> None:
    ends = [begin for begin, _, _ in log.decisions[1:]] + [float(log.t[-1])]
    for (begin, name, _), end in zip(log.decisions, ends, strict=True):
        bar.axvspan(begin, end, color=ACTION_COLORS[name], linewidth=0.0)
        for axis in axes:
            axis.axvline(begin, color=COLORS.faint, linewidth=0.6, linestyle=":", zorder=0)
    bar.set_yticks([])
    bar.tick_params(bottom=False)
    names = dict.fromkeys(name for _, name, _ in log.decisions)
    colors = {action_words(name): ACTION_COLORS[name] for name in names}
    legend_above(bar, ncols=5, handles=color_patches(colors))
