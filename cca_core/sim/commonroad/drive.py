"""Closed loop in a recorded scenario, along a route at a speed that meets the goal."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cca_core._checks import Array
from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.follow import SpeedSettings, steady_steering
from cca_core.geometry import box_gap, boxes, wrap_angle
from cca_core.path import Road
from cca_core.planner import EvasionSettings, Planner
from cca_core.sim.commonroad.goal_route import GoalSettings, cruise_speed, goal_road
from cca_core.sim.commonroad.scenario import CommonRoadScenario, PlanningProblem, RecordedObstacle
from cca_core.sim.plants.build import PLANTS, make_plant
from cca_core.sim.plants.multi_body import MultiBodyPlant
from cca_core.sim.plants.plant import Plant
from cca_core.sim.world.traffic import CYCLE_TIME
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState

__all__ = ["CommonRoadRun", "drive_commonroad"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CommonRoadRun:
    """One run in a recorded scenario, cycle by cycle.

    Parameters
    ----------
    scenario : CommonRoadScenario
        Recorded scenario.
    problem : PlanningProblem
        Planning problem of the ego.
    vehicle : VehicleParams
        The ego.
    plant : str
        Name of its plant.
    road : Road
        Its route and lanes.
    cruise_speed : float
        Its cruise speed [m/s].
    t : ndarray, shape (n,)
        Time [s].
    ego : ndarray, shape (n, 8)
        x [m], y [m], psi [rad], v_x [m/s], v_y [m/s], r [rad/s], delta [rad], a_x [m/s^2].
    a_y : ndarray, shape (n,)
        Lateral acceleration of the center of gravity [m/s^2], left positive.
    ego_frenet : ndarray, shape (n, 2)
        Frenet coordinates s, d of the ego's center of gravity [m].
    gaps : ndarray, shape (n, n_obstacles)
        Signed distance between the boxes of the ego and of each obstacle [m]; infinite while the obstacle is
        absent.
    decisions : tuple of (float, str, str)
        Time [s], action and reason at each change of action.
    cycle_reasons : tuple of str
        Reason of the command of each cycle.
    dropped : tuple of str
        Remote vehicles that the planner could not use, with the reason.
    t_goal : float or None
        Time at which the goal was reached [s].
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
    cycle_reasons: tuple[str, ...]
    dropped: tuple[str, ...]
    t_goal: float | None

    __repr__ = short_repr

    def summary(self) -> dict[str, Any]:
        """Key figures of the run.

        Returns
        -------
        summary : dict
            Outcome, time at the goal [s], gap [m], speeds [m/s], accelerations [m/s^2], actions with their
            times [s]. The goal counts as reached only if there was no collision.
        """
        min_gaps = self.gaps.min(axis=0, initial=math.inf)
        collided = [o.id for o, gap in zip(self.scenario.obstacles, min_gaps, strict=True) if gap <= 0.0]
        gap = float(min_gaps.min(initial=math.inf))
        return {
            "scenario": self.scenario.name,
            "plant": self.plant,
            "reached": self.t_goal is not None and not collided,
            "t_goal_s": None if self.t_goal is None else round(self.t_goal, 3),
            "collided_with": collided,
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
    evasion: EvasionSettings | None = None,
    toward: int | None = None,
    settings: GoalSettings | None = None,
) -> CommonRoadRun:
    """Drive a planning problem of a CommonRoad scenario until its goal or its last time.

    Parameters
    ----------
    scenario : CommonRoadScenario
        As from `read_commonroad`.
    problem : int
        Index of the planning problem [-].
    plant : {"single_track", "multi_body"}
        The ego's plant; the multi-body car (extra ``plant``) is a BMW 320i.
    vehicle : VehicleParams, optional
        The ego; the default is the BMW 320i.
    speed : SpeedSettings, optional
        Settings of longitudinal control.
    evasion : EvasionSettings, optional
        What the ego assumes of others, and how it passes them.
    toward : int, optional
        Lanelet [-] to which the route leads if the goal has no region.
    settings : GoalSettings, optional
        Settings of the road and the cruise speed to the goal.

    Returns
    -------
    run : CommonRoadRun
        Every cycle. A goal that is not reached is a result, not an error.

    Raises
    ------
    InputError
        If an argument is out of range, the ego starts on no lanelet, no goal is reachable on the lanelets, or
        no path fits the centerline.
    MissingExtraError
        If the multi-body plant is not installed.

    Notes
    -----
    An obstacle that lies on the ego at the start, with its heading and speed, is the ego's own recording. It
    is left out, and named in ``dropped`` and ``scenario.left_out`` of the run.

    The planner knows the exact position and motion of each recorded obstacle now, not its future. Recorded
    cars do not react: they can run into an ego that is slower than the recorded one was.

    The route is the shortest one on the lanelets. A lane change of the route does not depend on other
    vehicles. An adjacent lane counts if it exists, with one direction, all the way to the goal. If the goal
    has no region, the route goes straight on, or `toward` a lanelet. The cruise speed is the one closest to
    the initial speed with which the ego, without other vehicles, is in the goal's region at a time and speed
    that are allowed.
    """
    if not isinstance(scenario, CommonRoadScenario):
        raise InputError(f"scenario must be a CommonRoadScenario, was {type(scenario).__name__}")
    if not scenario.problems:
        raise InputError(f"scenario must have a planning problem, has none{_reason(scenario)}")
    if problem not in range(len(scenario.problems)):
        raise InputError(f"problem must be 0 to {len(scenario.problems) - 1}, was {problem!r}")
    vehicle = vehicle or VehicleParams.bmw_320i()
    if plant not in PLANTS:
        raise InputError(f"plant must be one of {', '.join(PLANTS)}, was {plant!r}")
    if plant == "multi_body" and vehicle != VehicleParams.bmw_320i():
        raise InputError("vehicle must be the BMW 320i for the multi-body plant")
    if toward is not None and toward not in scenario.lanelets:
        raise InputError(f"toward must be the id of a lanelet, was {toward!r}")
    task, speed, settings = scenario.problems[problem], speed or SpeedSettings(), settings or GoalSettings()
    scenario = _without_own_recording(scenario, task, vehicle)
    road, goal, s_goal = goal_road(scenario, task, speed, settings, toward)
    cruise = cruise_speed(road.path, task, goal, s_goal, speed, settings)
    start = _at_center_of_gravity(task.state, vehicle)
    # the multi-body car alone does not move off from rest: here it may stay there
    car = MultiBodyPlant(start) if plant == "multi_body" else make_plant(plant, vehicle, start)
    planner = Planner(vehicle, road, cruise_speed=cruise, speed=speed, evasion=evasion)
    return _drive(scenario, task, planner, plant, car)


