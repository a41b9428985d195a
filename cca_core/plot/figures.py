"""Two tunings on one axis (the counterpart of Fig. 15), and a run over time."""

from typing import TYPE_CHECKING

import numpy as np

from cca_core._checks import Array
from cca_core._optional import require_extra
from cca_core.errors import InputError
from cca_core.plot.style import (
    ACTIONS,
    EGO,
    LEAST_A_Y,
    assign_colors,
    draw_lanes,
    escape_figure_text,
    expand_limits,
    title,
)
from cca_core.sim import Log

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SMOOTH = "#D55E00"
_SETTLED = 0.05  # a lane change lasts from 5 % to 95 % of its width
_LEAST_ANGLE = 0.4  # height of the view of the road-wheel angle, at least [°]
_FAR = 60.0  # gaps above this are not drawn [m]


def first_lane_change(log: Log) -> tuple[float, float]:
    """Where the first lane change of a run begins and ends.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    start, end : float
        Path coordinates at which the ego has made 5 % and 95 % of its way to the other lane [m].

    Raises
    ------
    InputError
        If the ego never left its lane.
    """
    s, d = log.ego_frenet.T
    left = np.flatnonzero(np.abs(d) > log.scenario.road.ego_lane.width / 2.0)
    if not len(left):
        raise InputError("log must be of a run in which the ego leaves its lane")
    back = np.flatnonzero(np.abs(d[left[0] :]) < 0.5)
    until = left[0] + back[0] if len(back) else len(d)
    peak = left[0] + int(np.argmax(np.abs(d[left[0] : until])))
    way = np.abs(d[: peak + 1] / d[peak])
    start = int(np.flatnonzero(way < _SETTLED)[-1])
    end = start + int(np.argmax(way[start:] > 1.0 - _SETTLED))
    return float(s[start]), float(s[end])


