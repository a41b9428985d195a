"""Settings and horizon that both model predictive controllers share."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cca_core._checks import Array, check_real, check_reals
from cca_core._repr import short_repr
from cca_core.baselines.problems.problem import Problem
from cca_core.errors import InputError
from cca_core.frenet import FrenetVehicle, to_frenet
from cca_core.path import Road
from cca_core.predict import predict_distance
from cca_core.vehicle import VehicleParams

SAMPLES = 5
"""Samples of a trajectory per interval of the horizon."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MpcSettings:
    """Horizon, limits and weights; the cost is an integral over time of weighted squares.

    Parameters
    ----------
    intervals : int
        Intervals of the horizon [-].
    horizon : float
        Length of the horizon in closed loop [s]; a single plan extends to its goal.
    clearance : float
        Clearance in closed loop [m]; a single plan has that of its problem.
    a_y_max : float
        Largest lateral acceleration in closed loop [m/s^2]; a single plan has that of its problem.
    b_max, a_max, jerk_max : float
        Largest deceleration [m/s^2], acceleration [m/s^2] and longitudinal jerk [m/s^3]; nonlinear only.
    weight_d : float
        Of the lateral offset [1/m^2].
    weight_a : float
        Of the lateral acceleration relative to the road [s^4/m^2].
    weight_jerk : float
        Of the lateral and longitudinal jerk [s^6/m^2].
    weight_v : float
        Of the difference to the wanted speed [s^2/m^2]; nonlinear only.
    weight_a_x : float
        Of the longitudinal acceleration [s^4/m^2]; nonlinear only.
    corridor_penalty : float
        Weight of the squared distance outside the corridor [1/m^2]; linear only.
    vehicle_penalty : float
        Weight of the overlap with a vehicle, in half widths [-]; nonlinear only. It is exact: the overlap is
        zero if that is feasible.
    corridor_margins : tuple of float
        Margins of the corridor [m]: the next one is tried if the motion between nodes violates the clearance;
        linear only.
    vehicle_margin : float
        Lateral margin beyond the clearance [m]; nonlinear only.
    guess_margin : float
        Clearance that the initial guess has in addition [m]; nonlinear only.
    a_y_fraction : float
        Fraction of the lateral acceleration that the linear model uses [-].
    heading_tolerance : float
        Largest heading relative to the route at the end in closed loop [rad]; nonlinear only.
    min_model_speed : float
        Speed below which the linear model stays as it is there [m/s].
    max_side_choices : int
        Side choices that are solved until one keeps every limit [-]; linear only.
    iterations : int
        Largest number of iterations of the solver [-].
    cpu_time : float
        Time after which the solver stops [s].
    solver : {"ipopt", "fatrop"}
        Solver of the nonlinear program; FATROP has no time limit.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    intervals: int = 40
    horizon: float = 10.0
    clearance: float = 0.5
    a_y_max: float = 3.0
    b_max: float = 7.0
    a_max: float = 2.0
    jerk_max: float = 12.0
    weight_d: float = 1.0
    weight_a: float = 0.3
    weight_jerk: float = 0.3
    weight_v: float = 0.5
    weight_a_x: float = 0.5
    corridor_penalty: float = 1e5
    vehicle_penalty: float = 1e3
    corridor_margins: tuple[float, ...] = (0.03, 0.12)
    vehicle_margin: float = 0.03
    guess_margin: float = 0.2
    a_y_fraction: float = 0.97
    heading_tolerance: float = 0.05
    min_model_speed: float = 2.0
    max_side_choices: int = 3
    iterations: int = 80
    cpu_time: float = 0.5
    solver: Literal["ipopt", "fatrop"] = "ipopt"

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for name, lowest in (("intervals", 5), ("max_side_choices", 1), ("iterations", 1)):
            value = getattr(self, name)
            if not isinstance(value, int) or not lowest <= value <= 1000:
                raise InputError(f"{name} must be a whole number from {lowest} to 1000, was {value!r}")
        for name in (
            "horizon", "a_y_max", "b_max", "a_max", "jerk_max", "weight_d", "weight_a", "weight_jerk",
            "corridor_penalty", "vehicle_penalty", "heading_tolerance", "min_model_speed", "cpu_time",
        ):  # fmt: skip
            check_real(name, getattr(self, name), gt=0.0)
        for name in ("clearance", "weight_v", "weight_a_x", "vehicle_margin", "guess_margin"):
            check_real(name, getattr(self, name), ge=0.0)
        check_real("a_y_fraction", self.a_y_fraction, gt=0.0, le=1.0)
        if not check_reals("corridor_margins", self.corridor_margins, ge=0.0):
            raise InputError("corridor_margins must contain a margin, was empty")
        if self.solver not in ("ipopt", "fatrop"):
            raise InputError(f"solver must be 'ipopt' or 'fatrop', was {self.solver!r}")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Horizon:
    """Time span of a plan, with its limits and all other vehicles."""

    road: Road
    vehicle: VehicleParams
    t: Array  # (n + 1,): equidistant times from now [s]
    others: Sequence[FrenetVehicle]  # they keep lateral offset and speed; a braking one stops
    v_wanted: float
    clearance: float
    a_y_max: float
    final_d: tuple[float, float]  # smallest and largest lateral offset at the end [m]
    clearance_fraction: float = 1.0  # of the clearance, below which a trajectory is rejected
    goal: float = -np.inf  # smallest station at the end [m]

    @classmethod
    def of(cls, problem: Problem, intervals: int) -> "Horizon":
        """Horizon from start to goal, which ends on the route at the goal or beyond it."""
        others, _ = to_frenet(problem.others, problem.road.path, {})
        return cls(
            road=problem.road, vehicle=problem.vehicle, t=np.linspace(0.0, problem.duration, intervals + 1),
            others=others, v_wanted=problem.v_x, clearance=problem.clearance, a_y_max=problem.a_y_max,
            final_d=(0.0, 0.0), goal=problem.goal,
        )  # fmt: skip

    @property
    def step(self) -> float:
        """Length of an interval [s]."""
        return float(self.t[1] - self.t[0])

    @property
    def edges(self) -> tuple[float, float]:
        """Smallest and largest lateral offset of the ego's center line on the road [m]."""
        half = 0.5 * self.vehicle.width
        return self.road.right_edge + half, self.road.left_edge - half

    def stations(self) -> Array:
        """Stations (m, n + 1) of the centers of the other vehicles [m]."""
        s = np.empty((len(self.others), len(self.t)))
        for row, other in zip(s, self.others, strict=True):
            distance = predict_distance(abs(other.v_s), other.remote.a_x, self.t)
            row[:] = other.s + np.copysign(1.0, other.v_s) * distance
        return s

    def swept_half_lengths(self) -> Array:
        """Half lengths (m,) of the vehicles, plus half of their relative motion per interval [m]."""
        return np.array([o.half_length + 0.5 * self.step * abs(self.v_wanted - o.v_s) for o in self.others])


@dataclass(frozen=True, slots=True, kw_only=True)
class FrenetState:
    """The ego in Frenet coordinates."""

    s: float  # of the center of gravity [m]
    d: float = 0.0
    angle: float = 0.0  # of the velocity relative to the route [rad], counter-clockwise
    v: float = 0.0
    kappa: float = 0.0  # curvature of the trajectory [1/m], left positive
    a_x: float = 0.0
