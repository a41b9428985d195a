"""A planning problem, and the plan that a method returns for it."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_bool, check_real
from cca_core._repr import short_repr
from cca_core.errors import InputError, Status
from cca_core.geometry import Boxes
from cca_core.path import Road
from cca_core.predict import predict_along
from cca_core.vehicle import RemoteVehicle, VehicleParams


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Problem:
    """Section of a road past other vehicles that keep their lane and speed.

    Parameters
    ----------
    name : str
        Kind of the problem.
    road : Road
        Route, lanes and edges; the ego's body stays between the edges.
    vehicle : VehicleParams
        The ego.
    others : tuple of RemoteVehicle
        Other vehicles now. Their motion is known and the same for every method: `boxes_at`.
    start, goal : float
        Stations of the ego's center of gravity [m] now and at the end. At both the ego is on the route and
        heads along it.
    v_x : float
        Speed now, and the wanted speed [m/s].
    clearance : float
        Smallest distance allowed between the bodies [m].
    a_y_max : float
        Largest lateral acceleration [m/s^2].
    solvable : bool
        Whether a plan at constant speed exists; not meant for methods.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    name: str
    road: Road
    vehicle: VehicleParams
    others: tuple[RemoteVehicle, ...]
    start: float
    goal: float
    v_x: float
    clearance: float = 0.3
    a_y_max: float = 4.0
    solvable: bool = True

    __repr__ = short_repr

    def __post_init__(self) -> None:
        path = self.road.path
        check_real("start", self.start, ge=path.start, le=path.end)
        check_real("goal", self.goal, gt=self.start, le=path.end)
        check_real("v_x", self.v_x, gt=0.0)
        check_real("clearance", self.clearance, ge=0.0)
        check_real("a_y_max", self.a_y_max, gt=0.0)
        check_bool("solvable", self.solvable)
        for other in self.others:
            if other.invalid_reason is not None:
                raise InputError(f"others must be valid, {other.id} was not: {other.invalid_reason}")

    @property
    def duration(self) -> float:
        """Time from start to goal at the wanted speed [s]."""
        return (self.goal - self.start) / self.v_x

    @property
    def kappa_max(self) -> float:
        """Largest curvature at the wanted speed [1/m]: what tires and steering allow."""
        steering = float(np.tan(self.vehicle.delta_max)) / self.vehicle.wheelbase
        return min(self.a_y_max / self.v_x**2, steering)

    def boxes_at(self, t: ArrayLike) -> list[Boxes]:
        """Bodies of the other vehicles.

        Parameters
        ----------
        t : array_like, shape (n,)
            Times from now [s].

        Returns
        -------
        others : list of Boxes
            One for each vehicle, with fields of shape (n,).
        """
        path, bodies = self.road.path, []
        for other in self.others:
            s, d = path.project((other.x, other.y))
            bodies.append(predict_along(other, path, float(s), float(d), np.asarray(t, dtype=np.float64)))
        return bodies


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plan:
    """Trajectory of the ego, or the reason why there is none.

    Parameters
    ----------
    status : Status
        `Status.OK` if the method claims a trajectory that keeps all limits, `Status.INFEASIBLE` if it claims
        that none exists, `Status.NOT_CONVERGED` if it found none.
    message : str
        Reason in words if the status is not OK.
    t : ndarray, shape (n,)
        Times from now [s], beginning with 0; empty if there is no trajectory.
    xy : ndarray, shape (n, 2)
        The ego's center of gravity at these times [m].
    v_x : ndarray, shape (n,)
        Its speed [m/s].
    """

    status: Status
    message: str = ""
    t: Array = field(default_factory=lambda: np.empty(0))
    xy: Array = field(default_factory=lambda: np.empty((0, 2)))
    v_x: Array = field(default_factory=lambda: np.empty(0))

    __repr__ = short_repr


class PlanningMethod(Protocol):
    """Planning method: it never raises for a valid problem, and it terminates."""

    def plan(self, problem: Problem) -> Plan:
        """Plan once."""
