"""Past a parked vehicle, with and without V2V: the counterpart of Figs 11 and 12."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core.errors import InputError
from cca_core.plot.frenet_boxes import frenet_corners
from cca_core.plot.labels import ego_label, escape_figure_text, run_heading, sanitize_text
from cca_core.plot.style import (
    COLORS,
    EGO_TYPE_STYLES,
    MIN_A_Y_RANGE,
    TEXT,
    assign_colors,
    draw_lanes,
    expand_limits,
    mark_collision,
    new_figure,
)
from cca_core.sim import Log
from cca_core.sim.outcome import final_station, first_collision, row_at

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_VIEW = -95.0, 75.0  # of the road, from the middle of the obstacle [m]


def plot_passing(logs: Sequence[Log], obstacle_id: str, *, outcomes: Sequence[str] = ()) -> "Figure":
    """Draw how runs pass a stationary road user, or collide with it.

    Parameters
    ----------
    logs : sequence of Log
        Runs of one scenario, from top to bottom.
    obstacle_id : str
        Id of the stationary road user.
    outcomes : sequence of str, optional
        Added to each run's title, such as `cca_core.report.summarize_outcome`.

    Returns
    -------
    figure : Figure
        A strip of road for each run, with the bodies each half second, to scale; below, the paths of the
        ego's center of gravity in all runs, the width drawn larger, and the lateral accelerations.

    Raises
    ------
    InputError
        If there is no run, or no such road user in one.
    MissingExtraError
        If matplotlib is not installed.
    """
    if not logs:
        raise InputError("logs must hold at least one run")
    at = [_index(log, obstacle_id) for log in logs]
    figure = new_figure(1.05 * len(logs) + 4.6)
    axes = figure.subplots(len(logs) + 2, 1, height_ratios=[1.0] * len(logs) + [2.2, 1.6])
    *strips, paths, lateral = axes
    for k, (axis, log, i) in enumerate(zip(strips, logs, at, strict=True)):
        _draw_strip(axis, log, final_station(log, i))
        axis.set_title(run_heading(log, outcomes, k, ": "), fontsize=TEXT.heading, loc="left", pad=3)
    _draw_obstacle(paths, logs[-1], at[-1])
    for log, i in zip(logs, at, strict=True):
        _draw_path(paths, lateral, log, i)
    if logs[-1].scenario.ego_type == "v2v":
        _draw_swept(paths, logs[-1], at[-1])
    paths.set_title("Paths of the center of gravity, width drawn larger", fontsize=TEXT.heading, loc="left")
    paths.legend(fontsize=TEXT.legend, loc="upper left")
    lateral.set(xlim=_VIEW, xlabel=f"distance along the route from {sanitize_text(obstacle_id)} [m]")
    lateral.set_ylabel("lateral acc.\na_y [m/s²]")
    expand_limits(lateral, MIN_A_Y_RANGE, above=0.35)
    lateral.legend(fontsize=TEXT.legend, loc="upper left", ncols=len(logs))
    return escape_figure_text(figure)


def _index(log: Log, obstacle_id: str) -> int:
    names = [user.id for user in log.scenario.road_users]
    if obstacle_id not in names:
        raise InputError(f"obstacle_id must be one of {', '.join(names)}, was {obstacle_id!r}")
    return names.index(obstacle_id)


def _draw_strip(axis: Any, log: Log, base: float, *, period: float = 0.5) -> None:
    road = log.scenario.road
    draw_lanes(axis, road)
    axis.set(aspect="equal", xlim=_VIEW, ylim=(road.right_edge - 0.5, road.left_edge + 0.5))
    axis.tick_params(labelsize=TEXT.legend)
    axis.set_ylabel("left [m]", fontsize=TEXT.tiny)
    names = ["ego", *(user.id for user in log.scenario.road_users)]
    palette = {"ego": COLORS.ego, **assign_colors(names[1:])}
    rows = np.arange(len(log.t) - 1, -1, -max(round(period / (log.t[1] - log.t[0])), 1))
    corners = frenet_corners(log) - (base, 0.0)
    for i, name in enumerate(names):
        s = log.user_frenet[log.present[:, i - 1], i - 1, 0]
        is_moving = np.ptp(s) > 1.0 if i else True
        seen = [row for row in rows if i == 0 or log.present[row, i - 1]]
        for row in seen if is_moving else seen[:1]:
            box = corners[row, i]
            if box[:, 0].max() > _VIEW[0] and box[:, 0].min() < _VIEW[1]:
                solid = not is_moving or (i == 0 and row == rows[0])
                axis.fill(
                    *box.T, facecolor=palette[name], edgecolor="white", linewidth=0.4, zorder=2 + (i == 0),
                    alpha=1.0 if solid else 0.45, gid=f"{name}@{log.t[row]:.2f}",
                )  # fmt: skip
    collision = first_collision(log)
    if collision is not None:
        row = row_at(log, collision.t)
        mark_collision(axis, float(corners[row, 0, :, 0].max()), log.ego_frenet[row, 1])


def _draw_obstacle(axis: Any, log: Log, i: int) -> None:
    road, users = log.scenario.road, log.scenario.road_users
    draw_lanes(axis, road)
    axis.axhline(0.0, color="black", linewidth=0.8, linestyle=":")
    row = int(np.flatnonzero(log.present[:, i])[-1])
    box = frenet_corners(log, slice(row, row + 1))[0, 1 + i] - (final_station(log, i), 0.0)
    axis.fill(*box.T, color=assign_colors([user.id for user in users])[users[i].id], zorder=2)
    axis.set(xlim=_VIEW, ylim=(road.right_edge - 0.3, road.left_edge + 0.3), ylabel="left of the\nroute [m]")


def _draw_path(paths: Any, lateral: Any, log: Log, i: int) -> None:
    color, line, _ = EGO_TYPE_STYLES[log.scenario.ego_type]
    s = log.ego_frenet[:, 0] - final_station(log, i)
    near = (s > _VIEW[0] - 5.0) & (s < _VIEW[1] + 5.0)
    label = ego_label(log)
    paths.plot(s[near], log.ego_frenet[near, 1], line, color=color, label=label, zorder=3)
    label += f": {np.abs(log.a_y).max():.1f} m/s²"
    lateral.plot(s[near], log.a_y[near], line, color=color, label=label)
    collision = first_collision(log)
    if collision is not None:
        row = row_at(log, collision.t)
        mark_collision(paths, s[row], log.ego_frenet[row, 1], size=9.0)
        mark_collision(lateral, s[row], log.a_y[row], size=9.0)


def _draw_swept(axis: Any, log: Log, i: int) -> None:
    s, d = (log.ego_frenet - (final_station(log, i), 0.0)).T
    half = 0.5 * log.scenario.vehicle.width
    style = {"color": COLORS.ego, "alpha": 0.18, "linewidth": 0.0, "zorder": 1}
    axis.fill_between(s, d - half, d + half, label="swept by the body", **style)
