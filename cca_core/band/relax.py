"""Equilibrium of a band between pins, obstacles and edges."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_points, check_real
from cca_core.band.corridor import Side, bounds_of_corridor, bounds_of_obstacle, leads, per_node
from cca_core.band.equilibrium import equilibrium
from cca_core.band.stiffness import BandStiffness
from cca_core.errors import InfeasibleError, InputError, Status
from cca_core.geometry import Boxes, box_gap
from cca_core.vehicle import VehicleParams

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
    edge_lower, edge_upper = bounds_of_corridor(corridor, n)
    boxes = per_node(obstacles, n)
    lower, upper = edge_lower.copy(), edge_upper.copy()
    for obstacle, run_up in zip(boxes, leads(lead, len(boxes)), strict=True):
        low, high = bounds_of_obstacle(base, tangents, obstacle, side, vehicle, clearance, run_up)
        lower, upper = np.maximum(lower, low), np.minimum(upper, high)
    stencil, contact = stiffness.stencil(h), stiffness.k_e * h
    room = bool((lower <= upper).all())
    u, solves, settled = np.zeros(n), 0, True
    gaps = over = np.full(n, math.inf)
    pushed_lower, pushed_upper = lower, upper
    for _ in range(_TIGHTENINGS if room else 1):
        if room:
            u, count, settled = equilibrium(stencil, contact, pushed_lower, pushed_upper)
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
        status, message = Status.NOT_CONVERGED, f"contact set did not settle in {solves} solves"
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
        # circles around the boxes bound their gap from below, circles inside them from above
        centres = np.hypot(o.x - x, o.y - y)
        apart = centres - 0.5 * (np.hypot(o.length, o.width) + math.hypot(vehicle.length, vehicle.width))
        inner = 0.5 * (np.minimum(o.length, o.width) + min(vehicle.length, vehicle.width))
        near = apart <= max(clearance, (centres - inner).min())
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
