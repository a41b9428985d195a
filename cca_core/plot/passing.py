"""Past a parked vehicle, with and without V2V: the counterpart of Figs 11 and 12."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core.errors import InputError
from cca_core.plot.frenet_boxes import frenet_corners
from cca_core.plot.labels import escape_figure_text, fill_text, run_heading, sanitize_text
from cca_core.plot.legends import color_legend, figure_legend
from cca_core.plot.run_labels import run_labels, run_styles
from cca_core.plot.style import (
    COLORS,
    COLUMN_WIDTH,
    MIN_A_Y_RANGE,
    TEXT,
    assign_colors,
    draw_lanes,
    expand_limits,
    lighten,
    mark_collision,
    new_figure,
    set_text_sizes,
)
from cca_core.plot.text_slots import TextSlots, freeze_layout
from cca_core.sim import Log
from cca_core.sim.outcome import final_station, first_collision, row_at

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NEAR = -52.0, 23.0  # of a strip, from the middle of the obstacle [m]
_VIEW = -95.0, 75.0  # of the paths [m]
_SWEPT = "swept by its body with V2V"


def plot_passing(logs: Sequence[Log], obstacle_id: str, *, outcomes: Sequence[str] = ()) -> "Figure":
    """Draw how runs pass a stationary road user, or collide with it.

    Parameters
    ----------
    logs : sequence of Log
        Runs of one scenario, from top to bottom. Several runs of one ego type are named by what differs:
        scenario, case or plant, or else a number.
    obstacle_id : str
        Id of the stationary road user.
    outcomes : sequence of str, optional
        Added to each run's title, such as `cca_core.report.summarize_outcome`.

    Returns
    -------
    figure : Figure
        A strip of road for each run, with the bodies each second, labeled with the time, to scale; below, the
        paths of the ego's center of gravity in all runs, the width drawn larger, and a_y.

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
    n = len(logs)
    figure = new_figure(1.0 * n + 4.9, COLUMN_WIDTH)
    *strips, paths, lateral = figure.subplots(n + 2, 1, height_ratios=[1.0] * n + [1.7, 1.5])
    labels = run_labels(logs)
    for k, (axis, log) in enumerate(zip(strips, logs, strict=True)):
        road = log.scenario.road
        draw_lanes(axis, road)
        axis.set(aspect="equal", xlim=_NEAR, ylim=(road.right_edge - 2.5, road.left_edge + 2.5), yticks=[])
        axis.set_title(run_heading(labels[k], outcomes, k), fontsize=TEXT.heading, loc="left", pad=3)
        if k < n - 1:
            axis.set_xticklabels([])
    name = sanitize_text(obstacle_id)
    strips[-1].set_xlabel(fill_text(f"distance along the route from {name} [m], to scale", 60))
    _draw_obstacle(paths, logs[-1], at[-1])
    for log, i, label, style in zip(logs, at, labels, run_styles(logs), strict=True):
        _draw_path(paths, lateral, log, i, label, style)
    if logs[-1].scenario.ego_type == "v2v":
        _draw_swept(paths, logs[-1], at[-1])
    paths.set_title("Paths of the ego's center, width drawn larger", fontsize=TEXT.heading, loc="left")
    paths.set_xticklabels([])
    lateral.set(xlim=_VIEW, xlabel=fill_text(f"distance along the route from {name} [m]", 60))
    lateral.set_ylabel("lateral acc.\na_y [m/s²]")
    expand_limits(lateral, MIN_A_Y_RANGE)
    lateral.locator_params(axis="y", nbins=5)
    color_legend(figure, _palette(logs[-1]), loc="outside upper left")
    lines, bands = (
        {label: handle for handle, label in zip(*axis.get_legend_handles_labels(), strict=True)}
        for axis in (lateral, paths)
    )
    lines |= {label: handle for label, handle in bands.items() if label == _SWEPT}
    figure_legend(
        figure, list(lines.values()), loc="outside lower left", ncols=1, alignment="left",
        title="Ego, and its peak lateral acceleration:", title_fontsize=TEXT.legend,
    )  # fmt: skip
    set_text_sizes(figure)
    freeze_layout(figure)
    for axis, log, i in zip(strips, logs, at, strict=True):
        _draw_strip(axis, log, final_station(log, i))
    return escape_figure_text(figure)


