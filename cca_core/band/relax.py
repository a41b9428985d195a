"""Equilibrium of a band between pins, obstacles and edges, with its clearance certified."""

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, Index, Mask, check_real
from cca_core.band.band import Band, judged
from cca_core.band.certificate import Certificate, certify
from cca_core.band.corridor import Side, corridor_around
from cca_core.band.energy import band_energy
from cca_core.band.equilibrium import Bends, equilibrium
from cca_core.band.stiffness import BandStiffness
from cca_core.band.task import Task, frames
from cca_core.errors import InputError, Status
from cca_core.geometry import Boxes
from cca_core.vehicle import VehicleParams

_TIGHTENINGS = 16
_MOST_SHARE = 0.8  # by which contact may be taken to give way
_BEND = 0.25, 10.0  # stiffness of the curvature limit, per k_c [1/m^2] and per k_b [-]
_SPARE = 2e-3  # share of the curvature limit that is aimed below it
_AIM = 2e-3  # what is lacking is pushed for with this much more [m]
_CHOICES = 6  # obstacles of which every assignment of sides is tried
_TRIED = 8  # assignments whose clearance is certified, cheapest first
_TIE = 1e-6
_HELD = 0.7  # a change of sides must lower the energy to this share


def relax_band(
    nodes: ArrayLike,
    obstacles: Sequence[Boxes] = (),
    *,
    side: Side | Sequence[Side] | None = None,
    vehicle: VehicleParams,
    clearance: float = 1.0,
    lead: ArrayLike = 0.0,
    corridor: tuple[ArrayLike, ArrayLike] | None = None,
    curvature_limit: ArrayLike = math.inf,
    stiffness: BandStiffness | None = None,
    previous: Band | None = None,
) -> Band:
    """Bend a stretch of the route around obstacles.

    Parameters
    ----------
    nodes : array_like, shape (..., n, 2)
        Nodes of the undeformed route, equally spaced [m]; at least 5. Both ends are pinned: there
        displacement, heading change and curvature change are zero. Leading axes are bands of their own.
    obstacles : sequence of Boxes
        Each obstacle's box at the time the ego arrives at each node (fields of shape (..., n)), or one box if
        it stands still (fields of shape ()). Sizes include whatever uncertainty is to be respected.
    side : {"left", "right"} or sequence of them, optional
        Side on which the ego passes those obstacles that leave less than `clearance` beside the route (others
        stay on the side on which they are), or the side for every obstacle. By default the assignment of
        sides whose band has the least energy among those that keep clearance and limits; left of two equals.
    vehicle : VehicleParams
        The ego; its box is swept along the band.
    clearance : float
        Distance to keep between the boxes [m].
    lead : array_like, shape (n_obstacles,) or ()
        Distance before each obstacle from which on the band is fully beside it [m], on top of `clearance`.
    corridor : pair of array_like, shape (..., n) or (), optional
        Right and left edge that the ego's body does not cross [m], in the route's lateral coordinate, left
        positive.
    curvature_limit : array_like, shape (..., n) or ()
        Largest curvature allowed along the band [1/m].
    stiffness : BandStiffness, optional
        Elasticity; the default is smooth in curvature.
    previous : Band, optional
        Band of the cycle before. Where sides are chosen, its sides are kept unless others are much cheaper.

    Returns
    -------
    band : Band
        The equilibrium, with the clearance that it reached and a status. For nodes with leading axes each
        field has them too; each band is the same as if it had been relaxed alone.

    Raises
    ------
    InputError
        If an argument has a wrong shape, is not finite or is out of range.

    Notes
    -----
    Eqs (4)-(10) of the paper with three changes: forces act along the path normal, obstacles push one-sidedly
    until the clearance is reached (a semi-smooth Newton iteration on the contact set, one banded solve a
    step), and the band resists bending. Contact gives way a little and turned boxes stick out; the bounds are
    pushed by what the swept boxes lack, and the band is solved again.

    Examples
    --------
    >>> from cca_core.geometry import boxes
    >>> route = np.column_stack((np.arange(0.0, 101.0), np.zeros(101)))
    >>> car = boxes(50.0, 0.0, 0.0, 4.5, 1.8)
    >>> band = relax_band(route, [car], side="left", vehicle=VehicleParams.bmw_320i())
    >>> band.status.name, round(band.clearance, 1)
    ('OK', 1.0)
    """
    task, leading = _task(nodes, obstacles, vehicle, clearance, lead, corridor, curvature_limit, stiffness)
    if side is None:
        return _cheapest(task, leading, previous)
    if side in ("left", "right"):
        in_the_way, natural = task.corridor.natural_sides()
        passes_left = np.where(in_the_way, side == "left", natural)
    else:
        passes_left = _each_side(side, task)
    return _relaxed(task, leading, passes_left)


