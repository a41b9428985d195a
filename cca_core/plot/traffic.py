"""Who was where: path and traffic at numbered frames, the counterpart of Figs 13-14 and 16-19."""

from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array, check_array
from cca_core._optional import require_extra
from cca_core.errors import InputError
from cca_core.plot.story import KeyFrame, describe_run, key_frames
from cca_core.plot.style import ASPHALT, EGO, assign_colors, draw_lanes, escape_figure_text, row_at, title
from cca_core.sim import Log

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_WIDTH, _LEFT, _RIGHT = 9.0, 0.65, 0.15  # of the figure and its margins [in]
_HEAD, _OVERVIEW, _BETWEEN, _FOOT = 1.1, 1.6, 0.5, 0.5  # heights from top to bottom [in]
_TITLE, _STRIP = 0.27, 0.62  # the same of each frame [in]
_VIEW = (-75.0, 105.0)  # what a strip shows of the road, relative to the ego [m]
_TEXT, _LONG_TEXT = 15.0, 36.0  # room for a name and a speed, and for a distance too [m]
_STEP = 2.0  # between the places that are tried for a text [m]
_VERGE = 0.7  # shown beside the road [m]


def plot_traffic(log: Log, *, times: Sequence[float] | None = None) -> "Figure":
    """Draw path and traffic at numbered frames.

    Parameters
    ----------
    log : Log
        The run.
    times : sequence of float, shape (n,), optional
        Times of the frames [s]; the default is chosen by `key_frames`.

    Returns
    -------
    figure : Figure
        Above, the whole drive along the route with each vehicle's box at each frame, numbered; below, a
        strip of road for each frame, the ego at 0. Each box is a polygon with the gid ``"id@frame"``.

    Raises
    ------
    InputError
        If `times` are not finite or none is given.
    MissingExtraError
        If matplotlib is not installed.
    """
    if times is None:
        frames = key_frames(log)
    else:
        frames = [
            KeyFrame(t=t, text=_action_at(log, t)) for t in check_array("times", times, (None,)).tolist()
        ]
    if not frames:
        raise InputError("times must hold at least one time")
    below = len(frames) * (_STRIP + _TITLE)
    height = _HEAD + _OVERVIEW + _BETWEEN + below + _FOOT
    figure: Figure = require_extra("matplotlib.figure", "plot").Figure(figsize=(_WIDTH, height))
    figure.text(_LEFT / _WIDTH, 1.0 - 0.15 / height, title(log), va="top", weight="bold")
    figure.text(_LEFT / _WIDTH, 1.0 - 0.42 / height, fill(describe_run(log), 118), va="top", fontsize=9)

    def axes(top: float, tall: float) -> Any:
        bottom = 1.0 - (top + tall) / height
        return figure.add_axes((_LEFT / _WIDTH, bottom, 1.0 - (_LEFT + _RIGHT) / _WIDTH, tall / height))

    _draw_overview(axes(_HEAD, _OVERVIEW), log, frames)
    for i, frame in enumerate(frames):
        axis = axes(_HEAD + _OVERVIEW + _BETWEEN + i * (_STRIP + _TITLE) + _TITLE, _STRIP)
        _draw_strip(axis, log, i + 1, frame)
        if i + 1 < len(frames):
            axis.set_xticklabels([])
        else:
            wider = _exaggeration(axis, _STRIP)
            axis.set_xlabel(f"distance ahead of the ego [m] (width drawn {wider})", fontsize=8.5)
    return escape_figure_text(figure)


def _action_at(log: Log, t: float) -> str:
    name, reason = next(((n, r) for begin, n, r in reversed(log.decisions) if begin <= t), ("", ""))
    return f"{name}: {reason}"


def _draw_overview(axis: Any, log: Log, frames: list[KeyFrame]) -> None:
    rows = [row_at(log, frame.t) for frame in frames]
    told = log.ego_frenet[[*rows, row_at(log, log.decisions[-1][0])], 0]
    view = (told.min() - 40.0, told.max() + 40.0)
    _draw_road(axis, log, view)
    axis.plot(log.ego_frenet[:, 0], log.ego_frenet[:, 1], color=EGO, linewidth=1.2)
    users = log.scenario.road_users
    palette = {"ego": EGO, **assign_colors([user.id for user in users])}
    outline = require_extra("matplotlib.patheffects", "plot").withStroke(linewidth=2.0, foreground=ASPHALT)
    # numbers above the ego, below the others, in two rows on each lane, so that they do not meet
    down = {user.id: 5 + 9 * (sum(u.d == user.d for u in users[:i]) % 2) for i, user in enumerate(users)}
    for number, row in enumerate(rows, start=1):
        for id_, box, _ in _boxes(log, row):
            s = float(box[:, 0].mean())
            if view[0] < s < view[1]:
                _draw_box(axis, box, palette[id_], f"{id_}@{number}")
                below = id_ in down
                at, offset = (s, box[:, 1].min() if below else box[:, 1].max()), -down[id_] if below else 6
                axis.annotate(
                    str(number), at, (0, offset), textcoords="offset points", color=palette[id_],
                    fontsize=8, ha="center", va="center_baseline", zorder=4, path_effects=[outline],
                )  # fmt: skip
    axis.set_title(
        f"All frames on one road, numbered as below (width drawn {_exaggeration(axis, _OVERVIEW)})",
        fontsize=9, loc="left",
    )  # fmt: skip
    axis.set_xlabel("distance along the route [m]", fontsize=8.5, labelpad=1)
    axis.set_ylabel("left of the\nroute [m]", fontsize=8.5)
    patches = require_extra("matplotlib.patches", "plot")
    axis.legend(
        handles=[patches.Patch(facecolor=color, label=id_) for id_, color in palette.items()],
        loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(palette), frameon=False, fontsize=9,
        handlelength=1.0, columnspacing=1.2, borderaxespad=0.1,
    )  # fmt: skip


