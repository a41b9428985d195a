"""Path and traffic at numbered frames: the counterpart of Figs 13-14 and 16-19."""

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array, check_array
from cca_core._optional import require_extra
from cca_core.errors import InputError
from cca_core.plot.frenet_boxes import frenet_corners
from cca_core.plot.key_frames import KeyFrame, key_frames
from cca_core.plot.labels import escape_figure_text, title
from cca_core.plot.style import COLORS, PAGE_WIDTH, TEXT, assign_colors, draw_lanes
from cca_core.plot.text_slots import TextSlots
from cca_core.sim import Log
from cca_core.sim.outcome import row_at

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True, kw_only=True)
class Sheet:
    """Heights from top to bottom, and margins [in]."""

    head: float = 1.1
    overview: float = 1.6
    between: float = 0.5
    strip_title: float = 0.27
    strip: float = 0.62
    foot: float = 0.5
    left: float = 0.65
    right: float = 0.15


_SHEET = Sheet()
_VIEW = (-75.0, 105.0)  # of a strip along the road, relative to the ego [m]


def plot_traffic(log: Log, *, times: Sequence[float] | None = None, caption: str = "") -> "Figure":
    """Draw path and traffic at numbered frames.

    Parameters
    ----------
    log : Log
        The run.
    times : sequence of float, shape (n,), optional
        Times of the frames [s]. The default is a selection of at most six: the collision, changes of the
        action, the closest approach to other vehicles and what these do, the end.
    caption : str
        Text below the title, such as `cca_core.report.describe_run`.

    Returns
    -------
    figure : Figure
        Above, the whole run along the route with each vehicle's box at each frame, numbered; below, a strip
        of road for each frame, the ego at 0. Each box is a polygon with the gid ``"id@frame"``.

    Raises
    ------
    InputError
        If `times` are not finite or empty.
    MissingExtraError
        If matplotlib is not installed.
    """
    frames = (
        key_frames(log) if times is None else _frames_at(log, check_array("times", times, (None,)).tolist())
    )
    if not frames:
        raise InputError("times must hold at least one time")
    sheet, step = _SHEET, _SHEET.strip_title + _SHEET.strip
    height = sheet.head + sheet.overview + sheet.between + len(frames) * step + sheet.foot
    figure: Figure = require_extra("matplotlib.figure", "plot").Figure(figsize=(PAGE_WIDTH, height))
    left = sheet.left / PAGE_WIDTH
    figure.text(left, 1.0 - 0.15 / height, title(log), va="top", weight="bold")
    figure.text(left, 1.0 - 0.42 / height, fill(caption, 118), va="top", fontsize=TEXT.note)

    def axes(top: float, tall: float) -> Any:
        width = 1.0 - (sheet.left + sheet.right) / PAGE_WIDTH
        return figure.add_axes((left, 1.0 - (top + tall) / height, width, tall / height))

    _draw_overview(axes(sheet.head, sheet.overview), log, frames)
    top = sheet.head + sheet.overview + sheet.between + sheet.strip_title
    strips = [axes(top + i * step, sheet.strip) for i in range(len(frames))]
    for i, (axis, frame) in enumerate(zip(strips, frames, strict=True)):
        _draw_strip(axis, log, i + 1, frame)
        axis.set_title(f"{i + 1}   {frame.t:.1f} s   {frame.text}", fontsize=TEXT.note, loc="left", pad=3)
    for axis in strips[:-1]:
        axis.set_xticklabels([])
    wider = _exaggeration(strips[-1], sheet.strip)
    strips[-1].set_xlabel(f"distance ahead of the ego [m] (width drawn {wider})", fontsize=TEXT.axis)
    return escape_figure_text(figure)


def _frames_at(log: Log, times: list[float]) -> list[KeyFrame]:
    frames = []
    for t in times:
        begun = ((name, reason) for begin, name, reason in reversed(log.decisions) if begin <= t)
        frames.append(KeyFrame(t=t, text=": ".join(next(begun, ("", "")))))
    return frames


def _palette(log: Log) -> dict[str, str]:
    return {"ego": COLORS.ego, **assign_colors([user.id for user in log.scenario.road_users])}


