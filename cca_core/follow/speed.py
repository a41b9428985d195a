"""Speed: cruise, stop, limits along a path and of the tires, arrival times."""

import math
from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array, check_real, formula
from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.kernel import bind
from cca_core.kernel import speed as kernel
from cca_core.path.path import Path
from cca_core.vehicle import GRAVITY

_arrival_times, _profile_acceleration = bind(kernel.arrival_times), bind(kernel.profile_acceleration)
_squared_speed_limits = bind(kernel.squared_speed_limits)

_TRACKING_ERROR = 0.1  # by which a car that slows down is still too fast after that time [m/s]


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedSettings:
    """Limits and gaps of the speed controller.

    Parameters
    ----------
    a_max : float
        Largest acceleration [m/s^2].
    b_comfort : float
        Deceleration of a planned approach [m/s^2], positive.
    b_max : float
        Largest deceleration [m/s^2], positive.
    standstill_gap : float
        Bumper-to-bumper gap behind a stationary lead vehicle [m].
    time_gap : float
        Additional gap behind a moving lead vehicle, per speed [s].
    approach_rate : float
        Rate at which the last meters to the target gap are closed [1/s].
    jerk : float
        Largest rate of change of acceleration in normal driving [m/s^3].
    jerk_emergency : float
        Largest rate of change of acceleration during hard braking [m/s^3].

    Raises
    ------
    InputError
        If a value is not finite and positive.
    """

    a_max: float = 2.0
    b_comfort: float = 2.0
    b_max: float = 7.0
    standstill_gap: float = 3.0
    time_gap: float = 1.5
    approach_rate: float = 0.5
    jerk: float = 3.0
    jerk_emergency: float = 12.65

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for name in self.__slots__:
            check_real(name, getattr(self, name), gt=0.0)


@formula
def cruise_acceleration(v_x: float, v_target: float, settings: SpeedSettings) -> float:
    """Acceleration toward a target speed.

    Parameters
    ----------
    v_x, v_target : float
        Speed and target speed [m/s].
    settings : SpeedSettings
        Limits.

    Returns
    -------
    a_x : float
        Acceleration [m/s^2], between -b_comfort and a_max.
    """
    return min(max(v_target - v_x, -settings.b_comfort), settings.a_max)


@formula
def stop_acceleration(v_x: float, distance: float, settings: SpeedSettings) -> float:
    """Acceleration that stops the vehicle at a point.

    Parameters
    ----------
    v_x : float
        Speed of the ego [m/s].
    distance : float
        Distance to the point [m]; behind the point the vehicle brakes fully.
    settings : SpeedSettings
        Limits.

    Returns
    -------
    a_x : float
        Acceleration [m/s^2]: -v^2 / (2 distance) if that is at least `b_comfort`, else `a_max`.
    """
    if v_x <= 0.0:
        return 0.0
    need = v_x * v_x / (2.0 * distance) if distance > 0.0 else math.inf
    return -min(need, settings.b_max) if need >= settings.b_comfort else settings.a_max


@formula
def jerk_limited(
    target: float, previous: float, dt: float, settings: SpeedSettings, *, emergency: bool = False
) -> float:
    """Acceleration that approaches a target with limited jerk.

    Parameters
    ----------
    target, previous : float
        Target acceleration, and acceleration of the last cycle [m/s^2].
    dt : float
        Time between them [s].
    settings : SpeedSettings
        `jerk`, and `jerk_emergency` for braking.
    emergency : bool
        Whether braking may build up at `jerk_emergency`.

    Returns
    -------
    a_x : float
        Acceleration [m/s^2], at most jerk dt away from `previous`.
    """
    step = (settings.jerk_emergency if emergency else settings.jerk) * dt
    return min(max(target, previous - step), previous + step)


@formula
def friction_limited(a_x: float, a_y: float, mu: float, *, grip_fraction: float = 0.9) -> float:
    """Longitudinal acceleration that the tires can carry besides a lateral one.

    Parameters
    ----------
    a_x : float
        Target acceleration [m/s^2].
    a_y : float
        Lateral acceleration [m/s^2].
    mu : float
        Friction coefficient [-].
    grip_fraction : float
        Fraction of the friction circle that may be used [-].

    Returns
    -------
    a_x : float
        `a_x`, limited to +-sqrt((grip_fraction mu g)^2 - a_y^2) [m/s^2].

    Examples
    --------
    >>> round(friction_limited(-9.0, 4.0, 0.9), 2)
    -6.87
    """
    limit = math.sqrt(max((grip_fraction * mu * GRAVITY) ** 2 - a_y * a_y, 0.0))
    return min(max(a_x, -limit), limit)


