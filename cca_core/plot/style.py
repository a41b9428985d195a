"""How figures look: every color, the line styles, the sizes of texts, and the parts that figures share."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from cca_core._optional import require_extra
from cca_core.path import Road

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True, kw_only=True)
class Colors:
    """Colors of all figures; blue and orange are of the Okabe-Ito set, for color-blind readers."""

    ego: str = "#0072B2"
    second: str = "#D55E00"  # the other one of two curves
    paper: str = "#882255"  # the band as printed
    failed: str = "#CC79A7"  # a band that must not be driven
    collision: str = "#A33000"
    parked: str = "#777777"
    goal: str = "#009E73"
    admissible: str = "#A9D8F5"
    ink: str = "#333333"
    line: str = "#555555"  # lane boundaries, zero lines
    route: str = "#777777"
    faint: str = "#888888"  # lane arrows, lanelet bounds
    road: str = "#F2F2F2"  # in path coordinates
    asphalt: str = "#E3E3E3"  # in the plane, next to the verge
    verge: str = "#F6F7F4"


COLORS = Colors()

ROLE_COLORS = {
    "red": "#D62F27",
    "yellow": "#E0A800",
    "truck": "#56606B",
    "R1": "#009E73",
    "R2": "#CC79A7",
    "R3": "#8C6239",
    "A": "#D55E00",
}
"""Color of each road user of the built-in scenarios, the same in all cases."""

VEHICLE_COLORS = ("#D55E00", "#009E73", "#CC79A7", "#8C6239", "#56606B", "#E69F00")
"""Colors of other road users in the order of their ids; they repeat."""

ACTION_COLORS = {
    "KEEP": "#EEEEEE",
    "FOLLOW": "#F5E97A",
    "EVADE_LEFT": "#A9D8F5",
    "EVADE_RIGHT": "#C3B8EE",
    "BRAKE": "#F3A683",
}
"""Background color of each action."""

EGO_TYPE_STYLES = {
    "v2v": (COLORS.ego, "-", "o"),
    "sensor": ("#7A5195", "-.", "^"),
    "driver": (COLORS.ink, "--", "s"),
}
"""Color, line and marker of each ego type."""

METHOD_STYLES = {
    "band, eq 9": (COLORS.paper, "o"),
    "band, relaxed": (COLORS.ego, "D"),
    "band, QP": ("#009E73", "s"),
    "primitives": ("#CC79A7", "v"),
    "RRT": ("#E69F00", "^"),
    "RRT*": ("#56606B", "P"),
    "LTV MPC": ("#56B4E9", "*"),
    "NMPC, FATROP": ("#D55E00", "X"),
    "NMPC, IPOPT": ("#44AA99", "<"),
    "FISS": ("#000000", ">"),
}
"""Color and marker of each planning method."""

DASHES = (0, (8, 6))
"""Dashes of a lane boundary."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TextSizes:
    """Sizes of texts [pt]."""

    tiny: float = 7.5
    legend: float = 8.0
    axis: float = 8.5
    note: float = 9.0
    heading: float = 9.0
    title: float = 10.5


TEXT = TextSizes()

PAGE_WIDTH = 9.0
"""Width of a figure [in]."""

COLUMN_WIDTH = 4.6
"""Width of a figure that is read on a phone, or next to another one [in]."""

MIN_A_Y_RANGE = 1.0
"""Height of a view of lateral acceleration, at least [m/s^2]."""


def assign_colors(ids: Sequence[str]) -> dict[str, str]:
    """Color of each road user; the same ids get the same colors."""
    taken = {ROLE_COLORS[id_] for id_ in ids if id_ in ROLE_COLORS}
    free = [color for color in VEHICLE_COLORS if color not in taken] or VEHICLE_COLORS
    others = sorted(set(ids) - ROLE_COLORS.keys())
    palette = {id_: free[i % len(free)] for i, id_ in enumerate(others)}
    return {id_: ROLE_COLORS.get(id_) or palette[id_] for id_ in ids}


def new_figure(height: float, width: float = PAGE_WIDTH) -> "Figure":
    """Empty figure [in] that lays itself out and belongs to no window."""
    figure: Figure = require_extra("matplotlib.figure", "plot").Figure(
        figsize=(width, height), layout="constrained"
    )
    return figure


def darken(color: str, fraction: float = 1.0) -> str:
    """Color for texts: a darker one of the same hue, which is legible on a light background."""
    r, g, b = (int(color[i : i + 2], 16) for i in (1, 3, 5))
    factor = min(fraction, 110.0 / (0.3 * r + 0.6 * g + 0.1 * b + 1e-9))
    return "#" + "".join(f"{round(factor * part):02X}" for part in (r, g, b))


def lighten(color: str) -> str:
    """Color of a body at an earlier time: a lighter one, which is opaque."""
    return "#" + "".join(f"{round(0.45 * int(color[i : i + 2], 16) + 0.55 * 255):02X}" for i in (1, 3, 5))


def set_text_sizes(figure: "Figure") -> None:
    """Give the axes of a narrow figure texts of one size."""
    for axis in figure.axes:
        axis.tick_params(labelsize=TEXT.axis)
        axis.xaxis.label.set_fontsize(TEXT.axis)
        axis.yaxis.label.set_fontsize(TEXT.axis)


def draw_lanes(axis: Any, road: Road) -> None:
    """Draw lanes and edges of a road in path coordinates; the view along the road is unchanged."""
    axis.axhspan(road.right_edge, road.left_edge, color=COLORS.road, zorder=0)
    for d in {lane.right for lane in road.lanes} | {lane.left for lane in road.lanes}:
        if d in (road.right_edge, road.left_edge):
            axis.axhline(d, color=COLORS.line, linewidth=1.2)
        else:
            axis.axhline(d, color=COLORS.line, linewidth=0.8, linestyle=DASHES)
    axis.set_yticks([lane.d for lane in road.lanes])


def mark_collision(axis: Any, x: float, y: float, size: float = 11.0) -> None:
    """Draw the cross of a collision."""
    axis.plot(x, y, "x", color=COLORS.collision, markersize=size, markeredgewidth=0.22 * size, zorder=5)


def expand_limits(axis: Any, min_height: float, *, above: float = 0.0) -> None:
    """Widen a view to a height at least, so that noise looks small; `above` is a fraction for a legend."""
    low, high = axis.get_ylim()
    lack = 0.5 * max(min_height - (high - low), 0.0)
    axis.set_ylim(low - lack, high + lack + above * (high - low + 2.0 * lack))
