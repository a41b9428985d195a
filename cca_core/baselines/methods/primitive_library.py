"""Library of motion primitives: keeping an offset from the route, and shifting it."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import trapezoid

from cca_core._checks import Array, Index

_RAMP = 0.2  # part of each half of a shift in which its curvature rises, and in which it falls
_KNOTS = np.array([0.0, 0.5 * _RAMP, 0.5 - 0.5 * _RAMP, 0.5 + 0.5 * _RAMP, 1.0 - 0.5 * _RAMP])
_JERK = 8.0 / (_RAMP * (1.0 - _RAMP))  # of a unit shift
_CHANGES = _JERK * np.array([1.0, -1.0, -1.0, 1.0, 1.0])  # of the third derivative at the knots
_BENT = 4.0 / (1.0 - _RAMP)  # its largest second derivative
_LONGER = (1.0, 1.4, 2.0)  # lengths of shifts as multiples of the shortest one
_CURVED = np.array([0.05, 0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9, 0.95])  # where on a shift curvature is checked
_CELL = 0.05  # lateral spacing of the table of free poses [m]
_TURN = 0.0125  # spacing of its headings [rad]
_HALVINGS = 16
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Lattice:
    """What the primitives are made for.

    Parameters
    ----------
    spacing : float
        Between neighboring offsets of the lattice [m].
    least, most : int
        Its rightmost and leftmost offset, in spacings from the route [-].
    step : float
        Between neighboring stations [m].
    longest : int
        Most steps of a primitive [-].
    parts : int
        Parts of a step between whose ends the body is checked [-].
    v_x : float
        Speed along the route [m/s].
    kappa_max : float
        Largest curvature [1/m].
    rate_max : float
        Largest change of curvature [1/m^2].
    weights : tuple of float
        Cost of the squares of lateral acceleration [s^4/m^2], lateral jerk [s^6/m^2] and offset [1/m^2].
    """

    spacing: float
    least: int
    most: int
    step: float
    longest: int
    parts: int
    v_x: float
    kappa_max: float
    rate_max: float
    weights: tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Library:
    """All m primitives between n offsets, in the order of the offset at which they end.

    Parameters
    ----------
    step : float
        Between neighboring stations [m].
    offsets : ndarray, shape (n,)
        Offsets of the lattice [m], left positive.
    begins, ends : ndarray of int, shape (m,)
        Offsets at which primitives begin and end.
    steps : ndarray of int, shape (m,)
        Their lengths in steps.
    cost : ndarray, shape (m,)
        Their costs [-].
    first : ndarray of int, shape (n,)
        First primitive that ends at an offset.
    samples : ndarray of int, shape (m,)
        First sample of a primitive.
    cell : ndarray of int, shape (samples,)
        Cell (part of a step, heading, offset) of the table of free poses in which a sample lies, flattened.
    shift : ndarray of uint64, shape (samples,)
        Whole steps between the beginning of the primitive and the sample.
    headings, lateral : ndarray
        Headings [rad] and offsets [m] of the table.
    right, left : ndarray, shape (m,)
        Least and largest curvature of the route at which a primitive keeps the limit of curvature [1/m].
    """

    step: float
    offsets: Array
    begins: Index
    ends: Index
    steps: Index
    cost: Array
    first: Index
    samples: Index
    cell: Index
    shift: np.ndarray[tuple[int], np.dtype[np.uint64]]
    headings: Array
    lateral: Array
    right: Array
    left: Array


def library(lattice: Lattice) -> Library:
    """Compute all primitives that keep the limits on a straight road.

    Parameters
    ----------
    lattice : Lattice
        What they are made for.

    Returns
    -------
    library : Library
        Keeping of an offset for one step, and shifts between all offsets in several lengths each.
    """
    offsets: Array = lattice.spacing * np.arange(lattice.least, lattice.most + 1, dtype=np.float64)
    rows = sorted(row for change in range(len(offsets)) for row in _between(lattice, offsets, change))
    ends, begins, steps = (np.array([row[k] for row in rows], dtype=np.intp) for k in range(3))
    change, span = offsets[ends] - offsets[begins], steps * lattice.step
    per = steps * lattice.parts + 1
    samples = np.cumsum(per) - per
    p = np.repeat(np.arange(len(rows)), per)
    k = np.arange(len(p)) - samples[p]
    d, slope, _ = shifted(k / (per[p] - 1), offsets[begins][p], change[p], span[p])
    turn = np.arctan(slope)
    widest = math.ceil(float(np.abs(turn).max()) / _TURN) + 1
    headings: Array = _TURN * np.arange(-widest, widest + 1, dtype=np.float64)
    cells = round((offsets[-1] - offsets[0]) / _CELL) + 1
    row, column = np.rint(turn / _TURN).astype(np.intp) + widest, np.rint((d - offsets[0]) / _CELL)
    bent = shifted(_CURVED[:, None], offsets[begins], change, span)
    return Library(
        step=lattice.step, offsets=offsets, begins=begins, ends=ends, steps=steps,
        cost=np.array([row[3] for row in rows]), first=np.searchsorted(ends, np.arange(len(offsets))),
        samples=samples, shift=(k // lattice.parts).astype(np.uint64),
        cell=((k % lattice.parts) * len(headings) + row) * cells + column.astype(np.intp),
        headings=headings, lateral=offsets[0] + _CELL * np.arange(cells),
        right=_tolerated(-1.0, bent, lattice.kappa_max), left=_tolerated(1.0, bent, lattice.kappa_max),
    )  # fmt: skip


def _between(lattice: Lattice, offsets: Array, change: int) -> list[tuple[int, int, int, float]]:
    """End, beginning, steps and cost of all primitives that change the offset by so many spacings."""
    delta, v_x = lattice.spacing * change, lattice.v_x
    limits = (_BENT * delta / lattice.kappa_max) ** 0.5, (_JERK * delta / lattice.rate_max) ** (1.0 / 3.0)
    q = max(math.ceil(max(limits) / lattice.step - _ROUNDING), 1)
    unit = np.linspace(0.0, 1.0, 201)
    blend, _, second = shifted(unit, 0.0, 1.0, 1.0)
    found = []
    for steps in sorted({round(q * k) for k in _LONGER} | {q + 1} if change else {1}):
        span = steps * lattice.step
        lateral = float(trapezoid(second**2, unit)) * delta**2 / span**3 * v_x**3
        jerk = 2.0 * _RAMP * _JERK**2 * delta**2 / span**5 * v_x**5
        for i, begin in enumerate(offsets.tolist()):
            for j in {i - change, i + change} if steps <= lattice.longest else ():
                if 0 <= j < len(offsets):
                    square = float(trapezoid((begin + (offsets[j] - begin) * blend) ** 2, unit)) * span / v_x
                    cost = sum(w * c for w, c in zip(lattice.weights, (lateral, jerk, square), strict=True))
                    found.append((j, i, steps, cost))
    return found


def shifted(
    tau: ArrayLike, begin: ArrayLike, change: ArrayLike, length: ArrayLike
) -> tuple[Array, Array, Array]:
    """Offset along a shift.

    Parameters
    ----------
    tau : array_like, shape (...)
        Part of the shift, from 0 to 1 [-].
    begin, change : array_like, shape (...)
        Offset at its beginning, and what is added to it [m].
    length : array_like, shape (...)
        Its length along the route [m].

    Returns
    -------
    d, slope, second : ndarray, shape (...)
        Offset [m] and its first [-] and second [1/m] derivative by station.

    Notes
    -----
    The third derivative is constant in pieces, the second a trapezoid to the one side and one to the other.
    At equal length its largest curvature is 5/5.77 and its largest change of curvature 50/60 of those of
    the quintic polynomial.
    """
    tau, begin, change, length = (np.asarray(a, dtype=np.float64) for a in (tau, begin, change, length))
    blend, slope, second = (np.zeros(tau.shape) for _ in range(3))
    for knot, jerk in zip(_KNOTS, _CHANGES, strict=True):
        since = np.maximum(tau - knot, 0.0)
        second += jerk * since
        slope += jerk / 2.0 * since * since
        blend += jerk / 6.0 * since**3
    return begin + change * blend, change / length * slope, change / length**2 * second


def curvature_used(kappa: Array | float, d: Array, slope: Array, second: Array) -> Array:
    """Curvature, times the square of the speed over that of the station where the ego is faster.

    Parameters
    ----------
    kappa : ndarray, shape (...), or float
        Curvature of the route [1/m]; its change is neglected.
    d, slope, second : ndarray, shape (...)
        Offset [m] and its derivatives by station [-], [1/m].

    Returns
    -------
    used : ndarray, shape (...)
        Curvature [1/m], left positive: to be compared with a_y_max / v_x^2 and with the steering's.
    """
    scale = 1.0 - kappa * d
    square = scale * scale + slope * slope
    curvature = (second * scale + 2.0 * kappa * slope * slope + kappa * scale * scale) / square**1.5
    used: Array = curvature * np.maximum(square, 1.0)
    return used


def _tolerated(side: float, bent: tuple[Array, Array, Array], kappa_max: float) -> Array:
    """Largest curvature of the route to a side (1 left, -1 right) at which primitives keep the limit."""
    m = bent[0].shape[1]
    least, most = np.zeros(m), np.full(m, kappa_max)
    for _ in range(_HALVINGS):
        middle = 0.5 * (least + most)
        keeps = (np.abs(curvature_used(side * middle, *bent)) <= kappa_max).all(axis=0)
        least, most = np.where(keeps, middle, least), np.where(keeps, most, middle)
    return side * least