@formula
def arrival_times(v_x: float, v_target: float, distances: Array, settings: SpeedSettings) -> Array:
    """Time that the ego takes for distances ahead if no vehicle limits its speed.

    Parameters
    ----------
    v_x, v_target : float
        Speed and target speed [m/s].
    distances : ndarray, shape (n,)
        Distances ahead [m]; negative distances are behind, driven at constant speed.
    settings : SpeedSettings
        `a_max` and `b_comfort` hold until the target speed is reached.

    Returns
    -------
    t : ndarray, shape (n,)
        Times from now [s].
    """
    distances = np.asarray(distances, dtype=np.float64, order="C")
    t = np.empty_like(distances)
    _arrival_times(
        t.size, v_x, v_target, distances.reshape(-1), settings.a_max, settings.b_comfort, t.reshape(-1)
    )
    return t


@formula
def squared_speed_limit(
    path: Path,
    cruise: float,
    a_y: float,
    settings: SpeedSettings,
    limits: Array | None = None,
    *,
    start: tuple[float, float] | None = None,
) -> tuple[Array, Array]:
    """Square of the highest speed along a path: cruise speed, limits, curves, standstill at its end.

    Parameters
    ----------
    path : Path
        The route.
    cruise : float
        Upper limit everywhere [m/s].
    a_y : float
        Lateral acceleration on curves, which limits the speed there [m/s^2].
    settings : SpeedSettings
        `b_comfort` is the deceleration before slower points.
    limits : ndarray, shape (n, 2), optional
        Stations [m] and speeds [m/s] of `Road.speed_limits`. The ego is slower than a lower limit from a
        time of ``1 / approach_rate`` before its station on.
    start : tuple of float, optional
        Station [m] and speed [m/s] of the ego. If it is faster there, the squared speed falls from its own in
        comfort. A curve or the end ahead can still ask for more.

    Returns
    -------
    s : ndarray, shape (n,)
        Stations [m], up to 200 m behind the end.
    squared : ndarray, shape (n,)
        v^2 [m^2/s^2], linear between the stations. It is negative behind the end, so that its slope is twice
        the acceleration everywhere.
    """
    s = np.linspace(path.start, path.end, max(2, math.ceil(path.length / 2.0)))
    parts = [] if limits is None else _limited_parts(limits, 1.0 / settings.approach_rate)
    ends = np.array([at for part in parts for at in part[:2] if path.start < at < path.end])
    s = np.union1d(s, ends) if len(ends) else s
    squared = np.empty_like(s)
    _squared_speed_limits(path.curve, len(s), cruise, a_y, settings.b_comfort, s, squared)
    for first, end, limit in parts:
        before = 2.0 * settings.b_comfort * np.maximum(first - s, 0.0)
        squared = np.where(s <= end, np.minimum(squared, limit * limit + before), squared)
    tail = 200.0  # [m]: the profile falls on behind the end
    s, squared = np.append(s, s[-1] + tail), np.append(squared, -2.0 * settings.b_comfort * tail)
    if start is None or start[1] ** 2 <= np.interp(start[0], s, squared):
        return s, squared
    here, v = start
    begin = here + 0.5 * v * settings.b_comfort / settings.jerk  # while the deceleration builds up
    curves = np.interp(s, *squared_speed_limit(path, v, a_y, settings))
    return s, np.minimum(curves, np.maximum(squared, v * v - 2.0 * settings.b_comfort * (s - begin)))


def _limited_parts(limits: Array, time: float) -> list[tuple[float, float, float]]:
    """Return from where to where which speed is the limit; a lower limit is met a time before."""
    # plans are driven on a grid of whole meters, between which the squared speed is linear
    starts, ends = np.floor(limits[:, 0]), np.append(np.ceil(limits[1:, 0]), math.inf)
    starts[0], parts, last = -math.inf, [], 0.0
    for start, end, limit in zip(starts.tolist(), ends.tolist(), limits[:, 1].tolist(), strict=True):
        parts.append((start, end, limit))
        if limit < last:
            slower = max(limit - _TRACKING_ERROR, 0.9 * limit)
            parts.append((math.floor(start - limit * time), start, slower))
        last = limit
    return parts


@formula
def profile_acceleration(
    s: float, v_x: float, profile: tuple[Array, Array], settings: SpeedSettings
) -> float:
    """Acceleration along a speed profile, with its slope as feedforward.

    Parameters
    ----------
    s : float
        Station of the ego [m].
    v_x : float
        Forward speed [m/s].
    profile : tuple of ndarray
        Stations [m] and squared speeds [m^2/s^2] of `squared_speed_limit`.
    settings : SpeedSettings
        Limits.

    Returns
    -------
    a_x : float
        Acceleration [m/s^2], between -b_max and a_max. It leads to the speed of the profile about one second
        ahead, or to the speed of the profile here if that needs less.

    Raises
    ------
    InputError
        If the profile is empty, or its rows differ in length.
    """
    stations = np.ascontiguousarray(profile[0], dtype=np.float64)
    squared = np.ascontiguousarray(profile[1], dtype=np.float64)
    if stations.ndim != 1 or stations.shape != squared.shape or not stations.size:
        raise InputError(
            f"profile must be two rows of one length, not empty, had {stations.shape} and {squared.shape}"
        )
    return _profile_acceleration(
        len(stations), stations, squared, s, v_x, settings.a_max, settings.b_comfort, settings.b_max
    )
