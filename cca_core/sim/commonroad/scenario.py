"""A recorded world: lanelets, obstacles that move as they did, and what the ego is asked to do."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array
from cca_core.sim.commonroad.lanelets import Lanelet, inside
from cca_core.vehicle import RemoteVehicle, VehicleState

__all__ = ["CommonRoadScenario", "Goal", "PlanningProblem", "RecordedObstacle"]

_SOON = 1e-6  # tolerance of times [s]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordedObstacle:
    """Something that stands or moves as recorded, whatever the ego does.

    Parameters
    ----------
    id : str
        Its name in the file.
    kind : str
        Type such as ``"car"``.
    length, width : float
        Box around its body [m].
    t : ndarray, shape (n,)
        Times of its states [s], increasing.
    states : ndarray, shape (n, 4)
        x [m], y [m], psi [rad], v_x [m/s] of the box's center; psi without jumps of a full turn.
    static : bool
        Whether it stands there all the time; else it is there from its first to its last state.
    """

    id: str
    kind: str
    length: float
    width: float
    t: Array
    states: Array
    static: bool

    def at(self, t: float) -> RemoteVehicle | None:
        """Look at it at a time.

        Parameters
        ----------
        t : float
            Time [s].

        Returns
        -------
        vehicle : RemoteVehicle or None
            Its motion, linear between two states; acceleration and yaw rate are the slopes of speed and
            heading there. None if it is not there then.
        """
        if not self.static and not self.t[0] - _SOON <= t <= self.t[-1] + _SOON:
            return None
        i, share, span = 0, 0.0, math.inf
        if len(self.t) > 1:
            i = min(max(int(np.searchsorted(self.t, t + _SOON)) - 1, 0), len(self.t) - 2)
            span = float(self.t[i + 1] - self.t[i])
            share = min(max((t - float(self.t[i])) / span, 0.0), 1.0)
        here, there = self.states[i].tolist(), self.states[min(i + 1, len(self.t) - 1)].tolist()
        x, y, psi, v_x = (a + share * (b - a) for a, b in zip(here, there, strict=True))
        return RemoteVehicle(
            id=self.id, x=x, y=y, psi=psi, v_x=v_x, a_x=(there[3] - here[3]) / span,
            r=(there[2] - here[2]) / span, length=self.length, width=self.width, source="sensor",
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Goal:
    """When, where and how the ego shall arrive.

    Parameters
    ----------
    t : tuple of float
        First and last time [s].
    regions : tuple of ndarray, each of shape (n, 2)
        Polygons of which one must hold the ego's reference point [m]; none: anywhere.
    lanelets : tuple of int
        Lanelets that the file names as goal; their outlines are among the regions.
    v_x : tuple of float or None
        Least and largest speed [m/s].
    psi : tuple of float or None
        Interval of heading, counter-clockwise from the first to the second [rad].
    """

    t: tuple[float, float]
    regions: tuple[Array, ...] = ()
    lanelets: tuple[int, ...] = ()
    v_x: tuple[float, float] | None = None
    psi: tuple[float, float] | None = None

    def reached(self, t: float, state: VehicleState) -> bool:
        """Tell whether the goal is reached.

        Parameters
        ----------
        t : float
            Time [s].
        state : VehicleState
            The ego.

        Returns
        -------
        reached : bool
            Whether time, place, speed and heading all fit; the limits belong to the intervals.
        """
        if not self.t[0] - _SOON <= t <= self.t[1] + _SOON:
            return False
        if self.v_x is not None and not self.v_x[0] <= state.v_x <= self.v_x[1]:
            return False
        if self.psi is not None and (state.psi - self.psi[0]) % math.tau > self.psi[1] - self.psi[0]:
            return False
        return not self.regions or any(inside(region, state.x, state.y) for region in self.regions)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlanningProblem:
    """One ego: where it begins and where it is to go.

    Parameters
    ----------
    id : int
        Its name in the file [-].
    t : float
        When it begins [s].
    state : VehicleState
        Its motion then, at its reference point.
    goals : tuple of Goal
        One of them shall be reached.
    """

    id: int
    t: float
    state: VehicleState
    goals: tuple[Goal, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CommonRoadScenario:
    """What a CommonRoad file holds.

    Parameters
    ----------
    name : str
        Its benchmark id.
    dt : float
        Time step of the recording [s].
    lanelets : mapping of int to Lanelet
        The road network, read-only.
    obstacles : tuple of RecordedObstacle
        The others.
    problems : tuple of PlanningProblem
        At least one.
    """

    name: str
    dt: float
    lanelets: Mapping[int, Lanelet]
    obstacles: tuple[RecordedObstacle, ...]
    problems: tuple[PlanningProblem, ...]
