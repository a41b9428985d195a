"""Bend a band around obstacles, to an equilibrium whose clearance is certified."""

import math
from collections.abc import Sequence

from numpy.typing import ArrayLike

from cca_core.band.band import Band
from cca_core.band.corridor import Side
from cca_core.band.problem import make_problem
from cca_core.band.sides import choose_sides, parse_sides
from cca_core.band.stiffness import BandStiffness
from cca_core.band.tightening import relax_with_sides
from cca_core.geometry import Boxes
from cca_core.vehicle import VehicleParams


def relax_band(
    nodes: ArrayLike,
    obstacles: Sequence[Boxes] = (),
    *,
    side: Side | Sequence[Side] | None = None,
    vehicle: VehicleParams,
    clearance: float = 1.0,
    lead_distance: ArrayLike = 0.0,
    corridor: tuple[ArrayLike, ArrayLike] | None = None,
    curvature_limit: ArrayLike = math.inf,
    stiffness: BandStiffness | None = None,
    start: ArrayLike = 0.0,
    previous: Band | None = None,
) -> Band:
    """Bend a stretch of the route around obstacles.

    Parameters
    ----------
    nodes : array_like, shape (..., n, 2)
        Nodes of the undeformed route, equally spaced [m]; at least 5. Both ends are pinned, two nodes each:
        there displacement, heading change and curvature change are zero, at the first end unless `start` says
        otherwise. Leading axes are bands of their own.
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
    lead_distance : array_like, shape (n_obstacles,) or ()
        Distance before each obstacle from which on the band is fully beside it [m], on top of `clearance`.
    corridor : pair of array_like, shape (..., n) or (), optional
        Right and left edge that the ego's body does not cross [m], in the route's lateral coordinate, left
        positive.
    curvature_limit : array_like, shape (..., n) or ()
        Largest curvature allowed along the band [1/m].
    stiffness : BandStiffness, optional
        Elasticity; the default is smooth in curvature.
    start : array_like, shape (..., 3) or ()
        Displacement [m] at which the band begins: a node before the first, at the first and at the second
        node, which hold place, heading and curvature of what has been driven. By default it begins on the
        route.
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
    >>> import numpy as np
    >>> from cca_core.geometry import boxes
    >>> route = np.column_stack((np.arange(0.0, 101.0), np.zeros(101)))
    >>> car = boxes(50.0, 0.0, 0.0, 4.5, 1.8)
    >>> band = relax_band(route, [car], side="left", vehicle=VehicleParams.bmw_320i())
    >>> band.status.name, round(band.clearance, 1)
    ('OK', 1.0)
    """
    task, leading = make_problem(
        nodes,
        obstacles,
        vehicle,
        clearance,
        lead_distance,
        corridor,
        curvature_limit,
        stiffness or BandStiffness(),
        start,
    )
    sides = choose_sides(task, previous) if side is None else parse_sides(side, task)
    return relax_with_sides(task, leading, sides)
