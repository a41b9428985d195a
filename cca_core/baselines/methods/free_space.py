"""Where the ego's body is free on a road: a table for searching, and an exact check of what was found."""

import math
from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array, Complex, Index, Mask
from cca_core.baselines.problems.problem import Problem
from cca_core.geometry import gap_between

_SLOPES = np.array([-8.0, -2.4142, -1.0, -0.4142, 0.4142, 1.0, 2.4142, 8.0])
_STEEPEST = 20.0
_ROUNDING = 1e-6  # [m]


@dataclass(frozen=True, slots=True, eq=False)
class FreeCells:
    """Table of poses at which the ego's body keeps the clearance to the others and to the edges.

    A cell is free only if every pose half a spacing around its middle is.

    Parameters
    ----------
    between_edges : ndarray of bool, shape (m, k)
        Cells at headings and offsets that are free at stations which no other is near.
    near : ndarray of int, shape (j,)
        Increasing indices of the stations that another is near.
    there : ndarray of bool, shape (j, m, k)
        Free cells at these.
    """

    between_edges: Mask
    near: Index
    there: Mask


@dataclass(frozen=True, slots=True, eq=False)
class RouteSamples:
    """The route at stations that the ego passes at its wanted speed, and the others at those times.

    Parameters
    ----------
    s : ndarray, shape (n,)
        Stations: path coordinates of the foot point of the ego's center of gravity [m].
    t : ndarray, shape (n,)
        Times at which it is there, (s - start) / v_x [s].
    place, along : ndarray of complex, shape (n,)
        Points of the route x + iy [m] and unit tangents [-].
    kappa : ndarray, shape (n,)
        Curvature of the route [1/m].
    center, ahead : ndarray of complex, shape (others, n)
        Middles [m] and unit headings [-] of the others' boxes at these times.
    half_length, half_width : ndarray, shape (others, n)
        Half extents of their boxes [m].
    """

    s: Array
    t: Array
    place: Complex
    along: Complex
    kappa: Array
    center: Complex
    ahead: Complex
    half_length: Array
    half_width: Array


def sample_route(problem: Problem, s: Array) -> RouteSamples:
    """Sample the route and the others.

    Parameters
    ----------
    problem : Problem
        Road, others and speed.
    s : ndarray, shape (n,)
        Stations [m].

    Returns
    -------
    stretch : Stretch
        What stands where when the ego passes these stations.
    """
    t = (s - problem.start) / problem.v_x
    position, first, second = problem.road.path.derivatives(s)
    tangent: Complex = first[:, 0] + 1j * first[:, 1]
    norm = np.abs(tangent)
    kappa = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / norm**3
    shape = (len(problem.others), len(s))
    center, ahead = np.empty(shape, dtype=np.complex128), np.empty(shape, dtype=np.complex128)
    half_length, half_width = np.empty(shape), np.empty(shape)
    for i, box in enumerate(problem.boxes_at(t)):
        center[i], ahead[i] = box.x + 1j * box.y, np.exp(1j * box.psi)
        half_length[i], half_width[i] = 0.5 * box.length, 0.5 * box.width
    place: Complex = position[:, 0] + 1j * position[:, 1]
    tangent /= norm
    return RouteSamples(s, t, place, tangent, kappa, center, ahead, half_length, half_width)