def _palette(log: Log) -> dict[str, str]:
    return {"ego": COLORS.ego, **assign_colors([user.id for user in log.scenario.road_users])}


def _index(log: Log, obstacle_id: str) -> int:
    names = [user.id for user in log.scenario.road_users]
    if obstacle_id not in names:
        raise InputError(f"obstacle_id must be one of {', '.join(names)}, was {obstacle_id!r}")
    return names.index(obstacle_id)


def _draw_strip(axis: Any, log: Log, base: float, *, period: float = 1.0) -> None:
    collision = first_collision(log)
    last = len(log.t) - 1 if collision is None else row_at(log, collision.t)
    rows = np.arange(last, -1, -max(round(period / (log.t[1] - log.t[0])), 1))
    corners = frenet_corners(log) - (base, 0.0)
    slots, numbers = TextSlots(axis, ground=COLORS.road), []
    for i, (name, color) in enumerate(_palette(log).items()):
        s = log.user_frenet[log.present[:, i - 1], i - 1, 0]
        is_moving = np.ptp(s) > 1.0 if i else True
        seen = [row for row in rows if i == 0 or log.present[row, i - 1]]
        for row in seen if is_moving else seen[:1]:
            box = corners[row, i]
            if box[:, 0].max() > _NEAR[0] and box[:, 0].min() < _NEAR[1]:
                solid = not is_moving or (i == 0 and row == rows[0])
                axis.fill(
                    *box.T, facecolor=color if solid else lighten(color), edgecolor=color, linewidth=0.8,
                    zorder=2 + (i == 0), gid=f"{name}@{log.t[row]:.2f}",
                )  # fmt: skip
                slots.occupy(box)
                numbers.append((f"{log.t[row]:.0f} s" if is_moving else name, box, color, i))
    for text, box, color, i in numbers:
        up, x = 6.5, float(np.clip(box[:, 0].mean(), _NEAR[0] + 2.5, _NEAR[1] - 2.5))
        above, below = (0.0, up, "center", "bottom"), (0.0, -up, "center", "top")
        slots.write(
            text, (x, box[:, 1].mean()), color, (below, above) if i == 0 else (above, below), must=False,
            fontsize=TEXT.tiny,
        )  # fmt: skip
    if collision is not None:
        mark_collision(axis, float(corners[last, 0, :, 0].max()), log.ego_frenet[last, 1], size=9.0)


def _draw_obstacle(axis: Any, log: Log, i: int) -> None:
    road, users = log.scenario.road, log.scenario.road_users
    draw_lanes(axis, road)
    axis.axhline(0.0, color="black", linewidth=0.8, linestyle=":")
    row = int(np.flatnonzero(log.present[:, i])[-1])
    box = frenet_corners(log, slice(row, row + 1))[0, 1 + i] - (final_station(log, i), 0.0)
    axis.fill(*box.T, color=assign_colors([user.id for user in users])[users[i].id], zorder=2)
    axis.set(xlim=_VIEW, ylim=(road.right_edge - 0.3, road.left_edge + 0.3), ylabel="left of the\nroute [m]")


def _draw_path(
    paths: Any, lateral: Any, log: Log, i: int, label: str, style: tuple[str, str]
) -> None:  # fmt: skip
    color, line = style
    s = log.ego_frenet[:, 0] - final_station(log, i)
    near = (s > _VIEW[0] - 5.0) & (s < _VIEW[1] + 5.0)
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
    axis.fill_between(s, d - half, d + half, label=_SWEPT, **style)
