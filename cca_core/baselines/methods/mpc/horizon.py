"""What both model predictive controllers share: settings, the ego, the horizon with all others in it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cca_core._checks import Array, check_real
from cca_core.baselines.problems.problem import Problem
from cca_core.errors import InputError
from cca_core.frenet import FrenetVehicle, to_frenet
from cca_core.path import Road
from cca_core.predict import predict_distance
from cca_core.vehicle import VehicleParams

__all__ = ["FrenetState", "Horizon", "MpcSettings"]


@dataclass(frozen=True, slots=True, kw_only=True)
class MpcSettings:
    """Horizon, limits and weights; the cost is an integral over time of weighted squares.

    Parameters
    ----------
    intervals : int
        Intervals of the horizon [-].
    horizon : float
        Length of the horizon in closed loop [s]; one plan reaches to its goal.
    clearance : float
        Distance kept between bodies in closed loop [m]; a plan has that of its problem.
    a_y_max : float
        Largest lateral acceleration in closed loop [m/s^2]; a plan has that of its problem.
    weight_d : float
        On the lateral coordinate [1/m^2].
    weight_a : float
        On lateral acceleration relative to the road [s^4/m^2].
    weight_jerk : float
        On lateral and longitudinal jerk [s^6/m^2].
    weight_v : float
        On the difference to the wanted speed [s^2/m^2]; nonlinear controller only.
    weight_a_x : float
        On longitudinal acceleration [s^4/m^2]; nonlinear controller only.
    iterations : int
        Largest number of iterations of the solver [-].
    cpu_time : float
        Time after which a solver gives up [s].
    solver : {"ipopt", "fatrop"}
        Solver of the nonlinear program; FATROP has no limit of time.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    intervals: int = 40
    horizon: float = 10.0
    clearance: float = 0.5
    a_y_max: float = 3.0
    weight_d: float = 1.0
    weight_a: float = 0.3
    weight_jerk: float = 0.3
    weight_v: float = 0.5
    weight_a_x: float = 0.5
    iterations: int = 80
    cpu_time: float = 0.5
    solver: Literal["ipopt", "fatrop"] = "ipopt"

    def __post_init__(self) -> None:
        for name, least in (("intervals", 5), ("iterations", 1)):
            value = getattr(self, name)
            if not isinstance(value, int) or not least <= value <= 1000:
                raise InputError(f"{name} must be a whole number from {least} to 1000, was {value!r}")
        for name in ("horizon", "a_y_max", "weight_d", "weight_a", "weight_jerk", "cpu_time"):
            check_real(name, getattr(self, name), gt=0.0)
        for name in ("clearance", "weight_v", "weight_a_x"):
            check_real(name, getattr(self, name), ge=0.0)
        if self.solver not in ("ipopt", "fatrop"):
            raise InputError(f"solver must be 'ipopt' or 'fatrop', was {self.solver!r}")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Horizon:
    """The stretch of time that is planned, with limits and everybody in it.

    Parameters
    ----------
    road : Road
        Route, lanes and edges.
    vehicle : VehicleParams
        The ego.
    t : ndarray, shape (n + 1,)
        Equidistant times from now [s].
    others : sequence of Neighbor
        All others; they keep their lateral coordinate and speed, a braking one stops.
    v_wanted : float
        Wanted speed [m/s].
    clearance : float
        Distance to keep between bodies [m].
    a_y_max : float
        Largest lateral acceleration [m/s^2].
    share : float
        Share of the clearance that a trajectory must keep to be accepted [-].
    final : tuple of float
        Least and largest lateral coordinate at the end [m].
    goal : float
        Least path coordinate at the end [m].
    """

    road: Road
    vehicle: VehicleParams
    t: Array
    others: Sequence[FrenetVehicle]
    v_wanted: float
    clearance: float
    a_y_max: float
    final: tuple[float, float]
    share: float = 1.0
    goal: float = -np.inf

    @classmethod
    def of(cls, problem: Problem, intervals: int) -> "Horizon":
        """Make the horizon from start to goal.

        Parameters
        ----------
        problem : Problem
            What is to be driven.
        intervals : int
            Number of intervals [-].

        Returns
        -------
        horizon : Horizon
            It ends on the route, at the goal or beyond it.
        """
        others, _ = to_frenet(problem.others, problem.road.path, {})
        return cls(
            road=problem.road, vehicle=problem.vehicle, t=np.linspace(0.0, problem.duration, intervals + 1),
            others=others, v_wanted=problem.v_x, clearance=problem.clearance, a_y_max=problem.a_y_max,
            final=(0.0, 0.0), goal=problem.goal,
        )  # fmt: skip

    @property
    def step(self) -> float:
        """Length of an interval [s]."""
        return float(self.t[1] - self.t[0])

    @property
    def edges(self) -> tuple[float, float]:
        """Least and largest lateral coordinate of the ego's center line on the road [m]."""
        half = 0.5 * self.vehicle.width
        return self.road.right_edge + half, self.road.left_edge - half

    def places(self) -> Array:
        """Where the others are.

        Returns
        -------
        s : ndarray, shape (m, n + 1)
            Path coordinates of their centers [m].
        """
        s = np.empty((len(self.others), len(self.t)))
        for row, other in zip(s, self.others, strict=True):
            row[:] = other.s + np.copysign(1.0, other.v_s) * predict_distance(
                abs(other.v_s), other.remote.a_x, self.t
            )
        return s

    def swept(self) -> Array:
        """Half lengths of the others, grown by half of what they move in an interval, seen from the ego.

        Returns
        -------
        half_length : ndarray, shape (m,)
            Half lengths [m].
        """
        return np.array([o.half_length + 0.5 * self.step * abs(self.v_wanted - o.v_s) for o in self.others])


@dataclass(frozen=True, slots=True, kw_only=True)
class FrenetState:
    """The ego on its route.

    Parameters
    ----------
    s, d : float
        Center of gravity [m], d left positive.
    angle : float
        Its course relative to the route [rad], counter-clockwise.
    v : float
        Speed [m/s].
    kappa : float
        Curvature of its way [1/m], left turn positive.
    a_x : float
        Acceleration [m/s^2].
    """

    s: float
    d: float = 0.0
    angle: float = 0.0
    v: float = 0.0
    kappa: float = 0.0
    a_x: float = 0.0