def free_cells(
    problem: Problem, at: RouteSamples, headings: Array, offsets: Array, *, station_margin: float = 0.0
) -> FreeCells:
    """Look where the ego's body is free.

    Parameters
    ----------
    problem : Problem
        What is to be kept.
    at : Stretch
        Stations of the table.
    headings : ndarray, shape (m,)
        Equidistant headings relative to the route [rad].
    offsets : ndarray, shape (k,)
        Equidistant lateral coordinates of the center of gravity [m], left positive.
    station_margin : float
        How far before or behind its station a pose may be for which the table is asked [m].

    Returns
    -------
    free : FreeCells
        Table of stations, headings and offsets.

    Notes
    -----
    The offsets that another blocks at one heading are an interval: a slice of the Minkowski sum of both boxes
    and a disc of the clearance. It is bounded by lines along the boxes' sides and at eight fixed slopes,
    which lie on or a few millimeters outside it.
    """
    car = problem.vehicle
    front = abs(car.box_offset) + 0.5 * car.length
    lever = math.hypot(front, 0.5 * car.width)
    turned = 0.5 * lever * float(headings[1] - headings[0])
    shifted = 0.5 * float(offsets[1] - offsets[0])
    cos, sin = np.cos(headings), np.sin(headings)
    bend = 0.55 * front * front
    reach = 0.5 * car.length * np.abs(sin) + 0.5 * car.width * cos + turned + shifted - _ROUNDING
    leftmost = problem.road.left_edge - reach - bend * max(-float(at.kappa.min()), 0.0)
    rightmost = problem.road.right_edge + reach + bend * max(float(at.kappa.max()), 0.0)
    middle = offsets + car.box_offset * sin[:, None]
    between_edges = (middle <= leftmost[:, None]) & (middle >= rightmost[:, None])

    gap = problem.clearance + turned
    seen = (at.center - at.place) * at.along.conj()
    around = np.hypot(at.half_length, at.half_width) + gap + station_margin
    near = np.abs(seen.real) < front + around
    near &= (seen.imag - around < offsets[-1] + lever) & (seen.imag + around > offsets[0] - lever)
    other, i = near.nonzero()
    rows, row = np.unique(i, return_inverse=True)
    there = np.repeat(between_edges[None], len(rows), axis=0)
    if not len(i):
        return FreeCells(between_edges, rows, there)
    turn = (at.ahead[other, i] * at.along[i].conj())[:, None, None]
    x = seen.real[other, i, None] - car.box_offset * cos
    y = seen.imag[other, i, None] - car.box_offset * sin
    # sides of the ego, of the other, and the margin, as vectors from the middle
    ours = 0.5 * np.array((car.length * np.exp(1j * headings), 1j * car.width * np.exp(1j * headings)))
    a, b = at.half_length[other, i, None, None] * turn, 1j * at.half_width[other, i, None, None] * turn
    steep = np.abs(turn.imag) > _STEEPEST * np.abs(turn.real)
    theirs = np.where(steep, 0.0, turn.imag / np.where(steep, 1.0, turn.real))
    m = np.empty((len(i), len(headings), len(_SLOPES) + 2))
    m[..., 0], m[..., 1], m[..., 2:] = np.tan(headings), theirs[..., 0], _SLOPES
    high = np.abs(a.imag - m * a.real) + np.abs(b.imag - m * b.real) + gap * np.sqrt(1.0 + m * m)
    high += station_margin * np.abs(m) + shifted
    for side in ours[..., None]:
        high += np.abs(side.imag - m * side.real)
    long = (np.abs(a.real) + np.abs(b.real))[..., 0] + np.abs(ours.real).sum(axis=0) + gap + station_margin
    m *= x[..., None]
    beside = np.abs(x) < long
    upper = np.where(beside, (m + high).min(axis=-1), -math.inf)
    lower = np.where(beside, (m - high).max(axis=-1), math.inf)
    clear = (offsets <= (y - upper)[..., None]) | (offsets >= (y - lower)[..., None])
    for k in range(len(problem.others)):
        of_this = other == k
        there[row[of_this]] &= clear[of_this]
    return FreeCells(between_edges, rows, there)


def subsample(at: RouteSamples, k: int) -> RouteSamples:
    """Return every k-th station of a stretch."""
    return RouteSamples(*(getattr(at, name)[..., ::k] for name in RouteSamples.__slots__))


def clearance_shortfall(problem: Problem, at: RouteSamples, d: Array, turn: Complex) -> Array:
    """How much poses lack of the clearance to the others and to the edges.

    Parameters
    ----------
    problem : Problem
        What is to be kept.
    at : Stretch
        Stations of the poses.
    d : ndarray, shape (n,)
        Lateral coordinates of the center of gravity [m].
    turn : ndarray of complex, shape (n,)
        Headings relative to the route as unit numbers exp(i psi) [-].

    Returns
    -------
    shortfall : ndarray, shape (n,)
        Largest of the distances missing [m], zero or negative where nothing is.
    """
    car = problem.vehicle
    ends = car.box_offset + 0.5 * car.length * np.array([[1.0], [0.0], [-1.0]])
    sides = d + ends * turn.imag - 0.5 * at.kappa * (ends * turn.real) ** 2
    beside = 0.5 * car.width * np.abs(turn.real)
    left = (sides + beside).max(axis=0) - problem.road.left_edge
    right = problem.road.right_edge - (sides - beside).min(axis=0)
    lacks: Array = np.maximum(left, right) - _ROUNDING
    if len(at.center):
        ahead = at.along * turn
        offset = at.center - at.place - 1j * at.along * d - car.box_offset * ahead
        half = (0.5 * car.length, 0.5 * car.width, at.half_length, at.half_width)
        near = np.abs(offset) < np.hypot(half[2], half[3]) + math.hypot(*half[:2]) + problem.clearance
        other, i = near.nonzero()
        if len(i):
            gap = gap_between(
                offset[other, i],
                ahead[i],
                at.ahead[other, i],
                *half[:2],
                half[2][other, i],
                half[3][other, i],
            )
            np.maximum.at(lacks, i, problem.clearance - gap)
    return lacks
