"""Motion primitives: shortest path through a lattice of lane keeping and lateral shifts."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cca_core._checks import Array, Complex, Mask, check_real
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

__all__ = ["MotionPrimitives"]

_PARTS = 4  # of a step between stations, at which the table of free poses is asked
_FINE = 8  # of a step, at which the plan is checked and given
_STEPS = 63  # stations are the bits of a word
_TRIES = 20
_ROUNDING = 1e-9

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
    jerk_max : float
        Largest lateral jerk of a primitive [m/s^3].
    weight_a_y : float
        Cost of lateral acceleration beyond that of the route, per its square [s^4/m^2].
    weight_jerk : float
        Cost of lateral jerk [s^6/m^2].
    weight_offset : float
        Cost of being off the route [1/m^2].

    Raises
    ------
    InputError
        If a value is out of range.

    Notes
    -----
    Lattice points are stations and lateral offsets of the route, with its heading and curvature [1]_. Between
    them a primitive keeps its offset, or shifts it with a trapezoid of curvature to each side, zero slope and
    curvature at both ends, in four lengths from the shortest that the limits of curvature, lateral
    acceleration, jerk and steering rate allow. The cost is the integral of the weighted squares over time.
    Dynamic programming over the stations finds the cheapest sequence from the route to the route.

    The ego passes stations at the wanted speed, so it is known where others are then. Primitives are computed
    once for a speed, a road width and a vehicle, and kept. All of them are checked against a table of free
    poses, whose cells are a few centimeters on the safe side; what is found is checked once more, exactly
    and eight times a step, and a primitive that fails there is taken out.

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
    jerk_max: float = 40.0
    weight_a_y: float = 0.25
    weight_jerk: float = 0.01
    weight_offset: float = 0.25

    def __post_init__(self) -> None:
        check_real("step", self.step, gt=0.0)
        check_real("spacing", self.spacing, ge=0.05)
        check_real("jerk_max", self.jerk_max, gt=0.0)
        check_real("weight_a_y", self.weight_a_y, ge=0.0)
        check_real("weight_jerk", self.weight_jerk, ge=0.0)
        check_real("weight_offset", self.weight_offset, ge=0.0)
        if not self.weight_a_y + self.weight_jerk + self.weight_offset > 0.0:
            raise InputError("weight_a_y, weight_jerk or weight_offset must be greater than 0")

    def plan(self, problem: Problem) -> Plan:
        """Find the cheapest sequence of primitives.

        Parameters
        ----------
        problem : Problem
            What is to be driven.

        Returns
        -------
        plan : Plan
            Sampled eight times a step; its speed is that at which stations pass at the wanted speed.
            `Status.INFEASIBLE` if no sequence is free, `Status.NOT_CONVERGED` if those tried failed the exact
            check.
        """
        length = problem.goal - problem.start
        steps = min(max(round(length / (self.step * problem.v_x)), 1), _STEPS)
        half, road = 0.5 * problem.vehicle.width, problem.road
        least = math.ceil((road.right_edge + half) / self.spacing - _ROUNDING)
        most = math.floor((road.left_edge - half) / self.spacing + _ROUNDING)
        if not least <= 0 <= most:
            return Plan(status=Status.INFEASIBLE, message="the body does not fit on the route")
        steering = problem.vehicle.delta_rate_max / problem.vehicle.wheelbase  # of the curvature [1/(m s)]
        primitives = _library(
            Lattice(
                spacing=self.spacing, least=least, most=most, step=length / steps, longest=steps,
                parts=_PARTS, v_x=problem.v_x, kappa_max=problem.kappa_max,
                rate_max=min(self.jerk_max / problem.v_x**3, steering / problem.v_x),
                weights=(self.weight_a_y, self.weight_jerk, self.weight_offset),
            )
        )  # fmt: skip
        fine = sample_route(problem, np.linspace(problem.start, problem.goal, steps * _FINE + 1))
        at = subsample(fine, _FINE // _PARTS)
        free = free_cells(problem, at, primitives.headings, primitives.lateral)
        costs = _costs(primitives, free, at.kappa)
        for _ in range(_TRIES):
            found = _cheapest(primitives, costs, -least)
            if found is None:
                return Plan(status=Status.INFEASIBLE, message="no sequence of primitives is free")
            d, slope, second = _drawn(primitives, found)
            bad = np.flatnonzero(_fails(problem, fine, d, slope, second))
            if not len(bad):
                return _driven(problem, fine, d, slope)
            for p, first in found:
                if ((bad >= first * _FINE) & (bad <= (first + primitives.steps[p]) * _FINE)).any():
                    costs[first + primitives.steps[p], p] = math.inf
        return Plan(status=Status.NOT_CONVERGED, message=f"{_TRIES} sequences failed the exact check")


def _costs(library: Library, free: FreeCells, kappa: Array) -> Array:
    """Cost (steps + 1, m) of a primitive that ends at a station, infinite where it cannot be driven.

    The stations at which a cell is free are the bits of a word: one shift moves a primitive along the road.
    """
    steps = (len(kappa) - 1) // _PARTS
    words = np.where(free.between_edges.ravel(), np.uint64(2 ** (steps + 1) - 1), np.uint64(0))
    words = np.repeat(words[None], _PARTS, axis=0)
    taken = ~free.there.reshape(len(free.near), free.between_edges.size)
    for part in range(_PARTS):
        here = free.near % _PARTS == part
        bits = (free.near[here] // _PARTS).astype(np.uint64)[:, None]
        words[part] &= ~np.bitwise_or.reduce(taken[here].astype(np.uint64) << bits, axis=0)
    begins = np.bitwise_and.reduceat(words.ravel()[library.cell] >> library.shift, library.samples)
    ends = (begins << library.steps.astype(np.uint64)).astype("<u8")
    possible = np.unpackbits(ends.view(np.uint8).reshape(-1, 8), axis=1, bitorder="little", count=steps + 1)
    possible = possible.astype(np.bool_)
    if np.abs(kappa).max() > _ROUNDING:
        least, most = _curvatures(kappa, steps, int(library.steps.max()))
        possible &= (least[library.steps] >= library.right[:, None]) & (
            most[library.steps] <= library.left[:, None]
        )
    return np.where(possible.T, library.cost, math.inf)


def _curvatures(kappa: Array, steps: int, longest: int) -> tuple[Array, Array]:
    """Least and largest curvature of the route in q steps before a station, (longest + 1, steps + 1)."""
    of_step = kappa[np.arange(steps)[:, None] * _PARTS + np.arange(_PARTS + 1)]
    least, most = np.zeros((2, longest + 1, steps + 1))
    least[1, 1:], most[1, 1:] = of_step.min(axis=1), of_step.max(axis=1)
    for q in range(2, longest + 1):
        least[q, q:] = np.minimum(least[q - 1, q - 1 : -1], least[1, q:])
        most[q, q:] = np.maximum(most[q - 1, q - 1 : -1], most[1, q:])
    return least, most


def _cheapest(library: Library, costs: Array, route: int) -> list[tuple[int, int]] | None:
    """Primitives and the stations at which they begin, in driving order; None if there is no sequence."""
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
    borders = np.append(library.first, len(library.begins))
    while b > 0:
        of_j = slice(borders[j], borders[j + 1])
        p = borders[j] + int(np.argmin(flat[begin[of_j] + b * n] + costs[b, of_j]))
        b, j = b - int(library.steps[p]), int(library.begins[p])
        found.append((int(p), b))
    return found[::-1]


def _drawn(library: Library, found: list[tuple[int, int]]) -> tuple[Array, Array, Array]:
    """Offset, slope and second derivative of a sequence at the fine stations."""
    p, first = np.array(found).T
    span = library.steps[p] * _FINE
    k = np.arange(span.sum() + 1)
    piece = np.minimum(np.searchsorted(first * _FINE, k, side="right") - 1, len(p) - 1)
    begin = library.offsets[library.begins[p]]
    change = library.offsets[library.ends[p]] - begin
    tau = (k - first[piece] * _FINE) / span[piece]
    return shifted(tau, begin[piece], change[piece], library.steps[p][piece] * library.step)


def _fails(problem: Problem, at: RouteSamples, d: Array, slope: Array, second: Array) -> Mask:
    """Whether a sequence lacks clearance or is bent too much, at each of the fine stations."""
    ahead: Complex = 1.0 - at.kappa * d + 1j * slope
    lacks = clearance_shortfall(problem, at, d, np.divide(ahead, np.abs(ahead))) > 0.0
    limit = problem.kappa_max * (1.0 + 1e-3)
    return lacks | (np.abs(curvature_used(at.kappa, d, slope, second)) > limit)


def _driven(problem: Problem, at: RouteSamples, d: Array, slope: Array) -> Plan:
    position: Complex = at.place + 1j * at.along * d
    return Plan(
        status=Status.OK, t=at.t, xy=np.column_stack((position.real, position.imag)),
        v_x=problem.v_x * np.hypot(1.0 - at.kappa * d, slope),
    )  # fmt: skip
