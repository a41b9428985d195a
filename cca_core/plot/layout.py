"""Sketch of a scenario before it begins: the counterpart of Figs 5, 8 and 10."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core.geometry import boxes
from cca_core.path import Path
from cca_core.plot.labels import escape_figure_text, sanitize_text, scenario_name
from cca_core.plot.road_surface import draw_roads
from cca_core.plot.style import COLORS, TEXT, assign_colors, draw_lanes, new_figure
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
        route with the width drawn larger. Arrows are as long as the distance driven in one second.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    if scenario.other_roads:
        figure = new_figure(4.6)
        _draw_plane(figure.subplots(), scenario)
    else:
        figure = new_figure(2.3)
        _draw_strip(figure.subplots(), scenario)
    name = sanitize_text(scenario_name(scenario))
    figure.suptitle(name, x=0.01, ha="left", weight="bold", fontsize=TEXT.title)
    return escape_figure_text(figure)


def _describe_actions(user: RoadUser) -> str:
    """Speed and actions, such as ``"29 m/s, brakes with 7 m/s² at 3 s"``."""
    parts = ["stationary" if user.v_x == 0.0 else f"{user.v_x:.0f} m/s"]
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


def _draw_plane(axis: Any, scenario: Scenario, *, margin: float = 15.0) -> None:
    draw_roads(axis, scenario)
    axis.set_aspect("equal")
    path, start = scenario.road.path, scenario.start
    route = path.position(np.linspace(start, min(start + 110.0, path.end), 200))
    axis.plot(*route.T, color=COLORS.ego, linewidth=1.4, linestyle=":", zorder=1)
    shown = [route[0], 0.5 * (route[-1] + route[len(route) // 2])]
    for body in _bodies(scenario, 1):
        ((x, y),) = body.path.to_cartesian([body.s], [body.d])
        psi = float(body.path.heading(body.s)) + (0.0 if body.direction > 0 else np.pi)
        _draw_body(axis, boxes(x, y, psi, body.length, body.width).corners(), body.color)
        if body.v > 0.0:
            tip = (x + body.v * np.cos(psi), y + body.v * np.sin(psi))
            _draw_arrow(axis, (x, y), tip, body.color, 1.4)
        axis.annotate(
            body.text, (x, y), (0, 13 if y > -1.0 else -13), textcoords="offset points",
            ha="center", va="center", fontsize=TEXT.note, color=body.color, weight="bold", zorder=6,
            bbox={"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 0.8},
        )  # fmt: skip
        shown.append((x, y))
    low, high = np.min(shown, axis=0) - margin, np.max(shown, axis=0) + margin
    wide, tall = high - low
    axis.figure.set_figheight(min(5.0, 8.2 * tall / wide + 0.95))
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="x [m]", ylabel="y [m]")


def _draw_strip(axis: Any, scenario: Scenario, *, margin: float = 15.0, max_distance: float = 260.0) -> None:
    """Draw the vehicles within `max_distance` [m]; the others are named at the border."""
    road, start = scenario.road, scenario.start
    draw_lanes(axis, road)
    axis.axhline(0.0, color=COLORS.route, linewidth=0.9, linestyle=":", zorder=0.4)
    bodies = _bodies(scenario, 0)
    near = [body for body in bodies if body.id == "ego" or abs(body.s - start) < max_distance]
    ends = [x - start for body in near for x in (body.s, body.s + body.direction * body.v)]
    view = (min(ends) - margin, max(ends) + 2.0 * margin)
    for i, body in enumerate(sorted(near, key=lambda body: body.s)):
        x = body.s - start
        psi = 0.0 if body.direction > 0 else np.pi
        _draw_body(axis, boxes(x, body.d, psi, body.length, body.width).corners(), body.color)
        if body.v > 0.0:
            front = x + body.direction * 0.5 * body.length
            _draw_arrow(axis, (front, body.d), (front + body.direction * body.v, body.d), body.color, 1.0)
        y = road.left_edge + 1.6 if i % 2 == 0 else road.right_edge - 1.6
        side = "left" if x - view[0] < 0.06 * (view[1] - view[0]) else "center"
        axis.annotate(
            body.text, (x, body.d), (x, y), ha=side, va="center",
            fontsize=TEXT.note, color=body.color, weight="bold", annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": body.color, "linewidth": 0.6},
        )  # fmt: skip
    for body in bodies:
        if body not in near:
            _write_at_border(axis, body, body.s - start, view)
    axis.set(
        xlim=view, ylim=(road.right_edge - 3.2, road.left_edge + 3.2), ylabel="left of the\nroute [m]",
        xlabel="distance ahead of the ego at the start [m] (width drawn larger)",
    )  # fmt: skip


def _write_at_border(axis: Any, body: Body, distance: float, view: tuple[float, float]) -> None:
    is_ahead = distance > 0.0
    axis.text(
        view[1] - 1.0 if is_ahead else view[0] + 1.0, body.d,
        f"{body.text}, {abs(distance):.0f} m {'ahead ▸' if is_ahead else 'behind'}",
        ha="right" if is_ahead else "left", va="center",
        fontsize=TEXT.legend, color=body.color, weight="bold",
        bbox={"facecolor": COLORS.road, "edgecolor": "none", "pad": 1.0}, zorder=6,
    )  # fmt: skip


def _draw_arrow(
    axis: Any, tail: tuple[float, float], tip: tuple[float, float], color: str, width: float
) -> None:
    axis.annotate("", tip, tail, arrowprops={"arrowstyle": "-|>", "color": color, "linewidth": width})


def _draw_body(axis: Any, corners: Array, color: str) -> None:
    axis.fill(*corners.T, facecolor=color, edgecolor="white", linewidth=0.5, zorder=3)
