"""Prediction of other vehicles: distances, reachable intervals and boxes along a road."""

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, as_array, formula
from cca_core.geometry import Boxes
from cca_core.kernel import bind, reach
from cca_core.path.path import Path
from cca_core.vehicle import STANDSTILL_SPEED, RemoteVehicle

__all__ = ["occupancy_boxes", "predict_along", "predict_ctra", "predict_distance", "reachable_interval"]

_distances_driven, _reachable_intervals = bind(reach.distances_driven), bind(reach.reachable_intervals)
_occupancy_boxes = bind(reach.occupancy_boxes)
_BOUND = 2.0  # standard deviations of the 95 % uncertainty bound on each side


@formula
def predict_distance(v_x: float, a_x: float, t: ArrayLike) -> Array:
    """Distance driven in a time.

    Parameters
    ----------
    v_x : float
        Speed now [m/s].
    a_x : float
        Acceleration now [m/s^2]. Braking harder than 1 m/s^2 is assumed to last until standstill; any other
        acceleration is assumed to end now.
    t : array_like, shape (...)
        Time from now [s]; the speed was constant at negative times.

    Returns
    -------
    distance : ndarray, shape (...)
        Distance [m], in the direction of `v_x`.

    Raises
    ------
    InputError
        If a value is no array of real numbers.

    Examples
    --------
    >>> predict_distance(20.0, -5.0, [1.0, 4.0, 9.0])
    array([17.5, 40. , 40. ])
    """
    t = np.asarray(as_array("t", t), order="C")
    distance = np.empty_like(t)
    _distances_driven(t.size, t.reshape(-1), v_x, a_x, distance.reshape(-1))
    return distance[()]


@formula
def reachable_interval(
    v: ArrayLike,
    t: ArrayLike,
    *,
    braking: float,
    acceleration: float,
    age: ArrayLike = 0.0,
    a_reported: ArrayLike = 0.0,
) -> tuple[Array, Array]:
    """Interval of displacements that a vehicle can reach within assumed limits.

    Parameters
    ----------
    v : array_like, shape (...)
        Speed along the road now, dead-reckoned by `age` [m/s], negative against it.
    t : array_like, shape (...)
        Times from now [s]; the speed was constant at negative times.
    braking, acceleration : float
        Assumed maximum deceleration and acceleration [m/s^2], not negative. Braking ends at standstill.
    age : array_like, shape (...)
        Time since the speed was measured [s]. The vehicle may have braked or accelerated since then.
    a_reported : array_like, shape (...)
        Rate of change of ``|v|`` with which position and speed were dead-reckoned by `age` [m/s^2], for at
        most 1 s. The vehicle may have driven otherwise.

    Returns
    -------
    low, high : ndarray, shape (...)
        Least and largest displacement along the road from the position now [m].

    Raises
    ------
    InputError
        If a value is no array of real numbers.

    Notes
    -----
    Below 0.5 m/s the vehicle may start in both directions, because the sign of a small speed is noise.

    The measured speed is ``v_0 = |v| - a tau`` with the reported acceleration a and tau = min(age, 1 s).
    From the position at the measurement the vehicle has driven between v_0 (age + t) - b (age + t)^2 / 2
    and v_0 (age + t) + c (age + t)^2 / 2; dead reckoning has already counted ``|v| age - a tau^2 / 2`` of
    it. A reported braking therefore adds ``|a| age t`` to the larger displacement.

    Examples
    --------
    >>> low, high = reachable_interval(20.0, [1.0, 4.0], braking=8.0, acceleration=3.0)
    >>> low, high
    (array([16., 25.]), array([ 21.5, 104. ]))
    """
    named = {"v": v, "t": t, "age": age, "a_reported": a_reported}
    given = np.stack(np.broadcast_arrays(*(as_array(name, value) for name, value in named.items())))
    low, high = np.empty((2, *given.shape[1:]))
    speeds, times, ages, rates = given.reshape(4, -1)
    flat = low.reshape(-1), high.reshape(-1)
    _reachable_intervals(low.size, speeds, times, ages, rates, braking, acceleration, *flat)
    return low, high