def _draw_overview(axis: Any, log: Log, frames: list[KeyFrame]) -> None:
    rows, palette = [row_at(log, frame.t) for frame in frames], _palette(log)
    stations = log.ego_frenet[[*rows, row_at(log, log.decisions[-1][0])], 0]
    view = (stations.min() - 40.0, stations.max() + 40.0)
    _draw_road(axis, log, view)
    axis.plot(log.ego_frenet[:, 0], log.ego_frenet[:, 1], color=COLORS.ego, linewidth=1.2)
    for number, row in enumerate(rows, start=1):
        for id_, box, _ in _boxes(log, row):
            if view[0] < box[:, 0].mean() < view[1]:
                _draw_box(axis, box, palette[id_], f"{id_}@{number}")
                _number_box(axis, log, id_, box, number, palette[id_])
    axis.set_title(
        f"All frames on one road, numbered as below (width drawn {_exaggeration(axis, _SHEET.overview)})",
        fontsize=TEXT.note, loc="left",
    )  # fmt: skip
    axis.set_xlabel("distance along the route [m]", fontsize=TEXT.axis, labelpad=1)
    axis.set_ylabel("left of the\nroute [m]", fontsize=TEXT.axis)
    patches = require_extra("matplotlib.patches", "plot")
    axis.legend(
        handles=[patches.Patch(facecolor=color, label=id_) for id_, color in palette.items()],
        loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(palette), frameon=False, fontsize=TEXT.note,
        handlelength=1.0, columnspacing=1.2, borderaxespad=0.1,
    )  # fmt: skip


def _number_box(axis: Any, log: Log, id_: str, box: Array, number: int, color: str) -> None:
    """Write a frame's number above the ego, or below another vehicle in one of two rows for each lane."""
    users = log.scenario.road_users
    index = next((i for i, user in enumerate(users) if user.id == id_), None)
    if index is None:
        edge, offset = box[:, 1].max(), 6
    else:
        edge, offset = box[:, 1].min(), -5 - 9 * (sum(u.d == users[index].d for u in users[:index]) % 2)
    outline = require_extra("matplotlib.patheffects", "plot").withStroke(
        linewidth=2.0, foreground=COLORS.road
    )
    axis.annotate(
        str(number), (box[:, 0].mean(), edge), (0, offset), textcoords="offset points", color=color,
        fontsize=TEXT.legend, ha="center", va="center_baseline", zorder=4, path_effects=[outline],
    )  # fmt: skip


def _draw_strip(axis: Any, log: Log, number: int, frame: KeyFrame) -> None:
    row = row_at(log, frame.t)
    s, palette = log.ego_frenet[row, 0], _palette(log)
    _draw_road(axis, log, _VIEW)
    behind, ahead = (log.ego_frenet[rows] - (s, 0.0) for rows in (slice(row + 1), slice(row, None)))
    axis.plot(*behind.T, color=COLORS.ego, linewidth=1.2)
    axis.plot(*ahead.T, color=COLORS.ego, linewidth=1.0, linestyle=":")
    slots = TextSlots(axis, _VIEW)
    inside, outside = [], []
    for id_, box, v in _boxes(log, row):
        box = box - (s, 0.0)
        text = f"{id_} {v:.0f} m/s"
        if _VIEW[0] < box[:, 0].mean() < _VIEW[1]:
            _draw_box(axis, box, palette[id_], f"{id_}@{number}")
            slots.occupy(box)
            inside.append((id_, box, text))
        else:
            outside.append((id_, box, text))
    for id_, box, text in outside:
        slots.write_at_border(box, text, palette[id_])
    for id_, box, text in reversed(inside):  # the ego last: it has space on both sides
        slots.write_next_to(box, text, palette[id_], behind_first=id_ == "ego")


def _draw_road(axis: Any, log: Log, view: tuple[float, float]) -> None:
    road = log.scenario.road
    draw_lanes(axis, road)
    axis.set(xlim=view, ylim=(road.right_edge - 0.7, road.left_edge + 0.7))
    axis.tick_params(labelsize=TEXT.legend)
    for lane in road.lanes:
        arrow = "\u2192" if lane.direction > 0 else "\u2190"
        axis.annotate(
            arrow, (view[0], lane.d), (3, 0), textcoords="offset points", va="center_baseline",
            color=COLORS.faint, fontsize=TEXT.legend, zorder=1,
        )  # fmt: skip


def _boxes(log: Log, row: int) -> list[tuple[str, Array, float]]:
    """Id, corners in path coordinates and speed of each vehicle that is present in one cycle."""
    names = ["ego", *(user.id for user in log.scenario.road_users)]
    speeds = np.append(log.ego[row, 3], log.road_users[row, :, 3]).tolist()
    bodies = zip(names, frenet_corners(log, slice(row, row + 1))[0], speeds, strict=True)
    return [body for body in bodies if np.isfinite(body[2])]


def _draw_box(axis: Any, corners: Array, color: str, gid: str) -> None:
    polygon = require_extra("matplotlib.patches", "plot").Polygon
    axis.add_patch(polygon(corners, facecolor=color, edgecolor="white", linewidth=0.4, zorder=3, gid=gid))


def _exaggeration(axis: Any, height: float) -> str:
    (left, right), (low, high) = axis.get_xlim(), axis.get_ylim()
    width = PAGE_WIDTH - _SHEET.left - _SHEET.right
    ratio = height / (high - low) * (right - left) / width
    return f"{ratio:.0f} times larger" if ratio > 3.0 else f"{ratio:.1f} times larger"
