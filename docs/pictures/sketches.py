"""Draw the sketches of the pages: what lies where, to scale where a page gives numbers."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, Polygon, Rectangle

from cca_core import VehicleParams, relax_band
from cca_core.geometry import box_gap, boxes
from cca_core.plot.style import COLORS
from cca_core.v2x import position_bounds

EGO, OTHER, GRAY, GREEN = COLORS.ego, COLORS.second, COLORS.parked, COLORS.goal
CAR = VehicleParams.bmw_320i()
LANE = 3.5  # [m]
WIDTH = 4.8  # of a picture, so that its texts are legible on a phone [in]


def road(
    axis: Any, x: tuple[float, float], lanes: tuple[float, ...] = (0.0, LANE), stretch: float = 1.0
) -> None:
    """Straight lanes around their centers; widths are drawn larger by `stretch`."""
    low, high = min(lanes) - 0.5 * LANE, max(lanes) + 0.5 * LANE
    axis.add_patch(Rectangle((x[0], low), x[1] - x[0], high - low, color=COLORS.asphalt, zorder=0))
    for y in (low, high):
        axis.plot(x, (y, y), color=COLORS.line, linewidth=1.0, zorder=1)
    for y in sorted(lanes)[:-1]:
        middle = y + 0.5 * LANE
        axis.plot(x, (middle, middle), color="white", linewidth=1.5, linestyle=(0, (6, 5)), zorder=1)
    axis.set_xlim(*x)
    axis.set_aspect(stretch)
    axis.axis("off")


def body(
    axis: Any,
    x: float,
    y: float,
    color: str,
    psi: float = 0.0,
    size: tuple[float, float] = (4.5, 1.8),
    **options: Any,
) -> None:
    """Vehicle with its windshield to the front."""
    axis.add_patch(Polygon(boxes(x, y, psi, *size).corners(), facecolor=color, zorder=4, **options))
    at = 0.22 * size[0]
    glass = boxes(x + at * np.cos(psi), y + at * np.sin(psi), psi, 0.12 * size[0], 0.75 * size[1])
    axis.add_patch(Polygon(glass.corners(), facecolor="white", alpha=0.6, zorder=4))


def arrow(
    axis: Any, start: tuple[float, float], end: tuple[float, float], color: str, style: str = "->"
) -> None:
    """Arrow between two points."""
    properties = {"arrowstyle": style, "color": color, "shrinkA": 0, "shrinkB": 0, "linewidth": 1.2}
    axis.annotate("", end, start, arrowprops=properties, zorder=5)


def reference_points() -> Figure:
    """Axes of the library and of a screen, and the reference points of a vehicle."""
    fig, (here, there) = plt.subplots(
        2, 1, figsize=(WIDTH, 5.2), layout="constrained", height_ratios=(6.6, 4.3)
    )
    for axis, up, name, limits in (
        (here, 1.0, "the library (ISO 8855)", (-3.4, 3.2)),
        (there, -1.0, "a screen, CARLA, highway-env", (-3.3, 1.0)),
    ):
        axis.set(xlim=(-4.6, 4.6), ylim=limits, aspect="equal")
        axis.set_title(name, fontsize=10)
        axis.axis("off")
        arrow(axis, (0.0, 0.0), (3.8, 0.0), COLORS.ink)
        arrow(axis, (0.0, 0.0), (0.0, 2.6 * up), COLORS.ink)
        axis.text(3.9, 0.0, "x", va="center")
        axis.text(0.0, 2.95 * up, "y", ha="center", va="center")
        turn = np.linspace(0.0, 0.9 * up, 30)
        axis.plot(2.6 * np.cos(turn), 2.6 * np.sin(turn), color=OTHER)
        arrow(
            axis,
            (2.6 * np.cos(turn[-2]), 2.6 * np.sin(turn[-2])),
            (2.6 * np.cos(turn[-1]), 2.6 * np.sin(turn[-1])),
            OTHER,
        )
        axis.text(2.7, 1.6 * up, "positive angle", color=OTHER, va="center")
    there.text(-3.4, -1.0, "angles grow\nclockwise", color=GRAY, va="center")
    size = (CAR.length, CAR.width)
    here.add_patch(Polygon(boxes(0.0, 0.0, 0.0, *size).corners(), facecolor=EGO, alpha=0.25, zorder=1))
    points = (
        (0.5 * CAR.length, "front bumper", -1.2, "left"),
        (0.0, "center of gravity: VehicleState\ncenter of the body: RemoteVehicle", -2.6, "left"),
        (-CAR.l_r, "rear axle", -1.2, "right"),
    )
    for x, name, y, side in points:
        here.plot(x, 0.0, "o", color=EGO, zorder=6)
        here.plot((x, x), (0.0, y + 0.25), color=EGO, linewidth=0.8)
        here.text(x + (0.1 if side == "left" else -0.1), y, name, color=EGO, ha=side, va="top", fontsize=8)
    return fig


def preview() -> Figure:
    """Errors of the steering law."""
    fig, axis = plt.subplots(figsize=(WIDTH, 2.2), layout="constrained")
    turn = np.linspace(-0.25, 0.62, 100)
    radius = 60.0
    axis.plot(radius * np.sin(turn), radius * (1.0 - np.cos(turn)), "--", color="black", label="path")
    h, e_psi, ahead = 4.0, 0.2, 22.0
    front = (ahead * np.cos(e_psi), h + ahead * np.sin(e_psi))
    body(axis, 0.0, h, EGO, e_psi, (6.0, 2.4))
    axis.plot((0.0, front[0]), (h, front[1]), color=EGO)
    axis.plot((0.0, 28.0), (0.0, 0.0), color=GRAY, linewidth=1.0)
    axis.plot(*front, "o", color=EGO)
    arrow(axis, (0.0, 0.0), (0.0, h), OTHER, "<->")
    arrow(axis, (front[0], 0.0), front, OTHER, "<->")
    axis.plot(0.0, 0.0, "o", color="black", markersize=4)
    axis.text(0.5, 0.3, "$h$", color=OTHER)
    axis.text(front[0] + 0.5, 0.3 * front[1], "$e_y$", color=OTHER, va="center")
    axis.text(0.45 * front[0], h + 0.7 * front[1] - 1.2, "$l_s$", color=EGO, ha="right")
    axis.text(8.2, h + 0.55, "$e_\\psi$", color=EGO)
    axis.plot((0.0, 12.0), (h, h), color=GRAY, linewidth=0.8, linestyle=":")
    axis.text(front[0], front[1] + 0.7, "preview point", color=EGO, ha="center")
    axis.text(0.0, -1.8, "foot point", ha="center")
    axis.text(28.3, 0.0, "tangent", color=GRAY, va="center")
    axis.text(32.0, 11.0, "path", ha="right")
    axis.set(xlim=(-14.0, 36.0), ylim=(-3.0, 12.5), aspect="equal")
    axis.axis("off")
    return fig


def gap_zone() -> Figure:
    """Eq 11 for a faster car from behind: a short maneuver is accepted, a long one is rejected."""
    fig, axes = plt.subplots(2, 1, figsize=(WIDTH, 2.7), layout="constrained", height_ratios=(9.6, 12.0))
    front, closing, safety = -60.0, 10.0, 7.0
    for axis, t in zip(axes, (4.0, 6.0), strict=True):
        road(axis, (-72.0, 42.0), stretch=2.0)
        axis.set_ylim(-4.4 if axis is axes[1] else -2.0, 7.6)
        end = front + closing * t + safety
        accepted = end < -0.5 * CAR.length
        axis.add_patch(
            Rectangle(
                (front - 4.5 - safety, LANE - 1.3), end - front + 4.5 + safety, 2.6, color=OTHER, alpha=0.3
            )
        )
        body(axis, front - 2.25, LANE, OTHER)
        body(axis, 0.0, 0.0, EGO)
        body(axis, 30.0, 0.0, GRAY)
        arrow(axis, (front + 1.0, LANE), (end, LANE), OTHER)
        axis.text(front, LANE + 2.0, "$X_1$", ha="center", color=OTHER)
        axis.text(end, LANE + 2.0, "$X_2$", ha="center", color=OTHER)
        word = "accepted" if accepted else "rejected: the zone covers the ego"
        axis.set_title(f"maneuver of {t:g} s: {word}", fontsize=9, loc="left", pad=1)
    axes[1].text(0.0, -4.2, "ego", color=EGO, ha="center")
    axes[1].text(30.0, -4.2, "slow car", color=GRAY, ha="center")
    axes[1].text(front, -4.2, "10 m/s faster", color=OTHER, ha="center")
    return fig


def old_messages() -> Figure:
    """Where a car at 20 m/s may be, for messages of different age."""
    ages = (0.0, 0.1, 1.0, 2.0)
    fig, axes = plt.subplots(len(ages), 1, figsize=(WIDTH, 2.8), layout="constrained")
    for axis, age in zip(axes, ages, strict=True):
        road(axis, (-28.0, 28.0), (0.0,))
        along, across = position_bounds(20.0, age)
        size = 4.5 + 2.0 * along, 1.8 + 2.0 * across
        axis.add_patch(
            Rectangle((-0.5 * size[0], -0.5 * size[1]), *size, facecolor=OTHER, alpha=0.3, zorder=2)
        )
        body(axis, 0.0, 0.0, OTHER)
        axis.text(-27.0, 0.0, f"{age:g} s old", va="center", fontsize=9)
        axis.text(
            27.0, 0.0, f"± {along:.1f} m along\n± {across:.1f} m across", ha="right", va="center", fontsize=8
        )
    return fig


def crossing() -> Figure:
    """Conflict area of a crossing vehicle."""
    fig, axis = plt.subplots(figsize=(WIDTH, 2.3), layout="constrained")
    axis.add_patch(Rectangle((-30.0, -1.75), 60.0, 3.5, color=COLORS.asphalt, zorder=0))
    angle, half = np.radians(60.0), 0.5 * 1.8
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    strip = [-15.0 * along + 1.75 * across, 15.0 * along + 1.75 * across]
    strip += [15.0 * along - 1.75 * across, -15.0 * along - 1.75 * across]
    axis.add_patch(Polygon(strip, color=COLORS.asphalt, zorder=0))
    swept = (1.8 / 2 + half * np.cos(angle)) / np.sin(angle)
    area = [(-swept, -half), (swept - 2 * half / np.tan(angle), -half), (swept, half)]
    area.append((-swept + 2 * half / np.tan(angle), half))
    axis.add_patch(Polygon(area, facecolor=OTHER, alpha=0.35, hatch="//", edgecolor=OTHER, zorder=2))
    enter, leave = -swept - 0.5 * CAR.length, swept + 0.5 * CAR.length
    for s, name in ((enter, "s_enter"), (leave, "s_exit")):
        axis.plot((s, s), (-2.6, 2.2), color=EGO, linewidth=1.0, linestyle=":")
        axis.text(s, -3.5, name, color=EGO, ha="right" if s < 0.0 else "left", fontsize=9)
    body(axis, -20.0, 0.0, EGO)
    body(axis, -8.0 * np.cos(angle), -8.0 * np.sin(angle), OTHER, angle)
    axis.plot((-17.0, 14.0), (0.0, 0.0), color=EGO, linewidth=1.0, linestyle="--")
    start = -5.2 * along
    arrow(axis, (start[0], start[1]), (9.0 * along[0], 9.0 * along[1]), OTHER)
    arrow(axis, (14.0, 0.0), (17.0, 0.0), EGO)
    axis.text(-20.0, 2.1, "ego", color=EGO, ha="center")
    axis.text(-6.6, -8.6, "other vehicle", color=OTHER, ha="right")
    axis.text(5.5, 3.0, "conflict area", color=OTHER)
    axis.set(xlim=(-25.0, 20.0), ylim=(-9.5, 8.5), aspect="equal")
    axis.axis("off")
    return fig


def warning_zones() -> Figure:
    """Where each warning looks."""
    fig, axis = plt.subplots(figsize=(WIDTH, 1.4), layout="constrained")
    road(axis, (-16.0, 44.0), (-LANE, 0.0, LANE))
    body(axis, 0.0, 0.0, EGO)
    half = 0.5 * CAR.width
    for sign, name in ((1.0, "BSW, LCW"), (-1.0, "BSW, LCW")):
        low = sign * (half + 0.5) if sign > 0 else -half - 3.0
        zone = Rectangle((-0.5 * CAR.length - 3.0, low), 0.5 * CAR.length + 3.0, 2.5, color=OTHER, alpha=0.45)
        axis.add_patch(zone)
        axis.text(-5.8, 2.5 * sign, name, color=OTHER, ha="right", va="center", fontsize=8)
    axis.add_patch(Polygon([(3.0, -0.9), (40.0, -0.9), (40.0, 0.9), (3.0, 0.9)], color=GREEN, alpha=0.35))
    axis.text(
        21.0,
        0.0,
        "FCW: lead vehicle;  curb-side: stationary",
        color=COLORS.ink,
        ha="center",
        va="center",
        fontsize=8,
    )
    axis.add_patch(Rectangle((8.0, LANE - 1.2), 33.0, 2.4, color=EGO, alpha=0.25))
    axis.text(24.5, LANE, "DNPW, LTA: oncoming", color=COLORS.ink, ha="center", va="center", fontsize=8)
    axis.plot((3.0, 42.0, 42.0, 3.0, 3.0), (-5.0, -5.0, 5.1, 5.1, -5.0), ":", color=GRAY, linewidth=1.2)
    axis.text(
        41.3,
        -LANE,
        "EEBL: hard braking within 300 m, any lane",
        ha="right",
        va="center",
        fontsize=7.5,
    )
    axis.text(-3.4, 0.0, "ego", color=EGO, ha="right", va="center", fontsize=8)
    axis.set_ylim(-6.0, 6.0)
    return fig


def gap_bound() -> Figure:
    """Gap of the ego's body to a box along the band, and its bound from the gaps at the nodes."""
    fig, (plane, graph) = plt.subplots(
        2, 1, figsize=(WIDTH, 4.0), layout="constrained", height_ratios=(1.0, 1.4)
    )
    y, box, nodes = 3.4, boxes(0.4, 0.0, 0.5, 4.5, 1.8), np.linspace(-9.0, 9.0, 6)

    def gap(x: np.ndarray) -> np.ndarray:
        return box_gap(boxes(x, np.full_like(x, y), np.zeros_like(x), 4.5, 1.8), box)

    for x in nodes:
        outline = boxes(float(x), y, 0.0, 4.5, 1.8).corners()
        plane.add_patch(Polygon(outline, facecolor=EGO, alpha=0.2, edgecolor=EGO))
    plane.plot(nodes, np.full_like(nodes, y), "o--", color=EGO, markersize=4, linewidth=1.0)
    plane.add_patch(Polygon(box.corners(), facecolor=GRAY))
    plane.text(0.0, y + 1.3, "ego's body at the nodes of the band", color=EGO, ha="center", fontsize=8)
    plane.set(xlim=(-11.5, 11.5), ylim=(-2.2, 5.6), aspect="equal")
    plane.axis("off")
    dense = np.linspace(nodes[1], nodes[-2], 300)
    graph.plot(dense, gap(dense), color="black", linewidth=1.2, label="gap")
    at = gap(nodes)
    graph.plot(nodes, at, "o", color=EGO, label="at the nodes")
    for i in range(1, len(nodes) - 2):
        between = np.linspace(nodes[i], nodes[i + 1], 30)
        before = at[i] + (between - nodes[i]) * (at[i] - at[i - 1]) / (nodes[i] - nodes[i - 1])
        slope = (at[i + 2] - at[i + 1]) / (nodes[i + 2] - nodes[i + 1])
        bound = np.maximum(before, at[i + 1] + (between - nodes[i + 1]) * slope)
        graph.plot(between, bound, color=OTHER, label="bound" if i == 1 else None)
    graph.set(xlabel="along the band [m]", ylabel="gap [m]", xlim=(-9.5, 9.5), ylim=(-0.4, 6.0))
    graph.legend(fontsize=8, loc="upper center", ncols=3)
    return fig


