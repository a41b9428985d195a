"""Bands held by contacts: solve, see what the swept body lacks, push the bounds, solve again."""

import math

import numpy as np

from cca_core._checks import Array, Index, Mask
from cca_core.band.band import Band, assemble_band
from cca_core.band.certificate import Certificate, certify, end_gaps
from cca_core.band.equilibrium import CurvatureBounds, equilibrium
from cca_core.band.problem import BandProblem
from cca_core.errors import Status

_TIGHTENINGS = 16
_MOST_SOLVES = 400  # from which on it is not pushed any more: a drivable band takes 10 to 100
_GAIN, _STALL_LIMIT = 0.8, 4  # a round must lessen what is lacking to this share, one of so many at least
_MOST_SHARE = 0.8  # by which contact may be taken to give way
_AIM = 3e-3  # what is lacking is pushed for with this much more [m]
_END_SHORTFALL_LIMIT = 0.2  # lacking at a pinned end, from which on nothing is tried [m]
_SPARE = 2e-3  # share of the curvature limit that is aimed below it
_BEND = 0.25, 10.0  # stiffness of the curvature limit, per k_c [1/m^2] and per k_b [-]


def relax_with_sides(task: BandProblem, leading: tuple[int, ...], passes_left: Mask) -> Band:
    """Relax bands with their sides given.

    Parameters
    ----------
    task : Task
        Bands side by side.
    leading : tuple of int
        Leading axes of the result, () for a single band.
    passes_left : ndarray of bool, shape (m, bands)
        Whether the ego passes each obstacle on the obstacle's left.

    Returns
    -------
    band : Band
        The bands with their status.
    """
    lower, upper = task.corridor.bounds(passes_left)
    room = np.logical_and.reduce(lower <= upper, axis=1)
    stuck, pinned = {}, {}
    if not room.all():
        stuck = {int(i): _report_empty_interval(task, passes_left, int(i)) for i in np.flatnonzero(~room)}
    free = task.free_displacement
    ends = free[:, [0, -1]]
    if (lower[:, [0, -1]] > ends).any() or (upper[:, [0, -1]] < ends).any():
        pinned = _find_blocked_ends(task)
        room[list(pinned)] = False
    if stuck or pinned:
        lower[~room], upper[~room] = -math.inf, math.inf
    contact = task.stiffness.k_e * task.h
    stencil = task.stiffness.stencil(task.h)
    stiff = (_BEND[0] * task.stiffness.k_c + _BEND[1] * task.stiffness.k_b) / task.h**3
    u, solves, settled = equilibrium(stencil, contact, lower - free, upper - free)
    u += free
    found = certify(task, u)
    for at, o in pinned.items():
        reason = f"{found.gaps[o, at].min():.3f} m from obstacle {o}, which is at a pinned end"
        stuck[at] = Status.INFEASIBLE, f"{reason}, is below the {task.clearance:.3f} m asked", f"obstacle {o}"
    todo, lacked = np.flatnonzero(room), np.full(len(room), math.inf)
    bends: tuple[Array, Array] | None = None
    best, best_u = np.full(len(room), math.inf), u.copy()
    fruitless = np.zeros(len(room), dtype=np.intp)  # rounds since the last that brought much
    for _ in range(_TIGHTENINGS):
        lacks = np.maximum(task.clearance - found.min_gap, -found.min_edge_clearance)
        todo = todo[(lacks[todo] > 0.0) | (found.curvature_ratio[todo] > 1.0)]
        if not len(todo):
            break
        excess = found.violation(task)
        better = todo[excess[todo] < best[todo]]
        fruitless[todo] = np.where(excess[todo] < _GAIN * best[todo], 0, fruitless[todo] + 1)
        best[better], best_u[better] = excess[better], u[better]
        todo = todo[(fruitless[todo] < _STALL_LIMIT) & (solves[todo] < _MOST_SOLVES)]
        if not len(todo):
            break
        # contact gives way by a share of what it is pushed: extrapolate to where nothing is lacking
        gain = 1.0 / (1.0 - np.clip(lacks[todo] / lacked[todo], 0.0, _MOST_SHARE))
        lacked[todo] = np.maximum(lacks[todo], _AIM)
        low, up = _tighten_position_bounds(task, found, todo, passes_left, gain, u, lower, upper)
        fits = np.all(low <= up, axis=1)
        todo, low, up = todo[fits], low[fits], up[fits]
        if not len(todo):
            break
        lower[todo], upper[todo] = low, up
        held = None
        if bends is None and found.curvature_ratio[todo].max() > 1.0:
            bends = np.full(u.shape, -math.inf), np.full(u.shape, math.inf)
        if bends is not None:
            bends[0][todo], bends[1][todo] = _tighten_curvature_bounds(task, found, todo, u, *bends)
            bent = task.second_difference(free)[todo]
            held = CurvatureBounds(stiff[todo], bends[0][todo] - bent, bends[1][todo] - bent)
        from_there = free[todo]
        moved, count, settled[todo] = equilibrium(
            stencil[todo], contact[todo], low - from_there, up - from_there, held
        )
        u[todo] = from_there + moved
        solves[todo] += count
        found.update(todo, certify(task.select(todo), u[todo]))
        todo = todo[settled[todo]]
    worse = (found.violation(task) > best).nonzero()[0]  # pushing has led away from what was asked
    if len(worse):
        u[worse] = best_u[worse]
        found.update(worse, certify(task.select(worse), u[worse]))
    for i in np.flatnonzero(~settled):
        stuck[int(i)] = Status.NOT_CONVERGED, f"contact set did not settle in {solves[i]} solves", ""
    return assemble_band(
        task, leading, u, found, passes_left=passes_left, lower=lower, upper=upper, solves=solves, stuck=stuck
    )


