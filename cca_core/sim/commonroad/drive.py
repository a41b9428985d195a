"""Drive through a recorded world: its route and road, a speed that fits the goal, and the closed loop."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.follow import SpeedSettings, steady_steering
from cca_core.geometry import box_gap, boxes
from cca_core.path import Road
from cca_core.planner.planner import Planner
from cca_core.sim.commonroad.goal_route import cruise_speed, goal_road
from cca_core.sim.commonroad.scenario import CommonRoadScenario, PlanningProblem
from cca_core.sim.plants.multi_body import MultiBodyPlant
from cca_core.sim.plants.single_track import SingleTrackPlant
from cca_core.vehicle import VehicleParams, VehicleState

__all__ = ["CommonRoadRun", "drive_commonroad"]

_CYCLE = 0.02  # longest step of the closed loop [s]
_MOVES = 1.0  # slower than this the ego begins with straight wheels [m/s]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CommonRoadRun:
    """What happened on a drive through a recorded world, cycle by cycle.

    Parameters
    ----------
    scenario : CommonRoadScenario
        What was driven.
    problem : PlanningProblem
        Which ego's task.
    vehicle : VehicleParams
        The ego.
    plant : str
        Name of its plant.
    road : Road
        Its route and lanes.
    cruise_speed : float
        Its wanted speed [m/s].
    t : ndarray, shape (n,)
        Time [s].
    ego : ndarray, shape (n, 8)
        x [m], y [m], psi [rad], v_x [m/s], v_y [m/s], r [rad/s], delta [rad], a_x [m/s^2].
    a_y : ndarray, shape (n,)
        Lateral acceleration of the center of gravity [m/s^2], left positive.
    ego_frenet : ndarray, shape (n, 2)
        Ego in path coordinates s, d [m].
    gaps : ndarray, shape (n, n_obstacles)
        Signed distance between the ego's box and each other's [m]; infinite while the other is not there.
    decisions : tuple of (float, str, str)
        Time [s], action and reason at each change of action.
    dropped : tuple of str
        What the planner could not use, with the reason.
    t_goal : float or None
        When the goal was reached [s].
    """

    scenario: CommonRoadScenario
    problem: PlanningProblem
    vehicle: VehicleParams
    plant: str
    road: Road
    cruise_speed: float
    t: Array
    ego: Array
    a_y: Array
    ego_frenet: Array
    gaps: Array
    decisions: tuple[tuple[float, str, str], ...]
    dropped: tuple[str, ...]
    t_goal: float | None

    def summary(self) -> dict[str, Any]:
        """Key figures of the run.

        Returns
        -------
        summary : dict
            Outcome, time at the goal [s], gap [m], speeds [m/s], accelerations [m/s^2], actions with their
            times [s]. The goal counts as reached only if nothing was touched.
        """
        least = self.gaps.min(axis=0, initial=math.inf)
        hit = [o.id for o, gap in zip(self.scenario.obstacles, least, strict=True) if gap <= 0.0]
        gap = float(least.min(initial=math.inf))
        return {
            "scenario": self.scenario.name,
            "plant": self.plant,
            "reached": self.t_goal is not None and not hit,
            "t_goal_s": None if self.t_goal is None else round(self.t_goal, 3),
            "collided_with": hit,
            "min_gap_m": round(gap, 3) if math.isfinite(gap) else None,
            "cruise_speed_mps": round(self.cruise_speed, 3),
            "final_speed_mps": round(float(self.ego[-1, 3]), 3),
            "max_abs_ay_mps2": round(float(np.abs(self.a_y).max()), 3),
            "max_decel_mps2": round(max(0.0, -float(self.ego[:, 7].min())), 3),
            "max_offset_m": round(float(np.abs(self.ego_frenet[:, 1]).max()), 3),
            "actions": [[round(t, 2), name] for t, name, _ in self.decisions],
            "dropped": list(self.dropped),
        }


def drive_commonroad(
    scenario: CommonRoadScenario,
    *,
    problem: int = 0,
    plant: str = "single_track",
    vehicle: VehicleParams | None = None,
    speed: SpeedSettings | None = None,
    toward: int | None = None,
) -> CommonRoadRun:
    """Drive a planning problem of a CommonRoad scenario, to its goal or to the end of its time.

    Parameters
    ----------
    scenario : CommonRoadScenario
        As `read_commonroad` gives it.
    problem : int
        Index of the planning problem [-].
    plant : {"single_track", "multi_body"}
        What is driven; the multi-body car (extra ``plant``) is a BMW 320i.
    vehicle : VehicleParams, optional
        The ego; the default is the BMW 320i.
    speed : SpeedSettings, optional
        How the ego accelerates, follows and brakes.
    toward : int, optional
        Lanelet [-] to which the route leads if the goal is no place.

    Returns
    -------
    run : CommonRoadRun
        Every cycle. Not to reach the goal is an outcome, not an error.

    Raises
    ------
    InputError
        If an argument is out of range, the ego starts on no lanelet, no goal can be reached on the
        lanelets, or the center line cannot be made a path.
    MissingExtraError
        If the multi-body plant is asked for and not installed.

    Notes
    -----
    The planner knows of each recorded obstacle exactly where it is now and how it moves, not what it will
    do. Recorded cars do not react: they may run into an ego that is slower than the recorded one was.

    The route is the shortest way on the lanelets; a lane change on the way is part of it, and nobody looks
    behind for it. A lane beside the route counts if it is there, with the same direction, all the way to
    the goal. If the goal is no place, the route goes straight on, or `toward` a lanelet. The wanted speed
    is the one nearest to the initial speed with which an undisturbed ego arrives in the goal's window of
    time, with its speed.
    """
    if not isinstance(scenario, CommonRoadScenario):
        raise InputError(f"scenario must be a CommonRoadScenario, was {type(scenario).__name__}")
    if problem not in range(len(scenario.problems)):
        raise InputError(f"problem must be 0 to {len(scenario.problems) - 1}, was {problem!r}")
    task, speed, bmw = scenario.problems[problem], speed or SpeedSettings(), VehicleParams.bmw_320i()
    vehicle = vehicle or bmw
    if plant not in ("single_track", "multi_body"):
        raise InputError(f"plant must be 'single_track' or 'multi_body', was {plant!r}")
    if plant == "multi_body" and vehicle != bmw:
        raise InputError("vehicle must be the BMW 320i for the multi-body plant")
    if toward is not None and toward not in scenario.lanelets:
        raise InputError(f"toward must be the id of a lanelet, was {toward!r}")
    road, goal, s_goal = goal_road(scenario, task, speed, toward)
    cruise = cruise_speed(road.path, task, goal, s_goal, speed)
    planner = Planner(vehicle, road, cruise_speed=cruise, speed=speed)
    start = _at_center_of_gravity(task.state, vehicle)
    car = SingleTrackPlant(vehicle, start) if plant == "single_track" else MultiBodyPlant(start)
    step = scenario.dt / math.ceil(scenario.dt / _CYCLE - 1e-9)  # so that time steps are cycles
    n = max(1, round((max(g.t[1] for g in task.goals) - task.t) / step) + 1)
    rows, gaps = np.empty((n, 12)), np.full((n, len(scenario.obstacles)), np.inf)
    decisions: list[tuple[float, str, str]] = []
    dropped: set[str] = set()
    s, t_goal = float(road.path.project((start.x, start.y))[0]), None
    for k in range(n):
        t, state = task.t + k * step, car.state
        seen = [obstacle.at(t) for obstacle in scenario.obstacles]
        there = [i for i, remote in enumerate(seen) if remote is not None]
        remotes = [remote for remote in seen if remote is not None]
        command = planner.step(t, state, remotes)
        s, d, _, _ = road.path.foot_point(state.x, state.y, s)
        rows[k] = (
            t, state.x, state.y, state.psi, state.v_x, state.v_y, state.r, state.delta, state.a_x,
            car.a_y, s, d,
        )  # fmt: skip
        x, y = vehicle.center_at(state.x, state.y, state.psi)
        if remotes:
            others = np.array([(r.x, r.y, r.psi, r.length, r.width) for r in remotes]).T
            gaps[k, there] = box_gap(boxes(x, y, state.psi, vehicle.length, vehicle.width), boxes(*others))
        dropped.update(f"{id_}: {reason}" for id_, reason in command.dropped)
        name = command.decision.action.value
        if not decisions or decisions[-1][1] != name:
            decisions.append((t, name, command.decision.reason))
        body = VehicleState(x=x, y=y, psi=state.psi, v_x=state.v_x)
        if any(g.reached(t, body) for g in task.goals):
            t_goal, n = t, k + 1
            break
        car.step(command.delta, command.a_x, step)
    rows = rows[:n]
    return CommonRoadRun(
        scenario=scenario, problem=task, vehicle=vehicle, plant=plant, road=road, cruise_speed=cruise,
        t=rows[:, 0], ego=rows[:, 1:9], a_y=rows[:, 9], ego_frenet=rows[:, 10:12], gaps=gaps[:n],
        decisions=tuple(decisions), dropped=tuple(sorted(dropped)), t_goal=t_goal,
    )  # fmt: skip


def _at_center_of_gravity(state: VehicleState, vehicle: VehicleParams) -> VehicleState:
    """Turn a motion of the body's center into that of the center of gravity, the wheels turned to match."""
    kappa = state.r / state.v_x if state.v_x > _MOVES else 0.0
    return replace(
        state,
        x=state.x - vehicle.box_offset * math.cos(state.psi),
        y=state.y - vehicle.box_offset * math.sin(state.psi),
        v_y=state.v_y - vehicle.box_offset * state.r,
        delta=float(steady_steering(kappa, state.v_x, vehicle)),
    )
