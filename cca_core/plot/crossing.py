"""A crossing from above and as station over time: the counterpart of Fig 9."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.plot.conflict_area import EVERY, blocked, ego_stations
from cca_core.plot.labels import escape_figure_text, run_heading
from cca_core.plot.legends import color_legend, figure_legend
from cca_core.plot.road_surface import draw_roads
from cca_core.plot.run_labels import run_labels, run_styles
from cca_core.plot.style import (
    COLORS,
    COLUMN_WIDTH,
    TEXT,
    assign_colors,
    lighten,
    mark_collision,
    new_figure,
    set_text_sizes,
)
from cca_core.plot.text_slots import TextSlots, freeze_layout, offsets_around
from cca_core.sim import Log
from cca_core.sim.outcome import MOVING_SPEED, first_collision, row_at

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_crossing(logs: Sequence[Log], *, outcomes: Sequence[str] = ()) -> "Figure":
    """Draw runs in which routes cross, from above and as station over time.

    Parameters
    ----------
    logs : sequence of Log
        Runs of one scenario, from top to bottom. Several runs of one ego type are named by what differs:
        scenario, case or plant, or else a number.
    outcomes : sequence of str, optional
        Added to each run's title, such as `cca_core.report.summarize_outcome`.

    Returns
    -------
    figure : Figure
        For each run the bodies each two seconds from above, to scale, labeled with the time; below, the
        ego's station over time in all runs, with the area in which it would collide with another vehicle.

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
    n = len(logs)
    figure = new_figure(2.75 * n + 3.2, COLUMN_WIDTH)
    *above, below = figure.subplots(n + 1, 1, squeeze=False, height_ratios=[1.3] * n + [1.0])[:, 0]
    nearest = min(logs, key=lambda log: float(log.gaps().min()))
    center = nearest.ego[int(np.argmin(nearest.gaps().min(axis=1))), :2]
    labels = run_labels(logs)
    for i, (log, axis) in enumerate(zip(logs, above, strict=True)):
        draw_roads(axis, log.scenario)
        # half of the view is 32 m across and 20 m up
        axis.set(
            aspect="equal", xlim=center[0] + (-32.0, 32.0), ylim=center[1] + (-20.0, 20.0), ylabel="y [m]"
        )
        axis.set_title(run_heading(labels[i], outcomes, i), fontsize=TEXT.heading, loc="left")
    above[-1].set_xlabel("x [m]")
    _draw_diagram(below, logs)
    color_legend(figure, _palette(logs[0]), loc="outside upper left")
    figure_legend(figure, below.get_legend_handles_labels()[0], loc="outside lower center", ncols=2)
    set_text_sizes(figure)
    freeze_layout(figure)
    for log, axis in zip(logs, above, strict=True):
        slots = TextSlots(axis)
        _draw_bodies(axis, log, slots)
        _mark_collision_above(axis, log, slots)
    return escape_figure_text(figure)


def _palette(log: Log) -> dict[str, str]:
    return {"ego": COLORS.ego, **assign_colors([user.id for user in log.scenario.road_users])}


def _interesting(log: Log) -> float:
    """Time at which the ego left the last conflict area, and 4 s more [s]."""
    in_conflict = blocked(log).any(axis=1)
    if not in_conflict.any():
        return float(log.t[-1])
    last = np.flatnonzero(in_conflict)[-1] * EVERY
    stationary = np.flatnonzero(log.ego[:, 3] < MOVING_SPEED)
    row = max(last, stationary[-1] if len(stationary) else 0)
    return float(min(log.t[min(row, len(log.t) - 1)] + 4.0, log.t[-1]))


def _draw_bodies(
    axis: Any, log: Log, slots: TextSlots, *, period: float = 2.0, min_distance: float = 5.5
) -> None:
    """Draw each body every `period` [s], but not closer than `min_distance` [m] to its last one."""
    ego, others = log.bodies()
    corners = np.concatenate((ego.corners(), others.corners()), axis=1)
    collision = first_collision(log)
    rows = [row_at(log, t) for t in np.arange(log.t[0], log.t[-1] + 1e-6, period).tolist()]
    if collision is not None:
        rows = [row for row in rows if collision.t - log.t[row] > 0.4 * period]
        rows.append(row_at(log, collision.t))
    numbers = []
    for i, (name, color) in enumerate(_palette(log).items()):
        track = corners[:, i].mean(axis=1)
        axis.plot(*track.T, color=color, linewidth=0.8, alpha=0.7, zorder=2)
        seen = track[np.isfinite(track[:, 0])]
        is_moving = np.ptp(seen, axis=0).max() > 1.0
        shown: Array | None = None
        for row in rows if is_moving else rows[-1:]:
            at = track[row]
            if not np.isfinite(at[0]):
                continue
            if shown is not None and np.hypot(*(at - shown)) < min_distance and row != rows[-1]:
                continue
            shown = at
            is_last = not is_moving or (row == rows[-1] and collision is not None)
            axis.fill(
                *corners[row, i].T, facecolor=color if is_last else lighten(color), edgecolor=color,
                linewidth=0.8, zorder=3, gid=f"{name}@{log.t[row]:.1f}",
            )  # fmt: skip
            slots.occupy(corners[row, i])
            numbers.append((f"{log.t[row]:.0f} s" if is_moving else name, at, color))
    (x0, x1), (y0, y1) = axis.get_xlim(), axis.get_ylim()
    for text, (x, y), color in numbers:
        if x0 < x < x1 and y0 < y < y1:
            slots.write(text, (x, y), color, offsets_around(8.0), must=False, weight="bold")


def _mark_collision_above(axis: Any, log: Log, slots: TextSlots) -> None:
    collision = first_collision(log)
    if collision is not None:
        mark_collision(axis, *collision.xy, size=12.0)
        slots.write(
            str(collision).replace(" at ", "\nat "), collision.xy, COLORS.collision, offsets_around(14.0),
            weight="bold",
        )  # fmt: skip


def _draw_diagram(axis: Any, logs: Sequence[Log]) -> None:
    first = logs[0]
    line = first.scenario.stop_line
    base = first.ego_frenet[0, 0] if line is None else line
    longest = max(logs, key=lambda log: log.duration)
    area, stations = blocked(longest), ego_stations(longest) + longest.scenario.vehicle.front - base
    t = longest.t[0] + EVERY * (longest.t[1] - longest.t[0]) * np.arange(len(area))
    color = _palette(first)[first.scenario.road_users[0].id]
    if len(t) > 1:
        axis.contourf(t, stations, area.T.astype(float), levels=(0.5, 1.5), colors=[color], alpha=0.6)
    axis.plot([], [], color=color, alpha=0.6, linewidth=8, label="conflict area")
    for log, name, (color, style) in zip(logs, run_labels(logs), run_styles(logs), strict=True):
        ahead = log.ego_frenet[:, 0] + log.scenario.vehicle.front - base
        axis.plot(log.t, ahead, style, color=color, linewidth=1.6, label=f"ego, {name}")
        collision = first_collision(log)
        if collision is not None:
            mark_collision(axis, collision.t, ahead[row_at(log, collision.t)], size=9.0)
    if line is not None:
        axis.axhline(0.0, color=COLORS.line, linewidth=1.0, linestyle=":", label="stop line")
    end = max(_interesting(log) for log in logs)
    inside = stations[area.any(axis=0)] if area.any() else stations
    axis.set(
        xlabel="time [s]", xlim=(max(first.t[0], end - 12.0), end), ylim=(-22.0, float(inside.max()) + 6.0)
    )
    axis.set_ylabel(f"ego's front beyond\n{'the start' if line is None else 'the stop line'} [m]")
