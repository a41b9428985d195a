"""Motion primitives: shortest path through a lattice of lane keeping and lateral shifts."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cca_core._checks import Array, Complex, Mask, check_real, check_reals
from cca_core.baselines.methods.free_space import (
    FreeCells,
    RouteSamples,
    clearance_shortfall,
    free_cells,
    sample_route,
    subsample,
)
from cca_core.baselines.methods.primitive_library import Lattice, Library, curvature_used, library, shifted
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.errors import InputError, Status

_PARTS = 4  # of a step between stations, at whose ends the table of free poses is used
_FINE = 8  # parts of a step, at whose ends the plan is checked and sampled
_MAX_STEPS = 63  # stations are the bits of a word

_library = lru_cache(maxsize=32)(library)


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionPrimitives:
    """State lattice along a road, searched completely.

    Parameters
    ----------
    step : float
        Distance between stations of the lattice as a time at the wanted speed [s].
    spacing : float
        Lateral distance between its points [m].
    length_factors : tuple of float
        Lengths of shifts over the shortest one that keeps the limits [-].
    jerk_max : float
        Largest lateral jerk of a primitive [m/s^3].
    weight_a_y : float
        Cost of the squared lateral acceleration relative to the route [s^4/m^2].
    weight_jerk : float
        Cost of the squared lateral jerk [s^6/m^2].
    weight_offset : float
        Cost of the squared lateral offset [1/m^2].
    cell_width : float
        Width of the cells in the table of free poses [m].
    heading_step : float
        Distance between the headings of that table [rad].
    max_attempts : int
        Number of sequences of which the exact check may reject all before the search ends [-].

    Raises
    ------
    InputError
        If a value is out of range.

    Notes
    -----
    Lattice points are stations and lateral offsets of the route, with its heading and curvature [1]_. Between
    them a primitive keeps its offset, or shifts it by a trapezoid of curvature to each side, with zero slope
    and curvature at both ends. The shortest length follows from the limits of curvature, lateral
    acceleration, jerk and steering rate. The cost is the integral of the weighted squares over time. Dynamic
    programming over the stations finds the cheapest sequence from the route to the route.

    The ego passes stations at the wanted speed, which gives the time of each. Primitives are computed once
    for a speed, a road width and a vehicle. A table of free poses that is conservative by a few centimeters
    checks all of them. The sequence found is checked exactly, eight times a step; a primitive that fails is
    removed, and the search repeated.

    References
    ----------
    .. [1] M. Pivtoraiko, R. A. Knepper, A. Kelly, *Differentially constrained mobile robot motion planning
       in state lattices*, Journal of Field Robotics 26(3), 2009.

    Examples
    --------
    >>> MotionPrimitives(spacing=0.5).spacing
    0.5
    """

    step: float = 0.15
    spacing: float = 0.25
    length_factors: tuple[float, ...] = (1.0, 1.4, 2.0)
    jerk_max: float = 40.0
    weight_a_y: float = 0.25
    weight_jerk: float = 0.01
    weight_offset: float = 0.25
    cell_width: float = 0.05
    heading_step: float = 0.0125
    max_attempts: int = 20

    def __post_init__(self) -> None:
        check_real("step", self.step, gt=0.0)
        check_real("spacing", self.spacing, ge=0.05)
        check_real("jerk_max", self.jerk_max, gt=0.0)
        check_real("weight_a_y", self.weight_a_y, ge=0.0)
        check_real("weight_jerk", self.weight_jerk, ge=0.0)
        check_real("weight_offset", self.weight_offset, ge=0.0)
        check_real("cell_width", self.cell_width, gt=0.0)
        check_real("heading_step", self.heading_step, gt=0.0)
        check_reals("length_factors", self.length_factors, ge=1.0)
        check_real("max_attempts", self.max_attempts, ge=1.0)
        if not self.weight_a_y + self.weight_jerk + self.weight_offset > 0.0:
            raise InputError("weight_a_y, weight_jerk or weight_offset must be greater than 0")

    def plan(self, problem: Problem) -> Plan:
        """Find the cheapest sequence of primitives.

        Parameters
        ----------
        problem : Problem
            The problem.

        Returns
        -------
        plan : Plan
            Sampled eight times a step; its stations pass at the wanted speed. `Status.INFEASIBLE` if no
            sequence is free, `Status.NOT_CONVERGED` if the exact check rejected `max_attempts` sequences.
        """
        half, road = 0.5 * problem.vehicle.width, problem.road
        rightmost = math.ceil((road.right_edge + half) / self.spacing - 1e-9)
        leftmost = math.floor((road.left_edge - half) / self.spacing + 1e-9)
        if not rightmost <= 0 <= leftmost:
            return Plan(status=Status.INFEASIBLE, message="the body does not fit on the route")
        length = problem.goal - problem.start
        steps = min(max(round(length / (self.step * problem.v_x)), 1), _MAX_STEPS)
        primitives = _library(self._lattice(problem, rightmost, leftmost, length / steps, steps))
        fine = sample_route(problem, np.linspace(problem.start, problem.goal, steps * _FINE + 1))
        at = subsample(fine, _FINE // _PARTS)
        costs = _costs(primitives, free_cells(problem, at, primitives.headings, primitives.lateral), at.kappa)
        for _ in range(self.max_attempts):
            sequence = _cheapest(primitives, costs, -rightmost)
            if sequence is None:
                return Plan(status=Status.INFEASIBLE, message="no sequence of primitives is free")
            d, slope, second = _sampled(primitives, sequence)
            failed = np.flatnonzero(_fails(problem, fine, d, slope, second))
            if not len(failed):
                return _plan_of(problem, fine, d, slope)
            for p, first in sequence:
                last = first + primitives.steps[p]
                if ((failed >= first * _FINE) & (failed <= last * _FINE)).any():
                    costs[last, p] = math.inf
        message = f"{self.max_attempts} sequences failed the exact check"
        return Plan(status=Status.NOT_CONVERGED, message=message)

    def _lattice(self, problem: Problem, rightmost: int, leftmost: int, step: float, steps: int) -> Lattice:
        """Lattice for a problem."""
        steering = problem.vehicle.delta_rate_max / problem.vehicle.wheelbase  # of the curvature [1/(m s)]
        return Lattice(
            spacing=self.spacing, rightmost=rightmost, leftmost=leftmost, step=step, max_steps=steps,
            parts=_PARTS, length_factors=tuple(self.length_factors), cell_width=self.cell_width,
            heading_step=self.heading_step, v_x=problem.v_x, kappa_max=problem.kappa_max,
            rate_max=min(self.jerk_max / problem.v_x**3, steering / problem.v_x),
            weights=(self.weight_a_y, self.weight_jerk, self.weight_offset),
        )  # fmt: skip


def _costs(library: Library, free: FreeCells, kappa: Array) -> Array:
    """Cost (steps + 1, m) of each primitive that ends at a station, infinite where it is not free."""
    # The stations at which a cell is free are the bits of a word: one shift moves a primitive along the road.
    steps = (len(kappa) - 1) // _PARTS
    words = np.where(free.between_edges.ravel(), np.uint64(2 ** (steps + 1) - 1), np.uint64(0))
    words = np.repeat(words[None], _PARTS, axis=0)
    blocked = ~free.free_near.reshape(len(free.near), free.between_edges.size)
    for part in range(_PARTS):
        here = free.near % _PARTS == part
        bits = (free.near[here] // _PARTS).astype(np.uint64)[:, None]
        words[part] &= ~np.bitwise_or.reduce(blocked[here].astype(np.uint64) << bits, axis=0)
    begins = np.bitwise_and.reduceat(words.ravel()[library.cell] >> library.shift, library.samples)
    ends = (begins << library.steps.astype(np.uint64)).astype("<u8")
    possible = np.unpackbits(ends.view(np.uint8).reshape(-1, 8), axis=1, bitorder="little", count=steps + 1)
    possible = possible.astype(np.bool_)
    if np.abs(kappa).max() > 1e-9:
        lowest, highest = _curvatures(kappa, steps, int(library.steps.max()))
        possible &= lowest[library.steps] >= library.right[:, None]
        possible &= highest[library.steps] <= library.left[:, None]
    return np.where(possible.T, library.cost, math.inf)


def _curvatures(kappa: Array, steps: int, max_steps: int) -> tuple[Array, Array]:
    """Smallest and largest curvature of the route in q steps before a station, (max_steps + 1, steps + 1)."""
    of_step = kappa[np.arange(steps)[:, None] * _PARTS + np.arange(_PARTS + 1)]
    lowest, highest = np.zeros((2, max_steps + 1, steps + 1))
    lowest[1, 1:], highest[1, 1:] = of_step.min(axis=1), of_step.max(axis=1)
    for q in range(2, max_steps + 1):
        lowest[q, q:] = np.minimum(lowest[q - 1, q - 1 : -1], lowest[1, q:])
        highest[q, q:] = np.maximum(highest[q - 1, q - 1 : -1], highest[1, q:])
    return lowest, highest


def _cheapest(library: Library, costs: Array, route: int) -> list[tuple[int, int]] | None:
    """Primitives and the stations at which they begin, in driving order; None if there is none."""
    n, before = len(library.offsets), int(library.steps.max())
    value = np.full((len(costs) + before, n), math.inf)
    value[before, route] = 0.0
    flat = value.ravel()
    begin = (before - library.steps) * n + library.begins
    for b in range(1, len(costs)):
        value[before + b] = np.minimum.reduceat(flat[begin + b * n] + costs[b], library.first)
    if not math.isfinite(value[-1, route]):
        return None
    found: list[tuple[int, int]] = []
    b, j = len(costs) - 1, route
    bounds = np.append(library.first, len(library.begins))
    while b > 0:
        of_j = slice(bounds[j], bounds[j + 1])
        p = bounds[j] + int(np.argmin(flat[begin[of_j] + b * n] + costs[b, of_j]))
        b, j = b - int(library.steps[p]), int(library.begins[p])
        found.append((int(p), b))
    return found[::-1]


def _sampled(library: Library, sequence: list[tuple[int, int]]) -> tuple[Array, Array, Array]:
    """Offset, slope and second derivative of a sequence at the fine stations."""
    p, first = np.array(sequence).T
    span = library.steps[p] * _FINE
    k = np.arange(span.sum() + 1)
    piece = np.minimum(np.searchsorted(first * _FINE, k, side="right") - 1, len(p) - 1)
    begin = library.offsets[library.begins[p]]
    change = library.offsets[library.ends[p]] - begin
    tau = (k - first[piece] * _FINE) / span[piece]
    return shifted(tau, begin[piece], change[piece], library.steps[p][piece] * library.step)


def _fails(problem: Problem, at: RouteSamples, d: Array, slope: Array, second: Array) -> Mask:
    """Whether a sequence violates the clearance or the curvature limit, at each of the fine stations."""
    ahead: Complex = 1.0 - at.kappa * d + 1j * slope
    too_close = clearance_shortfall(problem, at, d, np.divide(ahead, np.abs(ahead))) > 0.0
    limit = problem.kappa_max * (1.0 + 1e-3)
    return too_close | (np.abs(curvature_used(at.kappa, d, slope, second)) > limit)


def _plan_of(problem: Problem, at: RouteSamples, d: Array, slope: Array) -> Plan:
    """Plan along offsets that passes the stations at the wanted speed."""
    position: Complex = at.position + 1j * at.tangent * d
    return Plan(
        status=Status.OK, t=at.t, xy=np.column_stack((position.real, position.imag)),
        v_x=problem.v_x * np.hypot(1.0 - at.kappa * d, slope),
    )  # fmt: skip
