"""A crossing from above and as station over time: the counterpart of Fig 9."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.plot.conflict_area import EVERY, blocked, ego_stations
from cca_core.plot.labels import escape_figure_text, run_heading
from cca_core.plot.road_surface import draw_roads
from cca_core.plot.style import COLORS, TEXT, assign_colors, mark_collision, new_figure
from cca_core.sim import Log
from cca_core.sim.outcome import MOVING_SPEED, first_collision, row_at

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_crossing(logs: Sequence[Log], *, outcomes: Sequence[str] = ()) -> "Figure":
    """Draw runs in which routes cross, from above and as station over time.

    Parameters
    ----------
    logs : sequence of Log
        Runs of one scenario, from left to right.
    outcomes : sequence of str, optional
        Second line of each run's title, such as `cca_core.report.summarize_outcome`.

    Returns
    -------
    figure : Figure
        A column for each run: above, the bodies each second, to scale; below, the ego's station over time,
        with the area in which it would collide with another vehicle.

    Raises
    ------
    InputError
        If there is no run, or a run without other road users.
    MissingExtraError
        If matplotlib is not installed.
    """
    if not logs:
        raise InputError("logs must hold at least one run")
    if not all(log.scenario.road_users for log in logs):
        raise InputError("logs must be of scenarios with other road users")
    figure = new_figure(8.2 if len(logs) < 3 else 6.6)
    axes = figure.subplots(2, len(logs), sharey="row", squeeze=False, height_ratios=(1.35, 1.0))
    nearest = min(logs, key=lambda log: float(log.gaps().min()))
    center = nearest.ego[int(np.argmin(nearest.gaps().min(axis=1))), :2]
    end = max(_interesting(log) for log in logs)
    for i, (log, (above, below)) in enumerate(zip(logs, axes.T, strict=True)):
        draw_roads(above, log.scenario)
        _draw_bodies(above, log)
        _mark_collision_above(above, log)
        # half of the view is 34 m across and 30 m up
        above.set(
            aspect="equal", xlim=center[0] + (-34.0, 34.0), ylim=center[1] + (-30.0, 30.0), xlabel="x [m]"
        )
        above.set_title(run_heading(log, outcomes, i), fontsize=TEXT.heading, loc="left")
        _draw_diagram(below, log)
        below.set(xlabel="time [s]", xlim=(logs[0].t[0], end), ylim=(-40.0, 30.0))
    axes[0, 0].set_ylabel("y [m]")
    base = "the stop line" if logs[0].scenario.stop_line is not None else "the start"
    axes[1, 0].set_ylabel(f"ego's front beyond\n{base} [m]")
    axes[1, 0].legend(fontsize=TEXT.legend, loc="lower right")
    return escape_figure_text(figure)


def _interesting(log: Log) -> float:
    """Time at which the ego left the last conflict area, and 4 s more [s]."""
    in_conflict = blocked(log).any(axis=1)
    if not in_conflict.any():
        return float(log.t[-1])
    last = np.flatnonzero(in_conflict)[-1] * EVERY
    stationary = np.flatnonzero(log.ego[:, 3] < MOVING_SPEED)
    row = max(last, stationary[-1] if len(stationary) else 0)
    return float(min(log.t[min(row, len(log.t) - 1)] + 4.0, log.t[-1]))


def _draw_bodies(axis: Any, log: Log, *, period: float = 1.0, min_distance: float = 4.6) -> None:
    """Draw each body every `period` [s], but not closer than `min_distance` [m] to its last one."""
    ego, others = log.bodies()
    corners = np.concatenate((ego.corners(), others.corners()), axis=1)
    collision = first_collision(log)
    rows = [row_at(log, t) for t in np.arange(log.t[0], log.t[-1] + 1e-6, period).tolist()]
    if collision is not None:
        rows = [row for row in rows if collision.t - log.t[row] > 0.4 * period]
        rows.append(row_at(log, collision.t))
    names = ["ego", *(user.id for user in log.scenario.road_users)]
    palette = {"ego": COLORS.ego, **assign_colors(names[1:])}
    for i, name in enumerate(names):
        track = corners[:, i].mean(axis=1)
        axis.plot(*track.T, color=palette[name], linewidth=0.8, alpha=0.7, zorder=2)
        seen = track[np.isfinite(track[:, 0])]
        is_moving = np.ptp(seen, axis=0).max() > 1.0
        shown: Array | None = None
        for row in rows:
            at = track[row]
            if not np.isfinite(at[0]):
                continue
            if shown is not None and np.hypot(*(at - shown)) < min_distance and row != rows[-1]:
                continue
            shown = at
            axis.fill(
                *corners[row, i].T, facecolor=palette[name], edgecolor="white", linewidth=0.5, zorder=3,
                alpha=1.0 if row == rows[-1] and collision is not None else 0.55,
                gid=f"{name}@{log.t[row]:.1f}",
            )  # fmt: skip
            axis.annotate(
                f"{log.t[row]:.0f}" if is_moving else name, at, ha="center", va="center_baseline",
                fontsize=TEXT.tiny, color="white", zorder=4, clip_on=True,
            )  # fmt: skip


def _mark_collision_above(axis: Any, log: Log) -> None:
    collision = first_collision(log)
    if collision is not None:
        mark_collision(axis, *collision.xy, size=14.0)
        axis.annotate(
            str(collision).replace(" at ", "\nat "), collision.xy, (12, 12), textcoords="offset points",
            color=COLORS.collision, weight="bold", fontsize=TEXT.note, zorder=6,
        )  # fmt: skip


def _draw_diagram(axis: Any, log: Log) -> None:
    scenario = log.scenario
    line = scenario.stop_line
    front = scenario.vehicle.front
    base = log.ego_frenet[0, 0] if line is None else line
    area, stations = blocked(log), ego_stations(log) + front - base
    t = log.t[::EVERY]
    if len(area) > len(t):  # beyond a collision, in which a simulated run ends
        t = log.t[0] + EVERY * (log.t[1] - log.t[0]) * np.arange(len(area))
    color = assign_colors([user.id for user in scenario.road_users])[scenario.road_users[0].id]
    if len(t) > 1:
        axis.contourf(t, stations, area.T.astype(float), levels=(0.5, 1.5), colors=[color], alpha=0.45)
    axis.plot([], [], color=color, alpha=0.45, linewidth=8, label="conflict area")
    axis.plot(log.t, log.ego_frenet[:, 0] + front - base, color=COLORS.ego, linewidth=2.0, label="ego")
    if line is not None:
        axis.axhline(0.0, color=COLORS.line, linewidth=1.0, linestyle="--", label="stop line")
    collision = first_collision(log)
    if collision is not None:
        mark_collision(axis, collision.t, log.ego_frenet[row_at(log, collision.t), 0] + front - base)
