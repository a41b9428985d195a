"""A plan driven on a car whose tires can slide."""

from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array
from cca_core.baselines.problem import Plan, Problem
from cca_core.baselines.verify import body_along, edge_distance, jerk_of
from cca_core.follow import PreviewController, steady_turn
from cca_core.geometry import box_gap
from cca_core.path import Path, interpolate_path
from cca_core.sim.handling.tracking import track_path
from cca_core.sim.plants.single_track import SingleTrackPlant
from cca_core.vehicle import VehicleParams, VehicleState

__all__ = ["DriveResult", "drive_plan"]

_CYCLE = 0.02  # of `track` [s]
_NODE = 1.0  # between nodes of the path that is followed [m]
_ON = 60.0  # of the route behind the plan [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DriveResult:
    """What happened on the road.

    Parameters
    ----------
    finished : bool
        Whether the end of the plan was reached within 5 m of it.
    clearance : float
        Least distance between the bodies [m].
    edge : float
        Least distance of the body to the edges [m], negative outside.
    tracking : float
        Largest distance of the center of gravity from the plan [m].
    a_y : float
        Largest lateral acceleration [m/s^2], without sign.
    jerk : float
        Largest change of it within 0.1 s, over this time [m/s^3].
    xy : ndarray, shape (n, 2)
        Where the center of gravity was, every 20 ms [m].
    """

    finished: bool
    clearance: float
    edge: float
    tracking: float
    a_y: float
    jerk: float
    xy: Array


class _Recorded(SingleTrackPlant):
    """A car that remembers where it was."""

    def __init__(self, vehicle: VehicleParams, state: VehicleState) -> None:
        super().__init__(vehicle, state)
        self.poses: list[tuple[float, float, float]] = []

    def step(self, delta: float, a_x: float, dt: float) -> None:
        now = self.state
        self.poses.append((now.x, now.y, now.psi))
        super().step(delta, a_x, dt)


def drive_plan(problem: Problem, plan: Plan) -> DriveResult:
    """Follow a plan with the steering and the speed control of this library.

    Parameters
    ----------
    problem : Problem
        Vehicle, start and others, who move as predicted.
    plan : Plan
        A trajectory.

    Returns
    -------
    drive : Drive
        What happened; the car begins on the route, along it, at the wanted speed, whatever the plan says.

    Raises
    ------
    InputError
        If the plan has no usable trajectory.
    """
    path, squared = _followed(problem, plan)
    car = _Recorded(
        problem.vehicle, steady_turn(problem.road.path, problem.start, problem.v_x, problem.vehicle)
    )
    steering = PreviewController(problem.vehicle)
    run = track_path(car, steering.steer, path, squared, margin=_ON)
    x, y, psi = np.array(car.poses).T
    t: Array = _CYCLE * np.arange(len(run.a_y), dtype=np.float64)
    body = body_along(problem, np.column_stack((x, y)), psi)
    return DriveResult(
        finished=run.finished,
        clearance=min((float(box_gap(body, b).min()) for b in problem.boxes_at(t[: len(x)])), default=np.inf),
        edge=edge_distance(problem, body), tracking=float(np.abs(run.d).max()),
        a_y=float(np.abs(run.a_y).max()), jerk=jerk_of(t, run.a_y),
        xy=np.column_stack((x, y)),
    )  # fmt: skip


def _followed(problem: Problem, plan: Plan) -> tuple[Path, tuple[Array, Array]]:
    """Path along a plan and then along the route beside it, and squares of speeds over it."""
    moved = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(plan.xy, axis=0).T))))
    nodes = np.linspace(0.0, moved[-1], max(round(moved[-1] / _NODE), 4) + 1)
    xy = np.column_stack([np.interp(nodes, moved, plan.xy[:, i]) for i in (0, 1)])
    s, d = problem.road.path.project(xy[-1])
    on = problem.road.path.to_cartesian(float(s) + np.arange(1.0, _ON + 0.5), float(d))
    first = plan.xy[1] - plan.xy[0]
    path = interpolate_path(np.vstack((xy, on)), start_tangent=first)
    speeds = np.interp(nodes, moved, plan.v_x)
    places = np.append(nodes, path.end)
    return path, (places, np.append(speeds, speeds[-1]) ** 2)
