"""Equilibrium of a band between pins, obstacles and edges."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import lapack

from cca_core._checks import Array, check_any, check_points, check_real
from cca_core.band.forces import lateral_span
from cca_core.band.stiffness import BandStiffness
from cca_core.errors import InfeasibleError, InputError, Status
from cca_core.geometry import Boxes, box_gap
from cca_core.vehicle import VehicleParams

Side = Literal["left", "right"]
_SOLVES = 30  # a contact set settles in 3 to 8
_TIGHTENINGS = 6
_SLACK = 1e-3  # clearance may miss by this before the band is pushed farther [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Band:
    """A stretch of the route, bent around obstacles.

    Parameters
    ----------
    nodes : ndarray, shape (n, 2)
        Deformed nodes [m] (eq 10), first and last on the route.
    displacement : ndarray, shape (n,)
        Lateral displacement u of each node [m], left positive.
    clearance : float
        Least distance between the ego's box and any obstacle's box at the same time [m]; infinite without
        obstacles, negative where they overlap.
    curvature : float
        Largest curvature along the band [1/m], without sign.
    side : {"left", "right"}
        Side on which obstacles in the way are passed.
    status : Status
        `Status.OK` only if clearance and limits are as asked.
    message : str
        Why the status is what it is.
    solves : int
        Banded systems solved [-].
    """

    nodes: Array
    displacement: Array
    clearance: float
    curvature: float
    side: Side
    status: Status
    message: str
    solves: int = field(default=0)

    def require(self) -> Self:
        """Return this band if it is usable.

        Returns
        -------
        band : Band
            The band itself.

        Raises
        ------
        InfeasibleError
            If the status is not OK.
        """
        if self.status is not Status.OK:
            raise InfeasibleError(self.message, self)
        return self


def relax_band(
    nodes: ArrayLike,
    obstacles: Sequence[Boxes] = (),
    *,
    side: Side,
    vehicle: VehicleParams,
    clearance: float = 1.0,
    lead: ArrayLike = 0.0,
    corridor: tuple[ArrayLike, ArrayLike] | None = None,
    curvature_limit: float = math.inf,
    stiffness: BandStiffness | None = None,
) -> Band:
    """Bend a stretch of the route around obstacles.

    Parameters
    ----------
    nodes : array_like, shape (n, 2)
        Nodes of the undeformed route, equally spaced [m]; at least 5. Both ends are pinned: there
        displacement, heading change and curvature change are zero.
    obstacles : sequence of Boxes
        Each obstacle's box at the time the ego arrives at each node (fields of shape (n,)), or one box if it
        stands still (fields of shape ()). Sizes include whatever uncertainty is to be respected.
    side : {"left", "right"}
        Side on which to pass obstacles that leave less than `clearance` beside the route. Others stay
        on the side on which they are.
    vehicle : VehicleParams
        The ego; its box is swept along the band.
    clearance : float
        Distance to keep between the boxes [m].
    lead : array_like, shape (n_obstacles,) or ()
        Distance before each obstacle from which on the band is fully beside it [m], on top of `clearance`.
    corridor : pair of array_like, shape (n,) or (), optional
        Right and left bound of the displacement of the ego's reference point [m], left positive.
    curvature_limit : float
        Largest curvature allowed along the band [1/m].
    stiffness : BandStiffness, optional
        Elasticity; the default is smooth in curvature.

    Returns
    -------
    band : Band
        The equilibrium, with the clearance that it reached and a status.

    Raises
    ------
    InputError
        If an argument has a wrong shape, is not finite or is out of range.

    Notes
    -----
    Eqs (4)-(10) of the paper with three changes: forces act along the path normal, obstacles push one-sidedly
    until the clearance is reached (a semi-smooth Newton iteration on the contact set, one banded solve a
    step), and the band resists bending. Contact gives way a little; the bounds are pushed out by
    what the swept boxes lack, and the band is solved again.

    Examples
    --------
    >>> from cca_core.geometry import boxes
    >>> route = np.column_stack((np.arange(0.0, 101.0), np.zeros(101)))
    >>> car = boxes(50.0, 0.0, 0.0, 4.5, 1.8)
    >>> band = relax_band(route, [car], side="left", vehicle=VehicleParams.bmw_320i())
    >>> band.status.name, round(band.clearance, 1)
    ('OK', 1.0)
    """
    base = check_points("nodes", nodes, 5)
    clearance = check_real("clearance", clearance, least=0.0)
    curvature_limit = check_real("curvature_limit", curvature_limit, above=0.0, infinite=True)
    if side not in ("left", "right"):
        raise InputError(f"side must be 'left' or 'right', was {side!r}")
    if not isinstance(vehicle, VehicleParams):
        raise InputError(f"vehicle must be VehicleParams, was {type(vehicle).__name__}")
    stiffness = stiffness or BandStiffness()
    n = len(base)
    steps = np.hypot(*np.diff(base, axis=0).T)
    h = float(np.mean(steps))
    if not steps.min() > 0.8 * h > 0.64 * steps.max():
        raise InputError("nodes must be equally spaced along the route")
    tangents = _tangents(base)
    edge_lower, edge_upper = _bounds_of_corridor(corridor, n)
    boxes = _per_node(obstacles, n)
    lower, upper = edge_lower.copy(), edge_upper.copy()
    for obstacle, run_up in zip(boxes, _leads(lead, len(boxes)), strict=True):
        low, high = _bounds_of_obstacle(base, tangents, obstacle, side, vehicle, clearance, run_up)
        lower, upper = np.maximum(lower, low), np.minimum(upper, high)
    stencil, contact = stiffness.stencil(h), stiffness.k_e * h
    room = bool((lower <= upper).all())
    u, solves, settled = np.zeros(n), 0, True
    gaps = over = np.full(n, math.inf)
    pushed_lower, pushed_upper = lower, upper
    for _ in range(_TIGHTENINGS if room else 1):
        if room:
            u, count, settled = _equilibrium(stencil, contact, pushed_lower, pushed_upper)
            solves += count
        gaps = _swept_gaps(base, tangents, u, boxes, vehicle, clearance)
        over = np.maximum(edge_lower - u, u - edge_upper)
        short = np.maximum(clearance - gaps, over).clip(0.0)
        if not settled or short.max() <= _SLACK:
            break
        pushed_lower = pushed_lower + np.maximum(short, lower - u).clip(0.0)
        pushed_upper = pushed_upper - np.maximum(short, u - upper).clip(0.0)
    moved = base + u[:, None] * np.column_stack((-tangents[:, 1], tangents[:, 0]))
    peak = _peak_curvature(moved)
    reached = float(gaps.min()) if boxes else math.inf
    status, message = Status.INFEASIBLE, ""
    if not room:
        message = "obstacles or edges leave no room between them"
    elif not settled:
        status, message = Status.NOT_CONVERGED, f"contact set did not settle in {_SOLVES} solves"
    elif reached < clearance - 2.0 * _SLACK:
        message = f"clearance {reached:.2f} m is below the {clearance:.2f} m asked"
    elif over.max() > 2.0 * _SLACK:
        message = f"the band leaves the corridor by {over.max():.2f} m"
    elif peak > curvature_limit:
        message = f"curvature {peak:.4f} 1/m is over the limit {curvature_limit:.4f} 1/m"
    else:
        status, message = Status.OK, "clearance and limits kept"
    for array in (moved, u):
        array.setflags(write=False)
    return Band(
        nodes=moved, displacement=u, clearance=reached, curvature=peak, side=side, status=status,
        message=message, solves=solves,
    )  # fmt: skip


def _per_node(obstacles: Sequence[Boxes], n: int) -> list[Boxes]:
    """Obstacles with one box per node in every field."""
    given: object = obstacles
    if not isinstance(given, (list, tuple)) or not all(isinstance(o, Boxes) for o in given):
        raise InputError("obstacles must be a list of Boxes")
    full = []
    for o in obstacles:
        fields = [check_any("obstacles", value) for value in (o.x, o.y, o.psi, o.length, o.width)]
        if any(value.shape not in ((), (n,)) for value in fields):
            raise InputError(f"obstacles must have fields of shape () or ({n},), one box per node")
        if fields[3].min() < 0.0 or fields[4].min() < 0.0:
            raise InputError("obstacles must have lengths and widths that are not negative")
        full.append(Boxes(*(np.broadcast_to(value, (n,)) for value in fields)))
    return full


def _leads(lead: ArrayLike, count: int) -> list[float]:
    """One run-up per obstacle [m]."""
    array = check_any("lead", lead)
    if array.shape not in ((), (count,)) or (array < 0.0).any():
        raise InputError(f"lead must have shape () or ({count},) and not be negative, was {lead!r}")
    leads: list[float] = np.broadcast_to(array, (count,)).tolist()
    return leads


def _bounds_of_corridor(corridor: tuple[ArrayLike, ArrayLike] | None, n: int) -> tuple[Array, Array]:
    if corridor is None:
        return np.full(n, -math.inf), np.full(n, math.inf)
    pair: object = corridor
    if not isinstance(pair, (tuple, list)) or len(pair) != 2:
        raise InputError("corridor must be a pair of bounds, right and left")
    right, left = (np.asarray(bound, dtype=np.float64) for bound in pair)
    for bound in (right, left):
        if bound.shape not in ((), (n,)) or np.isnan(bound).any():
            raise InputError(
                f"corridor must have bounds of shape () or ({n},) without NaN, had {bound.shape}"
            )
    return np.broadcast_to(right, (n,)).copy(), np.broadcast_to(left, (n,)).copy()


def _bounds_of_obstacle(
    base: Array,
    tangents: Array,
    obstacle: Boxes,
    side: Side,
    vehicle: VehicleParams,
    clearance: float,
    lead: float,
) -> tuple[Array, Array]:
    """Bounds of the displacement that keep the ego's box beside the obstacle at clearance."""
    reach = 0.5 * vehicle.length + clearance
    abeam, right, left = lateral_span(base, tangents, obstacle, reach, lead, vehicle.box_offset)
    keep = 0.5 * vehicle.width + clearance
    none = np.full(len(base), math.inf)
    if not abeam.any():
        return -none, none
    if (right[abeam] < keep).any() and (left[abeam] > -keep).any():
        passes_left = side == "left"
    else:
        passes_left = bool((right[abeam] + left[abeam]).sum() < 0.0)
    if passes_left:
        return np.where(abeam, left + keep, -none), none
    return -none, np.where(abeam, right - keep, none)