def occupancy_boxes(
    path: Path, s: ArrayLike, rear: ArrayLike, front: ArrayLike, d: ArrayLike, half_width: ArrayLike
) -> Boxes:
    """Boxes that cover an occupied interval of the road near given stations.

    Parameters
    ----------
    path : Path
        The road.
    s : array_like, shape (..., n)
        Stations of the ego [m], one box for each.
    rear, front : array_like, shape (..., n)
        Ends of the interval when the ego is at each station [m].
    d : array_like, shape (..., n) or (..., 1)
        Lateral offset of the interval [m], left positive.
    half_width : array_like, shape (..., n) or (..., 1)
        Half the width of the interval [m].

    Returns
    -------
    boxes : Boxes
        Part of the interval within 15 m of each station, or its nearest end. The boxes are wider by the
        deviation of the road from a straight line.

    Raises
    ------
    InputError
        If a value is no array of real numbers.
    """
    interval = (as_array("interval", a) for a in (s, rear, front, d, half_width))
    given = np.stack(np.broadcast_arrays(*interval))
    boxes = np.empty((*given.shape[1:], 5))
    stations, rears, fronts, offsets, halves = given.reshape(5, -1)
    rows = boxes.reshape(-1, 5)
    _occupancy_boxes(path.curve, len(rows), stations, rears, fronts, offsets, halves, rows)
    return Boxes(*np.moveaxis(boxes, -1, 0))


def predict_ctra(remote: RemoteVehicle, t: ArrayLike) -> tuple[Array, Array, Array]:
    """Motion of a vehicle at constant turn rate and acceleration (CTRA), independent of a road.

    Parameters
    ----------
    remote : RemoteVehicle
        The vehicle.
    t : array_like, shape (...)
        Times from now [s], not negative.

    Returns
    -------
    x, y, psi : ndarray, shape (...)
        Center of its body [m] and heading [rad]; a braking vehicle stops and no longer turns.

    Raises
    ------
    InputError
        If a value is no array of real numbers.
    """
    t = as_array("t", t)
    braking = remote.a_x * remote.v_x < 0.0
    moves = np.minimum(t, -remote.v_x / remote.a_x) if braking else t
    if remote.v_x == 0.0 and remote.a_x < 0.0:  # it has braked to standstill
        moves = np.zeros_like(t)
    s = remote.v_x * moves + 0.5 * remote.a_x * moves**2
    if abs(remote.v_x) < STANDSTILL_SPEED or remote.r == 0.0:
        psi = np.full(s.shape, remote.psi)
        return remote.x + s * np.cos(psi), remote.y + s * np.sin(psi), psi
    kappa = remote.r / remote.v_x  # constant: the speed changes along the circle
    half = 0.5 * kappa * s
    chord = s * np.sinc(half / np.pi)
    return (
        remote.x + chord * np.cos(remote.psi + half),
        remote.y + chord * np.sin(remote.psi + half),
        remote.psi + 2.0 * half,
    )


@formula
def predict_along(remote: RemoteVehicle, path: Path, s: float, d: float, t: ArrayLike) -> Boxes:
    """Boxes of a vehicle that keeps its lateral offset on the road.

    Parameters
    ----------
    remote : RemoteVehicle
        The vehicle.
    path : Path
        The road that the vehicle follows.
    s, d : float
        Frenet coordinates of the vehicle now [m], d left positive.
    t : array_like, shape (n,)
        Times from now [s].

    Returns
    -------
    boxes : Boxes
        One box for each time, longer and wider by two standard deviations on each side.

    Notes
    -----
    The speed along the path is v cos(psi - psi_p) / (1 - d kappa), with the curvature at the present station.
    A vehicle that heads against the path drives toward smaller s.
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
