"""Sketch of a scenario before it begins: the counterpart of Figs 5, 8 and 10."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cca_core.geometry import box_gap, boxes
from cca_core.path import Path
from cca_core.plot.labels import (
    break_title,
    escape_figure_text,
    is_called_oncoming,
    sanitize_text,
    scenario_name,
)
from cca_core.plot.road_surface import draw_roads
from cca_core.plot.style import (
    COLORS,
    COLUMN_WIDTH,
    TEXT,
    assign_colors,
    draw_lanes,
    new_figure,
    set_text_sizes,
)
from cca_core.plot.text_slots import Offset, TextSlots, freeze_layout, offsets_around
from cca_core.sim import (
    BrakeAction,
    LateralShiftAction,
    ReactToLeadAction,
    RoadUser,
    Scenario,
    SpeedAction,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_EXAGGERATION = 2.0  # of the width of a road along the route
_ROW = 12.0  # height of a text [pt]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Body:
    """A vehicle at the start: body center (s, d) on a path, direction, speed, size, color, text."""

    id: str
    path: Path
    s: float
    d: float
    direction: int
    v: float
    length: float
    width: float
    color: str
    text: str


class Shape(NamedTuple):
    """A body in an axis: center and heading."""

    body: Body
    x: float
    y: float
    psi: float


def plot_layout(scenario: Scenario) -> "Figure":
    """Sketch the vehicles at the start, and what each is going to do.

    Parameters
    ----------
    scenario : Scenario
        The scenario.

    Returns
    -------
    figure : Figure
        From above. A scenario with other roads is drawn to scale in the plane, any other one along the ego's
        route with the width drawn larger. Arrows show the directions; vehicles outside of the view are named
        at its border, with the gap to the ego.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    figure = new_figure(2.3, COLUMN_WIDTH)
    axis = figure.subplots()
    prepare = _prepare_plane if scenario.other_roads else _prepare_strip
    bodies = prepare(axis, scenario)
    name = break_title(sanitize_text(scenario_name(scenario)))
    figure.set_figheight(figure.get_figheight() + 0.17 * name.count("\n"))
    figure.suptitle(name, x=0.02, ha="left", weight="bold", fontsize=TEXT.title)
    set_text_sizes(figure)
    freeze_layout(figure)
    road = scenario.road
    _draw_bodies(axis, bodies, None if scenario.other_roads else (road.right_edge, road.left_edge))
    return escape_figure_text(figure)


def _describe_actions(user: RoadUser) -> str:
    """Speed and actions, such as ``"29 m/s, brakes with 7 m/s² at 3 s"``."""
    parts = ["stands still" if user.v_x == 0.0 else f"{user.v_x:.0f} m/s"]
    if is_called_oncoming(user):
        parts[0] += " oncoming"
    for action in user.actions:
        if isinstance(action, BrakeAction):
            parts.append(f"brakes with {action.deceleration:.0f} m/s² at {action.t:.0f} s")
        elif isinstance(action, ReactToLeadAction):
            parts.append(f"brakes after {action.lead_id}")
        elif isinstance(action, LateralShiftAction):
            parts.append(f"moves {abs(action.offset):.0f} m {'left' if action.offset > 0.0 else 'right'}")
        elif isinstance(action, SpeedAction):
            parts.append(f"changes to {action.v_x:.0f} m/s at {action.t:.0f} s")
    return ", ".join(parts)


def _bodies(scenario: Scenario, digits: int) -> list[Body]:
    """Bodies of all, the ego first."""
    palette = assign_colors([user.id for user in scenario.road_users])
    route, ego, v = scenario.road.path, scenario.vehicle, scenario.v_x
    return [
        Body(
            id="ego", path=route, s=scenario.start + ego.box_offset, d=0.0, direction=1, v=v,
            length=ego.length, width=ego.width, color=COLORS.ego, text=f"ego: {v:.{digits}f} m/s",
        ),
        *(
            Body(
                id=u.id, path=u.route or route, s=u.s, d=u.d, direction=u.direction, v=u.v_x, length=u.length,
                width=u.width, color=palette[u.id], text=f"{sanitize_text(u.id)}: {_describe_actions(u)}",
            )
            for u in scenario.road_users
        ),
    ]  # fmt: skip


def _prepare_plane(
    axis: Any, scenario: Scenario, *, margin: float = 8.0, max_size: float = 90.0
) -> list[Shape]:
    """Draw the roads from above; in view are the ego, its route to the junction and stationary vehicles."""
    draw_roads(axis, scenario)
    axis.set_aspect("equal")
    path, start = scenario.road.path, scenario.start
    line = start + 50.0 if scenario.stop_line is None else scenario.stop_line
    route = path.position(np.linspace(start, min(line + 30.0, path.end), 200))
    axis.plot(
        *path.position(np.linspace(start, path.end, 400)).T,
        color=COLORS.ego,
        linewidth=1.4,
        linestyle=":",
        zorder=1,
    )
    points = [*route]
    for user in scenario.road_users:
        ((x, y),) = (user.route or path).to_cartesian([user.s], [user.d])
        if user.v_x == 0.0 and np.hypot(x - route[0, 0], y - route[0, 1]) < max_size:
            points.append(np.array((x, y)))
    low, high = np.min(points, axis=0) - margin, np.max(points, axis=0) + margin
    wide, tall = np.minimum(high - low, max_size)
    x, y = 0.5 * (low + high)
    axis.figure.set_figheight(min(4.6, 4.0 * max(tall, 0.45 * wide) / wide + 0.88))
    axis.set(
        xlim=(x - 0.5 * wide, x + 0.5 * wide), xlabel="x [m]", ylabel="y [m]",
        ylim=(y - 0.5 * max(tall, 0.45 * wide), y + 0.5 * max(tall, 0.45 * wide)),
    )  # fmt: skip
    return [_in_plane(body) for body in _bodies(scenario, 1)]