def _task(
    nodes: ArrayLike,
    obstacles: Sequence[Boxes],
    vehicle: VehicleParams,
    clearance: float,
    lead: ArrayLike,
    corridor: tuple[ArrayLike, ArrayLike] | None,
    curvature_limit: ArrayLike,
    stiffness: BandStiffness | None,
) -> tuple[Task, tuple[int, ...]]:
    """Check the arguments and put every obstacle and edge into the frame of the nodes."""
    try:
        given = np.array(nodes, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("nodes must be an array of real numbers") from None
    if given.ndim < 2 or given.shape[-1] != 2 or given.shape[-2] < 5 or not given.size:
        raise InputError(f"nodes must have shape (..., n, 2) with at least 5 nodes, had {given.shape}")
    if not np.isfinite(given).all():
        raise InputError("nodes must be finite")
    if not isinstance(vehicle, VehicleParams):
        raise InputError(f"vehicle must be VehicleParams, was {type(vehicle).__name__}")
    clearance = check_real("clearance", clearance, least=0.0)
    shape, n = given.shape[:-1], given.shape[-2]
    try:
        limit = np.empty(shape)
        limit[...] = curvature_limit
    except (TypeError, ValueError):
        raise InputError(f"curvature_limit must have shape () or {shape}") from None
    if not limit.min() > 0.0:
        raise InputError("curvature_limit must be greater than 0")
    base = given.view(np.complex128).reshape(-1, n)
    steps = np.abs(base[:, 1:] - base[:, :-1])
    h = steps.mean(axis=1)
    if not (steps.min(axis=1) > 0.8 * h).all() or not (h > 0.8 * steps.max(axis=1)).all():
        raise InputError("nodes must be equally spaced along the route")
    tangents, curvature = frames(base)
    return Task(
        base=base, tangents=tangents, curvature=curvature, h=h, vehicle=vehicle, clearance=clearance,
        corridor=corridor_around(
            base, tangents, obstacles, corridor, vehicle, clearance, lead, given.shape[:-2]
        ),
        curvature_limit=limit.reshape(-1, n), stiffness=stiffness or BandStiffness(),
    ), given.shape[:-2]  # fmt: skip


def _each_side(sides: object, task: Task) -> Mask:
    """Whether each obstacle is passed on its left, shape (m, bands)."""
    m, bands = task.corridor.abeam.shape[:2]
    if not isinstance(sides, (list, tuple)) or len(sides) != m or not set(sides) <= {"left", "right"}:
        raise InputError(f"side must be 'left', 'right' or {m} of them, one an obstacle, was {sides!r}")
    return np.repeat(np.array([side == "left" for side in sides], dtype=np.bool_)[:, None], bands, axis=1)


def _relaxed(task: Task, leading: tuple[int, ...], passes_left: Mask) -> Band:
    """Bands with the sides given."""
    lower, upper = task.corridor.bounds(passes_left)
    room = np.all(lower <= upper, axis=1)
    stuck = {}
    if not room.all():
        stuck = {int(i): _no_room(task, passes_left, int(i)) for i in np.flatnonzero(~room)}
        lower[~room], upper[~room] = -math.inf, math.inf
    contact = task.stiffness.k_e * task.h
    stencil = task.stiffness.stencil(task.h)
    stiff = (_BEND[0] * task.stiffness.k_c + _BEND[1] * task.stiffness.k_b) / task.h**3
    u, solves, settled = equilibrium(stencil, contact, lower, upper)
    found = certify(task, u)
    todo, lacked = np.flatnonzero(room), np.full(len(room), math.inf)
    bent = np.full((2, *u.shape), math.inf) * np.array([[[-1.0]], [[1.0]]])
    for _ in range(_TIGHTENINGS):
        lacks = np.maximum(task.clearance - found.least_gap, -found.least_edge)
        over = np.abs(found.curvature) / task.curvature_limit
        todo = todo[(lacks[todo] > 0.0) | (over[todo].max(axis=1) > 1.0)]
        if not len(todo):
            break
        # contact gives way by a share of what it is pushed: extrapolate to where nothing is lacking
        gain = 1.0 / (1.0 - np.clip(lacks[todo] / lacked[todo], 0.0, _MOST_SHARE))
        lacked[todo] = np.maximum(lacks[todo], _AIM)
        low, up = _tightened(task, found, todo, passes_left, gain, u, lower, upper)
        fits = np.all(low <= up, axis=1)
        todo, low, up = todo[fits], low[fits], up[fits]
        if not len(todo):
            break
        lower[todo], upper[todo] = low, up
        bends = None
        if (over[todo] > 1.0).any() or np.isfinite(bent[1, todo]).any():
            bent[:, todo] = _unbent(task, found, todo, u, bent)
            bends = Bends(stiff[todo], *bent[:, todo])
        u[todo], count, settled[todo] = equilibrium(stencil[todo], contact[todo], low, up, bends)
        solves[todo] += count
        found.update(todo, certify(task.select(todo), u[todo]))
        todo = todo[settled[todo]]
    for i in () if settled.all() else np.flatnonzero(~settled):
        stuck[int(i)] = (
            Status.NOT_CONVERGED, f"contact set did not settle in {solves[i]} solves", "",
        )  # fmt: skip
    return judged(
        task, leading, u, found, passes_left=passes_left, lower=lower, upper=upper, solves=solves, stuck=stuck
    )


def _tightened(
    task: Task, found: Certificate, bands: Index, passes_left: Mask, gain: Array, u: Array, lower: Array,
    upper: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Bounds of some bands, pushed by what they lack."""
    lacks, left = task.clearance - found.gaps[:, bands], passes_left[:, bands, None]
    short_low = np.max(lacks, axis=0, where=left, initial=-math.inf)
    short_up = np.max(lacks, axis=0, where=~left, initial=-math.inf)
    short_low = np.maximum(short_low, -found.right[bands])
    short_up = np.maximum(short_up, -found.left[bands])
    low, up, at = lower[bands], upper[bands], u[bands]
    push_low, push_up = (gain[:, None] * short + _AIM for short in (short_low, short_up))
    low = np.where(short_low > 0.0, np.maximum(low, at) + push_low, low)
    up = np.where(short_up > 0.0, np.minimum(up, at) - push_up, up)
    return low, up


def _unbent(task: Task, found: Certificate, bands: Index, u: Array, bent: Array) -> Array:
    """Bounds of the bending of some bands, shape (2, bands, n), that take back what curvature is too much."""
    squared = task.h[bands, None] ** 2
    wide = np.pad(u[bands], ((0, 0), (1, 1)))
    now = np.diff(wide, n=2)
    curvature, limit = found.curvature[bands], (1.0 - _SPARE) * task.curvature_limit[bands]
    rest = curvature * squared - now
    least, most = -limit * squared - rest, limit * squared - rest
    held = np.isfinite(bent[1, bands]).any(axis=1)[:, None]
    over = (np.abs(curvature) - limit).clip(0.0) * squared
    pushed_least = np.maximum(bent[0, bands], now) + np.where(curvature < 0.0, over, 0.0)
    pushed_most = np.minimum(bent[1, bands], now) - np.where(curvature > 0.0, over, 0.0)
    return np.stack(
        (
            np.where(
                held & (curvature < 0.0) & (over > 0.0), pushed_least, np.maximum(least, bent[0, bands])
            ),
            np.where(held & (curvature > 0.0) & (over > 0.0), pushed_most, np.minimum(most, bent[1, bands])),
        )
    )


def _no_room(task: Task, passes_left: Mask, band: int) -> tuple[Status, str, str]:
    """Between what there is no room."""
    c = task.corridor
    lower, upper = c.bounds(passes_left)
    node = int(np.argmax(lower[band] - upper[band]))
    beside = c.abeam[:, band, node]
    right, left = "the right edge", "the left edge"
    for o in np.flatnonzero(beside):
        if passes_left[o, band] and c.left[o, band, node] == lower[band, node]:
            right = f"obstacle {o}"
        if not passes_left[o, band] and c.right[o, band, node] == upper[band, node]:
            left = f"obstacle {o}"
    binding = right if right.startswith("obstacle") else left
    return Status.INFEASIBLE, f"no room between {right} and {left} at node {node}", binding


def _cheapest(task: Task, leading: tuple[int, ...], previous: Band | None) -> Band:
    """Bands with the sides of least energy among those that keep clearance and limits."""
    m, bands = task.corridor.abeam.shape[:2]
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
            u, _, _ = equilibrium(task.stiffness.stencil(h), task.stiffness.k_e * h, lower, upper)
            cost = band_energy(u, lower=lower, upper=upper, spacing=h, stiffness=task.stiffness)
            cost = cost * (1.0 + _TIE * (~choices).sum(axis=0))
            if previous is not None and previous.passes_left.shape == (m, *leading):
                cost[(choices == previous.passes_left.reshape(m, bands)[:, [i]]).all(axis=0)] *= _HELD
            order = np.argsort(cost)[:_TRIED]
            first = _relaxed(alone.select(order[:1]), (1,), choices[:, order[:1]])
            if not first.ok[0] and len(order) > 1:
                tried = _relaxed(alone.select(order), (len(order),), choices[:, order])
                order = order[[np.argmin(np.where(tried.ok, 0.0, _excess(tried)))]]
            choices = choices[:, order[:1]]
        chosen[:, i] = choices[:, 0] if choices.shape[1] else task.corridor.natural_sides()[1][:, i]
    return _relaxed(task, leading, chosen)


def _excess(bands: Band) -> Array:
    """Return how far bands are from what was asked, a metre that is lacking as much as 5 times the limit."""
    short = np.maximum(bands.task.clearance - bands.clearance, -bands.edge_clearance).clip(0.0)
    bent = bands.curvature / bands.task.curvature_limit.min(axis=1)
    excess: Array = 5.0 * short + (bent - 1.0).clip(0.0) + 1e-9
    return excess


def _assignments(task: Task, band: int) -> Mask:
    """Return the assignments of sides that are worth a look, shape (m, assignments)."""
    c = task.corridor
    in_the_way, natural = (sides[:, band] for sides in c.natural_sides())
    if not in_the_way.any():
        return natural[:, None]
    abeam = c.abeam[:, band]
    left, right = c.left[:, band], c.right[:, band]
    no_left = (abeam & (left > c.upper[band])).any(axis=1)
    no_right = (abeam & (right < c.lower[band])).any(axis=1)
    distance = np.where(abeam, np.maximum(right, -left), math.inf).min(axis=1)
    free = ~no_left & ~no_right
    free[np.argsort(np.where(free, distance, math.inf))[_CHOICES:]] = False
    fixed = np.where(no_left != no_right, no_right, natural)
    options = [(True, False) if f else (bool(side),) for f, side in zip(free, fixed, strict=True)]
    return np.array(list(itertools.product(*options)), dtype=np.bool_).reshape(-1, len(free)).T
