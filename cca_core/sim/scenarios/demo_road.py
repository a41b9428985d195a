"""A real road, and the longest part of a road without tight curves."""

import math

import numpy as np

from cca_core._checks import check_real
from cca_core.path import Path, Waypoints

# Centerline of Interstate 80 eastbound in Wyoming: latitude, longitude [deg]
# fmt: off
_INTERSTATE_80 = (
    (41.294724, -110.691588), (41.294696, -110.691309), (41.294675, -110.691016), (41.294663, -110.690728),
    (41.294658, -110.690445), (41.294661, -110.690122), (41.294671, -110.689834), (41.294692, -110.689514),
    (41.294717, -110.689232), (41.294750, -110.688941), (41.294796, -110.688625), (41.294843, -110.688347),
    (41.294905, -110.688035), (41.294971, -110.687753), (41.295051, -110.687448), (41.295129, -110.687180),
    (41.295171, -110.687048), (41.295216, -110.686907), (41.295305, -110.686655), (41.295415, -110.686366),
    (41.295534, -110.686082), (41.295646, -110.685836), (41.295769, -110.685586), (41.295907, -110.685320),
    (41.296049, -110.685054), (41.296193, -110.684791), (41.297001, -110.683333), (41.297419, -110.682571),
    (41.297675, -110.682101), (41.297811, -110.681838), (41.297858, -110.681744), (41.297947, -110.681562),
    (41.298046, -110.681348), (41.298182, -110.681038), (41.298286, -110.680781), (41.298398, -110.680487),
    (41.298488, -110.680231), (41.298583, -110.679937), (41.298666, -110.679656), (41.298756, -110.679317),
    (41.298823, -110.679038), (41.298890, -110.678729), (41.298943, -110.678452), (41.298997, -110.678138),
    (41.299042, -110.677820), (41.299077, -110.677528), (41.299109, -110.677207), (41.299133, -110.676883),
    (41.299150, -110.676559), (41.299159, -110.676272), (41.299163, -110.675956), (41.299162, -110.675610),
    (41.299158, -110.675296), (41.299148, -110.674686), (41.299134, -110.673773), (41.299110, -110.672435),
    (41.299106, -110.672186), (41.299076, -110.670070), (41.299062, -110.669093), (41.299036, -110.667688),
    (41.299022, -110.666890), (41.299017, -110.666569), (41.299009, -110.666040), (41.298979, -110.664070),
    (41.298963, -110.663136),
)
# fmt: on


def demo_route() -> Waypoints:
    """Centerline of 2.5 km of motorway with curves of 700 m and 850 m radius.

    Returns
    -------
    waypoints : Waypoints
        65 points of Interstate 80 eastbound in Wyoming [deg], 9 to 177 m apart.

    Notes
    -----
    Vertices 759 to 823 (without repeated ones) of ``data/I_80_Eastbound_Vertices.csv`` in the repository
    usdot-jpo-ode/jpo-cvdp at commit 077dad5, Apache-2.0.

    Examples
    --------
    >>> len(demo_route().lat)
    65
    """
    table = np.array(_INTERSTATE_80)
    table.setflags(write=False)
    return Waypoints(lat=table[:, 0], lon=table[:, 1], duplicates=0)


def longest_stretch(path: Path, *, radius: float = 200.0) -> tuple[float, float]:
    """Longest part of a path without a tight curve.

    Parameters
    ----------
    path : Path
        The road.
    radius : float
        Minimum radius of curvature [m], positive.

    Returns
    -------
    start, end : float
        Stations of both ends [m], to 1 m; equal if there is no such part.

    Raises
    ------
    InputError
        If `radius` is not positive.
    """
    radius = check_real("radius", radius, gt=0.0)
    s = np.linspace(path.start, path.end, math.ceil(path.length) + 1)
    gentle = np.abs(path.curvature(s)) <= 1.0 / radius
    turns = np.flatnonzero(np.diff(gentle, prepend=False, append=False))
    if not len(turns):
        return path.start, path.start
    first, last = turns[0::2], turns[1::2] - 1
    longest = int(np.argmax(last - first))
    return float(s[first[longest]]), float(s[last[longest]])
