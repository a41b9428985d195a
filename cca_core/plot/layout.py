"""Sketch of a scenario before it begins: the counterpart of Figs 5, 8 and 10."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cca_core.geometry import boxes
from cca_core.path import Path
from cca_core.plot.labels import escape_figure_text, fill_text, sanitize_text, scenario_name
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
from cca_core.plot.text_slots import TextSlots, freeze_layout, offsets_around
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
        at its border, with their distance.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    if scenario.other_roads:
        figure = new_figure(3.6, COLUMN_WIDTH)
        axis = figure.subplots()
        bodies = _prepare_plane(axis, scenario)
    else:
        figure = new_figure(2.3, COLUMN_WIDTH)
        axis = figure.subplots()
        bodies = _prepare_strip(axis, scenario)
    name = fill_text(sanitize_text(scenario_name(scenario)), 46)
    figure.suptitle(name, x=0.02, ha="left", weight="bold", fontsize=TEXT.title)
    set_text_sizes(figure)
    freeze_layout(figure)
    road = scenario.road
    _draw_bodies(axis, bodies, None if scenario.other_roads else (road.right_edge, road.left_edge))
    return escape_figure_text(figure)


def _describe_actions(user: RoadUser) -> str:
    """Speed and actions, such as ``"29 m/s, brakes with 7 m/s² at 3 s"``."""
    parts = ["stands still" if user.v_x == 0.0 else f"{user.v_x:.0f} m/s"]
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
    axis.figure.set_figheight(min(4.6, 3.8 * max(tall, 0.45 * wide) / wide + 1.0))
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
    axis.set(
        xlim=(min(near) - margin, max(near) + right), ylabel="left of the\nroute [m]",
        ylim=(road.right_edge - 4.5, road.left_edge + 4.5),
        xlabel="distance ahead of the ego [m] (width drawn larger)",
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
    scale = 72.0 / axis.figure.dpi
    for each in inside:
        around, arrow = offsets_around(10.0), None
        if edges is not None:
            pixels = axis.transData.transform([(each.x, edge) for edge in (each.y, *edges)])[:, 1]
            below, above = scale * (pixels[1:] - pixels[0])
            around = [
                (dx, edge + sign * (8.0 + 12.0 * k), side, vertical)
                for k in range(3)
                for edge, sign, vertical in ((above, 1.0, "bottom"), (below, -1.0, "top"))
                for dx, side in ((0.0, "center"), (-12.0, "left"), (12.0, "right"))
            ]
            arrow = {"arrowstyle": "-", "color": each.body.color, "linewidth": 0.7}
        slots.write(
            each.body.text, (each.x, each.y), each.body.color, around, weight="bold", arrowprops=arrow
        )
    ego = shapes[0]
    for each in shapes:
        if each not in inside:
            x, y = float(np.clip(each.x, x0, x1)), float(np.clip(each.y, y0, y1))
            far = f"{each.body.text}, {np.hypot(each.x - ego.x, each.y - ego.y):.0f} m"
            right = each.x > x1
            text = (
                f"{far} ahead \u25b8" if right else f"\u25c2 {far} behind" if each.x < x0 else f"{far} away"
            )
            side = "right" if right else "left"
            step = -4.0 if right else 4.0
            slots.write(
                text, (x, y), each.body.color,
                [(step, sign * 11.0 * k, side, "center") for k in range(5) for sign in (1, -1)],
                weight="bold",
            )  # fmt: skip
