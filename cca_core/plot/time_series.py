"""A run over time."""

from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core.plot.labels import escape_figure_text, title
from cca_core.plot.style import (
    ACTION_COLORS,
    COLORS,
    MIN_A_Y_RANGE,
    TEXT,
    assign_colors,
    expand_limits,
    new_figure,
)
from cca_core.sim import Log
from cca_core.sim.outcome import lead_speed

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_time_series(log: Log) -> "Figure":
    """Draw a run over time.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    figure : Figure
        Speed, steering, lateral acceleration and gap over time, on backgrounds that show the action.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    figure = new_figure(7.6)
    axes = figure.subplots(4, 1, sharex=True)
    speed, steering, lateral, gap = axes
    _draw_speed(speed, log)
    steering.plot(log.t, np.degrees(log.ego[:, 6]), color=COLORS.ego)
    steering.set_ylabel("road-wheel\nangle [°]")
    expand_limits(steering, 0.4)
    lateral.plot(log.t, log.a_y, color=COLORS.ego)
    lateral.set_ylabel("lateral acc.\na_y [m/s²]")
    expand_limits(lateral, MIN_A_Y_RANGE)
    _draw_gaps(gap, log)
    gap.set_xlabel("time [s]")
    for axis in (speed, gap) if len(gap.lines) > 1 else (speed,):
        axis.legend(loc="upper right", fontsize=TEXT.legend, ncols=4, framealpha=0.9)
    _draw_actions(axes, log)
    speed.set_xlim(log.t[0], log.t[-1])
    figure.suptitle(title(log), x=0.01, ha="left", weight="bold", fontsize=TEXT.title)
    figure.align_ylabels()
    return escape_figure_text(figure)


def _draw_speed(axis: Any, log: Log) -> None:
    lead = lead_speed(log)
    axis.plot(log.t, log.ego[:, 3], color=COLORS.ego, label="ego")
    axis.plot(log.t, lead, color="black", linewidth=1.0, linestyle="--", label="lead vehicle (within 100 m)")
    axis.set_ylabel("speed [m/s]")
    low, high = np.nanmin([*log.ego[:, 3], *lead]), np.nanmax([*log.ego[:, 3], *lead])
    axis.set_ylim(low - 1.0, high + 1.0 + 0.3 * (high - low))  # the legend needs space


def _draw_gaps(axis: Any, log: Log, *, max_gap: float = 60.0) -> None:
    """Draw the gaps up to `max_gap` [m]."""
    palette = assign_colors([user.id for user in log.scenario.road_users])
    for i, (user, gaps) in enumerate(zip(log.scenario.road_users, log.gaps().T, strict=True)):
        near = np.where(gaps < max_gap, gaps, np.nan)
        if np.isfinite(near).any():
            line = ("-", "--", "-.", ":")[i % 4]
            axis.plot(log.t, near, line, color=palette[user.id], label=user.id)
    axis.axhline(0.0, color=COLORS.line, linewidth=0.8)
    axis.set(ylim=(-2.0, 1.3 * max_gap), ylabel="gap between\nboxes [m]")


def _draw_actions(axes: Any, log: Log) -> None:
    end_of_run = float(log.t[-1])
    ends = [begin for begin, _, _ in log.decisions[1:]] + [end_of_run]
    for (begin, name, _), end in zip(log.decisions, ends, strict=True):
        for axis in axes:
            axis.axvspan(begin, end, color=ACTION_COLORS[name], linewidth=0.0, zorder=0)
        if end - begin > 0.02 * log.duration:
            axes[0].annotate(
                name.replace("_", "\n"), (0.5 * (begin + end), 1.0), (0, 3),
                xycoords=("data", "axes fraction"), textcoords="offset points", ha="center",
                fontsize=TEXT.legend,
            )  # fmt: skip
