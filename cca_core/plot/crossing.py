"""A crossing from above and as time against way: the counterpart of Fig 9."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.geometry import box_gap, boxes
from cca_core.plot.road_surface import draw_roads
from cca_core.plot.style import EGO, HIT, assign_colors, ego_label, escape_figure_text, new_figure, row_at
from cca_core.plot.verdict import first_collision, summarize_outcome
from cca_core.sim import Log

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_VIEW = 34.0, 30.0  # half of what is shown from above, across and up [m]
_PERIOD = 1.0  # between two bodies that are drawn [s]
_STEP, _EVERY = 0.25, 2  # of the diagram: way [m] and cycles
_STANDS = 0.1  # [m/s]
_AFTER = 2.0  # for which others are taken to drive on after a contact [s]
_WAY = -40.0, 30.0  # of the diagram, from the line [m]
_BESIDE = 4.6  # least distance between two bodies that are drawn [m]


def plot_crossing(logs: Sequence[Log]) -> "Figure":
    """Draw runs in which ways cross, from above and as time against way.

    Parameters
    ----------
    logs : sequence of Log
        Runs of one scenario, from left to right.

    Returns
    -------
    figure : Figure
        A column for each run: above, the bodies each second, to scale; below, the ego's way over time, with
        the places at which it would touch another then.

    Raises
    ------
    InputError
        If there is no run, or nobody else in one.
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
    middle = nearest.ego[int(np.argmin(nearest.gaps().min(axis=1))), :2]
    end = max(_interesting(log) for log in logs)
    for log, (above, below) in zip(logs, axes.T, strict=True):
        _draw_view(above, log, middle)
        _draw_diagram(below, log)
        who = ego_label(log)
        above.set_title(f"{who[0].upper()}{who[1:]}\n{summarize_outcome(log)}", fontsize=10, loc="left")
        above.set_xlabel("x [m]")
        below.set(xlabel="time [s]", xlim=(0.0, end), ylim=_WAY)
    axes[0, 0].set_ylabel("y [m]")
    base = "the stop line" if logs[0].scenario.stop_line is not None else "the start"
    axes[1, 0].set_ylabel(f"ego's front beyond\n{base} [m]")
    axes[1, 0].legend(fontsize=8, loc="lower right")
    return escape_figure_text(figure)


def _interesting(log: Log) -> float:
    """When the ego has left all places where it could touch another by 2 s, or the run has ended [s]."""
    ahead = _blocked(log).any(axis=1)
    if not ahead.any():
        return float(log.t[-1])
    last = np.flatnonzero(ahead)[-1] * _EVERY
    stands = np.flatnonzero(log.ego[:, 3] < _STANDS)
    row = max(last, stands[-1] if len(stands) else 0)
    return float(min(log.t[min(row, len(log.t) - 1)] + 4.0, log.t[-1]))


def _draw_view(axis: Any, log: Log, middle: Array) -> None:
    draw_roads(axis, log.scenario)
    axis.set_aspect("equal")
    axis.set_xlim(middle[0] - _VIEW[0], middle[0] + _VIEW[0])
    axis.set_ylim(middle[1] - _VIEW[1], middle[1] + _VIEW[1])
    users = log.scenario.road_users
    ego, others = log.bodies()
    corners = np.concatenate((ego.corners(), others.corners()), axis=1)
    rows = [row_at(log, t) for t in np.arange(log.t[0], log.t[-1] + 1e-6, _PERIOD).tolist()]
    if first_collision(log) is not None:
        rows = [row for row in rows if log.t[-1] - log.t[row] > 0.4 * _PERIOD] + [len(log.t) - 1]
    names = ["ego", *(user.id for user in users)]
    palette = {"ego": EGO, **assign_colors(names[1:])}
    for i, name in enumerate(names):
        track = corners[:, i].mean(axis=1)
        axis.plot(*track.T, color=palette[name], linewidth=0.8, alpha=0.7, zorder=2)
        told: Array | None = None
        for row in rows:
            at = corners[row, i].mean(axis=0)
            if told is not None and np.hypot(*(at - told)) < _BESIDE and row != rows[-1]:
                continue
            told = at
            last = row == rows[-1] and first_collision(log) is not None
            axis.fill(
                *corners[row, i].T, facecolor=palette[name], edgecolor="white", linewidth=0.5, zorder=3,
                alpha=1.0 if last else 0.55, gid=f"{name}@{log.t[row]:.1f}",
            )  # fmt: skip
            moves = np.ptp(track, axis=0).max() > 1.0
            text = f"{log.t[row]:.0f}" if moves else name
            axis.annotate(
                text, at, ha="center", va="center_baseline", fontsize=7, color="white", zorder=4, clip_on=True
            )
    hit = first_collision(log)
    if hit is not None:
        axis.plot(*hit.xy, "x", color=HIT, markersize=14, markeredgewidth=3.0, zorder=5)
        axis.annotate(
            str(hit).replace(" at ", "\nat "), hit.xy, (12, 12), textcoords="offset points", color=HIT,
            weight="bold", fontsize=9, zorder=6,
        )  # fmt: skip


