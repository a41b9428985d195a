"""Where another vehicle will be: boxes along the road, grown by what is not known."""

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array
from cca_core.geometry import Boxes
from cca_core.path.path import Path
from cca_core.vehicle import STANDSTILL_SPEED, RemoteVehicle

__all__ = ["occupancy_boxes", "predict_along", "predict_ctra", "predict_distance", "reachable_interval"]

_OCCUPANCY_WINDOW = 15.0  # around the ego in which another body matters, with both half lengths [m]
_BOUND = 2.0  # standard deviations by which boxes grow on each side (95 %)
_TINY = 1e-300  # a braking by which speeds can be divided [m/s^2]
_BRAKING = -1.0  # a deceleration beyond this is taken to last until standstill [m/s^2]


def predict_distance(v_x: float, a_x: float, t: ArrayLike) -> Array:
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


def reachable_interval(
    v: ArrayLike, t: ArrayLike, *, braking: float, acceleration: float, age: ArrayLike = 0.0
) -> tuple[Array, Array]:
    """Where along a road a vehicle may be after a time, whatever it does within bounds.

    Parameters
    ----------
    v : array_like, shape (...)
        Speed along the road as reported [m/s], negative against it.
    t : array_like, shape (...)
        Times from now [s]; in the past the vehicle has driven at constant speed.
    braking, acceleration : float
        Largest deceleration and acceleration [m/s^2], not negative. Braking ends at standstill.
    age : array_like, shape (...)
        Time since the speed was measured [s]; since then the vehicle may have changed it already, while its
        place now is taken at constant speed.

    Returns
    -------
    low, high : ndarray, shape (...)
        Least and largest displacement along the road from its place now [m].

    Notes
    -----
    Slower than 0.5 m/s it may start either way, since the sign of so small a speed is noise.

    Examples
    --------
    >>> low, high = reach(20.0, [1.0, 4.0], braking=8.0, acceleration=3.0)
    >>> low, high
    (array([16., 25.]), array([ 21.5, 104. ]))
    """
    v, t, age = (np.asarray(a, dtype=np.float64) for a in (v, t, age))
    speed = np.abs(v)
    since = np.maximum(t, 0.0) + age * (t >= 0.0)
    slows = np.minimum(since, speed / max(braking, _TINY)) if braking > 0.0 else since
    known = speed * np.minimum(t, 0.0) - speed * age * (t >= 0.0)
    least = speed * slows - 0.5 * braking * slows * slows + known
    most = speed * since + 0.5 * acceleration * since * since + known
    creeping = STANDSTILL_SPEED if acceleration > 0.0 else 0.0
    forwards, backwards = v > -creeping, v < creeping
    low = np.where(backwards, -most, least)
    high = np.where(forwards, most, -least)
    return low, high


def occupancy_boxes(
    path: Path, s: ArrayLike, rear: ArrayLike, front: ArrayLike, d: ArrayLike, half_width: ArrayLike
) -> Boxes:
    """Boxes that cover a stretch of the road beside places on it.

    Parameters
    ----------
    path : Path
        The road.
    s : array_like, shape (..., n)
        Places [m], one box for each.
    rear, front : array_like, shape (..., n)
        Ends of the stretch that is covered when the ego is at each place [m].
    d : array_like, shape (..., n) or (..., 1)
        Its lateral coordinate [m], left positive.
    half_width : array_like, shape (..., n) or (..., 1)
        Half its width [m].

    Returns
    -------
    boxes : Boxes
        What of the stretch lies within 15 m of each place, or its end that is nearest; wider by what the
        road bends away from the box.
    """
    s, rear, front, d, half_width = (np.asarray(a, dtype=np.float64) for a in (s, rear, front, d, half_width))
    first = np.minimum(np.maximum(rear, s - _OCCUPANCY_WINDOW), front)
    last = np.maximum(np.minimum(front, s + _OCCUPANCY_WINDOW), rear)
    first, last = np.minimum(first, last), np.maximum(first, last)
    middle, length = 0.5 * (first + last), last - first
    center, tangent, second = path.derivatives(middle)
    norm = np.hypot(tangent[..., 0], tangent[..., 1])
    bend = np.abs(tangent[..., 0] * second[..., 1] - tangent[..., 1] * second[..., 0]) / norm**3
    return Boxes(
        center[..., 0] - d * tangent[..., 1] / norm,
        center[..., 1] + d * tangent[..., 0] / norm,
        np.arctan2(tangent[..., 1], tangent[..., 0]),
        length,
        2.0 * half_width + 0.25 * bend * length * length,
    )


def predict_ctra(remote: RemoteVehicle, t: ArrayLike) -> tuple[Array, Array, Array]:
    """Motion of a vehicle at constant turn rate and acceleration, off any road.

    Parameters
    ----------
    remote : RemoteVehicle
        The vehicle.
    t : array_like, shape (...)
        Times from now [s], not negative.

    Returns
    -------
    x, y, psi : ndarray, shape (...)
        Middle of its body [m] and heading [rad]; a braking vehicle stops and no longer turns.
    """
    t = np.asarray(t, dtype=np.float64)
    braking = remote.a_x * remote.v_x < 0.0
    moves = np.minimum(t, -remote.v_x / remote.a_x) if braking else t
    s = remote.v_x * moves + 0.5 * remote.a_x * moves**2
    if abs(remote.v_x) < STANDSTILL_SPEED or remote.r == 0.0:
        psi = np.full(s.shape, remote.psi)
        return remote.x + s * np.cos(psi), remote.y + s * np.sin(psi), psi
    kappa = remote.r / remote.v_x  # the circle stays, speed changes along it
    half = 0.5 * kappa * s
    chord = s * np.sinc(half / np.pi)
    return (
        remote.x + chord * np.cos(remote.psi + half),
        remote.y + chord * np.sin(remote.psi + half),
        remote.psi + 2.0 * half,
    )


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
    vehicle heading against the path drives toward smaller s.
    """
    relative = remote.psi - float(path.heading(s))
    forward = np.cos(relative) / max(1.0 - d * path.curvature_at(s), 0.1)
    at = s + forward * predict_distance(remote.v_x, remote.a_x, t)
    center, tangent, _ = path.derivatives(at)
    norm = np.hypot(tangent[..., 0], tangent[..., 1])
    heading = np.arctan2(tangent[..., 1], tangent[..., 0]) + relative
    return Boxes(
        center[..., 0] - d * tangent[..., 1] / norm,
        center[..., 1] + d * tangent[..., 0] / norm,
        heading,
        np.array(remote.length + 2.0 * _BOUND * remote.sigma_along),
        np.array(remote.width + 2.0 * _BOUND * remote.sigma_across),
    )
