"""Path and traffic at numbered frames: the counterpart of Figs 13-14 and 16-19."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array, check_array
from cca_core._optional import require_extra
from cca_core.errors import InputError
from cca_core.plot.frenet_boxes import frenet_corners
from cca_core.plot.key_frames import KeyFrame, key_frames
from cca_core.plot.labels import escape_figure_text, fill_text, is_called_oncoming, title_lines
from cca_core.plot.legends import color_patches, fit_texts
from cca_core.plot.style import COLORS, COLUMN_WIDTH, TEXT, assign_colors, darken, draw_lanes, set_text_sizes
from cca_core.plot.text_slots import TextSlots, offsets_around
from cca_core.sim import Log
from cca_core.sim.export import decision_index, reasons_of_cycles
from cca_core.sim.outcome import row_at

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True, kw_only=True)
class Sheet:
    """Heights from top to bottom, and margins [in]."""

    title: float = 0.45
    line: float = 0.155  # of a text
    overview_title: float = 0.42
    overview: float = 0.15  # per meter across the road
    between: float = 0.5
    strip: float = 0.075  # per meter across the road
    foot: float = 0.55
    left: float = 0.62
    right: float = 0.12
    characters: int = 60  # of a line
    verge: float = 2.2  # next to the road, where texts have space [m]


_SHEET = Sheet()
_VIEW = (-26.0, 54.0)  # of a strip along the road, relative to the ego [m]


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
        Above, the whole run along the route with a numbered mark for each vehicle in each frame; below, a
        strip of road for each frame, the ego at 0. Marks and boxes have the gid ``"id@frame"``.

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
    sheet, road = _SHEET, log.scenario.road
    across = road.left_edge - road.right_edge + 2.0 * sheet.verge
    head, caption = title_lines(log), fill_text(caption, sheet.characters + 4)
    titles = [
        fill_text(f"{i}   {frame.t:.1f} s   {frame.text}", sheet.characters)
        for i, frame in enumerate(frames, 1)
    ]
    top = sheet.title + sheet.line * (head.count("\n") * 1.2 + caption.count("\n") + bool(caption))
    heights = [sheet.line * (text.count("\n") + 1) + 0.1 + sheet.strip * across for text in titles]
    handles, width = color_patches(_palette(log)), 72.0 * (COLUMN_WIDTH - sheet.left - sheet.right)
    legend = fit_texts(handles, width, len(handles))
    above = 17.0 + 1.45 * TEXT.legend * (legend[2] - 1)  # of the legend [pt]
    overview = top + sheet.overview_title + (above - 17.0) / 72.0
    height = overview + sheet.overview * across + sheet.between + sum(heights) + sheet.foot
    figure: Figure = require_extra("matplotlib.figure", "plot").Figure(figsize=(COLUMN_WIDTH, height))
    left = 0.1 / COLUMN_WIDTH
    figure.text(left, 1.0 - 0.1 / height, head, va="top", weight="bold", fontsize=TEXT.title)
    figure.text(
        left,
        1.0 - (top - sheet.line * (caption.count("\n") + 1.6)) / height,
        caption,
        va="top",
        fontsize=TEXT.note,
    )

    def axes(from_top: float, tall: float) -> Any:
        width = 1.0 - (sheet.left + sheet.right) / COLUMN_WIDTH
        return figure.add_axes(
            (sheet.left / COLUMN_WIDTH, 1.0 - (from_top + tall) / height, width, tall / height)
        )

    axis = axes(overview, sheet.overview * across)
    _draw_overview(axis, log, frames)
    axis.set_title(
        "Where each vehicle is in each frame, numbered as below", fontsize=TEXT.note, loc="left", pad=above
    )
    axis.legend(
        handles, legend[0], loc="lower left", bbox_to_anchor=(0.0, 0.99), ncols=legend[1], frameon=False,
        fontsize=TEXT.legend, handlelength=1.0, handletextpad=0.4, columnspacing=1.0, borderaxespad=0.1,
        borderpad=0.2,
    )  # fmt: skip
    below = overview + sheet.overview * across + sheet.between
    for i, (frame, text, tall) in enumerate(zip(frames, titles, heights, strict=True)):
        axis = axes(below + tall - sheet.strip * across, sheet.strip * across)
        _draw_strip(axis, log, i + 1, frame)
        axis.set_title(text, fontsize=TEXT.note, loc="left", pad=3, linespacing=1.1)
        below += tall
        if i < len(frames) - 1:
            axis.set_xticklabels([])
    axis.set_xlabel(f"distance ahead of the ego [m] (width drawn {_exaggeration()})")
    set_text_sizes(figure)
    return escape_figure_text(figure)


def _frames_at(log: Log, times: list[float]) -> list[KeyFrame]:
    index, reasons = decision_index(log), reasons_of_cycles(log)
    rows = [row_at(log, t) for t in times]
    return [
        KeyFrame(t=t, text=f"{log.decisions[index[row]][1]}: {reasons[row]}")
        for t, row in zip(times, rows, strict=True)
    ]


def _palette(log: Log) -> dict[str, str]:
    return {"ego": COLORS.ego, **assign_colors([user.id for user in log.scenario.road_users])}


def _draw_overview(axis: Any, log: Log, frames: list[KeyFrame]) -> None:
    """Draw the ego's path, and a numbered mark for each vehicle in each frame."""
    rows, palette = [row_at(log, frame.t) for frame in frames], _palette(log)
    stations = log.ego_frenet[[*rows, row_at(log, log.decisions[-1][0])], 0]
    view = (stations.min() - 40.0, stations.max() + 40.0)
    _draw_road(axis, log, view)
    axis.plot(log.ego_frenet[:, 0], log.ego_frenet[:, 1], color=COLORS.ego, linewidth=1.2)
    slots = TextSlots(axis, padding=-1.0)
    for id_, color in palette.items():
        for numbers, xy in _stops(log, rows, id_):
            if view[0] < xy[0] < view[1]:
                _draw_number(axis, slots, xy, numbers, color, f"{id_}@{numbers[0]}")
    axis.set_xlabel("distance along the route [m]", labelpad=1)
    axis.set_ylabel("left of route [m]", labelpad=1)


