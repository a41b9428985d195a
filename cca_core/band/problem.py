"""A band problem: the checked arguments of `relax_band`, in the frame of each node."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, Complex, Index, check_any, check_real
from cca_core.band.corridor import Corridor, make_corridor
from cca_core.band.equilibrium import free_response
from cca_core.band.settings import BandSettings
from cca_core.band.stiffness import BandStiffness
from cca_core.errors import InputError
from cca_core.geometry import Boxes
from cca_core.vehicle import VehicleParams

MAX_DISPLACEMENT = 30.0
"""Largest displacement of a band on a road [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BandProblem:
    """Checked arguments of a batch of bands, flattened to shape (bands, ...)."""

    route_nodes: Complex  # x + iy of the undeformed route [m], (bands, n)
    tangents: Complex  # unit tangents there [-], (bands, n)
    end_headings: Complex  # unit heading of the band at its first and last node [-], (bands, 2)
    end_moments: Complex  # spline moments there, divided by 6 [1/m], (bands, 2)
    h: Array  # distance between nodes [m], (bands,)
    free_displacement: Array  # free response to the start [m], (bands, n)
    previous_displacement: Array  # displacement a node before the first [m], (bands,)
    corridor: Corridor
    vehicle: VehicleParams
    clearance: float  # [m]
    curvature_limit: Array  # [1/m], (bands, n)
    stiffness: BandStiffness
    settings: BandSettings

    def second_difference(self, u: Array) -> Array:
        """Return the second difference of a displacement at the nodes [m], shape (bands, n)."""
        difference: Array = np.diff(u, n=2, prepend=self.previous_displacement[:, None], append=0.0)
        return difference

    @property
    def curvature(self) -> Array:
        """Curvature of the route [1/m], left positive, shape (bands, n)."""
        return curvature_of(self.route_nodes)

    def select(self, bands: Index) -> "BandProblem":
        """Return the problem of some bands; an index may occur more than once."""
        return replace(
            self,
            route_nodes=self.route_nodes[bands],
            tangents=self.tangents[bands],
            end_headings=self.end_headings[bands],
            end_moments=self.end_moments[bands],
            h=self.h[bands],
            free_displacement=self.free_displacement[bands],
            previous_displacement=self.previous_displacement[bands],
            corridor=self.corridor.select(bands),
            curvature_limit=self.curvature_limit[bands],
        )


def tangents_of(nodes: Complex) -> tuple[Complex, Array]:
    """Return unit tangents [-] at nodes x + iy, by central differences, and the lengths between [m]."""
    steps = nodes[:, 1:] - nodes[:, :-1]
    along = np.empty_like(nodes)
    along[:, 1:-1] = steps[:, 1:] + steps[:, :-1]
    along[:, 0], along[:, -1] = steps[:, 0], steps[:, -1]
    return along / np.abs(along), np.abs(steps)


def curvature_of(nodes: Complex) -> Array:
    """Return the signed curvature [1/m] of the circles through three neighboring nodes x + iy."""
    steps = nodes[:, 1:] - nodes[:, :-1]
    before, after = steps[:, :-1], steps[:, 1:]
    length, chord = np.abs(steps), np.abs(before + after)
    curvature = np.empty(nodes.shape)
    curvature[:, 1:-1] = 2.0 * (before.conj() * after).imag / (length[:, 1:] * length[:, :-1] * chord)
    curvature[:, 0], curvature[:, -1] = curvature[:, 1], curvature[:, -2]
    return curvature


def spline_moments(nodes: Complex, ends: Complex) -> tuple[Complex, Array, Complex]:
    """Return unit tangents, curvature and moments / 6 [1/m] of the C2 cubic with given end moments."""
    from scipy.linalg import lapack  # slow to import, and importing the library is to be quick

    steps = nodes[:, 1:] - nodes[:, :-1]
    h = np.abs(steps)
    slopes = steps / h
    diagonal, off, rhs = np.ones(nodes.shape), np.zeros(nodes.shape), np.empty_like(nodes)
    diagonal[:, 1:-1] = 2.0 * (h[:, 1:] + h[:, :-1])
    off[:, 1:-2] = h[:, 1:-1]  # the ends are known, and nothing couples a band with the next
    rhs[:, 1:-1] = slopes[:, 1:] - slopes[:, :-1]
    rhs[:, 0], rhs[:, -1] = ends.T
    rhs[:, 1] -= h[:, 0] * rhs[:, 0]
    rhs[:, -2] -= h[:, -1] * rhs[:, -1]
    solved = lapack.dptsv(diagonal.ravel(), off.ravel()[:-1], rhs.view(np.float64).reshape(-1, 2))[2]
    moment_over_6 = np.ascontiguousarray(solved).view(np.complex128).reshape(nodes.shape)
    along = np.empty_like(nodes)
    along[:, :-1] = slopes - h * (2.0 * moment_over_6[:, :-1] + moment_over_6[:, 1:])
    along[:, -1] = slopes[:, -1] + h[:, -1] * (2.0 * moment_over_6[:, -1] + moment_over_6[:, -2])
    speed = np.abs(along)
    along /= speed
    return along, 6.0 * (along.conj() * moment_over_6).imag / (speed * speed), moment_over_6


def offset_curve(kappa: Array, u: Array, h: float | Array) -> tuple[Complex, Array]:
    """Return relative unit tangents [-] and curvature [1/m] of the curve at a lateral offset from a route."""
    slope, change = 0.5 * (u[2] - u[0]) / h, (u[2] - 2.0 * u[1] + u[0]) / (h * h)
    along = 1.0 - kappa * u[1]
    speed = np.hypot(along, slope)
    curvature: Array = (along * (change + kappa * along) + 2.0 * kappa * slope**2) / speed**3
    return (along + 1j * slope) / speed, curvature


def _fixed_start(start: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Return the displacement before the first node and at the first two, shape (bands, 3), checked."""
    checked = check_any("start", start)
    try:
        fixed = np.broadcast_to(checked, (*shape[:-1], 3)).reshape(-1, 3)
    except ValueError:
        raise InputError(f"start must have shape {(*shape[:-1], 3)}, had {checked.shape}") from None
    if np.abs(fixed).max() > MAX_DISPLACEMENT:
        raise InputError(f"start must be within {MAX_DISPLACEMENT:g} m, was {np.abs(fixed).max():g}")
    return fixed


def _end(a: complex, b: complex, c: complex, d: complex) -> float:
    """Extrapolate the curvature [1/m] to the first of four nodes from the circles through three of them."""

    def circle(x: complex, y: complex, z: complex) -> float:
        return 2.0 * ((y - x).conjugate() * (z - y)).imag / (abs(y - x) * abs(z - y) * abs(z - x))

    return 2.0 * circle(a, b, c) - circle(b, c, d)


def make_problem(
    nodes: ArrayLike,
    obstacles: Sequence[Boxes],
    *,
    vehicle: VehicleParams,
    clearance: float,
    lead_distance: ArrayLike,
    edges: tuple[ArrayLike, ArrayLike] | None,
    curvature_limit: ArrayLike,
    stiffness: BandStiffness,
    start: ArrayLike,
    settings: BandSettings,
) -> tuple[BandProblem, tuple[int, ...]]:
    """Check the arguments of `relax_band`; return the problem and the batch shape of `nodes`."""
    checked = _check_nodes(nodes)
    for name, value, kind in (
        ("stiffness", stiffness, BandStiffness),
        ("vehicle", vehicle, VehicleParams),
        ("settings", settings, BandSettings),
    ):
        if not isinstance(value, kind):
            raise InputError(f"{name} must be {kind.__name__}, was {type(value).__name__}")
    clearance = check_real("clearance", clearance, ge=0.0)
    shape, n, batch_shape = checked.shape[:-1], checked.shape[-2], checked.shape[:-2]
    try:
        limit = np.empty(shape)
        limit[...] = curvature_limit
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"curvature_limit must have shape () or {shape}") from None
    if not limit.min() > 0.0:
        raise InputError("curvature_limit must be greater than 0")
    route = checked.view(np.complex128).reshape(-1, n)
    tangents, h = _check_spacing(route)
    end_curvature = np.array([(_end(*z[:4].tolist()), -_end(*z[:-5:-1].tolist())) for z in route])
    fixed, free = _fixed_start(start, shape), np.zeros(route.shape)
    off = fixed.any(axis=1)
    # the chord between the first two nodes is rotated against the tangent at the first
    tangents[off, 0] *= np.exp(-0.5j * h[off] * end_curvature[off, 0])
    headings = tangents[:, [0, -1]]
    if off.any():
        free[off] = free_response(stiffness.stencil(h[off]), fixed[off], n)
        turn, end_curvature[off, 0] = offset_curve(end_curvature[off, 0], fixed[off].T, h[off])
        headings[off, 0] *= turn
    return BandProblem(
        route_nodes=route, tangents=tangents, h=h, end_headings=headings,
        end_moments=1j * end_curvature * headings / 6.0, free_displacement=free,
        previous_displacement=fixed[:, 0], vehicle=vehicle, clearance=clearance,
        corridor=make_corridor(
            route, tangents, obstacles, edges, vehicle, clearance, lead_distance, batch_shape
        ),
        curvature_limit=limit.reshape(-1, n), stiffness=stiffness, settings=settings,
    ), batch_shape  # fmt: skip


def _check_nodes(nodes: ArrayLike) -> Array:
    """Return finite nodes of shape (..., n, 2)."""
    try:
        checked = np.array(nodes, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"nodes must be an array of real numbers, was {type(nodes).__name__}") from None
    if checked.ndim < 2 or checked.shape[-1] != 2 or checked.shape[-2] < 5 or not checked.size:
        raise InputError(f"nodes must have shape (..., n, 2) with at least 5 nodes, had {checked.shape}")
    if not np.isfinite(checked).all():
        index = np.argwhere(~np.isfinite(checked))[0]
        raise InputError(f"nodes must be finite, was {checked[tuple(index)]} at {index.tolist()}")
    return checked


def _check_spacing(route: Complex) -> tuple[Complex, Array]:
    """Return unit tangents and the distance between nodes [m], which must be equal within 20 %."""
    if (route[:, 1:] == route[:, :-1]).any():
        raise InputError("nodes must be equally spaced along the route, two neighbors are equal")
    tangents, steps = tangents_of(route)
    h = np.add.reduce(steps, axis=1) / (route.shape[1] - 1)
    if (steps.min(axis=1) <= 0.8 * h).any() or (h <= 0.8 * steps.max(axis=1)).any():
        raise InputError(
            f"nodes must be equally spaced along the route, as those of Path.sample are; "
            f"neighbors are {steps.min():.3g} to {steps.max():.3g} m apart"
        )
    return tangents, h
