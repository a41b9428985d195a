"""On which side bands pass obstacles: the assignment whose band has the least energy."""

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

_CHOICES = 6  # obstacles of which every assignment of sides is tried
_TRIED = 8  # assignments whose clearance is certified, cheapest first
_TIE = 1e-6  # share by which passing on the right costs more
_HELD = 0.7  # a change of sides must lower the energy to this share


def parse_sides(side: object, task: BandProblem) -> Mask:
    """Check the sides that were asked for.

    Parameters
    ----------
    side : {"left", "right"} or sequence of them
        Side for the obstacles in the way, or for every obstacle.
    task : Task
        Bands side by side.

    Returns
    -------
    passes_left : ndarray of bool, shape (m, bands)
        Whether each obstacle is passed on its left.

    Raises
    ------
    InputError
        If `side` is anything else.
    """
    m, bands = task.corridor.alongside.shape[:2]
    if isinstance(side, str) and side in ("left", "right"):
        in_the_way, natural = task.corridor.default_sides()
        return np.where(in_the_way, side == "left", natural)
    if not isinstance(side, (list, tuple)) or len(side) != m or not set(side) <= {"left", "right"}:
        raise InputError(
            f"side must be 'left', 'right' or a list of {m}, one for each obstacle, was {side!r}"
        )
    return np.repeat(np.array([each == "left" for each in side], dtype=np.bool_)[:, None], bands, axis=1)


def choose_sides(task: BandProblem, previous: Band | None) -> Mask:
    """Choose the sides of least energy among those that keep clearance and limits.

    Parameters
    ----------
    task : Task
        Bands side by side.
    previous : Band, optional
        Bands whose sides are kept unless others are much cheaper.

    Returns
    -------
    passes_left : ndarray of bool, shape (m, bands)
        Whether each obstacle is passed on its left; where nothing keeps clearance and limits, what misses
        them least.
    """
    m, bands = task.corridor.alongside.shape[:2]
    if not isinstance(previous, (Band, NoneType)):
        raise InputError(f"previous must be a Band, was {type(previous).__name__}")
    held = None if previous is None else previous.passes_left.reshape(len(previous.passes_left), -1)
    chosen = np.empty((m, bands), dtype=np.bool_)
    for i in range(bands):
        choices = _assignments(task, i)
        if choices.shape[1] > 1:
            alone = task.select(np.full(choices.shape[1], i))
            lower, upper = alone.corridor.bounds(choices)
            room = (lower <= upper).all(axis=1)
            choices, lower, upper = choices[:, room], lower[room], upper[room]
        if choices.shape[1] > 1:
            alone = alone.select(np.flatnonzero(room))
            h = float(task.h[i])
            lower, upper = lower - task.free_displacement[i], upper - task.free_displacement[i]
            u, _, _ = equilibrium(task.stiffness.stencil(h), task.stiffness.k_e * h, lower, upper)
            cost = band_energy(u, lower=lower, upper=upper, spacing=h, stiffness=task.stiffness)
            cost = cost * (1.0 + _TIE * (~choices).sum(axis=0))
            if held is not None and held.shape == (m, bands):
                cost[(choices == held[:, [i]]).all(axis=0)] *= _HELD
            order = np.argsort(cost)[:_TRIED]
            first = relax_with_sides(alone.select(order[:1]), (1,), choices[:, order[:1]])
            if not first.ok[0] and len(order) > 1:
                tried = relax_with_sides(alone.select(order), (len(order),), choices[:, order])
                order = order[[np.argmin(np.where(tried.ok, 0.0, _violation(tried)))]]
            choices = choices[:, order[:1]]
        chosen[:, i] = choices[:, 0] if choices.shape[1] else task.corridor.default_sides()[1][:, i]
    return chosen


def _violation(bands: Band) -> Array:
    """Return how far bands are from what was asked, a meter that is lacking as much as 5 times the limit."""
    short = np.maximum(bands.problem.clearance - bands.clearance, -bands.edge_clearance).clip(0.0)
    bent = bands.curvature / bands.problem.curvature_limit.min(axis=1)
    excess: Array = 5.0 * short + (bent - 1.0).clip(0.0) + 1e-9
    return excess


def _assignments(task: BandProblem, band: int) -> Mask:
    """Return the assignments of sides that are worth a look, shape (m, assignments)."""
    c = task.corridor
    in_the_way, natural = (sides[:, band] for sides in c.default_sides())
    if not in_the_way.any():
        return natural[:, None]
    abeam = c.alongside[:, band]
    left, right = c.left[:, band], c.right[:, band]
    no_left = (abeam & (left > c.upper[band])).any(axis=1)
    no_right = (abeam & (right < c.lower[band])).any(axis=1)
    distance = np.where(abeam, np.maximum(right, -left), math.inf).min(axis=1)
    free = ~no_left & ~no_right
    free[np.argsort(np.where(free, distance, math.inf))[_CHOICES:]] = False
    fixed = np.where(no_left != no_right, no_right, natural)
    options = [(True, False) if f else (bool(side),) for f, side in zip(free, fixed, strict=True)]
    return np.array(list(itertools.product(*options)), dtype=np.bool_).reshape(-1, len(free)).T
