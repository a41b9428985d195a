"""Bumper to bumper over time: the counterpart of Figs 6 and 7."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.plot.labels import escape_figure_text, run_heading
from cca_core.plot.style import COLORS, TEXT, assign_colors, mark_collision, new_figure
from cca_core.sim import Log
from cca_core.sim.outcome import MOVING_SPEED, first_collision, row_at

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_braking(logs: Sequence[Log], *, outcomes: Sequence[str] = ()) -> "Figure":
    """Draw position, speed and deceleration of all vehicles, in runs side by side.

    Parameters
    ----------
    logs : sequence of Log
        Runs of one scenario, from left to right; all vehicles on the ego's route.
    outcomes : sequence of str, optional
        Second line of each run's title, such as `cca_core.report.summarize_outcome`.

    Returns
    -------
    figure : Figure
        A column for each run; from top to bottom, the interval from the rear to the front bumper of each
        vehicle, speeds, and decelerations over time. Where two bands meet, the vehicles collide.

    Raises
    ------
    InputError
        If there is no run.
    MissingExtraError
        If matplotlib is not installed.
    """
    if not logs:
        raise InputError("logs must hold at least one run")
    figure = new_figure(7.6)
    axes = figure.subplots(
        3, len(logs), sharex=True, sharey="row", squeeze=False, height_ratios=(2.2, 1.0, 1.0)
    )
    for i, (log, column) in enumerate(zip(logs, axes.T, strict=True)):
        _draw_run(column, log)
        column[0].set_title(run_heading(log, outcomes, i), fontsize=TEXT.heading, loc="left")
    position, speed, brake = axes[:, 0]
    position.set_ylabel("front and rear bumpers,\nfrom the ego's start [m]")
    speed.set_ylabel("speed [m/s]")
    brake.set_ylabel("deceleration [m/s²]")
    first, last = _interesting(logs)
    position.set_xlim(first, last)
    shown = [_body_centers(log)[(log.t >= first) & (log.t <= last)] for log in logs]
    position.set_ylim(min(np.nanmin(s) for s in shown) - 10.0, max(np.nanmax(s) for s in shown) + 10.0)
    position.legend(fontsize=TEXT.legend, loc="upper left")
    return escape_figure_text(figure)


def _draw_run(column: Any, log: Log) -> None:
    position, speed, brake = column
    users = log.scenario.road_users
    palette = assign_colors([user.id for user in users])
    _draw_bands(position, log, palette)
    speed.plot(log.t, log.ego[:, 3], color=COLORS.ego)
    brake.plot(log.t, -log.ego[:, 7], color=COLORS.ego)
    for i, user in enumerate(users):
        speed.plot(log.t, log.road_users[:, i, 3], color=palette[user.id])
        brake.plot(log.t, -log.user_motion[:, i, 0], color=palette[user.id])
    collision = first_collision(log)
    if collision is not None:
        for axis in column:
            axis.axvline(collision.t, color=COLORS.collision, linewidth=1.0, linestyle=":")
    brake.set_xlabel("time [s]")


def _body_centers(log: Log) -> Array:
    """Body centers along the route from the ego's start, the ego first, shape (n, 1 + n_users)."""
    ego = log.ego_frenet[:, :1] + log.scenario.vehicle.box_offset
    centers: Array = np.hstack((ego, log.user_frenet[:, :, 0])) - log.ego_frenet[0, 0]
    return centers


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
            f"{collision.speed:.1f} m/s", (collision.t, s), (9, -3), textcoords="offset points",
            color=COLORS.collision, weight="bold",
        )  # fmt: skip


def _interesting(logs: Sequence[Log]) -> tuple[float, float]:
    """Time from the first braking to the last standstill of any vehicle in any run [s]."""
    first, last = [], []
    for log in logs:
        v = np.column_stack((log.ego[:, 3], log.road_users[:, :, 3]))
        a = np.column_stack((log.ego[:, 7], log.user_motion[:, :, 0]))
        brakes, moves = (a < -1.0).any(axis=1), (v > MOVING_SPEED).any(axis=1)
        first.append(log.t[np.argmax(brakes)] if brakes.any() else log.t[0])
        last.append(log.t[np.flatnonzero(moves)[-1]] if moves.any() else log.t[-1])
    return max(min(first) - 1.0, min(log.t[0] for log in logs)), max(last) + 1.5