def safe_stop() -> Figure:
    """Draw a plan, the part that is driven before the next decision, and its two safe ends."""
    fig, axis = plt.subplots(figsize=(WIDTH, 2.0), layout="constrained")
    road(axis, (8.0, 104.0), stretch=3.0)
    nodes = np.column_stack((np.arange(0.0, 101.0), np.zeros(101)))
    slow = boxes(52.0, -0.2, 0.0, 4.5, 1.8)
    band = relax_band(nodes, [slow], side="left", vehicle=CAR)
    x, u = nodes[:, 0], band.displacement
    axis.plot(x, u, color=EGO, linestyle="--", linewidth=1.0, zorder=3)
    begin, committed, stop = 20, 28, 62
    axis.plot(x[begin : committed + 1], u[begin : committed + 1], color=EGO, linewidth=4.0, zorder=3)
    axis.plot(x[committed : stop + 1], u[committed : stop + 1], color=OTHER, linewidth=2.5, zorder=3)
    ratio = np.linspace(0.0, 1.0, 18)
    back = u[committed] * (1.0 - 10 * ratio**3 + 15 * ratio**4 - 6 * ratio**5)
    axis.plot(x[committed] + ratio * 17.0, back, color=GREEN, linewidth=2.5, zorder=3)
    body(axis, x[begin], u[begin], EGO, 0.03)
    body(axis, 52.0, -0.2, GRAY)
    axis.text(x[begin] + 3.0, -2.9, "0.4 s of the plan", color=EGO, ha="center", fontsize=8)
    axis.text(103.0, 3.2, "safe end 1: brake on the path", color=OTHER, fontsize=8, ha="right")
    axis.text(44.0, -2.9, "safe end 2: return, then brake", color=GREEN, ha="left", fontsize=8)
    axis.text(103.0, 0.8, "rest of the plan", color=EGO, fontsize=8, ha="right")
    axis.set_ylim(-3.2, 5.6)
    return fig


