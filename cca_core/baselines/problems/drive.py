"""Plans driven by a car with limited tire grip."""

from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array
from cca_core._repr import short_repr
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.baselines.problems.verify import edge_distance, max_jerk
from cca_core.follow import PreviewController, steady_turn
from cca_core.geometry import arc_length, box_gap
from cca_core.path import Path, interpolate_path
from cca_core.sim.handling.tracking import track_path
from cca_core.sim.loop import CYCLE_TIME
from cca_core.sim.plants.single_track import SingleTrackPlant
from cca_core.vehicle import VehicleParams, VehicleState

_RUN_OUT = 60.0  # of the route behind the plan, so that the preview does not end [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DriveResult:
    """Motion of a car that follows a plan.

    Parameters
    ----------
    finished : bool
        Whether the car reached the end of the plan within 5 m of it.
    clearance : float
        Smallest distance between the bodies [m].
    edge : float
        Smallest distance of the body to the road edges [m], negative outside.
    tracking : float
        Largest distance of the center of gravity from the plan [m].
    a_y : float
        Largest absolute lateral acceleration [m/s^2].
    jerk : float
        Largest change of the lateral acceleration within 0.1 s, divided by this time [m/s^3].
    xy : ndarray, shape (n, 2)
        Center of gravity every 20 ms [m].
    """

    finished: bool
    clearance: float
    edge: float
    tracking: float
    a_y: float
    jerk: float
    xy: Array

    __repr__ = short_repr


class _RecordingPlant(SingleTrackPlant):
    """Single-track plant that records its poses."""

    def __init__(self, vehicle: VehicleParams, state: VehicleState) -> None:
        super().__init__(vehicle, state)
        self.poses: list[tuple[float, float, float]] = []

    def step(self, delta: float, a_x: float, dt: float) -> None:
        now = self.state
        self.poses.append((now.x, now.y, now.psi))
        super().step(delta, a_x, dt)


def drive_plan(problem: Problem, plan: Plan) -> DriveResult:
    """Follow a plan with the preview steering and the speed control of this library.

    Parameters
    ----------
    problem : Problem
        Vehicle, start and other vehicles, which move as predicted.
    plan : Plan
        A trajectory.

    Returns
    -------
    driven : DriveResult
        The motion. The car starts on the route, along it, at the wanted speed, whatever the plan is.

    Raises
    ------
    InputError
        If the plan has no usable trajectory.
    """
    path, squared_speed = _path_to_follow(problem, plan)
    start = steady_turn(problem.road.path, problem.start, problem.v_x, problem.vehicle)
    car = _RecordingPlant(problem.vehicle, start)
    run = track_path(car, PreviewController(problem.vehicle).steer, path, squared_speed, margin=_RUN_OUT)
    x, y, psi = np.array(car.poses).T
    t: Array = CYCLE_TIME * np.arange(len(run.a_y), dtype=np.float64)
    body = problem.vehicle.body_at(x, y, psi)
    return DriveResult(
        finished=run.finished,
        clearance=min((float(box_gap(body, b).min()) for b in problem.boxes_at(t[: len(x)])), default=np.inf),
        edge=edge_distance(problem, body), tracking=float(np.abs(run.d).max()),
        a_y=float(np.abs(run.a_y).max()), jerk=max_jerk(t, run.a_y), xy=np.column_stack((x, y)),
    )  # fmt: skip


def _path_to_follow(problem: Problem, plan: Plan) -> tuple[Path, tuple[Array, Array]]:
    """Path along a plan and then parallel to the route; squares of the speeds at arc lengths."""
    distance = arc_length(plan.xy)
    nodes = np.linspace(0.0, distance[-1], max(round(distance[-1]), 4) + 1)  # about 1 m apart
    xy = np.column_stack([np.interp(nodes, distance, plan.xy[:, i]) for i in (0, 1)])
    s, d = problem.road.path.project(xy[-1])
    beyond = problem.road.path.to_cartesian(float(s) + np.arange(1.0, _RUN_OUT + 0.5), float(d))
    path = interpolate_path(np.vstack((xy, beyond)), start_tangent=plan.xy[1] - plan.xy[0])
    speed = np.interp(nodes, distance, plan.v_x)
    return path, (np.append(nodes, path.end), np.append(speed, speed[-1]) ** 2)