def _reason(scenario: CommonRoadScenario) -> str:
    reasons = [text for text in scenario.left_out if text.startswith("planningProblem")]
    return f": {reasons[0]}" if reasons else ""


def _without_own_recording(
    scenario: CommonRoadScenario, problem: PlanningProblem, vehicle: VehicleParams
) -> CommonRoadScenario:
    """Return the scenario without the recording of the ego itself."""
    own = [obstacle for obstacle in scenario.obstacles if _is_own(obstacle, problem, vehicle, scenario.dt)]
    if not own:
        return scenario
    named = tuple(f"{obstacle.id}: recording of planningProblem {problem.id} itself" for obstacle in own)
    others = tuple(obstacle for obstacle in scenario.obstacles if obstacle not in own)
    return replace(scenario, obstacles=others, left_out=(*scenario.left_out, *named))


def _is_own(obstacle: RecordedObstacle, problem: PlanningProblem, vehicle: VehicleParams, dt: float) -> bool:
    """Return whether an obstacle starts in the ego's body with the ego's motion: two cars cannot."""
    state, t = problem.state, min(max(problem.t, float(obstacle.t[0])), float(obstacle.t[-1]))
    body = obstacle.at(t)
    if (
        obstacle.static or body is None or abs(t - problem.t) > 2.0 * dt + 1e-9
    ):  # recordings start a little later
        return False
    x, y = body.x - state.x, body.y - state.y
    cos, sin = math.cos(state.psi), math.sin(state.psi)
    along, across = cos * x + sin * y - state.v_x * (t - problem.t), cos * y - sin * x
    return (
        abs(along) < 0.5 * vehicle.length and abs(across) < 0.5 * vehicle.width
        and abs(wrap_angle(body.psi - state.psi)) < 0.3
        and abs(body.v_x - state.v_x) < max(1.0, 0.1 * state.v_x)
    )  # fmt: skip