def _in_plane(body: Body) -> Shape:
    ((x, y),) = body.path.to_cartesian([body.s], [body.d])
    psi = float(body.path.heading(body.s)) + (0.0 if body.direction > 0 else np.pi)
    return Shape(body=body, x=float(x), y=float(y), psi=psi)


def _prepare_strip(
    axis: Any, scenario: Scenario, *, margin: float = 12.0, max_distance: float = 100.0
) -> list[Shape]:
    """Draw the road along the route, with the vehicles within `max_distance` [m] in view."""
    road, start = scenario.road, scenario.start
    draw_lanes(axis, road)
    axis.axhline(0.0, color=COLORS.route, linewidth=0.9, linestyle=":", zorder=0.4)
    bodies = _bodies(scenario, 0)
    ahead = [body.s - start for body in bodies]
    near = [distance for distance in ahead if abs(distance) < max_distance]
    right = 3.5 * margin if max(ahead) > max(near) and max(near) > 0.0 else 2.0 * margin  # room for a text
    low, high = min(near) - margin, max(near) + right
    scale = _EXAGGERATION * (COLUMN_WIDTH - 0.75) / (high - low)  # per meter across [in]
    verge = 2.2 * _ROW / 72.0 / scale
    axis.figure.set_figheight(scale * (road.left_edge - road.right_edge + 2.0 * verge) + 0.8)
    axis.set(
        xlim=(low, high), ylim=(road.right_edge - verge, road.left_edge + verge),
        ylabel="left of the\nroute [m]",
        xlabel=f"distance ahead of the ego [m] (width drawn {_EXAGGERATION:g} times larger)",
    )  # fmt: skip
    return [
        Shape(body=body, x=body.s - start, y=body.d, psi=0.0 if body.direction > 0 else np.pi)
        for body in bodies
    ]


def _draw_bodies(axis: Any, shapes: list[Shape], edges: tuple[float, float] | None) -> None:
    """Draw bodies with arrows and texts, off the road between `edges` if they are given [m].

    Those outside of the view are named at its border.
    """
    slots = TextSlots(axis)
    (x0, x1), (y0, y1) = axis.get_xlim(), axis.get_ylim()
    path = shapes[0].body.path
    for point in path.position(np.arange(path.start, path.end, 1.0)) if edges is None else ():
        slots.occupy(point[None])
    inside = [each for each in shapes if x0 < each.x < x1 and y0 < each.y < y1]
    for each in inside:
        body = each.body
        corners = boxes(each.x, each.y, each.psi, body.length, body.width).corners()
        axis.fill(*corners.T, facecolor=body.color, edgecolor="white", linewidth=0.5, zorder=3)
        slots.occupy(corners)
        if body.v > 0.0:
            ahead = np.array((np.cos(each.psi), np.sin(each.psi)))
            tail = (each.x, each.y) + 0.5 * body.length * ahead
            axis.annotate(
                "", tail + 0.08 * (x1 - x0) * ahead, tail,
                arrowprops={"arrowstyle": "-|>", "color": body.color, "linewidth": 1.2},
            )  # fmt: skip
    for each in inside:
        around = offsets_around(10.0) if edges is None else _rows(axis, each.y, edges)
        found = slots.write(each.body.text, (each.x, each.y), each.body.color, around, weight="bold")
        if edges is not None and found is not None:
            line = {"arrowstyle": "-", "color": each.body.color, "linewidth": 0.7, "shrinkA": 0, "shrinkB": 0}
            axis.annotate(
                "", (each.x, each.y), (0.0, found[1]), textcoords="offset points", arrowprops=line, zorder=2
            )
    ego = shapes[0]
    for each in shapes:
        if each not in inside:
            x, y = float(np.clip(each.x, x0, x1)), float(np.clip(each.y, y0, y1))
            far = f"{each.body.text}, {_gap(ego, each, along=edges is not None):.0f} m"
            right = each.x > x1
            text = (
                f"{far} ahead \u25b8" if right else f"\u25c2 {far} behind" if each.x < x0 else f"{far} away"
            )
            side, step = ("right", -4.0) if right else ("left", 4.0)
            heights = [sign * 11.0 * k for k in range(5) for sign in (1, -1)]
            if edges is not None:  # below the road: above it are the lines to the texts of bodies
                heights = [dy - 5.0 for _, dy, _, va in _rows(axis, y, edges)[::3] if va == "top"] + heights
            slots.write(
                text, (x, y), each.body.color, [(step, dy, side, "center") for dy in heights], weight="bold"
            )


def _gap(a: Shape, b: Shape, *, along: bool) -> float:
    """Gap between two bodies, along the road or in the plane [m]."""
    if along:
        return max(abs(a.x - b.x) - 0.5 * (a.body.length + b.body.length), 0.0)
    shapes = [boxes(each.x, each.y, each.psi, each.body.length, each.body.width) for each in (a, b)]
    return float(box_gap(*shapes))


def _rows(axis: Any, y: float, edges: tuple[float, float]) -> list[Offset]:
    """Offsets of texts above and below the road, of which each covers the height of its point."""
    pixels = axis.transData.transform([(0.0, at) for at in (y, *edges)])[:, 1]
    below, above = 72.0 / axis.figure.dpi * (pixels[1:] - pixels[0])
    return [
        (dx, edge + sign * (5.0 + _ROW * k), side, vertical)
        for k in range(3)
        for edge, sign, vertical in ((above, 1.0, "bottom"), (below, -1.0, "top"))
        for dx, side in ((0.0, "center"), (-12.0, "left"), (12.0, "right"))
    ]
