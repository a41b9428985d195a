"""A recorded scenario: lanelets, obstacles on their recorded motion, and planning problems of the ego."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array
from cca_core._repr import short_repr
from cca_core.sim.commonroad.lanelets import Lanelet, inside
from cca_core.vehicle import RemoteVehicle, VehicleState

__all__ = ["CommonRoadScenario", "Goal", "PlanningProblem", "RecordedObstacle"]

_TIME_TOLERANCE = 1e-6  # [s]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordedObstacle:
    """An obstacle on its recorded motion, whatever the ego does."""

    id: str
    kind: str  # such as "car"
    length: float  # of the box around the body [m]
    width: float
    t: Array  # times of the states [s], increasing
    states: Array  # x, y [m], psi [rad] (continuous), v_x [m/s] of the box's center
    static: bool  # always present; else from the first to the last state

    def at(self, t: float) -> RemoteVehicle | None:
        """Return the obstacle at a time [s], interpolated between its states; None before and after them."""
        if not self.static and not self.t[0] - _TIME_TOLERANCE <= t <= self.t[-1] + _TIME_TOLERANCE:
            return None
        i, fraction, span = 0, 0.0, math.inf
        if len(self.t) > 1:
            i = min(max(int(np.searchsorted(self.t, t + _TIME_TOLERANCE)) - 1, 0), len(self.t) - 2)
            span = float(self.t[i + 1] - self.t[i])
            fraction = min(max((t - float(self.t[i])) / span, 0.0), 1.0)
        here, there = self.states[i].tolist(), self.states[min(i + 1, len(self.t) - 1)].tolist()
        x, y, psi, v_x = (a + fraction * (b - a) for a, b in zip(here, there, strict=True))
        return RemoteVehicle(
            id=self.id, x=x, y=y, psi=psi, v_x=v_x, a_x=(there[3] - here[3]) / span,
            r=(there[2] - here[2]) / span, length=self.length, width=self.width, source="sensor",
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Goal:
    """Time, position, speed and heading of an arrival; limits belong to their intervals."""

    t: tuple[float, float]  # first and last time [s]
    regions: tuple[Array, ...] = ()  # polygons [m]; one must hold the body's center, unless empty
    lanelets: tuple[int, ...] = ()  # named as goal; their outlines are among the regions
    v_x: tuple[float, float] | None = None  # minimum and maximum [m/s]
    psi: tuple[float, float] | None = None  # counter-clockwise from the first to the second [rad]

    def reached(self, t: float, state: VehicleState) -> bool:
        """Return whether time, position, speed and heading of a body are within the goal's intervals."""
        if not self.t[0] - _TIME_TOLERANCE <= t <= self.t[1] + _TIME_TOLERANCE:
            return False
        if self.v_x is not None and not self.v_x[0] <= state.v_x <= self.v_x[1]:
            return False
        if self.psi is not None and (state.psi - self.psi[0]) % math.tau > self.psi[1] - self.psi[0]:
            return False
        return not self.regions or any(inside(region, state.x, state.y) for region in self.regions)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlanningProblem:
    """Start and goals of one ego."""

    id: int
    t: float  # start [s]
    state: VehicleState  # motion of the body's center at the start
    goals: tuple[Goal, ...]  # of which one must be reached


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CommonRoadScenario:
    """Contents of a CommonRoad file.

    Parameters
    ----------
    name : str
        Benchmark id.
    dt : float
        Time step of the recording [s].
    lanelets : mapping of int to Lanelet
        The road network, read-only.
    obstacles : tuple of RecordedObstacle
        All other vehicles and obstacles.
    problems : tuple of PlanningProblem
        Planning problems; a map may have none.
    left_out, changed : tuple of str
        Elements of the file that were left out, or read otherwise than they stand there, each with the
        reason.
    """

    name: str
    dt: float
    lanelets: Mapping[int, Lanelet]
    obstacles: tuple[RecordedObstacle, ...]
    problems: tuple[PlanningProblem, ...]
    left_out: tuple[str, ...] = ()
    changed: tuple[str, ...] = ()

    __repr__ = short_repr