def rig_links() -> Figure:
    """Draw the processes of the rig and the links between them."""
    fig, axis = plt.subplots(figsize=(WIDTH, 3.6), layout="constrained")
    axis.set(xlim=(0.0, 15.0), ylim=(0.0, 6.0))
    axis.axis("off")
    parts = (
        (
            0.2,
            1.6,
            4.2,
            4.2,
            "plant",
            "ego's car, traffic,\nsensor,\ndrive-by-wire kit,\nmodems of others",
            OTHER,
        ),
        (10.6, 1.6, 4.2, 4.2, "vehicle", "tracker, planner,\nsteering, safe stop,\nmodem of the ego", EGO),
        (5.4, 0.1, 4.2, 1.2, "monitor", "reads along, one page", GRAY),
    )
    for x, y, w, h, name, text, color in parts:
        style = FancyBboxPatch(
            (x, y), w, h, boxstyle="round,pad=0.05", facecolor=color, alpha=0.2, edgecolor=color
        )
        axis.add_patch(style)
        axis.text(x + 0.5 * w, y + h - 0.15, name, ha="center", va="top", weight="bold")
        axis.text(x + 0.5 * w, y + 0.4 * h, text, ha="center", va="center", fontsize=8)
    links = (
        (5.1, "->", "CAN: state,\nstatus of the kit, 50 Hz"),
        (4.1, "<-", "CAN: commands 50 Hz,\nsafe stop 10 Hz"),
        (3.1, "<->", "radio: messages\nas bytes"),
        (2.1, "->", "UDP: detections\nof the sensor"),
    )
    for y, style, text in links:
        arrow(axis, (4.5, y), (10.5, y), COLORS.ink, style)
        axis.text(7.5, y + 0.08, text, ha="center", va="bottom", fontsize=8)
    axis.plot((7.5, 7.5), (1.4, 2.0), ":", color=GRAY)
    return fig


SKETCHES: tuple[Callable[[], Figure], ...] = (
    reference_points, preview, gap_zone, old_messages, crossing, warning_zones, gap_bound,
    safe_stop, rig_links,
)  # fmt: skip


def main() -> None:
    """Draw the sketches next to this file."""
    for sketch in SKETCHES:
        mpl.rcParams.update({"svg.hashsalt": sketch.__name__, "svg.fonttype": "none", "font.size": 10})
        mpl.rcParams["font.family"] = "sans-serif"
        fig = sketch()
        name = Path(__file__).with_name(f"{sketch.__name__}.svg")
        fig.savefig(name, bbox_inches="tight", pad_inches=0.05, metadata={"Date": None})
        plt.close(fig)


if __name__ == "__main__":
    main()
