"""Free poses of the ego's body on a road: a table for the search, and an exact check of a result."""

import math
from dataclasses import dataclass, fields

import numpy as np

from cca_core._checks import Array, Complex, Index, Mask
from cca_core.baselines.problems.problem import Problem
from cca_core.geometry import Boxes, box_gap

# fixed slopes of the lines that bound a Minkowski sum besides those along the sides of the boxes
_SLOPES = np.array([-8.0, -2.4142, -1.0, -0.4142, 0.4142, 1.0, 2.4142, 8.0])
_ROUNDING = 1e-6  # a body on the road edge is inside [m]


@dataclass(frozen=True, slots=True, eq=False)
class FreeCells:
    """Table of free poses: a cell is free only if every pose half a spacing around its center is."""

    between_edges: Mask  # (headings, offsets): cells that are free where no vehicle is near
    near: Index  # (j,): increasing indices of the stations with a vehicle near
    free_near: Mask  # (j, headings, offsets): free cells at these stations


@dataclass(frozen=True, slots=True, eq=False)
class RouteSamples:
    """The route at n stations, and m other vehicles when the ego passes them at the wanted speed."""

    s: Array  # stations of the ego's center of gravity [m]
    t: Array  # times [s]
    position: Complex  # x + iy [m]
    tangent: Complex  # unit tangents [-]
    kappa: Array  # curvature of the route [1/m]
    other_center: Complex  # (m, n): centers of the boxes [m]
    other_heading: Complex  # (m, n): their headings as unit numbers [-]
    half_length: Array  # (m, n) [m]
    half_width: Array


def sample_route(problem: Problem, s: Array) -> RouteSamples:
    """Sample the route and the other vehicles."""
    t = (s - problem.start) / problem.v_x
    position, first, second = problem.road.path.derivatives(s)
    tangent: Complex = first[:, 0] + 1j * first[:, 1]
    norm = np.abs(tangent)
    kappa = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / norm**3
    shape = (len(problem.others), len(s))
    center, heading = np.empty(shape, dtype=np.complex128), np.empty(shape, dtype=np.complex128)
    half_length, half_width = np.empty(shape), np.empty(shape)
    for i, box in enumerate(problem.boxes_at(t)):
        center[i], heading[i] = box.x + 1j * box.y, np.exp(1j * box.psi)
        half_length[i], half_width[i] = 0.5 * box.length, 0.5 * box.width
    tangent /= norm
    return RouteSamples(
        s, t, position[:, 0] + 1j * position[:, 1], tangent, kappa, center, heading, half_length, half_width
    )


def subsample(at: RouteSamples, k: int) -> RouteSamples:
    """Return every k-th station."""
    return RouteSamples(*(getattr(at, field.name)[..., ::k] for field in fields(RouteSamples)))


def free_cells(
    problem: Problem, at: RouteSamples, headings: Array, offsets: Array, *, station_margin: float = 0.0
) -> FreeCells:
    """Table for equidistant headings [rad] and offsets [m], for poses up to a margin off a station [m]."""
    car = problem.vehicle
    turned = 0.5 * math.hypot(_reach(problem), 0.5 * car.width) * float(headings[1] - headings[0])
    shifted = 0.5 * float(offsets[1] - offsets[0])
    between_edges = _between_edges(problem, at, headings, offsets, turned + shifted)
    gap = problem.clearance + turned
    other, i = _near_vehicles(problem, at, offsets, gap + station_margin)
    rows, row = np.unique(i, return_inverse=True)
    free_near = np.repeat(between_edges[None], len(rows), axis=0)
    if not len(i):
        return FreeCells(between_edges, rows, free_near)
    lower, upper = _blocked_offsets(problem, at, headings, other, i, gap, station_margin, shifted)
    clear = (offsets <= lower[..., None]) | (offsets >= upper[..., None])
    for k in range(len(problem.others)):
        of_this = other == k
        free_near[row[of_this]] &= clear[of_this]
    return FreeCells(between_edges, rows, free_near)


def _reach(problem: Problem) -> float:
    """Longest distance of the body's ends from the center of gravity [m]."""
    return abs(problem.vehicle.box_offset) + 0.5 * problem.vehicle.length


def _between_edges(
    problem: Problem, at: RouteSamples, headings: Array, offsets: Array, margin: float
) -> Mask:
    """Cells between the road edges at every station."""
    car, sin = problem.vehicle, np.sin(headings)
    sagitta = 0.55 * _reach(problem) ** 2  # over the curvature, with a reserve of 10 %
    half = 0.5 * car.length * np.abs(sin) + 0.5 * car.width * np.cos(headings) + margin - _ROUNDING
    leftmost = problem.road.left_edge - half - sagitta * max(-float(at.kappa.min()), 0.0)
    rightmost = problem.road.right_edge + half + sagitta * max(float(at.kappa.max()), 0.0)
    center = offsets + car.box_offset * sin[:, None]
    cells: Mask = (center <= leftmost[:, None]) & (center >= rightmost[:, None])
    return cells


