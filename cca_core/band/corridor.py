"""Bounds of a band's displacement: edges of the corridor, and obstacles on the side where they are passed."""

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, Mask, check_any
from cca_core.errors import InputError
from cca_core.geometry import Boxes
from cca_core.vehicle import VehicleParams

Side = Literal["left", "right"]


def per_node(obstacles: Sequence[Boxes], n: int) -> list[Boxes]:
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
        full.append(Boxes(*(value if value.ndim else np.full(n, value) for value in fields)))
    return full


def leads(lead: ArrayLike, count: int) -> list[float]:
    """One run-up per obstacle [m]."""
    array = check_any("lead", lead)
    if array.shape not in ((), (count,)) or (array < 0.0).any():
        raise InputError(f"lead must have shape () or ({count},) and not be negative, was {lead!r}")
    leads: list[float] = np.broadcast_to(array, (count,)).tolist()
    return leads


def bounds_of_corridor(corridor: tuple[ArrayLike, ArrayLike] | None, n: int) -> tuple[Array, Array]:
    """Right and left bound at each node [m], infinite without a corridor."""
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


def bounds_of_obstacle(
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


def lateral_span(
    nodes: Array, tangents: Array, obstacle: Boxes, reach: float, lead: float, offset: float
) -> tuple[Mask, Array, Array]:
    """Where an obstacle stands in the frame of each node.

    Parameters
    ----------
    nodes, tangents : ndarray, shape (n, 2)
        Positions [m] and unit tangents [-] of the undeformed band.
    obstacle : Boxes
        The obstacle's box when the ego arrives at each node, fields of shape (n,) or ().
    reach : float
        Half the ego's length plus the distance to keep along the band [m].
    lead : float
        Further distance to keep while the obstacle is in front [m].
    offset : float
        From the node to the centre of the ego's box, forward positive [m].

    Returns
    -------
    abeam : ndarray of bool, shape (n,)
        Whether the obstacle is beside the ego there.
    right, left : ndarray, shape (n,)
        Lateral coordinates of the obstacle's sides [m], left of the node positive.
    """
    dx, dy = obstacle.x - nodes[:, 0], obstacle.y - nodes[:, 1]
    along = dx * tangents[:, 0] + dy * tangents[:, 1] - offset
    across = dy * tangents[:, 0] - dx * tangents[:, 1]
    cos, sin = np.cos(obstacle.psi), np.sin(obstacle.psi)
    c = np.abs(cos * tangents[:, 0] + sin * tangents[:, 1])
    s = np.abs(sin * tangents[:, 0] - cos * tangents[:, 1])
    half_along = 0.5 * (obstacle.length * c + obstacle.width * s)
    half_across = 0.5 * (obstacle.length * s + obstacle.width * c)
    abeam: Mask = (along >= -half_along - reach) & (along <= half_along + reach + lead)
    return abeam, across - half_across, across + half_across