def _tighten_position_bounds(
    task: BandProblem, found: Certificate, bands: Index, passes_left: Mask, gain: Array, u: Array, lower: Array,
    upper: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Bounds of some bands, pushed by what they lack."""
    lacks, left = task.clearance - found.gaps[:, bands], passes_left[:, bands, None]
    short_low = np.max(lacks, axis=0, where=left, initial=-math.inf)
    short_up = np.max(lacks, axis=0, where=~left, initial=-math.inf)
    short_low = np.maximum(short_low, -found.right_margin[bands])
    short_up = np.maximum(short_up, -found.left_margin[bands])
    low, up, at = lower[bands], upper[bands], u[bands]
    push_low, push_up = (gain[:, None] * short + _AIM for short in (short_low, short_up))
    low = np.where(short_low > 0.0, np.maximum(low, at) + push_low, low)
    up = np.where(short_up > 0.0, np.minimum(up, at) - push_up, up)
    return low, up


def _tighten_curvature_bounds(
    task: BandProblem, found: Certificate, bands: Index, u: Array, least: Array, most: Array
) -> tuple[Array, Array]:
    """Bounds of the bending of some bands, pushed by what their curvature is over its limit."""
    squared = task.h[bands, None] ** 2
    curvature, limit = found.curvature[bands] * squared, task.curvature_limit[bands] * squared
    bend = task.second_difference(u)[bands]
    before, now = curvature - bend, (1.0 - _SPARE) * limit
    over = np.maximum(np.abs(curvature) - now, 0.0)
    least, most = np.maximum(least[bands], -now - before), np.minimum(most[bands], now - before)
    least = np.where((curvature < 0.0) & (over > 0.0), np.maximum(least, bend) + over, least)
    most = np.where((curvature > 0.0) & (over > 0.0), np.minimum(most, bend) - over, most)
    return np.minimum(least, 0.5 * (least + most)), np.maximum(most, 0.5 * (least + most))


def _report_empty_interval(task: BandProblem, passes_left: Mask, band: int) -> tuple[Status, str, str]:
    """Between what there is no room."""
    c = task.corridor
    lower, upper = c.bounds(passes_left)
    node = int(np.argmax(lower[band] - upper[band]))
    beside = c.alongside[:, band, node]
    right, left = "the right edge", "the left edge"
    for o in np.flatnonzero(beside):
        if passes_left[o, band] and c.left[o, band, node] == lower[band, node]:
            right = f"obstacle {o}"
        if not passes_left[o, band] and c.right[o, band, node] == upper[band, node]:
            left = f"obstacle {o}"
    binding = right if right.startswith("obstacle") else left
    return Status.INFEASIBLE, f"no room between {right} and {left} at node {node}", binding


def _find_blocked_ends(task: BandProblem) -> dict[int, int]:
    """Find the bands that have an obstacle where they are pinned, and which."""
    gaps = end_gaps(task)
    blocked = np.logical_or.reduce(gaps < task.clearance - _END_SHORTFALL_LIMIT, axis=0)
    return {int(i): int(gaps[:, i].argmin()) for i in np.flatnonzero(blocked)}
