"""Bumper to bumper over time: the counterpart of Figs 6 and 7."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.plot.labels import escape_figure_text, run_heading
from cca_core.plot.legends import color_legend, figure_legend
from cca_core.plot.run_labels import run_labels, run_styles
from cca_core.plot.style import (
    COLORS,
    COLUMN_WIDTH,
    TEXT,
    assign_colors,
    mark_collision,
    new_figure,
    set_text_sizes,
)
from cca_core.sim import Log
from cca_core.sim.outcome import MOVING_SPEED, first_collision, row_at

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_braking(logs: Sequence[Log], *, outcomes: Sequence[str] = ()) -> "Figure":
    """Draw the positions of all vehicles, and the ego's speed and acceleration, in runs one below the other.

    Parameters
    ----------
    logs : sequence of Log
        Runs of one scenario, from top to bottom; all vehicles on the ego's route. Several runs of one ego
        type are named by what differs: scenario, case or plant, or else a number.
    outcomes : sequence of str, optional
        Added to each run's title, such as `cca_core.report.summarize_outcome`.

    Returns
    -------
    figure : Figure
        From top to bottom: for each run the interval from the rear to the front bumper of each vehicle; then
        the speeds and the accelerations of the ego in all runs. Where two bands meet, the vehicles collide.
        The time is that in which vehicles brake and stop, gray after the end of a run; oncoming vehicles are
        shown where they are near.

    Raises
    ------
    InputError
        If there is no run.
    MissingExtraError
        If matplotlib is not installed.
    """
    if not logs:
        raise InputError("logs must hold at least one run")
    n = len(logs)
    figure = new_figure(1.4 * n + 3.3, COLUMN_WIDTH)
    axes = figure.subplots(n + 2, 1, sharex=True, squeeze=False, height_ratios=[1.4] * n + [1.0, 1.0])[:, 0]
    *positions, speed, acceleration = axes
    palette = assign_colors([user.id for log in logs for user in log.scenario.road_users])
    first, last = _interesting(logs)
    inside = [_in_view(log, first, last) for log in logs]
    colors = {"ego": COLORS.ego, **palette}
    labels = run_labels(logs)
    for i, (log, position, (color, line)) in enumerate(zip(logs, positions, run_styles(logs), strict=True)):
        _draw_bands(position, log, palette)
        position.set_title(run_heading(labels[i], outcomes, i), fontsize=TEXT.heading, loc="left")
        position.set_ylim(min(map(np.nanmin, inside)) - 10.0, max(map(np.nanmax, inside)) + 10.0)
        position.set_ylabel("from ego's\nstart [m]")
        if log.t[-1] < last - 0.1:
            position.axvspan(log.t[-1], last, color=COLORS.asphalt, linewidth=0.0, zorder=0)
            colors["after the run"] = COLORS.asphalt
        speed.plot(log.t, log.ego[:, 3], line, color=color, label=labels[i])
        acceleration.plot(log.t, log.ego[:, 7], line, color=color)
    speed.set_ylabel("ego's speed\n[m/s]")
    acceleration.set(ylabel="ego's accel.\na_x [m/s²]", xlabel="time [s]", xlim=(first, last))
    for axis in axes:
        axis.locator_params(axis="y", nbins=4, min_n_ticks=3)
    color_legend(figure, colors, loc="outside upper left")
    figure_legend(figure, speed.lines, loc="outside lower center", ncols=2)
    set_text_sizes(figure)
    figure.align_ylabels()
    return escape_figure_text(figure)


def _body_centers(log: Log) -> Array:
    """Body centers along the route from the ego's start, the ego first, shape (n, 1 + n_users)."""
    ego = log.ego_frenet[:, :1] + log.scenario.vehicle.box_offset
    centers: Array = np.hstack((ego, log.user_frenet[:, :, 0])) - log.ego_frenet[0, 0]
    return centers


def _in_view(log: Log, first: float, last: float) -> Array:
    """Body centers that the view holds: not those of oncoming vehicles, which come from far away."""
    is_along = [True, *(user.direction > 0 for user in log.scenario.road_users)]
    return _body_centers(log)[(log.t >= first) & (log.t <= last)][:, is_along]


def _draw_bands(axis: Any, log: Log, palette: dict[str, str]) -> None:
    ego = log.scenario.vehicle
    bodies = [("ego", ego.length, COLORS.ego)]
    bodies += [(user.id, user.length, palette[user.id]) for user in log.scenario.road_users]
    for (name, length, color), s in zip(bodies, _body_centers(log).T, strict=True):
        axis.fill_between(log.t, s - 0.5 * length, s + 0.5 * length, color=color, linewidth=0.3, label=name)
    collision = first_collision(log)
    if collision is not None:
        s = _body_centers(log)[row_at(log, collision.t), 0] + 0.5 * ego.length
        mark_collision(axis, collision.t, s)
        axis.annotate(
            f"collision,\n{collision.speed:.1f} m/s", (collision.t, s), (9, 0), textcoords="offset points",
            color=COLORS.collision, weight="bold", fontsize=TEXT.legend, va="top",
        )  # fmt: skip


def _interesting(logs: Sequence[Log]) -> tuple[float, float]:
    """Time from 1 s before a vehicle brakes to 1.5 s after all stand still, or to the last end [s]."""
    first, last = [], []
    for log in logs:
        v = np.column_stack((log.ego[:, 3], log.road_users[:, :, 3]))
        a = np.column_stack((log.ego[:, 7], log.user_motion[:, :, 0]))
        brakes, moves = (a < -1.0).any(axis=1), (v > MOVING_SPEED).any(axis=1)
        first.append(log.t[np.argmax(brakes)] if brakes.any() else log.t[0])
        last.append(log.t[np.flatnonzero(moves)[-1]] if moves.any() else log.t[-1])
    begin, end = min(log.t[0] for log in logs), max(log.t[-1] for log in logs)
    return max(min(first) - 1.0, begin), min(max(last) + 1.5, end)
