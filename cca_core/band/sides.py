"""Side assignment: the sides whose band has the least energy."""

import itertools
import math
from types import NoneType

import numpy as np

from cca_core._checks import Array, Mask
from cca_core.band.band import Band
from cca_core.band.energy import band_energy
from cca_core.band.equilibrium import equilibrium
from cca_core.band.problem import BandProblem
from cca_core.band.tightening import relax_with_sides
from cca_core.errors import InputError


def parse_sides(side: object, problem: BandProblem) -> Mask:
    """Check the `side` argument of `relax_band`; return passes_left, shape (m, bands)."""
    m, bands = problem.corridor.alongside.shape[:2]
    if isinstance(side, str) and side in ("left", "right"):
        is_blocking, default = problem.corridor.default_sides()
        return np.where(is_blocking, side == "left", default)
    if not isinstance(side, (list, tuple)) or len(side) != m or not set(side) <= {"left", "right"}:
        raise InputError(
            f"side must be 'left', 'right' or a list of {m}, one for each obstacle, was {side!r}"
        )
    return np.repeat(np.array([each == "left" for each in side], dtype=np.bool_)[:, None], bands, axis=1)


def choose_sides(problem: BandProblem, previous: Band | None) -> Mask:
    """Return the sides of least energy among feasible bands, else those of least violation."""
    m, bands = problem.corridor.alongside.shape[:2]
    if not isinstance(previous, (Band, NoneType)):
        raise InputError(f"previous must be a Band, was {type(previous).__name__}")
    former = None if previous is None else previous.passes_left.reshape(len(previous.passes_left), -1)
    if former is not None and former.shape != (m, bands):
        former = None
    chosen = np.empty((m, bands), dtype=np.bool_)
    for i in range(bands):
        choices = _assignments(problem, i)
        if choices.shape[1] > 1:
            choices = _cheapest(problem, i, choices, None if former is None else former[:, [i]])
        chosen[:, i] = choices[:, 0] if choices.shape[1] else problem.corridor.default_sides()[1][:, i]
    return chosen


def _cheapest(problem: BandProblem, band: int, choices: Mask, former: Mask | None) -> Mask:
    """Return the best of several assignments, shape (m, 1); none if no assignment is feasible."""
    settings = problem.settings
    copies = problem.select(np.full(choices.shape[1], band))
    lower, upper = copies.corridor.bounds(choices)
    fits = (lower <= upper).all(axis=1)
    choices, lower, upper = choices[:, fits], lower[fits], upper[fits]
    if choices.shape[1] < 2:
        return choices
    copies = copies.select(np.flatnonzero(fits))
    h = float(problem.h[band])
    lower, upper = lower - problem.free_displacement[band], upper - problem.free_displacement[band]
    u, _, _ = equilibrium(problem.stiffness.stencil(h), problem.stiffness.k_e * h, lower, upper)
    cost = band_energy(u, lower=lower, upper=upper, spacing=h, stiffness=problem.stiffness)
    cost = cost * (1.0 + 1e-6 * (~choices).sum(axis=0))  # of two equals the left one
    if former is not None:
        cost[(choices == former).all(axis=0)] *= settings.side_change_fraction
    order = np.argsort(cost)[: settings.max_certified_sides]
    first = relax_with_sides(copies.select(order[:1]), (1,), choices[:, order[:1]])
    if not first.ok[0] and len(order) > 1:
        tried = relax_with_sides(copies.select(order), (len(order),), choices[:, order])
        order = order[[np.argmin(np.where(tried.ok, 0.0, _violation(tried)))]]
    return choices[:, order[:1]]


def _violation(bands: Band) -> Array:
    """Return the violation of clearance and curvature limit of bands [-]; a meter counts as 5 limits."""
    shortfall = np.maximum(bands.problem.clearance - bands.clearance, -bands.edge_clearance).clip(0.0)
    ratio = bands.curvature / bands.problem.curvature_limit.min(axis=1)
    violation: Array = 5.0 * shortfall + (ratio - 1.0).clip(0.0) + 1e-9
    return violation


def _assignments(problem: BandProblem, band: int) -> Mask:
    """Return the assignments of sides to be tried for a band, shape (m, assignments)."""
    c = problem.corridor
    is_blocking, default = (sides[:, band] for sides in c.default_sides())
    if not is_blocking.any():
        return default[:, None]
    alongside = c.alongside[:, band]
    left, right = c.left[:, band], c.right[:, band]
    no_left = (alongside & (left > c.upper[band])).any(axis=1)
    no_right = (alongside & (right < c.lower[band])).any(axis=1)
    distance = np.where(alongside, np.maximum(right, -left), math.inf).min(axis=1)
    free = ~no_left & ~no_right
    free[np.argsort(np.where(free, distance, math.inf))[problem.settings.max_free_sides :]] = False
    fixed = np.where(no_left != no_right, no_right, default)
    options = [(True, False) if f else (bool(side),) for f, side in zip(free, fixed, strict=True)]
    return np.array(list(itertools.product(*options)), dtype=np.bool_).reshape(-1, len(free)).T
