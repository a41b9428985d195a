"""Past something on the road, with and without V2V: the counterpart of Figs 11 and 12."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.plot.style import (
    EGO,
    HIT,
    LEAST_A_Y,
    assign_colors,
    draw_lanes,
    ego_label,
    escape_figure_text,
    expand_limits,
    new_figure,
    sanitize_text,
)
from cca_core.plot.verdict import first_collision, summarize_outcome
from cca_core.sim import Log

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_VIEW = -95.0, 75.0  # of the road, from the middle of the obstacle [m]
_PERIOD = 0.5  # between two bodies that are drawn [s]
_LINES = {"v2v": "-", "sensor": "-.", "driver": "--"}
_HUES = {"v2v": EGO, "sensor": "#7A5195", "driver": "#333333"}


def plot_passing(logs: Sequence[Log], obstacle: str) -> "Figure":
    """Draw how runs pass a road user that stands, or fail to.

    Parameters
    ----------
    logs : sequence of Log
        Runs of one scenario, from top to bottom.
    obstacle : str
        Id of who is passed.

    Returns
    -------
    figure : Figure
        A strip of road for each run, with the bodies each half second, to scale; below, all ways of the ego's
        center of gravity beside each other, the width drawn larger, and the lateral accelerations.

    Raises
    ------
    InputError
        If there is no run, or no such road user in one.
    MissingExtraError
        If matplotlib is not installed.
    """
    if not logs:
        raise InputError("logs must hold at least one run")
    at = [_index(log, obstacle) for log in logs]
    figure = new_figure(1.05 * len(logs) + 4.6)
    axes = figure.subplots(len(logs) + 2, 1, height_ratios=[1.0] * len(logs) + [2.2, 1.6])
    *strips, way, push = axes
    for axis, log, i in zip(strips, logs, at, strict=True):
        _draw_strip(axis, log, float(log.user_frenet[-1, i, 0]))
    _draw_ways(way, push, logs, at)
    return escape_figure_text(figure)


def _index(log: Log, obstacle: str) -> int:
    names = [user.id for user in log.scenario.road_users]
    if obstacle not in names:
        raise InputError(f"obstacle must be one of {', '.join(names)}, was {obstacle!r}")
    return names.index(obstacle)


def _corners(log: Log) -> Array:
    """Corners of all bodies in path coordinates, the ego first, shape (n, 1 + n_users, 4, 2)."""
    ego, others = log.bodies()
    corners = np.concatenate((ego.corners(), others.corners()), axis=1)
    near = np.concatenate((log.ego_frenet[:, None, 0], log.user_frenet[:, :, 0]), axis=1)
    s, d = log.scenario.road.path.project(corners, s_guess=np.repeat(near[..., None], 4, axis=-1))
    return np.stack((s, d), axis=-1)


def _draw_strip(axis: Any, log: Log, base: float) -> None:
    road, users = log.scenario.road, log.scenario.road_users
    draw_lanes(axis, road)
    axis.set_aspect("equal")
    axis.set_xlim(*_VIEW)
    axis.set_ylim(road.right_edge - 0.5, road.left_edge + 0.5)
    axis.tick_params(labelsize=8)
    axis.set_ylabel("left [m]", fontsize=7.5)
    names = ["ego", *(user.id for user in users)]
    palette = {"ego": EGO, **assign_colors(names[1:])}
    rows = np.arange(len(log.t) - 1, -1, -round(_PERIOD / (log.t[1] - log.t[0])))
    corners = _corners(log) - (base, 0.0)
    for i, name in enumerate(names):
        moves = np.ptp(log.user_frenet[:, i - 1, 0]) > 1.0 if i else True
        for row in rows if moves else rows[:1]:
            box = corners[row, i]
            if box[:, 0].max() > _VIEW[0] and box[:, 0].min() < _VIEW[1]:
                solid = not moves or (i == 0 and row == rows[0])
                axis.fill(
                    *box.T, facecolor=palette[name], edgecolor="white", linewidth=0.4, zorder=2 + (i == 0),
                    alpha=1.0 if solid else 0.45, gid=f"{name}@{log.t[row]:.2f}",
                )  # fmt: skip
    hit = first_collision(log)
    if hit is not None:
        s = float(corners[-1, 0, :, 0].max())
        axis.plot(s, log.ego_frenet[-1, 1], "x", color=HIT, markersize=11, markeredgewidth=2.5, zorder=5)
    who = ego_label(log)
    axis.set_title(f"{who[0].upper()}{who[1:]}: {summarize_outcome(log)}", fontsize=10, loc="left", pad=3)


def _draw_ways(way: Any, push: Any, logs: Sequence[Log], at: list[int]) -> None:
    log, i = logs[-1], at[-1]
    road = log.scenario.road
    draw_lanes(way, road)
    way.axhline(0.0, color="black", linewidth=0.8, linestyle=":")
    user = log.scenario.road_users[i]
    base = log.user_frenet[-1, i, 0]
    box = _corners(log)[-1, 1 + i] - (base, 0.0)
    way.fill(*box.T, color=assign_colors([u.id for u in log.scenario.road_users])[user.id], zorder=2)
    for run, j in zip(logs, at, strict=True):
        kind = run.scenario.ego_type
        s = run.ego_frenet[:, 0] - run.user_frenet[-1, j, 0]
        near = (s > _VIEW[0] - 5.0) & (s < _VIEW[1] + 5.0)
        label = ego_label(run)
        peak = np.abs(run.a_y).max()
        way.plot(s[near], run.ego_frenet[near, 1], _LINES[kind], color=_HUES[kind], label=label, zorder=3)
        push.plot(s[near], run.a_y[near], _LINES[kind], color=_HUES[kind], label=f"{label}: {peak:.1f} m/s²")
        if first_collision(run) is not None:
            for axis, value in ((way, run.ego_frenet[-1, 1]), (push, run.a_y[-1])):
                axis.plot(s[-1], value, "x", color=HIT, markersize=9, markeredgewidth=2.0, zorder=5)
    if log.scenario.ego_type == "v2v":
        half = 0.5 * log.scenario.vehicle.width
        s = log.ego_frenet[:, 0] - base
        way.fill_between(
            s, log.ego_frenet[:, 1] - half, log.ego_frenet[:, 1] + half, color=EGO, alpha=0.18, linewidth=0.0, zorder=1,
            label="swept by the body",
        )  # fmt: skip
    way.set(xlim=_VIEW, ylim=(road.right_edge - 0.3, road.left_edge + 0.3), ylabel="left of the\nroute [m]")
    way.set_title("The ways of the center of gravity, width drawn larger", fontsize=10, loc="left")
    push.set(xlim=_VIEW, xlabel=f"distance along the route from {sanitize_text(user.id)} [m]")
    push.set_ylabel("lateral acc.\na_y [m/s²]")
    way.legend(fontsize=8, loc="upper left")
    expand_limits(push, LEAST_A_Y, above=0.35)
    push.legend(fontsize=8, loc="upper left", ncols=len(logs))
