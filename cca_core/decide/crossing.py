"""Crossing conflicts: conflict areas of the ego and another vehicle, and when each is inside."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_array, check_real
from cca_core._repr import short_repr
from cca_core.decide.sweep import Sweep, always_parallel, heading_range
from cca_core.errors import InputError
from cca_core.path import Path
from cca_core.vehicle import STALE_AGE, STANDSTILL_SPEED, RemoteVehicle, VehicleParams


@dataclass(frozen=True, slots=True, kw_only=True)
class CrossingSettings:
    """Limits assumed for the other vehicle, and what counts as crossing; defaults are this project's own.

    Parameters
    ----------
    a_max : float
        Assumed maximum acceleration of the other vehicle [m/s^2].
    b_max : float
        Assumed maximum deceleration of the other vehicle [m/s^2], positive.
    min_pet : float
        Least post-encroachment time: time between two bodies in the conflict area [s].
    clearance : float
        Margin around the ego's body on each side [m].
    min_angle : float
        Angle between the headings [rad]. Paths at a smaller angle run parallel or merge, and do not cross.
    standstill_speed : float
        A slower vehicle is assumed to stay where it is [m/s].

    Raises
    ------
    InputError
        If a value is not finite or out of range.
    """

    a_max: float = 2.0
    b_max: float = 2.0
    min_pet: float = 1.0
    clearance: float = 0.3
    min_angle: float = math.pi / 6.0
    standstill_speed: float = STANDSTILL_SPEED

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for name in ("a_max", "b_max", "min_pet", "clearance"):
            check_real(name, getattr(self, name), ge=0.0)
        check_real("standstill_speed", self.standstill_speed, gt=0.0)
        check_real("min_angle", self.min_angle, gt=0.0, le=0.5 * math.pi)


@dataclass(frozen=True, slots=True, kw_only=True)
class Conflict:
    """Conflict area on the ego's path, and when the ego and another vehicle are inside.

    Parameters
    ----------
    vehicle_id : str
        Id of the other vehicle.
    s_enter, s_exit : float
        Stations of the ego's center of gravity between which the bodies could overlap [m].
    distance : float
        Distance from the ego to `s_enter` [m], where it must stop in order to yield. Not positive if its body
        may already be in the area.
    t_ego : tuple of float
        Times from now at which the ego intends to enter and to exit [s]; infinite beyond the horizon.
    t_other : tuple of float
        Earliest time at which the other vehicle could enter, and latest at which it could exit [s]; infinite
        if it could stop inside.
    t_other_nominal : tuple of float
        The same at its present speed [s].
    min_pet : float
        Least time between the first exit and the second entry [s].
    """

    vehicle_id: str
    s_enter: float
    s_exit: float
    distance: float
    t_ego: tuple[float, float]
    t_other: tuple[float, float]
    t_other_nominal: tuple[float, float]
    min_pet: float

    __repr__ = short_repr

    @property
    def ego_first(self) -> bool:
        """Whether the ego exits at least `min_pet` before the other vehicle could enter."""
        return self.t_ego[1] + self.min_pet <= self.t_other[0]

    @property
    def other_first(self) -> bool:
        """Whether the other vehicle exits for certain at least `min_pet` before the ego enters."""
        return self.t_other[1] + self.min_pet <= self.t_ego[0]

    @property
    def is_clear(self) -> bool:
        """Whether the ego can drive as intended, before or after the other vehicle."""
        return self.ego_first or self.other_first

    @property
    def must_yield(self) -> bool:
        """Whether the ego must stop before the area; an ego that is inside must clear it instead.

        The property does not check whether the ego can still stop.
        """
        return not self.is_clear and self.distance > 0.0


def find_conflict(
    path: Path,
    s: float,
    stations: ArrayLike,
    times: ArrayLike,
    vehicle: VehicleParams,
    remote: RemoteVehicle,
    *,
    horizon: float = 8.0,
    settings: CrossingSettings | None = None,
) -> Conflict | None:
    """Find the conflict between the ego's path and the predicted path of another vehicle.

    Parameters
    ----------
    path : Path
        Path of the ego's center of gravity.
    s : float
        Station of the ego now [m].
    stations : array_like, shape (n,)
        Stations that the ego intends to pass [m], increasing from `s`.
    times : array_like, shape (n,)
        Times from now at these stations [s], increasing; linear between them.
    vehicle : VehicleParams
        The ego.
    remote : RemoteVehicle
        The other vehicle.
    horizon : float
        Length of the prediction [s].
    settings : CrossingSettings, optional
        Assumed limits and margins.

    Returns
    -------
    conflict : Conflict or None
        None if the bodies cannot overlap within the horizon, if the vehicle is stationary or invalid, or if
        it drives along the ego's path in either direction.

    Raises
    ------
    InputError
        If an argument is not finite or out of range, or `stations` or `times` does not increase.

    Notes
    -----
    The other vehicle is predicted straight ahead, or on the circle given by its yaw rate up to a right angle.
    Along this path it may have any acceleration within the limits. Its box grows by two standard deviations
    of its position, and by the distance that it may have gained or lost since it was measured. The conflict
    area reaches from the first to the last position of each body at which it could overlap the other.
    """
    settings = CrossingSettings() if settings is None else settings
    s, horizon = check_real("s", s), check_real("horizon", horizon, gt=0.0, le=60.0)
    at, t = check_array("stations", stations, (None,)), check_array("times", times, (None,))
    if at.shape != t.shape or len(at) < 2 or np.diff(at).min() <= 0.0 or np.diff(t).min() <= 0.0:
        raise InputError("stations and times must have the same length of at least 2, and increase")
    if remote.invalid_reason is not None or t[0] >= horizon:
        return None
    end = float(np.interp(horizon, t, at))
    body = Sweep.along_path(path, float(at[0]), end, vehicle, settings.clearance)
    return find_conflict_for_sweep(body, s, at, t, remote, horizon, settings)


def find_conflict_for_sweep(
    body: Sweep,
    s: float,
    at: Array,
    t: Array,
    remote: RemoteVehicle,
    horizon: float,
    settings: CrossingSettings,
) -> Conflict | None:
    """Find the conflict of a swept ego; `find_conflict` checks the arguments."""
    v, age = abs(remote.v_x), remote.age
    nominal = max(v, settings.standstill_speed)
    # since the measurement it may have driven otherwise than with the reported acceleration
    rate, elapsed = (-remote.a_x if remote.v_x < 0.0 else remote.a_x), min(age, STALE_AGE)
    gained, counted = rate * elapsed, rate * elapsed * (age - 0.5 * elapsed)
    speed_change = max(settings.a_max, settings.b_max) * age
    faster = max(speed_change, settings.a_max * age - gained)
    if v + faster - speed_change < settings.standstill_speed:
        return None
    fast, slow = v + faster, max(v - max(speed_change, settings.b_max * age + gained), 0.0)
    reach = fast * horizon + 0.5 * settings.a_max * horizon**2
    along = 2.0 * remote.sigma_along + max(
        0.5 * speed_change * age,
        0.5 * settings.a_max * age * age - counted,
        0.5 * settings.b_max * age * age + counted,
    )
    if always_parallel(body.headings, heading_range(remote, reach), settings.min_angle):
        return None
    start = complex(body.center[0]) - complex(remote.x, remote.y)
    sizes = body.half_length + body.half_width + remote.length + remote.width + along + remote.sigma_across
    if abs(start) > float(body.station[-1] - body.station[0]) + reach + sizes + 2.0 * remote.sigma_across:
        return None
    other = Sweep.from_remote(remote, reach, along, 2.0 * remote.sigma_across)
    overlap = body.find_overlap(other, settings.min_angle)
    if overlap is None:
        return None
    first, last, first_other, last_other = overlap
    s_enter = float(body.station[first]) - 0.5 * body.step
    s_exit = float(body.station[last]) + 0.5 * body.step
    u_in = max(float(other.station[first_other]) - 0.5 * other.step, 0.0)
    u_out = float(other.station[last_other]) + 0.5 * other.step
    open_end = last == len(body.station) - 1
    leaves = math.inf if open_end else float(np.interp(s_exit, at, t))
    endless = last_other == len(other.station) - 1
    latest = math.inf if endless else _time(u_out, slow, -settings.b_max)
    return Conflict(
        vehicle_id=remote.id, s_enter=s_enter, s_exit=s_exit, distance=s_enter - s, min_pet=settings.min_pet,
        t_ego=(float(np.interp(s_enter, at, t)), leaves),
        t_other=(_time(u_in, fast, settings.a_max), latest),
        t_other_nominal=(u_in / nominal, math.inf if endless else u_out / nominal),
    )  # fmt: skip


def _time(distance: float, v: float, a: float) -> float:
    """Time to cover a distance from speed v at constant acceleration [s]; infinite if never."""
    squared = v * v + 2.0 * a * distance
    if squared < 0.0 or (v == 0.0 and squared == 0.0):
        return math.inf if distance > 0.0 else 0.0
    return 2.0 * distance / (v + math.sqrt(squared))