def _near_vehicles(problem: Problem, at: RouteSamples, offsets: Array, margin: float) -> tuple[Index, Index]:
    """Vehicles and stations at which they may block a cell."""
    front = _reach(problem)
    lever = math.hypot(front, 0.5 * problem.vehicle.width)
    relative = (at.other_center - at.position) * at.tangent.conj()
    around = np.hypot(at.half_length, at.half_width) + margin
    near = np.abs(relative.real) < front + around
    near &= (relative.imag - around < offsets[-1] + lever) & (relative.imag + around > offsets[0] - lever)
    other, i = near.nonzero()
    return other, i


def _blocked_offsets(
    problem: Problem, at: RouteSamples, headings: Array, other: Index, i: Index, gap: float,
    station_margin: float, shifted: float,
) -> tuple[Array, Array]:  # fmt: skip
    """Open interval of offsets that a vehicle blocks, for each heading; lower is above upper if none is."""
    # a slice of the Minkowski sum of both boxes and a disc of the gap, bounded by lines along the sides of
    # the boxes and at fixed slopes, which lie on or a few millimeters outside it
    car, cos, sin = problem.vehicle, np.cos(headings), np.sin(headings)
    relative = (at.other_center[other, i] - at.position[i]) * at.tangent[i].conj()
    x, y = relative.real[:, None] - car.box_offset * cos, relative.imag[:, None] - car.box_offset * sin
    turn = (at.other_heading[other, i] * at.tangent[i].conj())[:, None, None]
    ego_sides = 0.5 * np.array((car.length * np.exp(1j * headings), 1j * car.width * np.exp(1j * headings)))
    a, b = at.half_length[other, i, None, None] * turn, 1j * at.half_width[other, i, None, None] * turn
    steep = np.abs(turn.imag) > 20.0 * np.abs(turn.real)
    m = np.empty((len(i), len(headings), len(_SLOPES) + 2))
    m[..., 0] = np.tan(headings)
    m[..., 1] = np.where(steep, 0.0, turn.imag / np.where(steep, 1.0, turn.real))[..., 0]
    m[..., 2:] = _SLOPES
    high = np.abs(a.imag - m * a.real) + np.abs(b.imag - m * b.real) + gap * np.sqrt(1.0 + m * m)
    high += station_margin * np.abs(m) + shifted
    for side in ego_sides[..., None]:
        high += np.abs(side.imag - m * side.real)
    length = (np.abs(a.real) + np.abs(b.real))[..., 0] + np.abs(ego_sides.real).sum(axis=0)
    m *= x[..., None]
    alongside = np.abs(x) < length + gap + station_margin
    upper = np.where(alongside, (m + high).min(axis=-1), -math.inf)
    lower = np.where(alongside, (m - high).max(axis=-1), math.inf)
    return y - upper, y - lower


def clearance_shortfall(problem: Problem, at: RouteSamples, d: Array, turn: Complex) -> Array:
    """Missing clearance [m] of poses with offsets [m] and headings relative to the route, as unit numbers."""
    car = problem.vehicle
    ends = car.box_offset + 0.5 * car.length * np.array([[1.0], [0.0], [-1.0]])
    axis = d + ends * turn.imag - 0.5 * at.kappa * (ends * turn.real) ** 2
    half_width = 0.5 * car.width * np.abs(turn.real)
    left = (axis + half_width).max(axis=0) - problem.road.left_edge
    right = problem.road.right_edge - (axis - half_width).min(axis=0)
    shortfall: Array = np.maximum(left, right) - _ROUNDING
    if not len(at.other_center):
        return shortfall
    heading = at.tangent * turn
    offset = at.other_center - at.position - 1j * at.tangent * d - car.box_offset * heading
    half = (0.5 * car.length, 0.5 * car.width)
    sizes = np.hypot(at.half_length, at.half_width) + math.hypot(*half)
    other, i = (np.abs(offset) < sizes + problem.clearance).nonzero()
    if len(i):
        away = offset[other, i]
        body = Boxes(np.array(0.0), np.array(0.0), np.angle(heading[i]), *(np.array(2.0 * h) for h in half))
        boxes = Boxes(
            away.real, away.imag, np.angle(at.other_heading[other, i]), 2.0 * at.half_length[other, i],
            2.0 * at.half_width[other, i],
        )  # fmt: skip
        gap = box_gap(body, boxes)
        np.maximum.at(shortfall, i, problem.clearance - gap)
    return shortfall