def _draw_strip(axis: Any, log: Log, number: int, frame: KeyFrame) -> None:
    row = row_at(log, frame.t)
    s = log.ego_frenet[row, 0]
    _draw_road(axis, log, _VIEW)
    axis.plot(log.ego_frenet[: row + 1, 0] - s, log.ego_frenet[: row + 1, 1], color=EGO, linewidth=1.2)
    axis.plot(log.ego_frenet[row:, 0] - s, log.ego_frenet[row:, 1], color=EGO, linewidth=1.0, linestyle=":")
    axis.set_title(f"{number}   {frame.t:.1f} s   {frame.text}", fontsize=9, loc="left", pad=3)
    palette = {"ego": EGO, **assign_colors([user.id for user in log.scenario.road_users])}
    taken: list[tuple[float, float, float]] = []  # from, to, lateral: where no text may stand
    inside, outside = [], []
    for id_, box, v in _boxes(log, row):
        box = box - (s, 0.0)
        ahead = float(box[:, 0].mean())
        if _VIEW[0] < ahead < _VIEW[1]:
            _draw_box(axis, box, palette[id_], f"{id_}@{number}")
            taken.append((box[:, 0].min(), box[:, 0].max(), box[:, 1].mean()))
            inside.append((id_, *taken[-1], f"{id_} {v:.0f} m/s"))
        else:
            outside.append((id_, ahead, box[:, 1].mean(), f"{id_} {v:.0f} m/s, {abs(ahead):.0f} m"))
    for id_, ahead, d, text in outside:
        if ahead > 0.0:
            places = [(x, "right") for x in np.arange(_VIEW[1] - 1.0, _VIEW[0] + _LONG_TEXT, -_STEP)]
            text += " ahead \u25b8"
        else:
            places = [(x, "left") for x in np.arange(_VIEW[0] + 4.0, _VIEW[1] - _LONG_TEXT, _STEP)]
            text = f"\u25c2 {text} behind"
        _place(axis, places, d, text, palette[id_], _LONG_TEXT, taken)
    for id_, rear, front, d, text in reversed(inside):  # the ego last, which has both sides to choose from
        behind_first = id_ == "ego"
        places = [(front + 1.0, "left"), (rear - 1.0, "right")][:: -1 if behind_first else 1]
        _place(axis, places, d, text, palette[id_], _TEXT, taken)


def _place(
    axis: Any,
    places: list[tuple[float, str]],
    d: float,
    text: str,
    color: str,
    width: float,
    taken: list[tuple[float, float, float]],
) -> None:
    """Write a text at the first place where it meets nothing."""
    for x, align in places:
        left = x if align == "left" else x - width
        inside = _VIEW[0] <= left and left + width <= _VIEW[1]
        if inside and all(left + width < a or left > b or abs(d - other) > 2.0 for a, b, other in taken):
            break
    taken.append((left, left + width, d))
    axis.text(
        x, d, text, color=color, fontsize=8, ha=align, va="center_baseline",
        bbox={"facecolor": ASPHALT, "edgecolor": "none", "pad": 0.5},
    )  # fmt: skip


def _draw_road(axis: Any, log: Log, view: tuple[float, float]) -> None:
    road = log.scenario.road
    draw_lanes(axis, road)
    axis.set_xlim(*view)
    axis.set_ylim(road.right_edge - _VERGE, road.left_edge + _VERGE)
    axis.tick_params(labelsize=8)
    for lane in road.lanes:
        arrow = "\u2192" if lane.direction > 0 else "\u2190"
        axis.annotate(
            arrow, (view[0], lane.d), (3, 0), textcoords="offset points", va="center_baseline",
            color="#888888", fontsize=8, zorder=1,
        )  # fmt: skip


def _boxes(log: Log, row: int) -> list[tuple[str, Array, float]]:
    """Name, corners in path coordinates and speed of everybody in one cycle."""
    ego, others = log.bodies()
    near = np.append(log.ego_frenet[row, 0], log.user_frenet[row, :, 0])
    corners = np.vstack((ego.corners()[row], others.corners()[row]))
    s, d = log.scenario.road.path.project(corners, s_guess=np.repeat(near[:, None], 4, axis=1))
    names = ["ego", *(user.id for user in log.scenario.road_users)]
    speeds = np.append(log.ego[row, 3], log.road_users[row, :, 3])
    boxes = np.stack((s, d), axis=-1)
    return [(name, box, float(v)) for name, box, v in zip(names, boxes, speeds, strict=True)]


def _draw_box(axis: Any, corners: Array, color: str, gid: str) -> None:
    polygon = require_extra("matplotlib.patches", "plot").Polygon
    axis.add_patch(polygon(corners, facecolor=color, edgecolor="white", linewidth=0.4, zorder=3, gid=gid))


def _exaggeration(axis: Any, height: float) -> str:
    (left, right), (low, high) = axis.get_xlim(), axis.get_ylim()
    ratio = height / (high - low) * (right - left) / (_WIDTH - _LEFT - _RIGHT)
    return f"{ratio:.0f} times larger" if ratio > 3.0 else f"{ratio:.1f} times larger"