def _stops(log: Log, rows: list[int], id_: str) -> list[tuple[list[int], Array]]:
    """Numbers of consecutive frames in which a vehicle is at one point, and that point [m]."""
    found: list[tuple[list[int], Array]] = []
    for number, row in enumerate(rows, start=1):
        for xy in (box.mean(axis=0) for name, box, _ in _boxes(log, row) if name == id_):
            if found and np.hypot(*(found[-1][1] - xy)) < 1.0:
                found[-1][0].append(number)
            else:
                found.append(([number], xy))
    return found


def _draw_number(axis: Any, slots: TextSlots, xy: Array, numbers: list[int], color: str, gid: str) -> None:
    """Draw the numbers of frames in a disk at a vehicle, moved aside where others are, with a line to it."""
    steps = [0.0] + [sign * 12.0 * k for k in range(1, 5) for sign in (1, -1)]
    offset = slots.free(xy, [(dx, dy) for dy in steps for dx in (0.0, 7.0, -7.0)], 5.5)
    is_moved = offset != (0.0, 0.0)
    axis.annotate(
        str(numbers[0]) if len(numbers) == 1 else f"{numbers[0]}\u2013{numbers[-1]}", xy, offset,
        textcoords="offset points", fontsize=TEXT.tiny, weight="bold", ha="center", va="center_baseline",
        zorder=5, gid=gid, color="white" if darken(color) == color else COLORS.ink,
        bbox={
            "boxstyle": "round,pad=0.2,rounding_size=0.6", "facecolor": color, "edgecolor": "white",
            "linewidth": 0.5,
        },
        arrowprops={"arrowstyle": "-", "color": color, "linewidth": 0.9} if is_moved else None,
    )  # fmt: skip


