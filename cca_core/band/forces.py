"""External force of a point obstacle on the nodes of a band: eq 8 as printed."""

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_array, check_points, check_real


def external_force(nodes: ArrayLike, obstacle: ArrayLike, *, k_e: float, r_0: float) -> Array:
    """Repulsion of nodes by a point obstacle, eq 8 of the paper.

    Parameters
    ----------
    nodes : array_like, shape (n, 2)
        Nodes of the undeformed band [m].
    obstacle : array_like, shape (2,)
        Position of the obstacle [m].
    k_e : float
        Stiffness of the external force [N/m].
    r_0 : float
        Threshold distance [m]; no force beyond it.

    Returns
    -------
    F_e : ndarray, shape (n, 2)
        Force on each node [N].

    Raises
    ------
    InputError
        If a value is not finite, a shape is wrong, or `k_e` or `r_0` is negative.

    Notes
    -----
    ``-k_e (|r| - r_0) r / |r|`` with r from the obstacle to the node (the other reading of the paper's
    "position vector between each node and the obstacle" would attract). A node exactly on the
    obstacle has no direction and gets no force.

    Examples
    --------
    >>> external_force([[0.0, 1.0]], [0.0, 0.0], k_e=2.0, r_0=4.0)
    array([[0., 6.]])
    """
    points = check_points("nodes", nodes, 1)
    r = points - check_array("obstacle", obstacle, (2,))
    k_e, r_0 = check_real("k_e", k_e, ge=0.0), check_real("r_0", r_0, ge=0.0)
    distance = np.hypot(r[:, 0], r[:, 1])
    near = (distance <= r_0) & (distance > 0.0)
    magnitude = np.where(near, k_e * (r_0 - distance), 0.0)
    return magnitude[:, None] * r / np.where(distance > 0.0, distance, 1.0)[:, None]
