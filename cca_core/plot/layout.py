"""Sketch of a scenario before it begins: the counterpart of Figs 5, 8 and 10."""

from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core.geometry import boxes
from cca_core.plot.road_surface import draw_roads
from cca_core.plot.style import (
    ASPHALT,
    EGO,
    assign_colors,
    draw_lanes,
    escape_figure_text,
    new_figure,
    sanitize_text,
    scenario_name,
)
from cca_core.sim import Scenario
from cca_core.sim.scenarios.road_user import BrakeAction, LateralShiftAction, ReactToLeadAction, RoadUser

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MARGIN = 15.0  # around what is shown [m]
_ARROW = 1.0  # way that arrows show [s]
_LONGEST = 260.0  # road users further from the ego are told at the border [m]


def plot_layout(scenario: Scenario) -> "Figure":
    """Sketch who is where at the start, and what each is going to do.

    Parameters
    ----------
    scenario : Scenario
        The scenario.

    Returns
    -------
    figure : Figure
        From above. A scenario with other roads is drawn to scale in the plane, any other one along the
        ego's route with the width drawn larger. Arrows are as long as the way in one second.

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
    figure.suptitle(sanitize_text(scenario_name(scenario)), x=0.01, ha="left", weight="bold", fontsize=11)
    return escape_figure_text(figure)


def describe_action(user: RoadUser) -> str:
    """Say what a road user is going to do.

    Parameters
    ----------
    user : RoadUser
        The road user.

    Returns
    -------
    deed : str
        Its speed and acts, such as ``"29 m/s, brakes with 7 m/s²"``.
    """
    told = ["stands" if user.v_x == 0.0 else f"{user.v_x:.0f} m/s"]
    for act in user.actions:
        if isinstance(act, BrakeAction):
            told.append(f"brakes with {act.deceleration:.0f} m/s² at {act.t:.0f} s")
        elif isinstance(act, ReactToLeadAction):
            told.append(f"brakes after {act.lead_id}")
        elif isinstance(act, LateralShiftAction):
            told.append(f"swerves {abs(act.offset):.0f} m {'left' if act.offset > 0.0 else 'right'}")
    return ", ".join(told)


def _draw_plane(axis: Any, scenario: Scenario) -> None:
    draw_roads(axis, scenario)
    axis.set_aspect("equal")
    palette = assign_colors([user.id for user in scenario.road_users])
    route = scenario.road.path
    way = route.position(np.linspace(scenario.start, min(scenario.start + 110.0, route.end), 200))
    axis.plot(*way.T, color=EGO, linewidth=1.4, linestyle=":", zorder=1)
    shown = [way[0], way[-1] * 0.5 + way[len(way) // 2] * 0.5]
    car = scenario.vehicle
    begin = scenario.start + car.box_offset
    bodies = [("ego", route, begin, 0.0, 1, scenario.v_x, car.length, car.width, EGO)]
    bodies += [
        (u.id, u.route or route, u.s, u.d, u.direction, u.v_x, u.length, u.width, palette[u.id])
        for u in scenario.road_users
    ]
    for name, path, s, d, along, v, long, wide, color in bodies:
        ((x, y),) = path.to_cartesian([s], [d])
        psi = float(path.heading(s)) + (0.0 if along > 0 else np.pi)
        _draw_body(axis, boxes(x, y, psi, long, wide).corners(), color)
        if v > 0.0:
            tip = (x + v * _ARROW * np.cos(psi), y + v * _ARROW * np.sin(psi))
            arrow = {"arrowstyle": "-|>", "color": color, "linewidth": 1.4}
            axis.annotate("", tip, (x, y), arrowprops=arrow)
        user = next((u for u in scenario.road_users if u.id == name), None)
        told = f"{scenario.v_x:.1f} m/s" if user is None else describe_action(user)
        axis.annotate(
            f"{sanitize_text(name)}: {told}", (x, y), (0, 13 if y > -1.0 else -13), textcoords="offset points",
            ha="center", va="center", fontsize=9, color=color, weight="bold", zorder=6,
            bbox={"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 0.8},
        )  # fmt: skip
        shown.append((x, y))
    low, high = np.min(shown, axis=0) - _MARGIN, np.max(shown, axis=0) + _MARGIN
    wide, tall = high - low
    axis.figure.set_figheight(min(5.0, 8.2 * tall / wide + 0.95))
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="x [m]", ylabel="y [m]")


def _draw_strip(axis: Any, scenario: Scenario) -> None:
    road, car = scenario.road, scenario.vehicle
    draw_lanes(axis, road)
    axis.axhline(0.0, color="#777777", linewidth=0.9, linestyle=":", zorder=0.4)
    palette = assign_colors([user.id for user in scenario.road_users])
    v = scenario.v_x
    told = [("ego", car.box_offset, 0.0, 1, v, car.length, car.width, EGO, f"{v:.0f} m/s")]
    far = []
    for u in scenario.road_users:
        if abs(u.s - scenario.start) < _LONGEST:
            at = u.s - scenario.start
            told.append(
                (u.id, at, u.d, u.direction, u.v_x, u.length, u.width, palette[u.id], describe_action(u))
            )
        else:
            far.append(u)
    ends = [place for entry in told for place in (entry[1], entry[1] + entry[3] * entry[4] * _ARROW)]
    view = (min(ends) - _MARGIN, max(ends) + 2.0 * _MARGIN)
    for i, (name, x, y, along, v, long, wide, color, text) in enumerate(sorted(told, key=lambda e: e[1])):
        psi = 0.0 if along > 0 else np.pi
        _draw_body(axis, boxes(x, y, psi, long, wide).corners(), color)
        if v > 0.0:
            tip = (x + along * (0.5 * long + v * _ARROW), y)
            axis.annotate(
                "", tip, (x + along * 0.5 * long, y), arrowprops={"arrowstyle": "-|>", "color": color}
            )
        above = i % 2 == 0
        edge = road.left_edge if above else road.right_edge
        side = "left" if x - view[0] < 0.06 * (view[1] - view[0]) else "center"
        axis.annotate(
            f"{sanitize_text(name)}: {text}", (x, y), (x, edge + (1.6 if above else -1.6)), ha=side, va="center",
            fontsize=9, color=color, weight="bold", annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": color, "linewidth": 0.6},
        )  # fmt: skip
    for u in far:
        ahead = u.s > scenario.start
        where = f"{abs(u.s - scenario.start):.0f} m {'ahead ▸' if ahead else 'behind'}"
        axis.text(
            view[1] - 1.0 if ahead else view[0] + 1.0, u.d, f"{sanitize_text(u.id)}: {describe_action(u)}, {where}",
            ha="right" if ahead else "left", va="center", fontsize=8, color=palette[u.id], weight="bold",
            bbox={"facecolor": ASPHALT, "edgecolor": "none", "pad": 1.0}, zorder=6,
        )  # fmt: skip
    axis.set(
        xlim=view, ylim=(road.right_edge - 3.2, road.left_edge + 3.2), ylabel="left of the\nroute [m]",
        xlabel="distance ahead of the ego at the start [m] (width drawn larger)",
    )  # fmt: skip


def _draw_body(axis: Any, corners: Array, color: str) -> None:
    axis.fill(*corners.T, facecolor=color, edgecolor="white", linewidth=0.5, zorder=3)