def plot_tunings(fast: Log, smooth: Log) -> "Figure":
    """Draw the paths of two tunings on one axis.

    Parameters
    ----------
    fast, smooth : Log
        Runs on the same road, in both of which the ego changes lane.

    Returns
    -------
    figure : Figure
        Both paths in path coordinates, with the length of the first lane change and the peak lateral
        acceleration of each.

    Raises
    ------
    InputError
        If the ego stays in its lane in one of them.
    MissingExtraError
        If matplotlib is not installed.
    """
    figure: Figure = require_extra("matplotlib.figure", "plot").Figure(
        figsize=(9.0, 3.6), layout="constrained"
    )
    axis = figure.subplots()
    road = fast.scenario.road
    draw_lanes(axis, road)
    view = []
    for i, (log, color, name) in enumerate(((fast, EGO, "fast"), (smooth, _SMOOTH, "smooth"))):
        s, d = log.ego_frenet.T
        start, end = first_lane_change(log)
        height = road.left_edge + 0.6 + 0.9 * i
        aim, peak = log.scenario.evasion.lateral_acceleration, np.abs(log.a_y).max()
        axis.plot(
            s, d, color=color, label=f"{name}: aims at {aim:g} m/s², peak |a_y| {peak:.2f} m/s²",
            linestyle=("-", "--")[i], linewidth=1.8,
        )  # fmt: skip
        axis.vlines((start, end), np.interp((start, end), s, d), height, color=color, linewidth=0.8)
        axis.annotate("", (start, height), (end, height), arrowprops={"arrowstyle": "<->", "color": color})
        axis.annotate(
            f"{name}: lane change in {end - start:.0f} m", (end, height), (6, 0),
            textcoords="offset points", color=color, va="center",
        )  # fmt: skip
        view += np.interp([log.decisions[1][0], log.decisions[-1][0]], log.t, s).tolist()
    axis.set_xlim(min(view) - 20.0, max(view) + 20.0)
    axis.set_ylim(road.right_edge - 0.5, road.left_edge + 2.2)
    axis.set_xlabel("distance along the route [m] (a lane change is counted from 5 % to 95 % of its width)")
    axis.set_ylabel("left of the route [m]")
    axis.set_title("The same traffic, two tunings", loc="left", weight="bold")
    figure.legend(loc="outside lower left", ncols=2, frameon=False)
    return escape_figure_text(figure)


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
    figure: Figure = require_extra("matplotlib.figure", "plot").Figure(
        figsize=(9.0, 7.6), layout="constrained"
    )
    speed, steer, lateral, gap = figure.subplots(4, 1, sharex=True)
    t, palette = log.t, assign_colors([user.id for user in log.scenario.road_users])
    speed.plot(t, log.ego[:, 3], color=EGO, label="ego")
    leader = lead_speed(log)
    speed.plot(
        t, leader, color="black", linewidth=1.0, linestyle="--", label="vehicle in front (within 100 m)"
    )
    speed.set_ylabel("speed [m/s]")
    low, high = np.nanmin([*log.ego[:, 3], *leader]), np.nanmax([*log.ego[:, 3], *leader])
    speed.set_ylim(low - 1.0, high + 1.0 + 0.3 * (high - low))  # the legend needs room
    steer.plot(t, np.degrees(log.ego[:, 6]), color=EGO)
    steer.set_ylabel("road-wheel\nangle [°]")
    expand_limits(steer, _LEAST_ANGLE)
    lateral.plot(t, log.a_y, color=EGO)
    lateral.set_ylabel("lateral acc.\na_y [m/s²]")
    expand_limits(lateral, LEAST_A_Y)
    for i, (user, gaps) in enumerate(zip(log.scenario.road_users, log.gaps().T, strict=True)):
        near = np.where(gaps < _FAR, gaps, np.nan)
        if np.isfinite(near).any():
            gap.plot(t, near, color=palette[user.id], label=user.id, linestyle=("-", "--", "-.", ":")[i % 4])
    gap.axhline(0.0, color="#555555", linewidth=0.8)
    gap.set_ylim(-2.0, 1.3 * _FAR)
    gap.set_ylabel("gap between\nboxes [m]")
    gap.set_xlabel("time [s]")
    for axis in (speed, gap) if len(gap.lines) > 1 else (speed,):
        axis.legend(loc="upper right", fontsize=8, ncols=4, framealpha=0.9)
    ends = [begin for begin, _, _ in log.decisions[1:]] + [float(t[-1])]
    for (begin, name, _), end in zip(log.decisions, ends, strict=True):
        for axis in (speed, steer, lateral, gap):
            axis.axvspan(begin, end, color=ACTIONS[name], linewidth=0.0, zorder=0)
        if end - begin > 0.02 * t[-1]:
            speed.annotate(
                name.replace("_", "\n"), (0.5 * (begin + end), 1.0), (0, 3),
                xycoords=("data", "axes fraction"), textcoords="offset points", ha="center", fontsize=8,
            )  # fmt: skip
    speed.set_xlim(0.0, t[-1])
    figure.suptitle(title(log), x=0.01, ha="left", weight="bold", fontsize=11)
    figure.align_ylabels()
    return escape_figure_text(figure)


def lead_speed(log: Log, *, reach: float = 100.0) -> Array:
    """Speed of the vehicle in front of the ego on the ego's route.

    Parameters
    ----------
    log : Log
        The run.
    reach : float
        How far ahead to look [m].

    Returns
    -------
    v_x : ndarray, shape (n,)
        Its speed [m/s], NaN while there is none.
    """
    if not log.scenario.road_users:
        return np.full(len(log.t), np.nan)
    own = log.scenario.road.ego_lane
    along = log.user_frenet[..., 0] - log.ego_frenet[:, None, 0]
    d = log.user_frenet[..., 1]
    along = np.where((along > 0.0) & (along < reach) & (d < own.left) & (d > own.right), along, np.inf)
    nearest = np.argmin(along, axis=1)
    rows = np.arange(len(log.t))
    v_x: Array = np.where(np.isfinite(along[rows, nearest]), log.road_users[rows, nearest, 3], np.nan)
    return v_x
