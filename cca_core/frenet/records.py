"""The ego and remote vehicles in Frenet coordinates of the route, as records."""

import math
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from cca_core._checks import Array
from cca_core._repr import short_repr
from cca_core.follow import SpeedSettings, arrival_times
from cca_core.frenet.extent import Extent
from cca_core.geometry import Boxes
from cca_core.kernel import bind
from cca_core.kernel.reach import occupied_intervals
from cca_core.path import Path
from cca_core.vehicle import STALE_AGE, STANDSTILL_SPEED, RemoteVehicle, VehicleParams

_occupied_intervals = bind(occupied_intervals)
_STALE_BRAKING = 8.0  # assumed deceleration of a stale vehicle, as in its uncertainty bound [m/s^2]


@dataclass(frozen=True, slots=True, kw_only=True)
class FrenetVehicle:
    """A remote vehicle in Frenet coordinates, at the center of what its body covers.

    Parameters
    ----------
    remote : RemoteVehicle
        The vehicle as reported.
    s, d : float
        Station and lateral offset of the center of what its body covers [m], d left positive: of the center
        of its body, unless its ends reach across a bend.
    v_s : float
        Speed along the route [m/s], negative against it.
    half_length, half_width : float
        Half extent along and across the route [m], with two standard deviations of the position.
    angle : float
        Heading relative to the route [rad], counter-clockwise.
    added_length, added_width : float
        Part of both half extents that a bend adds [m], because the body is straight.
    """

    remote: RemoteVehicle
    s: float
    d: float
    v_s: float
    half_length: float
    half_width: float
    angle: float
    added_length: float = 0.0
    added_width: float = 0.0

    __repr__ = short_repr

    @classmethod
    def from_remote(
        cls,
        remote: RemoteVehicle,
        s: float,
        d: float,
        angle: float,
        kappa: float,
        extent: Extent | None = None,
    ) -> Self:
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
        extent : tuple of float, optional
            Least and largest station, least and largest lateral offset [m] of what the body covers in a bend;
            the record covers them as well.

        Returns
        -------
        vehicle : FrenetVehicle
            The vehicle in Frenet coordinates.
        """
        cos, sin = math.cos(angle), math.sin(angle)
        added_length = added_width = 0.0
        v_s = remote.v_x * cos / max(1.0 - d * kappa, 0.1)
        if extent is not None:
            along, across = _half_extents(0.5 * remote.length, 0.5 * remote.width, angle)
            s, added_length = _cover(s, along, extent[0], extent[1])
            d, added_width = _cover(d, across, extent[2], extent[3])
        along = 0.5 * remote.length + 2.0 * remote.sigma_along
        across = 0.5 * remote.width + 2.0 * remote.sigma_across
        cos, sin = abs(cos), abs(sin)
        return cls(
            remote=remote, s=s, d=d, v_s=v_s, half_length=along * cos + across * sin + added_length,
            half_width=along * sin + across * cos + added_width, angle=angle, added_length=added_length,
            added_width=added_width,
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
        return self._scale * (-a if v < 0.0 else a)

    @property
    def _scale(self) -> float:
        """Distance along the route for each meter that it drives."""
        v = self.remote.v_x
        return abs(self.v_s / v) if abs(v) > STANDSTILL_SPEED else abs(math.cos(self.angle))

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
        along, across = _half_extents(0.5 * self.remote.length, 0.5 * self.remote.width, self.angle)
        return replace(
            self, remote=replace(self.remote, age=0.0, sigma_along=0.0, sigma_across=0.0),
            half_length=along + self.added_length, half_width=across + self.added_width,
        )  # fmt: skip

    def since_measurement(self) -> "FrenetVehicle":
        """Return the vehicle without the growth of its uncertainty bound along the road while it was stale.

        Returns
        -------
        vehicle : FrenetVehicle
            For motions that begin at the measurement, as of `occupied_interval`: they contain that growth.
        """
        remote, late = self.remote, self.remote.age - STALE_AGE
        if late <= 0.0:
            return self
        measured = abs(remote.v_x - remote.a_x * STALE_AGE)
        growth = min(0.5 * _STALE_BRAKING * late * late, max(measured, STANDSTILL_SPEED) * late)
        if 2.0 * remote.sigma_along < growth:  # not the bound of a tracker
            return self
        along, across = _half_extents(growth, 0.0, self.angle)
        return replace(
            self, remote=replace(remote, sigma_along=remote.sigma_along - 0.5 * growth),
            half_length=self.half_length - along, half_width=self.half_width - across,
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
            scale = self._scale
            braking, acceleration = max(scale * braking, -rate), max(scale * acceleration, rate)
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

    __repr__ = short_repr

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


def _half_extents(length: float, width: float, angle: float) -> tuple[float, float]:
    """Half extents along and across the route of a body with a half length and a half width [m]."""
    cos, sin = abs(math.cos(angle)), abs(math.sin(angle))
    return length * cos + width * sin, length * sin + width * cos


def _cover(center: float, half: float, low: float, high: float) -> tuple[float, float]:
    """Center of the interval that covers another one too, and what is added to its half length."""
    low, high = min(low, center - half), max(high, center + half)
    return 0.5 * (low + high), max(0.5 * (high - low) - half, 0.0)
