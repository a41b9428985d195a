"""One planning problem for all methods, and what a method answers."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_real
from cca_core.errors import InputError, Status
from cca_core.geometry import Boxes
from cca_core.path import Road
from cca_core.predict import predict_along
from cca_core.vehicle import RemoteVehicle, VehicleParams

__all__ = ["Method", "Plan", "Problem"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Problem:
    """A stretch of road to be driven past others, all of whom keep their lane and speed.

    Parameters
    ----------
    name : str
        What kind of problem it is.
    road : Road
        Route, lanes and edges; the ego's body stays between the edges.
    vehicle : VehicleParams
        The ego.
    others : tuple of RemoteVehicle
        All other vehicles now; what they will do is known, and the same to every method: `boxes_at`.
    start, goal : float
        Path coordinates [m]: the ego's center of gravity now, on the route and along it, and where it is on
        the route and along it again.
    v_x : float
        Speed now, and wanted all along [m/s].
    clearance : float
        Distance to keep between the bodies [m].
    a_y_max : float
        Largest lateral acceleration [m/s^2].
    solvable : bool
        Whether a plan exists at constant speed; a method is not told.

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

    def __post_init__(self) -> None:
        path = self.road.path
        check_real("start", self.start, ge=path.start, le=path.end)
        check_real("goal", self.goal, gt=self.start, le=path.end)
        check_real("v_x", self.v_x, gt=0.0)
        check_real("clearance", self.clearance, ge=0.0)
        check_real("a_y_max", self.a_y_max, gt=0.0)
        for other in self.others:
            if other.invalid_reason is not None:
                raise InputError(f"others must be usable, {other.id}: {other.invalid_reason}")

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
        """Where the others are.

        Parameters
        ----------
        t : array_like, shape (n,)
            Times from now [s].

        Returns
        -------
        others : list of Boxes
            One for each vehicle, with fields of shape (n,).
        """
        path, found = self.road.path, []
        for other in self.others:
            s, d = path.project((other.x, other.y))
            found.append(predict_along(other, path, float(s), float(d), np.asarray(t, dtype=np.float64)))
        return found


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plan:
    """What a method answers.

    Parameters
    ----------
    status : Status
        `Status.OK` if the method holds its trajectory for drivable and clear, `Status.INFEASIBLE` if it says
        that there is none, `Status.NOT_CONVERGED` if it gave up.
    message : str
        Why, in words, if it is not OK.
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


Method = Callable[[Problem], Plan]
"""A planning method: it never raises for a valid problem, and ends by itself."""
