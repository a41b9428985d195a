"""The ego and its neighbors in path coordinates.

What a neighbor is, may be and most likely is stands beside how it is found on the route, since all of it is
read together; with the checks of a step's arguments this module is a little longer than others.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from numbers import Real
from typing import Self

import numpy as np

from cca_core._checks import Array
from cca_core.follow import SpeedSettings, arrival_times
from cca_core.geometry import Boxes
from cca_core.path import Path
from cca_core.predict import predict_distance, reachable_interval
from cca_core.vehicle import MAX_COORDINATE, MAX_SPEED, STALE_AGE, RemoteVehicle, VehicleParams, VehicleState

__all__ = ["HORIZON", "FrenetEgo", "FrenetVehicle", "invalid_input_reason", "to_frenet"]

HORIZON = 600.0
"""Farthest point ahead at which a pass may end [m]."""

_STALE_BRAKING = 8.0  # [m/s^2]
_CROSSING = 0.35  # sine of the angle to the route above which a vehicle may cross it
_FAR_FUTURE = 1e12  # [s]
_SCALAR_LIMIT = 25  # vehicles up to which one by one is faster than all at once


@dataclass(frozen=True, slots=True, kw_only=True)
class FrenetVehicle:
    """A remote vehicle in path coordinates.

    Parameters
    ----------
    remote : RemoteVehicle
        The vehicle.
    s, d : float
        Its place along and beside the route [m], d left positive.
    v_s : float
        Its speed along the route [m/s], negative if it comes toward the ego.
    half_length, half_width : float
        Half its extent along and across the route [m], with two standard deviations of its place.
    angle : float
        Its heading relative to the route [rad], counter-clockwise.
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
        """Turn a vehicle at a place on the route into path coordinates.

        Parameters
        ----------
        remote : RemoteVehicle
            The vehicle.
        s, d : float
            Its foot point and lateral coordinate [m].
        angle : float
            Its heading relative to the route [rad], counter-clockwise.
        kappa : float
            Curvature of the route there [1/m].

        Returns
        -------
        neighbor : Neighbor
            The vehicle along and across the route.
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
    def v_lower(self) -> float:
        """Least speed along the route [m/s]: the one told, or less if nothing was heard since it was stale.

        The bounds of a stale vehicle's place grow as if it had braked at 8 m/s^2 from 1 s of age on; this is
        its speed then. One that comes toward the ego keeps its speed.
        """
        late = self.remote.age - STALE_AGE
        if late <= 0.0 or self.v_s <= 0.0:
            return self.v_s
        return max(self.v_s - _STALE_BRAKING * late, 0.0)

    @property
    def is_stale(self) -> bool:
        """Whether it was heard so long ago (more than 1 s) that where it is now is a guess."""
        return self.remote.age > STALE_AGE

    def nominal(self) -> "FrenetVehicle":
        """Tell where and how fast it is most likely, instead of what must be reckoned with.

        Returns
        -------
        likely : Neighbor
            The same without bounds, as if it had just been heard.
        """
        cos, sin = abs(math.cos(self.angle)), abs(math.sin(self.angle))
        length, width = 0.5 * self.remote.length, 0.5 * self.remote.width
        return replace(
            self, remote=replace(self.remote, age=0.0, sigma_along=0.0, sigma_across=0.0),
            half_length=length * cos + width * sin, half_width=length * sin + width * cos,
        )  # fmt: skip

    def is_following_ego(self, ego: "FrenetEgo", right: float, left: float) -> bool:
        """Tell whether it is behind the ego on its lane: keeping the distance is its own duty.

        Parameters
        ----------
        ego : Ego
            The ego.
        right, left : float
            Borders of the ego's lane [m].

        Returns
        -------
        follows : bool
            Whether it is.
        """
        rear = ego.s + ego.vehicle.rear
        return self.s + self.half_length < rear and right < self.d < left and self.v_s >= 0.0

    def occupied_interval(self, t: Array, *, braking: float, acceleration: float) -> tuple[Array, Array]:
        """Stretch of the route that its body may cover at times from now.

        Parameters
        ----------
        t : ndarray, shape (n,)
            Times from now [s].
        braking, acceleration : float
            Its largest deceleration and acceleration [m/s^2]; if both are 0 it goes on as it does now.

        Returns
        -------
        rear, front : ndarray, shape (n,)
            Least and largest path coordinate of its body [m].
        """
        a_x = self.remote.a_x
        if braking == acceleration == 0.0:
            low = high = math.copysign(1.0, self.v_s) * predict_distance(abs(self.v_s), a_x, t)
        else:
            low, high = reachable_interval(
                self.v_s, t, braking=max(braking, -a_x), acceleration=max(acceleration, a_x),
                age=self.remote.age,
            )  # fmt: skip
        return self.s + low - self.half_length, self.s + high + self.half_length


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrenetEgo:
    """The ego as evasions see it: its place on the route and how it intends to drive.

    Parameters
    ----------
    vehicle : VehicleParams
        Its parameters.
    s : float
        Path coordinate of its center of gravity [m].
    v_x, v_target : float
        Speed now and wanted [m/s].
    speed : SpeedSettings
        How it accelerates.
    """

    vehicle: VehicleParams
    s: float
    v_x: float
    v_target: float
    speed: SpeedSettings

    def swept_boxes(self, path: Path, s: Array, d: Array) -> Boxes:
        """Its body along a displaced route.

        Parameters
        ----------
        path : Path
            The route.
        s, d : ndarray, shape (n,)
            Path coordinates and displacements [m]; at least 2.

        Returns
        -------
        body : Boxes
            One for each place.
        """
        x, y = path.to_cartesian(s, d).T
        psi = np.arctan2(np.gradient(y), np.gradient(x))
        return self.vehicle.body_at(x, y, psi)

    def arrival_times(self, s: Array) -> Array:
        """When the ego is where on the route.

        Parameters
        ----------
        s : ndarray, shape (n,)
            Path coordinates [m].

        Returns
        -------
        t : ndarray, shape (n,)
            Times from now [s].
        """
        return arrival_times(self.v_x, self.v_target, s - self.s, self.speed)


def to_frenet(
    remotes: Iterable[RemoteVehicle],
    path: Path,
    last_s: dict[str, float],
    lateral_range: tuple[float, float] = (-15.0, 15.0),
) -> tuple[list[FrenetVehicle], tuple[tuple[str, str], ...]]:
    """Bring remote vehicles into path coordinates.

    Parameters
    ----------
    remotes : iterable of RemoteVehicle
        What is known of other vehicles; of two with one id the younger counts.
    path : Path
        The route.
    last_s : dict
        Where each vehicle was on the route last time [m], by id; kept up to date here.
    lateral_range : tuple of float
        Right and left end of what matters beside the route [m]: a vehicle beyond, with its bounds, that does
        not head across the route is left out.

    Returns
    -------
    neighbors : list of Neighbor
        The usable ones.
    dropped : tuple of (str, str)
        Id and reason of those that cannot be used.
    """
    usable: dict[str, RemoteVehicle] = {}
    dropped = []
    records: Iterable[object] = remotes if hasattr(remotes, "__iter__") else (remotes,)
    for remote in records:
        if not isinstance(remote, RemoteVehicle):
            dropped.append((str(remote)[:20], "not a RemoteVehicle"))
            continue
        defect = remote.invalid_reason
        if defect is not None:
            dropped.append((str(remote.id), defect))
        elif remote.id not in usable or remote.age < usable[remote.id].age:
            usable[remote.id] = remote
    feet = _project_all(usable, path, last_s)
    last_s.clear()
    last_s.update(zip(usable, (foot[0] for foot in feet), strict=True))
    neighbors = []
    for remote, (s, d, heading, kappa) in zip(usable.values(), feet, strict=True):
        angle = remote.psi - heading
        if not lateral_range[0] <= d <= lateral_range[1]:
            across = abs(math.sin(angle))
            room = (0.5 * remote.length + 2.0 * remote.sigma_along) * across
            room += 0.5 * remote.width + 2.0 * remote.sigma_across
            if across < _CROSSING and not lateral_range[0] - room <= d <= lateral_range[1] + room:
                continue
        neighbors.append(FrenetVehicle.from_remote(remote, s, d, angle, kappa))
    return neighbors, tuple(dropped)


def _project_all(
    remotes: dict[str, RemoteVehicle], path: Path, places: dict[str, float]
) -> Iterable[tuple[float, float, float, float]]:
    """Foot point, lateral coordinate, heading and curvature of the route for each vehicle."""
    new = [(remote.x, remote.y) for name, remote in remotes.items() if name not in places]
    cold = iter(path.project(new)[0].tolist() if new else ())
    near = [places[name] if name in places else next(cold) for name in remotes]
    if len(near) <= _SCALAR_LIMIT:
        pairs = zip(remotes.values(), near, strict=True)
        return [path.foot_point(remote.x, remote.y, at) for remote, at in pairs]
    s, d = path.project([(remote.x, remote.y) for remote in remotes.values()], near)
    _, first, second = path.derivatives(s)
    heading = np.arctan2(first[:, 1], first[:, 0])
    cross = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    kappa = cross / np.hypot(first[:, 0], first[:, 1]) ** 3
    return list(zip(s.tolist(), d.tolist(), heading.tolist(), kappa.tolist(), strict=True))


def invalid_input_reason(t: object, last: float, state: object) -> str:
    """Tell why the arguments of a planner's step cannot be used.

    Parameters
    ----------
    t : object
        Time of the step [s], whatever came in.
    last : float
        Time of the step before [s].
    state : object
        Motion of the ego, whatever came in.

    Returns
    -------
    reason : str
        In words; empty if they can be used.
    """
    moment = float(t) if isinstance(t, Real) and abs(t) < _FAR_FUTURE else math.nan  # type: ignore[operator]
    if not moment > last:
        return f"t must be finite and increase, was {str(t)[:20]} after {last:g}"
    if not isinstance(state, VehicleState):
        return f"state must be a VehicleState, was {type(state).__name__}"
    if max(abs(state.x), abs(state.y)) > MAX_COORDINATE or state.v_x > MAX_SPEED:
        return "state is not that of a road vehicle"
    return ""
