"""The ego and remote vehicles in Frenet coordinates of the route, as records."""

import math
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from cca_core._checks import Array
from cca_core.follow import SpeedSettings, arrival_times
from cca_core.geometry import Boxes
from cca_core.kernel import bind
from cca_core.kernel.reach import occupied_intervals
from cca_core.path import Path
from cca_core.vehicle import STALE_AGE, STANDSTILL_SPEED, RemoteVehicle, VehicleParams

_occupied_intervals = bind(occupied_intervals)
_STALE_BRAKING = 8.0  # assumed deceleration of a stale vehicle, as in its uncertainty bound [m/s^2]


@dataclass(frozen=True, slots=True, kw_only=True)
class FrenetVehicle:
    """A remote vehicle in Frenet coordinates, at the center of its body.

    Parameters
    ----------
    remote : RemoteVehicle
        The vehicle as reported.
    s, d : float
        Station and lateral offset of the center of its body [m], d left positive.
    v_s : float
        Speed along the route [m/s], negative against it.
    half_length, half_width : float
        Half extent along and across the route [m], with two standard deviations of the position.
    angle : float
        Heading relative to the route [rad], counter-clockwise.
    """

    remote: RemoteVehicle
    s: float
    d: float
    v_s: float
    half_length: float
    half_width: float
    angle: float

    @classmethod
    def from_remote(cls, remote: RemoteVehicle, s: float, d: float, angle: float, kappa: float) -> Self:
        """Make the record from a foot point.

        Parameters
        ----------
        remote : RemoteVehicle
            The vehicle.
        s, d : float
            Station and lateral offset of the center of its body [m].
        angle : float
            Heading relative to the route [rad], counter-clockwise.
        kappa : float
            Curvature of the route at the foot point [1/m].

        Returns
        -------
        vehicle : FrenetVehicle
            The vehicle in Frenet coordinates.
        """
        cos, sin = math.cos(angle), math.sin(angle)
        along = 0.5 * remote.length + 2.0 * remote.sigma_along
        across = 0.5 * remote.width + 2.0 * remote.sigma_across
        return cls(
            remote=remote, s=s, d=d, v_s=remote.v_x * cos / max(1.0 - d * kappa, 0.1),
            half_length=along * abs(cos) + across * abs(sin), half_width=along * abs(sin) + across * abs(cos),
            angle=angle,
        )  # fmt: skip

    @property
    def id(self) -> str:
        """Id of the vehicle."""
        return self.remote.id

    @property
    def front(self) -> float:
        """Largest station that its body may cover now [m]."""
        return self.s + self.half_length

    @property
    def rear(self) -> float:
        """Smallest station that its body may cover now [m]."""
        return self.s - self.half_length

    @property
    def body_front(self) -> float:
        """Station of its front end without the uncertainty bound [m]."""
        return self.front - 2.0 * self.remote.sigma_along

    @property
    def body_half_width(self) -> float:
        """Half extent across the route without the uncertainty bound [m]."""
        return self.half_width - 2.0 * self.remote.sigma_across

    @property
    def v_lower(self) -> float:
        """Lower bound of the speed along the route [m/s].

        The uncertainty bound of a stale vehicle grows as if it braked with 8 m/s^2 from 1 s of age on. An
        oncoming vehicle keeps its speed.
        """
        stale_time = self.remote.age - STALE_AGE
        if stale_time <= 0.0 or self.v_s <= 0.0:
            return self.v_s
        return max(self.v_s - _STALE_BRAKING * stale_time, 0.0)

    @property
    def speed_rate(self) -> float:
        """Reported rate of change of the magnitude of the speed along the route [m/s^2]."""
        v, a = self.remote.v_x, self.remote.a_x
        scale = abs(self.v_s / v) if abs(v) > STANDSTILL_SPEED else abs(math.cos(self.angle))
        return scale * (-a if v < 0.0 else a)

    @property
    def is_stale(self) -> bool:
        """Whether the age exceeds 1 s."""
        return self.remote.age > STALE_AGE

    def nominal(self) -> "FrenetVehicle":
        """Return the vehicle at its nominal position, without age and uncertainty bound.

        Returns
        -------
        vehicle : FrenetVehicle
            The same vehicle with the extent of its body.
        """
        cos, sin = abs(math.cos(self.angle)), abs(math.sin(self.angle))
        length, width = 0.5 * self.remote.length, 0.5 * self.remote.width
        return replace(
            self, remote=replace(self.remote, age=0.0, sigma_along=0.0, sigma_across=0.0),
            half_length=length * cos + width * sin, half_width=length * sin + width * cos,
        )  # fmt: skip

    def occupied_interval(self, t: Array, *, braking: float, acceleration: float) -> tuple[Array, Array]:
        """Return the stations that its body may cover.

        Parameters
        ----------
        t : ndarray, shape (n,)
            Times from now [s].
        braking, acceleration : float
            Assumed maximum deceleration and acceleration [m/s^2]; with both 0 it keeps its motion.

        Returns
        -------
        rear, front : ndarray, shape (n,)
            Smallest and largest station of its body [m].
        """
        age, rate = 0.0, 0.0
        if not braking == acceleration == 0.0:
            age, rate = self.remote.age, self.speed_rate
            braking, acceleration = max(braking, -rate), max(acceleration, rate)
        a_x = self.remote.a_x
        motion = np.array([(self.rear, self.front, self.v_s, age, rate, braking, acceleration, a_x)])
        rear, front = np.empty((2, 1, len(t)))
        _occupied_intervals(1, len(t), motion, np.ascontiguousarray(t), rear, front)
        return rear[0], front[0]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrenetEgo:
    """The ego in Frenet coordinates, at the center of its body, and the speed that it intends.

    Parameters
    ----------
    vehicle : VehicleParams
        The ego's parameters.
    s, d : float
        Station and lateral offset of the center of its body [m], d left positive.
    v_x, v_target : float
        Speed along the route now and target speed [m/s].
    speed : SpeedSettings, optional
        Limits of its acceleration.
    """

    vehicle: VehicleParams
    s: float
    v_x: float
    v_target: float
    d: float = 0.0
    speed: SpeedSettings = field(default_factory=SpeedSettings)

    @property
    def s_cg(self) -> float:
        """Station of the center of gravity, to which paths and bands refer [m]."""
        return self.s - self.vehicle.box_offset

    @property
    def front(self) -> float:
        """Station of the front end of its body [m]."""
        return self.s + 0.5 * self.vehicle.length

    @property
    def rear(self) -> float:
        """Station of the rear end of its body [m]."""
        return self.s - 0.5 * self.vehicle.length

    def swept_boxes(self, path: Path, s: Array, d: Array) -> Boxes:
        """Return boxes of its body along a displaced route.

        Parameters
        ----------
        path : Path
            The route.
        s, d : ndarray, shape (n,)
            Stations and lateral offsets of the center of gravity [m]; at least 2.

        Returns
        -------
        body : Boxes
            One box for each station.
        """
        x, y = path.to_cartesian(s, d).T
        return self.vehicle.body_at(x, y, np.arctan2(np.gradient(y), np.gradient(x)))

    def arrival_times(self, s: Array) -> Array:
        """Return the times at which its center of gravity reaches stations.

        Parameters
        ----------
        s : ndarray, shape (n,)
            Stations [m].

        Returns
        -------
        t : ndarray, shape (n,)
            Times from now [s].
        """
        return arrival_times(self.v_x, self.v_target, s - self.s_cg, self.speed)
