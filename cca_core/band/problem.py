"""What bands are asked to do, checked and in the frame of each node."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, Complex, Index, check_any, check_real
from cca_core.band.corridor import Corridor, make_corridor
from cca_core.band.equilibrium import free_response
from cca_core.band.stiffness import BandStiffness
from cca_core.errors import InputError
from cca_core.geometry import Boxes
from cca_core.vehicle import VehicleParams

MAX_DISPLACEMENT = 30.0
"""Swerve beyond which a band is none of a road [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BandProblem:
    """What bands were asked to do, checked; `bands` of them side by side.

    Parameters
    ----------
    route_nodes, tangents : ndarray of complex, shape (bands, n)
        Nodes x + iy of the undeformed route [m] and unit tangents there [-].
    end_headings : ndarray of complex, shape (bands, 2)
        Heading of the band at its first and last node [-].
    end_moments : ndarray of complex, shape (bands, 2)
        A sixth of its second derivative there [1/m].
    h : ndarray, shape (bands,)
        Distance between nodes [m].
    free_displacement : ndarray, shape (bands, n)
        Displacement that nothing but its start bends [m].
    previous_displacement : ndarray, shape (bands,)
        Displacement a node before the first [m].
    corridor : Corridor
        Obstacles and edges.
    vehicle : VehicleParams
        The ego.
    clearance : float
        Distance asked [m].
    curvature_limit : ndarray, shape (bands, n)
        Largest curvature allowed [1/m].
    stiffness : BandStiffness
        Elasticity.
    """

    route_nodes: Complex
    tangents: Complex
    end_headings: Complex
    end_moments: Complex
    h: Array
    free_displacement: Array
    previous_displacement: Array
    corridor: Corridor
    vehicle: VehicleParams
    clearance: float
    curvature_limit: Array
    stiffness: BandStiffness

    def second_difference(self, u: Array) -> Array:
        """Second difference of a displacement at the nodes [m], shape (bands, n)."""
        bend: Array = np.diff(u, n=2, prepend=self.previous_displacement[:, None], append=0.0)
        return bend

    @property
    def curvature(self) -> Array:
        """Curvature of the route [1/m], left positive, shape (bands, n)."""
        return curvature_of(self.route_nodes)

    def select(self, bands: Index) -> "BandProblem":
        """Return the same for some bands, each as often as it is named."""
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
    """Return unit tangents [-] at nodes x + iy and the lengths between [m].

    Tangents are central differences, one-sided at the ends.
    """
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
    """Lay the C2 cubic through nodes.

    Parameters
    ----------
    nodes : ndarray of complex, shape (bands, n)
        Positions x + iy [m].
    ends : ndarray of complex, shape (bands, 2)
        A sixth of its second derivative at the first and last node [1/m].

    Returns
    -------
    along : ndarray of complex, shape (bands, n)
        Its unit tangents at the nodes [-].
    curvature : ndarray, shape (bands, n)
        Its curvature there [1/m], left positive.
    sixth : ndarray of complex, shape (bands, n)
        A sixth of its second derivative there [1/m].
    """
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
    sixth = np.ascontiguousarray(solved).view(np.complex128).reshape(nodes.shape)
    along = np.empty_like(nodes)
    along[:, :-1] = slopes - h * (2.0 * sixth[:, :-1] + sixth[:, 1:])
    along[:, -1] = slopes[:, -1] + h[:, -1] * (2.0 * sixth[:, -1] + sixth[:, -2])
    speed = np.abs(along)
    along /= speed
    return along, 6.0 * (along.conj() * sixth).imag / (speed * speed), sixth


def offset_curve(kappa: Array, u: Array, h: float | Array) -> tuple[Complex, Array]:
    """Describe a curve that runs beside a route.

    Parameters
    ----------
    kappa : ndarray, shape (n,)
        Curvature of the route [1/m], left positive, taken to change slowly.
    u : ndarray, shape (3, n)
        Displacement a node before, at and after each place [m], left positive.
    h : float or ndarray, shape (n,)
        Distance between nodes along the route [m].

    Returns
    -------
    turn : ndarray of complex, shape (n,)
        Its unit tangents relative to those of the route [-].
    curvature : ndarray, shape (n,)
        Its curvature [1/m].
    """
    slope, change = 0.5 * (u[2] - u[0]) / h, (u[2] - 2.0 * u[1] + u[0]) / (h * h)
    along = 1.0 - kappa * u[1]
    speed = np.hypot(along, slope)
    curvature: Array = (along * (change + kappa * along) + 2.0 * kappa * slope**2) / speed**3
    return (along + 1j * slope) / speed, curvature


def _held(start: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Displacement at the node before the first and at the first two, (bands, 3), checked."""
    given = check_any("start", start)
    try:
        held = np.broadcast_to(given, (*shape[:-1], 3)).reshape(-1, 3)
    except ValueError:
        raise InputError(f"start must have shape {(*shape[:-1], 3)}, had {given.shape}") from None
    if np.abs(held).max() > MAX_DISPLACEMENT:
        raise InputError(f"start must be within {MAX_DISPLACEMENT:g} m, was {np.abs(held).max():g}")
    return held


def _end(a: complex, b: complex, c: complex, d: complex) -> float:
    """Curvature at the first of nodes that begin so, drawn on from the circles through three of them."""

    def circle(x: complex, y: complex, z: complex) -> float:
        return 2.0 * ((y - x).conjugate() * (z - y)).imag / (abs(y - x) * abs(z - y) * abs(z - x))

    return 2.0 * circle(a, b, c) - circle(b, c, d)


def make_problem(
    nodes: ArrayLike,
    obstacles: Sequence[Boxes],
    vehicle: VehicleParams,
    clearance: float,
    lead: ArrayLike,
    corridor: tuple[ArrayLike, ArrayLike] | None,
    curvature_limit: ArrayLike,
    stiffness: BandStiffness,
    start: ArrayLike,
) -> tuple[BandProblem, tuple[int, ...]]:
    """Check the arguments of `relax_band` and put every obstacle and edge into the frame of the nodes.

    Returns
    -------
    task : Task
        Bands side by side.
    leading : tuple of int
        Leading axes of `nodes`, () for a single band.
    """
    try:
        given = np.array(nodes, dtype=np.float64, order="C")
    except (TypeError, ValueError):
        raise InputError(f"nodes must be an array of real numbers, was {type(nodes).__name__}") from None
    if given.ndim < 2 or given.shape[-1] != 2 or given.shape[-2] < 5 or not given.size:
        raise InputError(f"nodes must have shape (..., n, 2) with at least 5 nodes, had {given.shape}")
    if not np.isfinite(given).all():
        where = np.argwhere(~np.isfinite(given))[0]
        raise InputError(f"nodes must be finite, was {given[tuple(where)]} at {where.tolist()}")
    if not isinstance(stiffness, BandStiffness):
        raise InputError(f"stiffness must be BandStiffness, was {type(stiffness).__name__}")
    if not isinstance(vehicle, VehicleParams):
        raise InputError(f"vehicle must be VehicleParams, was {type(vehicle).__name__}")
    clearance = check_real("clearance", clearance, ge=0.0)
    shape, n = given.shape[:-1], given.shape[-2]
    try:
        limit = np.empty(shape)
        limit[...] = curvature_limit
    except (TypeError, ValueError):
        raise InputError(f"curvature_limit must have shape () or {shape}") from None
    if not limit.min() > 0.0:
        raise InputError("curvature_limit must be greater than 0")
    base = given.view(np.complex128).reshape(-1, n)
    if (base[:, 1:] == base[:, :-1]).any():
        raise InputError("nodes must be equally spaced along the route, two neighbors are equal")
    tangents, steps = tangents_of(base)
    h = np.add.reduce(steps, axis=1) / (n - 1)
    if (steps.min(axis=1) <= 0.8 * h).any() or (h <= 0.8 * steps.max(axis=1)).any():
        raise InputError(
            f"nodes must be equally spaced along the route, as those of Path.sample are; "
            f"neighbors are {steps.min():.3g} to {steps.max():.3g} m apart"
        )
    bent = np.array([(_end(*b[:4].tolist()), -_end(*b[:-5:-1].tolist())) for b in base])
    held, free = _held(start, shape), np.zeros(base.shape)
    off = held.any(axis=1)
    # the chord between the first two nodes is turned against the tangent at the first
    tangents[off, 0] *= np.exp(-0.5j * h[off] * bent[off, 0])
    ahead = tangents[:, [0, -1]]
    if off.any():
        free[off] = free_response(stiffness.stencil(h[off]), held[off], n)
        turn, bent[off, 0] = offset_curve(bent[off, 0], held[off].T, h[off])
        ahead[off, 0] *= turn
    return BandProblem(
        route_nodes=base, tangents=tangents, h=h, end_headings=ahead, end_moments=1j * bent * ahead / 6.0,
        free_displacement=free, previous_displacement=held[:, 0], vehicle=vehicle, clearance=clearance,
        corridor=make_corridor(
            base, tangents, obstacles, corridor, vehicle, clearance, lead, given.shape[:-2]
        ),
        curvature_limit=limit.reshape(-1, n), stiffness=stiffness,
    ), given.shape[:-2]  # fmt: skip