def _ways(log: Log) -> Array:
    """Path coordinates of the ego's center of gravity that are looked at."""
    path = log.scenario.road.path
    return np.arange(log.ego_frenet[0, 0], min(log.ego_frenet[-1, 0] + 15.0, path.end), _STEP)


def _poses(log: Log) -> Array:
    """Place and heading of the others, shape (m, n_users, 3); after a contact as if they drove on."""
    poses = log.road_users[::_EVERY, :, :3]
    if first_collision(log) is None:
        return poses
    step = log.t[1] - log.t[0]
    rows = _EVERY * np.arange(len(poses), len(poses) + int(_AFTER / (_EVERY * step)))
    after = step * (rows - len(log.t) + 1)
    _, _, psi, v = log.road_users[-1].T
    way = np.stack((v * np.cos(psi), v * np.sin(psi), 0.0 * v), axis=-1)
    return np.concatenate((poses, log.road_users[-1, :, :3] + after[:, None, None] * way))


def _blocked(log: Log) -> "np.ndarray[Any, np.dtype[np.bool_]]":
    """At which of some times (rows) the ego would touch another at which places of its route (columns)."""
    path, vehicle, ways = log.scenario.road.path, log.scenario.vehicle, _ways(log)
    (x, y), psi = path.position(ways).T, path.heading(ways)
    ego = vehicle.body_at(x, y, psi)
    poses = _poses(log)
    touched = np.zeros((len(poses), len(ways)), dtype=bool)
    for i, user in enumerate(log.scenario.road_users):
        ux, uy, upsi = poses[:, i].T[:, :, None]
        touched |= box_gap(ego, boxes(ux, uy, upsi, user.length, user.width)) <= 0.0
    return touched


def _draw_diagram(axis: Any, log: Log) -> None:
    scenario = log.scenario
    line = scenario.stop_line
    front = scenario.vehicle.front
    base = log.ego_frenet[0, 0] if line is None else line
    touched, ways = _blocked(log), _ways(log) + front - base
    t = log.t[0] + _EVERY * (log.t[1] - log.t[0]) * np.arange(len(touched))
    color = assign_colors([user.id for user in scenario.road_users])[scenario.road_users[0].id]
    axis.contourf(t, ways, touched.T.astype(float), levels=(0.5, 1.5), colors=[color], alpha=0.45)
    axis.plot([], [], color=color, alpha=0.45, linewidth=8, label="would touch another")
    axis.plot(log.t, log.ego_frenet[:, 0] + front - base, color=EGO, linewidth=2.0, label="ego")
    if line is not None:
        axis.axhline(0.0, color="#555555", linewidth=1.0, linestyle="--", label="stop line")
    hit = first_collision(log)
    if hit is not None:
        axis.plot(
            hit.t, log.ego_frenet[-1, 0] + front - base, "x", color=HIT, markersize=11, markeredgewidth=2.5
        )
