"""Bumper to bumper over time: the counterpart of Figs 6 and 7."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.plot.style import EGO, HIT, assign_colors, ego_label, escape_figure_text, new_figure
from cca_core.plot.verdict import first_collision, summarize_outcome
from cca_core.sim import Log

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BRAKES = -1.0  # acceleration that counts as braking [m/s^2]
_STANDS = 0.1  # [m/s]
_BEFORE, _AFTER = 1.0, 1.5  # shown before the first braking and after the last standstill [s]


def plot_braking(logs: Sequence[Log]) -> "Figure":
    """Draw who is where, how fast, and how hard it brakes, in runs beside each other.

    Parameters
    ----------
    logs : sequence of Log
        Runs of one scenario, from left to right; all on the ego's route.

    Returns
    -------
    figure : Figure
        A column for each run: from top to bottom the place of each body from its rear to its front bumper,
        speeds, and decelerations over time. Where two bands meet the vehicles touch.

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
    for log, (place, speed, brake) in zip(logs, axes.T, strict=True):
        _draw_bands(place, log)
        users = log.scenario.road_users
        palette = assign_colors([user.id for user in users])
        speed.plot(log.t, log.ego[:, 3], color=EGO)
        brake.plot(log.t, -log.ego[:, 7], color=EGO)
        for i, user in enumerate(users):
            speed.plot(log.t, log.road_users[:, i, 3], color=palette[user.id])
            brake.plot(log.t, -log.user_motion[:, i, 0], color=palette[user.id])
        hit = first_collision(log)
        if hit is not None:
            for axis in (place, speed, brake):
                axis.axvline(hit.t, color=HIT, linewidth=1.0, linestyle=":")
        who = ego_label(log)
        place.set_title(f"{who[0].upper()}{who[1:]}\n{summarize_outcome(log)}", fontsize=10, loc="left")
        brake.set_xlabel("time [s]")
    place, speed, brake = axes[:, 0]
    place.set_ylabel("front and rear bumpers,\nfrom the ego's start [m]")
    speed.set_ylabel("speed [m/s]")
    brake.set_ylabel("deceleration [m/s²]")
    first, last = _interesting(logs)
    place.set_xlim(first, last)
    seen = [_middles(log)[(log.t >= first) & (log.t <= last)] for log in logs]
    place.set_ylim(min(s.min() for s in seen) - 10.0, max(s.max() for s in seen) + 10.0)
    place.legend(fontsize=8, loc="upper left")
    return escape_figure_text(figure)


def _middles(log: Log) -> Array:
    """Middle of each body along the route from the ego's start, the ego first, shape (n, 1 + n_users)."""
    own = log.ego_frenet[:, :1] + log.scenario.vehicle.box_offset
    middles: Array = np.hstack((own, log.user_frenet[:, :, 0])) - log.ego_frenet[0, 0]
    return middles


def _draw_bands(axis: Any, log: Log) -> None:
    users = log.scenario.road_users
    palette = assign_colors([user.id for user in users])
    bodies = [("ego", log.scenario.vehicle.length, EGO), *((u.id, u.length, palette[u.id]) for u in users)]
    for (name, length, color), s in zip(bodies, _middles(log).T, strict=True):
        axis.fill_between(log.t, s - 0.5 * length, s + 0.5 * length, color=color, linewidth=0.3, label=name)
    hit = first_collision(log)
    if hit is not None:
        s = _middles(log)[-1, 0] + 0.5 * log.scenario.vehicle.length
        axis.plot(hit.t, s, "x", color=HIT, markersize=11, markeredgewidth=2.5, zorder=5)
        axis.annotate(
            f"{hit.speed:.1f} m/s", (hit.t, s), (9, -3), textcoords="offset points", color=HIT, weight="bold"
        )


def _interesting(logs: Sequence[Log]) -> tuple[float, float]:
    """From when until when something happens, in any of the runs [s]."""
    first, last = [], []
    for log in logs:
        v = np.column_stack((log.ego[:, 3], log.road_users[:, :, 3]))
        a = np.column_stack((log.ego[:, 7], log.user_motion[:, :, 0]))
        brakes, moves = (a < _BRAKES).any(axis=1), (v > _STANDS).any(axis=1)
        first.append(log.t[np.argmax(brakes)] if brakes.any() else log.t[0])
        last.append(log.t[np.flatnonzero(moves)[-1]] if moves.any() else log.t[-1])
    return max(min(first) - _BEFORE, 0.0), max(last) + _AFTER
