"""Deformation of a band around obstacles, to an equilibrium whose clearance is certified."""

import math
from collections.abc import Sequence

from numpy.typing import ArrayLike

from cca_core.band.band import Band, assemble_band
from cca_core.band.corridor import Side
from cca_core.band.problem import make_problem
from cca_core.band.settings import BandSettings
from cca_core.band.sides import former_sides, parse_sides
from cca_core.band.solver import relax
from cca_core.band.stiffness import BandStiffness
from cca_core.errors import InputError
from cca_core.geometry import Boxes
from cca_core.vehicle import VehicleParams

_STIFFNESS, _SETTINGS = BandStiffness(), BandSettings()


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
    settings: BandSettings | None = None,
    threads: int = 1,
) -> Band:
    """Deform a stretch of the route around obstacles.

    Parameters
    ----------
    nodes : array_like, shape (..., n, 2)
        Nodes of the undeformed route, equally spaced [m]; at least 5. Two nodes at each end are pinned: there
        displacement, heading change and curvature change are zero, at the first end unless `start` is given.
        Leading axes are a batch of bands.
    obstacles : sequence of Boxes
        Each obstacle's box at the time the ego arrives at each node (fields of shape (..., n)). One box
        (fields of shape ()) is a stationary obstacle. Sizes include the uncertainty that is to be respected.
    side : {"left", "right"} or sequence of them, optional
        Side on which the ego passes the obstacles that leave less than `clearance` next to the route; the
        other obstacles keep their side. A sequence gives the side of every obstacle. By default, the
        assignment with the least energy among those that satisfy clearance and limits; left of two equals.
    vehicle : VehicleParams
        The ego; its box is swept along the band.
    clearance : float
        Least distance between the boxes [m].
    lead_distance : array_like, shape (n_obstacles,) or ()
        Distance before each obstacle from which on the band is fully displaced [m], on top of `clearance`.
    corridor : pair of array_like, shape (..., n) or (), optional
        Right and left edge that the ego's body does not cross [m], in the route's lateral coordinate, left
        positive.
    curvature_limit : array_like, shape (..., n) or ()
        Largest curvature allowed along the band [1/m].
    stiffness : BandStiffness, optional
        Elasticity; the default is smooth in curvature.
    start : array_like, shape (..., 3) or ()
        Displacement [m] at which the band begins: a node before the first, at the first and at the second
        node. They fix position, heading and curvature there. By default the band begins on the route.
    previous : Band, optional
        Band of the previous cycle. If sides are chosen, its sides stay unless others cost much less.
    settings : BandSettings, optional
        Effort and tolerances of the search.
    threads : int
        Threads that share a batch [-]. The result does not depend on it.

    Returns
    -------
    band : Band
        The equilibrium, with its clearance and a status. A batch of nodes gives a batch in every field; each
        band equals the one relaxed alone.

    Raises
    ------
    InputError
        If an argument has a wrong shape, is not finite or is out of range.

    Notes
    -----
    Eqs (4)-(10) of the paper with three changes. Forces act along the path normal. Obstacles push one-sidedly
    until the clearance is reached, by a semi-smooth Newton iteration on the active set with one banded solve
    per step. The band resists bending. Contacts yield a little and rotated boxes protrude: the bounds are
    moved by the shortfall of the swept boxes, and the band is solved again, from where it is.

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
    problem, batch_shape = make_problem(
        nodes,
        obstacles,
        vehicle=vehicle,
        clearance=clearance,
        lead_distance=lead_distance,
        edges=corridor,
        curvature_limit=curvature_limit,
        stiffness=_STIFFNESS if stiffness is None else stiffness,
        start=start,
        settings=_SETTINGS if settings is None else settings,
    )
    count: object = threads  # may be anything
    if not isinstance(count, int) or count < 1:
        raise InputError(f"threads must be an integer of at least 1, was {threads!r}")
    bands, m = len(problem.nodes), problem.boxes.shape[1]
    rule, sides = parse_sides(side, m, bands)
    former = former_sides(previous, m, bands) if side is None else None
    return assemble_band(problem, batch_shape, relax(problem, rule, sides, former, threads))
