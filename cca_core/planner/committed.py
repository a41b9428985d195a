"""What of a swerve can no longer change, and what is forgiven because of that."""

from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.geometry import Boxes, box_gap

__all__ = ["committed_nodes", "first_replannable_node", "relax_clearance", "resample_displacement"]

_LEAST_NODES = 6  # of a band
_COMMITTED_TIME = 0.5  # time in which what is steered along can hardly change [s]
_RECOVERY_TIME = 2.0  # and then the one in which a clearance that is lacking is gained [s]
_MIN_CLEARANCE = 0.3  # gap that must be left for a clearance to be regained in comfort [m]
_SPARE = 0.05  # forgiven on top of what is lacking: bounds between nodes are looser than at nodes [m]


def resample_displacement(s: Array, places: Array, displacement: Array) -> Array:
    """Tell a displacement at other places.

    Parameters
    ----------
    s : ndarray, shape (m,)
        Where [m].
    places, displacement : ndarray, shape (n,)
        Path coordinates, equally spaced and beginning as `s`, and the displacement there [m], 0 beyond.

    Returns
    -------
    displacement : ndarray, shape (m,)
        The same curve [m], continuous in curvature.
    """
    from scipy.interpolate import CubicSpline  # slow to import, and importing the library is to be quick

    if len(s) == len(places) and s[-1] == places[-1]:
        return displacement
    told: Array = np.where(s <= places[-1], CubicSpline(places, displacement)(s), 0.0)
    return told


def first_replannable_node(s: Array, here: float) -> int:
    """Find the node from which on a band is bent anew: the first in front of the ego.

    Parameters
    ----------
    s : ndarray, shape (n,)
        Path coordinates of the nodes of the whole swerve [m].
    here : float
        That of the ego [m].

    Returns
    -------
    k : int
        Its index, at least 1, with at least 6 nodes from there on.
    """
    return min(max(int(np.searchsorted(s, here)), 1), len(s) - _LEAST_NODES)


def committed_nodes(t: Array) -> int:
    """Count the nodes that the ego reaches so soon that what it steers along there can hardly change.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Times from now at which it is there [s], increasing.

    Returns
    -------
    count : int
        At least 3.
    """
    return max(int(np.searchsorted(t, _COMMITTED_TIME)), 3)


def relax_clearance(boxes: Boxes, body: Boxes, t: Array, clearance: float) -> Boxes:
    """Shrink bounds by the clearance that is lacking already, less and less as there is time to gain it.

    Parameters
    ----------
    boxes : Boxes
        Bounds of other vehicles when the ego is at each of its n nodes, shape (..., n).
    body : Boxes
        The ego at the first of these nodes, where nothing can be changed.
    t : ndarray, shape (n,)
        Times from now at which it is at the nodes [s].
    clearance : float
        Distance asked [m].

    Returns
    -------
    boxes : Boxes
        The same where nothing is lacking. Of a clearance above 0.3 m no more is forgiven than leaves that:
        whoever is nearer is not passed as if nothing were.
    """
    m = len(body.x)
    first = Boxes(*(f[..., :m] for f in (boxes.x, boxes.y, boxes.psi, boxes.length, boxes.width)))
    lacks = np.maximum(clearance + _SPARE - box_gap(body, first).min(axis=-1), 0.0)
    if clearance > _MIN_CLEARANCE:
        lacks = np.minimum(lacks, clearance - _MIN_CLEARANCE + _SPARE)
    share = np.clip((t - max(_COMMITTED_TIME, t[m - 1])) / _RECOVERY_TIME, 0.0, 1.0)
    less = 2.0 * lacks[..., None] * (1.0 - share * share * (3.0 - 2.0 * share))
    length, width = np.maximum(boxes.length - less, 0.0), np.maximum(boxes.width - less, 0.0)
    return replace(boxes, length=length, width=width)
