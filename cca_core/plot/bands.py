"""The band around a parked car, and the band of two tunings: counterparts of Figs 12 and 15."""

from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core.band import Band, relax_band
from cca_core.errors import InputError
from cca_core.geometry import boxes
from cca_core.path import Path, interpolate_path
from cca_core.plot.parked_car import EXAMPLE
from cca_core.plot.style import COLORS, DASHES, TEXT, new_figure
from cca_core.sim import make_planner, overtaking
from cca_core.vehicle import RemoteVehicle, VehicleState

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def fig_12() -> "Figure":
    """Draw the band around a parked car on a curve, as Fig 12 of the paper does.

    Returns
    -------
    figure : Figure
        Above, the lane from above, to scale; below, the same along the route.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    radius, lane, s = 120.0, 3.5, np.arange(0.0, 101.0)

    def to_xy(s: Array, d: float) -> Array:
        turn = s / radius
        return np.column_stack(((radius - d) * np.sin(turn), radius - (radius - d) * np.cos(turn)))

    ((x, y),) = to_xy(s[50:51], -1.1)
    car = boxes(x, y, s[50] / radius, EXAMPLE.length, EXAMPLE.width)
    band = relax_band(
        to_xy(s, 0.0), [car], vehicle=EXAMPLE.vehicle, clearance=EXAMPLE.clearance,
        corridor=(-0.5 * lane, 1.5 * lane),
    )  # fmt: skip
    figure = new_figure(6.0)
    above, below = figure.subplots(2, 1, height_ratios=(1.6, 1.0))
    lines = {d: to_xy(s, d) for d in (-0.5 * lane, 0.0, 0.5 * lane, 1.5 * lane)}
    above.fill(*np.vstack((lines[-0.5 * lane], lines[1.5 * lane][::-1])).T, color=COLORS.road)
    above.plot(*lines[0.5 * lane].T, color=COLORS.line, linewidth=0.8, linestyle=DASHES)
    above.plot(*lines[0.0].T, "--", color="black", linewidth=1.0, label="route")
    above.plot(*band.nodes.T, color=COLORS.ego, label="band")
    above.fill(*car.corners().T, color=COLORS.parked, label="parked car")
    above.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    above.set_title("From above, to scale", fontsize=TEXT.heading, loc="left")
    above.legend(fontsize=TEXT.legend, loc="upper left")
    below.axhspan(-0.5 * lane, 1.5 * lane, color=COLORS.road)
    below.axhline(0.5 * lane, color=COLORS.line, linewidth=0.8, linestyle=DASHES)
    corners = car.corners()
    below.fill(
        radius * np.arctan2(corners[:, 0], radius - corners[:, 1]),
        radius - np.hypot(corners[:, 0], radius - corners[:, 1]), color=COLORS.parked,
    )  # fmt: skip
    _draw_band_along_route(below, s, band)
    return figure


def _draw_band_along_route(axis: Any, s: Array, band: Band) -> None:
    u, half = band.displacement, 0.5 * EXAMPLE.vehicle.width
    axis.fill_between(
        s, u - half, u + half, color=COLORS.ego, alpha=0.2, linewidth=0.0, label="swept by the body"
    )
    axis.plot(s, 0.0 * s, "--", color="black", linewidth=1.0)
    axis.plot(s, u, color=COLORS.ego)
    axis.set(xlabel="distance along the route [m]", ylabel="left of the\nroute [m]", xlim=(s[0], s[-1]))
    clearance = f"clearance {band.clearance:.2f} m (limit {EXAMPLE.clearance:.2f} m)"
    axis.set_title(f"Along the route, width drawn larger; {clearance}", fontsize=TEXT.heading, loc="left")
    axis.legend(fontsize=TEXT.legend, loc="upper left")


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
    figure = new_figure(4.6)
    offset, lateral = figure.subplots(2, 1, sharex=True)
    v = EXAMPLE.speed
    for tuning, color, line in (("fast", COLORS.ego, "-"), ("smooth", COLORS.second, "--")):
        limit, reference, band = _first_maneuver(f"1-{tuning}")
        s = np.linspace(reference.start, reference.end, 1000)
        x, d = reference.position(s).T
        near = (x > band.nodes[0, 0] - 20.0) & (x < band.nodes[-1, 0] + 20.0)
        a_y = v**2 * reference.curvature(s)
        label = f"{tuning}: comfort limit {limit:g} m/s², peak {np.abs(a_y).max():.1f} m/s²"
        offset.plot(x[near], d[near], line, color=color, label=tuning)
        lateral.plot(x[near], a_y[near], line, color=color, label=label)
    alongside = np.flatnonzero(band.lower > 0.0)
    offset.axvspan(
        *band.nodes[alongside[[0, -1]], 0], color=COLORS.parked, alpha=0.25, linewidth=0.0, label="passing R1"
    )
    offset.set_ylabel("left of the route [m]")
    offset.legend(fontsize=TEXT.legend, loc="upper right")
    lateral.set(xlabel="distance along the route [m]", ylabel=f"lateral acceleration\nat {v:g} m/s [m/s²]")
    lateral.legend(fontsize=TEXT.legend, loc="upper center")
    lateral.margins(y=0.15)
    return figure


def _first_maneuver(case: str) -> tuple[float, Path, Band]:
    """Comfort limit [m/s^2], reference and band of the cycle in which the maneuver starts."""
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
            return scenario.evasion.lateral_acceleration, command.reference, command.band
    raise InputError(f"case {case!r} never leaves its lane")
