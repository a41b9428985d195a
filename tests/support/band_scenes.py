"""Plain roads and scenes for the tests of the band, and its certificate by dense measurement."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from cca_core.band import Band, BandStiffness, relax_band
from cca_core.geometry import Boxes, boxes
from cca_core.vehicle import VehicleParams
from tests.support.band_cases import Case
from tests.support.band_measure import curvature_excess, edge_excess, remeasure

CAR = VehicleParams.bmw_320i()
SOFT = BandStiffness()
BETWEEN = 1e-5  # by which a clearance may exceed the measured one, due to the cubic between nodes [m]
SHORTFALL = 1e-3  # of clearance, allowed for OK bands [m]


def straight(length: float = 150.0, h: float = 1.0) -> np.ndarray:
    x = np.linspace(0.0, length, round(length / h) + 1)
    return np.column_stack((x, np.zeros_like(x)))


def bend(radius: float = 200.0, length: float = 150.0, h: float = 1.0) -> np.ndarray:
    phi = np.linspace(0.0, length, round(length / h) + 1) / abs(radius)
    return np.column_stack((abs(radius) * np.sin(phi), radius * (1.0 - np.cos(phi))))


def on(
    nodes: np.ndarray, i: int, d: float, psi: float = 0.0, length: float = 4.5, width: float = 1.8
) -> Boxes:
    """Box at lateral offset d from node i, rotated by psi against the route."""
    step = nodes[i + 1] - nodes[i - 1]
    heading = math.atan2(step[1], step[0])
    return boxes(
        nodes[i, 0] - d * math.sin(heading), nodes[i, 1] + d * math.cos(heading), heading + psi, length, width
    )


def moving(
    nodes: np.ndarray,
    met: float,
    position: tuple[float, float],
    velocity: tuple[float, float],
    psi: float | None = None,
    length: float = 4.5,
    width: float = 1.8,
) -> Boxes:
    """Box at a position when the ego is at node `met` (fractional); velocity in meters per node.

    Its heading is that of its velocity unless psi is given.
    """
    n = len(nodes)
    x, y = (np.array(position) + np.outer(np.arange(n) - met, velocity)).T
    heading = math.atan2(velocity[1], velocity[0]) if psi is None else psi
    return boxes(x, y, np.full(n, heading), np.full(n, length), np.full(n, width))


def scene(
    nodes: np.ndarray,
    obstacles: Sequence[Boxes],
    *,
    clearance: float = 1.0,
    corridor: tuple[Any, Any] = (-20.0, 20.0),
    curvature_limit: Any = 0.5,
    vehicle: VehicleParams = CAR,
) -> Case:
    """Return the case of these obstacles along these nodes."""
    right, left = (np.broadcast_to(np.asarray(edge, dtype=float), len(nodes)) for edge in corridor)
    return Case(
        nodes=nodes,
        obstacles=list(obstacles),
        corridor=(right, left),
        curvature_limit=np.asarray(curvature_limit, dtype=float),
        clearance=clearance,
        vehicle=vehicle,
        kind="straight",
    )


def relax(case: Case, **options: Any) -> Band:
    """Band of a case."""
    arguments = {
        "vehicle": case.vehicle,
        "clearance": case.clearance,
        "corridor": case.corridor,
        "curvature_limit": case.curvature_limit,
    }
    return relax_band(case.nodes, case.obstacles, **{**arguments, **options})


def assert_certified(band: Band, case: Case) -> None:
    """Assert that the clearance is a lower bound, and that OK bands satisfy their limits."""
    assert np.isfinite(band.nodes).all()
    found = remeasure(band.nodes, case)
    assert math.isfinite(band.clearance) == math.isfinite(found) == bool(case.obstacles)
    over = band.clearance - found if case.obstacles else 0.0
    assert over <= BETWEEN, f"{band} is {over:.5f} m nearer than its clearance ({case.clearance:.2f} m asked)"
    if band.ok:
        edge, excess = edge_excess(band.nodes, case), curvature_excess(band.nodes, case)
        assert found >= case.clearance - SHORTFALL, f"{band}: shortfall {case.clearance - found:.5f} m"
        assert edge <= 0.01, f"{band} crosses an edge by {edge:.5f} m"
        assert excess <= 0.02, f"{band}: curvature {excess:.2%} above its limit"
    else:
        assert band.message


def dense_stiffness(stiffness: BandStiffness, h: float, n: int) -> np.ndarray:
    """Hessian of the documented energy for the inner nodes of a band that is 0 beyond its ends."""
    inner = n - 4
    padded = np.vstack((np.zeros((3, inner)), np.eye(inner), np.zeros((3, inner))))
    return sum(
        k * h * (D.T @ D)
        for order, k in ((1, stiffness.k_s), (2, stiffness.k_b), (3, stiffness.k_c))
        for D in [np.diff(padded, n=order, axis=0) / h**order]
    )
