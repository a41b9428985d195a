"""The band around a parked car, and the band of two tunings: counterparts of Figs 12 and 15."""

from typing import TYPE_CHECKING

import numpy as np

from cca_core._checks import Array
from cca_core.band import Band, relax_band
from cca_core.errors import InputError
from cca_core.geometry import boxes
from cca_core.path import Path, interpolate_path
from cca_core.plot.style import ASPHALT, EGO, PARKED, new_figure
from cca_core.sim import make_planner, overtaking
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SMOOTH = "#D55E00"
_V = 20.0  # at which lateral accelerations are told [m/s]
_VEHICLE = VehicleParams.bmw_320i()
_CAR = 4.5, 1.8  # length and width of the parked car [m]
_ASKED = 1.0  # clearance [m]


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
    turn = s / radius

    def aside(d: float) -> Array:
        return np.column_stack(((radius - d) * np.sin(turn), radius - (radius - d) * np.cos(turn)))

    route, at = aside(0.0), 50
    x, y = aside(-1.1)[at].tolist()
    car = boxes(x, y, turn[at], *_CAR)
    band = relax_band(route, [car], vehicle=_VEHICLE, clearance=_ASKED, corridor=(-0.5 * lane, 1.5 * lane))
    figure = new_figure(6.0)
    above, below = figure.subplots(2, 1, height_ratios=(1.6, 1.0))
    above.fill(*np.vstack((aside(-0.5 * lane), aside(1.5 * lane)[::-1])).T, color=ASPHALT)
    above.plot(*aside(0.5 * lane).T, color="#555555", linewidth=0.8, linestyle=(0, (8, 6)))
    above.plot(*route.T, "--", color="black", linewidth=1.0, label="route")
    above.plot(*band.nodes.T, color=EGO, label="band")
    above.fill(*car.corners().T, color=PARKED, label="parked car")
    above.set_aspect("equal")
    above.set(xlabel="x [m]", ylabel="y [m]")
    above.set_title("From above, to scale", fontsize=10, loc="left")
    above.legend(fontsize=8, loc="upper left")
    half = 0.5 * _VEHICLE.width
    below.axhspan(-0.5 * lane, 1.5 * lane, color=ASPHALT)
    below.axhline(0.5 * lane, color="#555555", linewidth=0.8, linestyle=(0, (8, 6)))
    u = band.displacement
    below.fill_between(s, u - half, u + half, color=EGO, alpha=0.2, linewidth=0.0, label="swept by the body")
    below.plot(s, 0.0 * s, "--", color="black", linewidth=1.0)
    below.plot(s, u, color=EGO)
    corners = car.corners()
    below.fill(
        radius * np.arctan2(corners[:, 0], radius - corners[:, 1]),
        radius - np.hypot(corners[:, 0], radius - corners[:, 1]), color=PARKED,
    )  # fmt: skip
    below.set(xlabel="distance along the route [m]", ylabel="left of the\nroute [m]", xlim=(s[0], s[-1]))
    below.set_title(
        f"Along the route, width drawn larger. Clearance {band.clearance:.2f} m, asked {_ASKED:g} m",
        fontsize=10, loc="left",
    )  # fmt: skip
    below.legend(fontsize=8, loc="upper left")
    return figure


def fig_15() -> "Figure":
    """Draw the first swerve that the two tunings of maneuvering case 1 plan, as Fig 15 of the paper does.

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
    place, push = figure.subplots(2, 1, sharex=True)
    for tuning, color, line in (("fast", EGO, "-"), ("smooth", _SMOOTH, "--")):
        aim, reference, band = _first_swerve(f"1-{tuning}")
        s = np.linspace(reference.start, reference.end, 1000)
        x, d = reference.position(s).T
        near = (x > band.nodes[0, 0] - 20.0) & (x < band.nodes[-1, 0] + 20.0)
        a_y = _V**2 * reference.curvature(s)
        label = f"{tuning}: aims at {aim:g} m/s², peak {np.abs(a_y).max():.1f} m/s²"
        place.plot(x[near], d[near], line, color=color, label=tuning)
        push.plot(x[near], a_y[near], line, color=color, label=label)
    beside = np.flatnonzero(band.lower > 0.0)
    place.axvspan(
        *band.nodes[beside[[0, -1]], 0], color=PARKED, alpha=0.25, linewidth=0.0, label="passing R1"
    )
    place.set_ylabel("left of the route [m]")
    place.legend(fontsize=8, loc="upper right")
    push.set(xlabel="distance along the route [m]", ylabel=f"lateral acceleration\nat {_V:g} m/s [m/s²]")
    push.legend(fontsize=8, loc="upper center")
    push.margins(y=0.15)
    return figure


def _first_swerve(case: str) -> tuple[float, Path, Band]:
    """Lateral acceleration aimed at, reference and band of the cycle in which a case begins to evade."""
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