def _draw_strip(axis: Any, log: Log, number: int, frame: KeyFrame) -> None:
    row = row_at(log, frame.t)
    s, palette = log.ego_frenet[row, 0], _palette(log)
    _draw_road(axis, log, _VIEW)
    axis.set_ylabel("left [m]", labelpad=1)
    behind, ahead = (log.ego_frenet[rows] - (s, 0.0) for rows in (slice(row + 1), slice(row, None)))
    axis.plot(*behind.T, color=COLORS.ego, linewidth=1.2)
    axis.plot(*ahead.T, color=COLORS.ego, linewidth=1.0, linestyle=":")
    slots, inside, outside = TextSlots(axis, ground=COLORS.road), [], []
    ego, users = log.scenario.vehicle.box_offset, log.scenario.road_users
    lengths = {"ego": log.scenario.vehicle.length, **{user.id: user.length for user in users}}
    oncoming = {user.id for user in users if is_called_oncoming(user)}
    for id_, box, v in _boxes(log, row):
        box = box - (s, 0.0)
        x, d = box.mean(axis=0).tolist()
        text = f"{id_} {v:.0f} m/s{' oncoming' if id_ in oncoming else ''}"
        if _VIEW[0] < x < _VIEW[1]:
            _draw_box(axis, box, palette[id_], f"{id_}@{number}")
            slots.occupy(box)
            half = 0.5 * float(np.ptp(axis.transData.transform(box)[:, 0])) * 72.0 / axis.figure.dpi + 2.0
            sides = [(half, 0.0, "left", "center"), (-half, 0.0, "right", "center")]
            inside.append(
                (
                    text,
                    (x, d),
                    palette[id_],
                    [*(sides[::-1] if id_ == "ego" else sides), *offsets_around(6.0)],
                )
            )
        else:
            is_ahead = x > 0.0
            gap = max(abs(x - ego) - 0.5 * (lengths[id_] + lengths["ego"]), 0.0)
            text = f"{text}, {gap:.0f} m ahead \u25b8" if is_ahead else f"\u25c2 {text}, {gap:.0f} m behind"
            rows = _rows(log, d)
            shifts = [(4.0, dy) for dy in rows] + [(60.0, dy) for dy in rows]
            side = "right" if is_ahead else "left"
            border = [(-dx if is_ahead else dx, dy, side, "center") for dx, dy in shifts]
            outside.append((text, (_VIEW[is_ahead], d), palette[id_], border))
    for text, xy, color, offsets in inside + outside:
        slots.write(text, xy, color, offsets)


def _rows(log: Log, d: float) -> list[float]:
    """Heights of texts relative to a lateral offset: there, next to the road, in other lanes [pt]."""
    road, verge = log.scenario.road, 0.5 * _SHEET.verge
    edges = sorted((road.left_edge + verge, road.right_edge - verge), key=lambda edge: abs(edge - d))
    lanes = [lane.d for lane in road.lanes if abs(lane.d - d) > 1.0]
    return [72.0 * _SHEET.strip * (at - d) for at in (d, *edges, *lanes)]


def _draw_road(axis: Any, log: Log, view: tuple[float, float]) -> None:
    road = log.scenario.road
    draw_lanes(axis, road)
    axis.set(xlim=view, ylim=(road.right_edge - _SHEET.verge, road.left_edge + _SHEET.verge))


def _boxes(log: Log, row: int) -> list[tuple[str, Array, float]]:
    """Id, corners in path coordinates and speed of each vehicle that is present in one cycle."""
    names = ["ego", *(user.id for user in log.scenario.road_users)]
    speeds = np.append(log.ego[row, 3], log.road_users[row, :, 3]).tolist()
    bodies = zip(names, frenet_corners(log, slice(row, row + 1))[0], speeds, strict=True)
    return [body for body in bodies if np.isfinite(body[2])]


def _draw_box(axis: Any, corners: Array, color: str, gid: str) -> None:
    polygon = require_extra("matplotlib.patches", "plot").Polygon
    axis.add_patch(polygon(corners, facecolor=color, edgecolor="white", linewidth=0.4, zorder=3, gid=gid))


def _exaggeration() -> str:
    width = COLUMN_WIDTH - _SHEET.left - _SHEET.right
    return f"{_SHEET.strip * (_VIEW[1] - _VIEW[0]) / width:.1f} times larger"
