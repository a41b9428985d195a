"""The band around a parked car, and the band of two tunings: counterparts of Figs 12 and 15."""

from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core.band import Band, relax_band
from cca_core.errors import InputError
from cca_core.geometry import boxes
from cca_core.path import Lane, Path, Road, interpolate_path
from cca_core.plot.legends import legend_above
from cca_core.plot.parked_car import EXAMPLE
from cca_core.plot.road_surface import boundary_lines
from cca_core.plot.style import (
    COLORS,
    COLUMN_WIDTH,
    DASHES,
    ROLE_COLORS,
    draw_lanes,
    lighten,
    new_figure,
    set_text_sizes,
)
from cca_core.sim import Scenario, make_planner, overtaking
from cca_core.vehicle import RemoteVehicle, VehicleState

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def fig_12() -> "Figure":
    """Draw the band around a parked car on a curve, as Fig 12 of the paper does.

    Returns
    -------
    figure : Figure
        Above, the road from above, to scale; below, the same along the route.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    radius, s = 120.0, np.arange(0.0, 101.0)
    turn = s / radius
    nodes = radius * np.column_stack((np.sin(turn), 1.0 - np.cos(turn)))
    road = Road(path=interpolate_path(nodes), lanes=(Lane(d=0.0), Lane(d=3.5)))
    ((x, y),) = road.path.to_cartesian([50.0], [-1.1])
    car = boxes(x, y, 50.0 / radius, EXAMPLE.length, EXAMPLE.width)
    band = relax_band(
        nodes, [car], vehicle=EXAMPLE.vehicle, clearance=EXAMPLE.clearance,
        corridor=(road.right_edge, road.left_edge),
    )  # fmt: skip
    figure = new_figure(4.9, COLUMN_WIDTH)
    above, below = figure.subplots(2, 1, height_ratios=(1.5, 1.0))
    _draw_road(above, road)
    above.plot(*nodes.T, ":", color=COLORS.ink, linewidth=1.0, label="route")
    above.plot(*band.nodes.T, color=COLORS.ego, linewidth=1.2, label="band")
    tangents = np.gradient(band.nodes, axis=0)
    for i in range(4, len(s), 23):
        psi = float(np.arctan2(*tangents[i, ::-1]))
        x, y = band.nodes[i].tolist()
        body = boxes(x, y, psi, EXAMPLE.vehicle.length, EXAMPLE.vehicle.width)
        above.fill(*body.corners().T, color=lighten(COLORS.ego), label="" if i > 4 else "ego on the band")
    above.fill(*car.corners().T, color=COLORS.parked, label="parked car")
    above.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    above.margins(x=0.0, y=0.04)
    above.set_title("From above, to scale", loc="left")
    legend_above(above, ncols=4)
    draw_lanes(below, road)
    below.fill(*road.path.project(car.corners()), color=COLORS.parked)
    _draw_band_along_route(below, s, band)
    set_text_sizes(figure)
    return figure


def _draw_road(axis: Any, road: Road) -> None:
    """Draw edges and lane boundaries from above."""
    (right, left), between = boundary_lines(road, road.path.start, road.path.end)
    axis.fill(*np.vstack((right, left[::-1])).T, color=COLORS.road, linewidth=0.0)
    for edge in (right, left):
        axis.plot(*edge.T, color=COLORS.line, linewidth=1.2)
    for line in between:
        axis.plot(*line.T, color=COLORS.line, linewidth=0.8, linestyle=DASHES)


def _draw_band_along_route(axis: Any, s: Array, band: Band) -> None:
    u, half = band.displacement, 0.5 * EXAMPLE.vehicle.width
    axis.fill_between(
        s, u - half, u + half, color=COLORS.ego, alpha=0.2, linewidth=0.0, label="swept by the ego's body"
    )
    axis.plot(s, 0.0 * s, ":", color=COLORS.ink, linewidth=1.0)
    axis.plot(s, u, color=COLORS.ego, linewidth=1.2)
    axis.set(xlabel="distance along the route [m]", ylabel="left of the\nroute [m]", xlim=(s[0], s[-1]))
    clearance = f"clearance {band.clearance:.2f} m (limit {EXAMPLE.clearance:.2f} m)"
    axis.set_title(f"Width drawn larger; {clearance}", loc="left")
    legend_above(axis)


def fig_15() -> "Figure":
    """Draw the first maneuver that the two tunings of maneuvering case 1 plan, as Fig 15 of the paper does.

    Returns
    -------
    figure : Figure
        Displacement and lateral acceleration over the route.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    figure = new_figure(4.4, COLUMN_WIDTH)
    offset, lateral = figure.subplots(2, 1, sharex=True)
    v = EXAMPLE.speed
    for tuning, color, line in (("fast", COLORS.ego, "-"), ("smooth", COLORS.second, "--")):
        scenario, reference, band = _first_maneuver(f"1-{tuning}")
        s = np.linspace(reference.start, reference.end, 1000)
        x, d = reference.position(s).T
        near = (x > band.nodes[0, 0] - 20.0) & (x < band.nodes[-1, 0] + 20.0)
        a_y = v**2 * reference.curvature(s)
        label = f"{tuning}: peak {np.abs(a_y).max():.1f} m/s²"
        label += f" (comfort limit {scenario.evasion.lateral_acceleration:g} m/s²)"
        offset.plot(x[near], d[near], line, color=color, label=tuning)
        lateral.plot(x[near], a_y[near], line, color=color, label=label)
    draw_lanes(offset, scenario.road)
    alongside = band.nodes[np.flatnonzero(band.lower > 0.0)[[0, -1]], 0]
    offset.axvspan(*alongside, color=ROLE_COLORS["R1"], alpha=0.25, linewidth=0.0, label="passing R1")
    offset.set_ylabel("left of the\nroute [m]")
    offset.set_title("The first maneuver as planned, width drawn larger", loc="left")
    legend_above(offset, ncols=3)
    lateral.axhline(0.0, color=COLORS.line, linewidth=0.8)
    lateral.set(xlabel="distance along the route [m]", ylabel="lateral acc.\na_y [m/s²]")
    lateral.set_title(f"Lateral acceleration at {v:g} m/s", loc="left")
    legend_above(lateral, ncols=1)
    lateral.margins(x=0.0)
    set_text_sizes(figure)
    figure.align_ylabels()
    return figure


def _first_maneuver(case: str) -> tuple[Scenario, Path, Band]:
    """Scenario, and reference and band of the cycle in which the maneuver starts."""
    x = np.arange(0.0, 1000.0, 20.0)
    scenario = overtaking(case, interpolate_path(np.column_stack((x, np.zeros_like(x)))))
    planner = make_planner(scenario)
    for t in np.arange(0.0, scenario.duration, 0.1).tolist():
        ego = VehicleState(x=scenario.start + scenario.v_x * t, y=0.0, psi=0.0, v_x=scenario.v_x)
        others = [
            RemoteVehicle(id=o.id, x=o.s + o.v_x * t, y=o.d, psi=0.0, v_x=o.v_x) for o in scenario.road_users
        ]
        command = planner.step(t, ego, others)
        if command.band is not None:
            return scenario, command.reference, command.band
    raise InputError(f"case {case!r} never leaves its lane")