def _equilibrium(stencil: Array, contact: float, lower: Array, upper: Array) -> tuple[Array, int, bool]:
    """Least energy with pinned ends by Newton on the contact set; returns u, solves, whether it settled.

    The energy is convex and piecewise quadratic, so a Newton step whose contact set is its own is the
    minimum; a step that overshoots is shortened to where the energy along it is least.
    """
    n = len(lower) - 2
    low, high = lower[1:-1], upper[1:-1]
    kernel = np.concatenate((stencil[:0:-1], stencil))
    matrix = np.repeat(stencil[::-1, None], n, axis=1)
    u = np.zeros(n)
    inside = np.zeros(n)  # the internal forces at u
    active = (u < low) | (u > high)
    for solve in range(_SOLVES):
        if not active.any():
            break
        bound = np.where(u < low, low, high)
        matrix[3] = stencil[0] + contact * active
        target = lapack.dpbsv(matrix, np.where(active, contact * bound, 0.0))[1]
        reached = (target < low) | (target > high)
        if (reached == active).all():
            full = np.zeros(n + 2)
            full[1:-1] = target
            return full, solve + 1, True
        step = target - u
        forces = np.convolve(target, kernel)[3:-3] - inside
        share = _least_along(u, step, inside, forces, contact, low, high)
        u = u + share * step
        inside = inside + share * forces
        active = (u < low) | (u > high)
    full = np.zeros(n + 2)
    full[1:-1] = u
    return full, _SOLVES if active.any() else 0, not active.any()


