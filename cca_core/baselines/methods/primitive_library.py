"""Library of motion primitives: constant lateral offsets, and shifts between them."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import trapezoid

from cca_core._checks import Array, Index

# A unit shift: its second derivative is a trapezoid to the one side and one to the other.
_RAMP = 0.2  # fraction of each half of a shift in which its curvature rises, and in which it falls
_KNOTS = np.array([0.0, 0.5 * _RAMP, 0.5 - 0.5 * _RAMP, 0.5 + 0.5 * _RAMP, 1.0 - 0.5 * _RAMP])
_PEAK_JERK = 8.0 / (_RAMP * (1.0 - _RAMP))
_JERK_STEPS = _PEAK_JERK * np.array([1.0, -1.0, -1.0, 1.0, 1.0])  # of the third derivative at the knots


@dataclass(frozen=True, slots=True, kw_only=True)
class Lattice:
    """Points of a lattice, and the limits and costs of the primitives between them."""

    spacing: float  # between neighboring offsets [m]
    rightmost: int  # offsets from the route in spacings [-]
    leftmost: int
    step: float  # between neighboring stations [m]
    max_steps: int  # of a primitive [-]
    parts: int  # of a step between whose ends the body is checked [-]
    length_factors: tuple[float, ...]  # lengths of shifts over the shortest one [-]
    cell_width: float  # of the table of free poses [m]
    heading_step: float  # of that table [rad]
    v_x: float  # along the route [m/s]
    kappa_max: float  # largest curvature [1/m]
    rate_max: float  # largest change of curvature [1/m^2]
    weights: tuple[float, float, float]  # of lateral acceleration, lateral jerk and offset, squared


@dataclass(frozen=True, slots=True, eq=False)
class Library:
    """All m primitives between n offsets, in the order of the offset at which they end."""

    step: float  # between neighboring stations [m]
    offsets: Array  # (n,): offsets of the lattice [m], left positive
    begins: Index  # (m,): indices of the offsets at both ends
    ends: Index
    steps: Index  # (m,): lengths in steps
    cost: Array  # (m,)
    first: Index  # (n,): first primitive that ends at an offset
    samples: Index  # (m,): first sample of a primitive
    cell: Index  # (samples,): flat index (part of a step, heading, offset) in the table of free poses
    shift: np.ndarray[tuple[int], np.dtype[np.uint64]]  # (samples,): whole steps from the begin
    headings: Array  # of the table [rad]
    lateral: Array  # offsets of the table [m]
    right: Array  # (m,): smallest and largest route curvature at which the curvature limit holds [1/m]
    left: Array


def library(lattice: Lattice) -> Library:
    """Compute all primitives that keep the limits on a straight road."""
    offsets: Array = lattice.spacing * np.arange(lattice.rightmost, lattice.leftmost + 1, dtype=np.float64)
    rows = sorted(row for change in range(len(offsets)) for row in _between(lattice, offsets, change))
    ends, begins, steps = (np.array([row[k] for row in rows], dtype=np.intp) for k in range(3))
    change, span = offsets[ends] - offsets[begins], steps * lattice.step
    per = steps * lattice.parts + 1
    samples = np.cumsum(per) - per
    p = np.repeat(np.arange(len(rows)), per)
    k = np.arange(len(p)) - samples[p]
    d, slope, _ = shifted(k / (per[p] - 1), offsets[begins][p], change[p], span[p])
    turn, width, angle = np.arctan(slope), lattice.cell_width, lattice.heading_step
    widest = math.ceil(float(np.abs(turn).max()) / angle) + 1
    headings: Array = angle * np.arange(-widest, widest + 1, dtype=np.float64)
    cells = round((offsets[-1] - offsets[0]) / width) + 1
    row, column = np.rint(turn / angle).astype(np.intp) + widest, np.rint((d - offsets[0]) / width)
    # where on a shift the curvature may be largest on a curved route
    checked = np.array([0.05, 0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9, 0.95])[:, None]
    motion = shifted(checked, offsets[begins], change, span)
    return Library(
        step=lattice.step, offsets=offsets, begins=begins, ends=ends, steps=steps,
        cost=np.array([row[3] for row in rows]), first=np.searchsorted(ends, np.arange(len(offsets))),
        samples=samples, shift=(k // lattice.parts).astype(np.uint64),
        cell=((k % lattice.parts) * len(headings) + row) * cells + column.astype(np.intp),
        headings=headings, lateral=offsets[0] + width * np.arange(cells),
        right=_route_curvature(-1.0, motion, lattice.kappa_max),
        left=_route_curvature(1.0, motion, lattice.kappa_max),
    )  # fmt: skip


def _between(lattice: Lattice, offsets: Array, change: int) -> list[tuple[int, int, int, float]]:
    """End, begin, steps and cost of all primitives that change the offset by a number of spacings."""
    delta, v_x = lattice.spacing * change, lattice.v_x
    peak = 4.0 / (1.0 - _RAMP)  # largest second derivative of a unit shift
    limits = (peak * delta / lattice.kappa_max) ** 0.5, (_PEAK_JERK * delta / lattice.rate_max) ** (1.0 / 3.0)
    q = max(math.ceil(max(limits) / lattice.step - 1e-9), 1)
    unit = np.linspace(0.0, 1.0, 201)
    blend, _, second = shifted(unit, 0.0, 1.0, 1.0)
    found = []
    for steps in sorted({round(q * k) for k in lattice.length_factors} | {q + 1} if change else {1}):
        span = steps * lattice.step
        lateral = float(trapezoid(second**2, unit)) * delta**2 / span**3 * v_x**3
        jerk = 2.0 * _RAMP * _PEAK_JERK**2 * delta**2 / span**5 * v_x**5
        for i, begin in enumerate(offsets.tolist()):
            for j in {i - change, i + change} if steps <= lattice.max_steps else ():
                if 0 <= j < len(offsets):
                    square = float(trapezoid((begin + (offsets[j] - begin) * blend) ** 2, unit)) * span / v_x
                    cost = sum(w * c for w, c in zip(lattice.weights, (lateral, jerk, square), strict=True))
                    found.append((j, i, steps, cost))
    return found


def shifted(
    tau: ArrayLike, begin: ArrayLike, change: ArrayLike, length: ArrayLike
) -> tuple[Array, Array, Array]:
    """Offset along a shift [m] and its first [-] and second [1/m] derivative by station."""
    # `tau` is the fraction of its length [m]; `change` is added to the offset at its begin [m]. At equal
    # length the largest curvature is 5/5.77 and the largest change of curvature 50/60 of those of a quintic.
    tau, begin, change, length = (np.asarray(a, dtype=np.float64) for a in (tau, begin, change, length))
    blend, slope, second = (np.zeros(tau.shape) for _ in range(3))
    for knot, jerk in zip(_KNOTS, _JERK_STEPS, strict=True):
        since = np.maximum(tau - knot, 0.0)
        second += jerk * since
        slope += jerk / 2.0 * since * since
        blend += jerk / 6.0 * since**3
    return begin + change * blend, change / length * slope, change / length**2 * second


def curvature_used(kappa: Array | float, d: Array, slope: Array, second: Array) -> Array:
    """Curvature, times the squared speed ratio where the ego is faster than its station [1/m]."""
    # The limits a_y_max / v_x^2 and that of the steering apply to it. The change of `kappa` is neglected.
    scale = 1.0 - kappa * d
    square = scale * scale + slope * slope
    curvature = (second * scale + 2.0 * kappa * slope * slope + kappa * scale * scale) / square**1.5
    used: Array = curvature * np.maximum(square, 1.0)
    return used


def _route_curvature(side: float, motion: tuple[Array, Array, Array], kappa_max: float) -> Array:
    """Largest curvature of the route to a side (1 left, -1 right) at which primitives keep the limit."""
    m = motion[0].shape[1]
    kept, broken = np.zeros(m), np.full(m, kappa_max)
    for _ in range(16):  # bisection to 2^-16 of the limit
        middle = 0.5 * (kept + broken)
        keeps = (np.abs(curvature_used(side * middle, *motion)) <= kappa_max).all(axis=0)
        kept, broken = np.where(keeps, middle, kept), np.where(keeps, broken, middle)
    return side * kept
