"""Where another vehicle will be: boxes along the road, grown by what is not known."""

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array
from cca_core.geometry import Boxes
from cca_core.path.path import Path
from cca_core.vehicle import RemoteVehicle

__all__ = ["predict_along", "travel"]

_BOUND = 2.0  # standard deviations by which boxes grow on each side (95 %)
_BRAKING = -1.0  # a deceleration beyond this is taken to last until standstill [m/s^2]


def travel(v_x: float, a_x: float, t: ArrayLike) -> Array:
    """Distance driven after a time.

    Parameters
    ----------
    v_x : float
        Speed now [m/s].
    a_x : float
        Acceleration now [m/s^2]. Braking harder than 1 m/s^2 is taken to last until standstill, everything
        else to be over.
    t : array_like, shape (...)
        Time from now [s]; negative times look back at constant speed.

    Returns
    -------
    distance : ndarray, shape (...)
        Distance [m], in the direction of `v_x`.

    Examples
    --------
    >>> travel(20.0, -5.0, [1.0, 4.0, 9.0])
    array([17.5, 40. , 40. ])
    """
    t = np.asarray(t, dtype=np.float64)
    if a_x >= _BRAKING or v_x <= 0.0:
        return v_x * t
    braking = np.clip(t, 0.0, v_x / -a_x)
    distance: Array = v_x * (braking + np.minimum(t, 0.0)) + 0.5 * a_x * braking**2
    return distance


def predict_along(remote: RemoteVehicle, path: Path, s: float, d: float, t: ArrayLike) -> Boxes:
    """Boxes of a vehicle that keeps its lateral place on the road.

    Parameters
    ----------
    remote : RemoteVehicle
        The vehicle.
    path : Path
        The road that it follows.
    s, d : float
        Its place in path coordinates now [m], d left positive.
    t : array_like, shape (n,)
        Times from now [s].

    Returns
    -------
    boxes : Boxes
        One box for each time, longer and wider by two standard deviations on each side.

    Notes
    -----
    Its speed along the path is v cos(psi - psi_p) / (1 - d kappa), with the curvature where it is now; a
    vehicle heading against the path drives towards smaller s.
    """
    relative = remote.psi - float(path.heading(s))
    forward = np.cos(relative) / max(1.0 - d * path.curvature_at(s), 0.1)
    at = s + forward * travel(remote.v_x, remote.a_x, t)
    centre, tangent, _ = path.derivatives(at)
    norm = np.hypot(tangent[..., 0], tangent[..., 1])
    heading = np.arctan2(tangent[..., 1], tangent[..., 0]) + relative
    return Boxes(
        centre[..., 0] - d * tangent[..., 1] / norm,
        centre[..., 1] + d * tangent[..., 0] / norm,
        heading,
        np.array(remote.length + 2.0 * _BOUND * remote.sigma_along),
        np.array(remote.width + 2.0 * _BOUND * remote.sigma_across),
    )