def _drive(
    scenario: CommonRoadScenario,
    problem: PlanningProblem,
    planner: Planner,
    plant: str,
    car: Plant,
) -> CommonRoadRun:
    vehicle, road = planner.vehicle, planner.road
    step = scenario.dt / math.ceil(scenario.dt / CYCLE_TIME - 1e-9)  # a time step is a number of cycles
    n = max(1, round((max(g.t[1] for g in problem.goals) - problem.t) / step) + 1)
    rows, gaps = np.empty((n, 12)), np.full((n, len(scenario.obstacles)), np.inf)
    decisions: list[tuple[float, str, str]] = []
    reasons: list[str] = []
    dropped = set(scenario.left_out)
    s, t_goal = float(road.path.project((car.state.x, car.state.y))[0]), None
    for k in range(n):
        t, state = problem.t + k * step, car.state
        obstacles = [obstacle.at(t) for obstacle in scenario.obstacles]
        present = [i for i, obstacle in enumerate(obstacles) if obstacle is not None]
        remotes = [obstacle for obstacle in obstacles if obstacle is not None]
        command = planner.step(t, state, remotes)
        s, d, _, _ = road.path.foot_point(state.x, state.y, s)
        rows[k] = (
            t, state.x, state.y, state.psi, state.v_x, state.v_y, state.r, state.delta, state.a_x,
            car.a_y, s, d,
        )  # fmt: skip
        gaps[k, present] = _gaps(state, vehicle, remotes)
        dropped.update(f"{id_}: {reason}" for id_, reason in command.dropped)
        action = command.decision.action.value
        reasons.append(command.decision.reason)
        if not decisions or decisions[-1][1] != action:
            decisions.append((t, action, reasons[-1]))
        x, y = vehicle.center_at(state.x, state.y, state.psi)
        body = VehicleState(x=x, y=y, psi=state.psi, v_x=state.v_x)
        if any(g.reached(t, body) for g in problem.goals):
            t_goal, n = t, k + 1
            break
        car.step(command.delta, command.a_x, step)
    rows = rows[:n]
    return CommonRoadRun(
        scenario=scenario, problem=problem, vehicle=vehicle, plant=plant, road=road,
        cruise_speed=planner.cruise_speed, t=rows[:, 0], ego=rows[:, 1:9], a_y=rows[:, 9],
        ego_frenet=rows[:, 10:12], gaps=gaps[:n], decisions=tuple(decisions),
        cycle_reasons=tuple(reasons), dropped=tuple(sorted(dropped)), t_goal=t_goal,
    )  # fmt: skip


def _gaps(state: VehicleState, vehicle: VehicleParams, remotes: list[RemoteVehicle]) -> Array:
    """Signed distance between the boxes of the ego and of each obstacle [m]."""
    if not remotes:
        return np.empty(0)
    others = np.array([(r.x, r.y, r.psi, r.length, r.width) for r in remotes]).T
    x, y = vehicle.center_at(state.x, state.y, state.psi)
    return box_gap(boxes(x, y, state.psi, vehicle.length, vehicle.width), boxes(*others))


def _at_center_of_gravity(state: VehicleState, vehicle: VehicleParams) -> VehicleState:
    """Convert a motion of the body's center to that of the center of gravity, with steady wheels."""
    kappa = state.r / state.v_x if state.v_x > 1.0 else 0.0  # slower, the wheels are straight
    return replace(
        state,
        x=state.x - vehicle.box_offset * math.cos(state.psi),
        y=state.y - vehicle.box_offset * math.sin(state.psi),
        v_y=state.v_y - vehicle.box_offset * state.r,
        delta=float(steady_steering(kappa, state.v_x, vehicle)),
    )