def _least_along(
    u: Array, step: Array, inside: Array, forces: Array, contact: float, low: Array, high: Array
) -> float:
    """Share of a Newton step at which the energy is least: the root of its slope, found by bisection."""

    def slope(share: float) -> float:
        at = u + share * step
        push = np.maximum(low - at, 0.0) - np.maximum(at - high, 0.0)
        return float(step @ (inside + share * forces - contact * push))

    if slope(1.0) <= 0.0:
        return 1.0
    a, b = 0.0, 1.0
    for _ in range(12):
        middle = 0.5 * (a + b)
        a, b = (middle, b) if slope(middle) <= 0.0 else (a, middle)
    return 0.5 * (a + b)


def _swept_gaps(
    base: Array,
    tangents: Array,
    u: Array,
    obstacles: list[Boxes],
    vehicle: VehicleParams,
    clearance: float,
) -> Array:
    """Signed distance [m] at each node from the ego's box along the band to the nearest obstacle.

    Exact where it is below `clearance` and at its least, elsewhere a lower bound.
    """
    n = len(base)
    if not obstacles:
        return np.full(n, math.inf)
    moved = base + u[:, None] * np.column_stack((-tangents[:, 1], tangents[:, 0]))
    along = _tangents(moved)
    x, y = (moved + vehicle.box_offset * along).T
    psi = np.arctan2(along[:, 1], along[:, 0])
    size = np.array(vehicle.length), np.array(vehicle.width)
    least = np.full(n, math.inf)
    for o in obstacles:
        # circles around the boxes bound their gap from below, the distance of the centres from above
        centres = np.hypot(o.x - x, o.y - y)
        apart = centres - 0.5 * (np.hypot(o.length, o.width) + math.hypot(vehicle.length, vehicle.width))
        near = apart <= max(clearance, centres.min())
        ego = Boxes(x[near], y[near], psi[near], *size)
        apart[near] = box_gap(ego, Boxes(o.x[near], o.y[near], o.psi[near], o.length[near], o.width[near]))
        least = np.minimum(least, apart)
    return least


def _tangents(nodes: Array) -> Array:
    """Return unit tangents at nodes: central differences, one-sided at the ends."""
    steps = nodes[1:] - nodes[:-1]
    along = np.empty_like(nodes)
    along[1:-1] = steps[1:] + steps[:-1]
    along[0], along[-1] = steps[0], steps[-1]
    along /= np.sqrt(along[:, 0] ** 2 + along[:, 1] ** 2)[:, None]
    return along


def _peak_curvature(nodes: Array) -> float:
    """Largest curvature of the circle through three neighbouring nodes."""
    a, b = nodes[1:-1] - nodes[:-2], nodes[2:] - nodes[1:-1]
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    c = a + b
    lengths = np.hypot(*a.T) * np.hypot(*b.T) * np.hypot(*c.T)
    return float(np.abs(2.0 * cross / lengths).max())
