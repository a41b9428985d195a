"""The road and the speed that lead to the goal of a planning problem."""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.follow import SpeedSettings, jerk_limited, profile_acceleration, squared_speed_limit
from cca_core.geometry import wrap_angle
from cca_core.path import Lane, Path, Road, fit_path
from cca_core.sim.commonroad.lanelets import Lanelet, centerline, extend_straight, find_route, inside
from cca_core.sim.commonroad.scenario import CommonRoadScenario, Goal, PlanningProblem

__all__ = ["cruise_speed", "goal_road"]

_TOLERANCE = 0.1  # of the route about the lanelets' center lines [m]
_SPARE = 30.0  # the route goes on behind the goal for this and the way to stop [m]
_NARROWEST = 2.0  # a strip beside the own lane is a lane if it is as wide [m]
_LEAST = 0.1  # half width of the own lane, however narrow its lanelets [m]
_SAMPLES = 50  # places at which lanes are measured
_TAIL_STEP = 10.0  # between points of the route where the map has ended [m]
_FASTEST = 36.0  # the ego is not made faster than this to be in time [m/s]
_SPEED_STEP, _TIME_STEP = 0.5, 0.05  # of the search for a speed [m/s], [s]
_SPARE_TIME = 0.1  # the ego is planned to be inside the window of time by this [s]
_SPARE_SPEED = 0.2  # and inside that of speed by this [m/s]
_LATE = 5.0  # an arrival later than this behind the window is not timed [s]
_BENDS = 2.5  # lateral acceleration for which speed is cut in bends [m/s^2]


def goal_road(
    scenario: CommonRoadScenario,
    problem: PlanningProblem,
    speed: SpeedSettings,
    toward: int | None = None,
) -> tuple[Road, Goal, float]:
    """Lay the road from the start of a planning problem to its goal.

    Parameters
    ----------
    scenario : CommonRoadScenario
        The road network.
    problem : PlanningProblem
        Start and goals.
    speed : SpeedSettings
        Its comfortable deceleration says how far the route goes on behind the goal.
    toward : int, optional
        Lanelet [-] to which the route leads if the goal is no place; without it, it goes straight on.

    Returns
    -------
    road : Road
        The route with its lane, and the lanes beside that are there all the way to the goal.
    goal : Goal
        The first goal that can be reached on the lanelets.
    s_goal : float
        Path coordinate of its center [m]; infinite if it is no place.

    Raises
    ------
    InputError
        If the problem starts on no lanelet or no goal can be reached.
    """
    lanelets, state = scenario.lanelets, problem.state
    here = [lane for lane in lanelets.values() if inside(lane.outline, state.x, state.y)]
    off = {lane.id: abs(wrap_angle(lane.heading_at(state.x, state.y) - state.psi)) for lane in here}
    starts = sorted((id_ for id_ in off if off[id_] < 0.5 * math.pi), key=off.__getitem__)
    if not starts:
        raise InputError(f"planningProblem {problem.id} must start on a lanelet, in its direction")
    tail = _SPARE + 0.5 * max(state.v_x, _FASTEST) ** 2 / speed.b_comfort
    for goal in problem.goals:
        for start in starts:
            route, target = _route(scenario, start, goal, toward)
            if not route:
                continue
            if target is None:
                way = max(state.v_x, 1.0) * max(goal.t[1] - problem.t, 0.0)
                route = extend_straight(lanelets, route, way)
            path = _path(lanelets, extend_straight(lanelets, route, tail), problem, tail)
            s = float(path.project((state.x, state.y))[0])
            s_goal = math.inf if target is None else float(path.project(target)[0])
            if s_goal > s:
                end = path.end - tail if target is None else s_goal
                lanes = _lanes(path, [lanelets[i] for i in route], lanelets, s, end)
                return Road(path, lanes), goal, s_goal
    raise InputError(f"goalState of planningProblem {problem.id} must be reachable on the lanelets, was not")


def _route(
    scenario: CommonRoadScenario, start: int, goal: Goal, toward: int | None
) -> tuple[tuple[int, ...], tuple[float, float] | None]:
    """Lanelets to a goal and the center of the region reached; no center if the goal is no place."""
    if not goal.regions:
        return find_route(scenario.lanelets, start, [start if toward is None else toward]), None
    for region in goal.regions:
        x, y = region.mean(axis=0).tolist()
        holding = [lane.id for lane in scenario.lanelets.values() if inside(lane.outline, x, y)]
        route = find_route(scenario.lanelets, start, holding)
        if route:
            return route, (x, y)
    return (), None


def _path(
    lanelets: Mapping[int, Lanelet], route: Sequence[int], problem: PlanningProblem, tail: float
) -> Path:
    """Center line of the lanelets, and straight on where the map ends."""
    state = problem.state
    line = centerline(lanelets, route, (state.x, state.y), max(state.v_x, 1.0))
    ahead = line[-1] - line[-2]
    steps = np.arange(_TAIL_STEP, tail + _TAIL_STEP, _TAIL_STEP)[:, None]
    return fit_path(np.vstack((line, line[-1] + steps * ahead / math.hypot(*ahead))), tolerance=_TOLERANCE)


def _lanes(
    path: Path, route: Sequence[Lanelet], lanelets: Mapping[int, Lanelet], start: float, end: float
) -> list[Lane]:
    """Own lane and those beside it on all lanelets of the route, as wide as at the narrowest."""
    if any(after.id not in lane.successors for lane, after in pairwise(route)):
        return [Lane(d=0.0, width=min(lane.width for lane in route))]
    at = np.linspace(start, end, _SAMPLES)

    def border(bounds: list[Array]) -> Array:
        s, d = path.project(np.vstack(bounds))
        order = np.argsort(s)
        return np.interp(at, s[order], d[order])

    edges = {
        1: max(float(border([lane.left for lane in route]).min()), _LEAST),
        -1: min(float(border([lane.right for lane in route]).max()), -_LEAST),
    }
    lanes = [Lane(d=0.5 * (edges[1] + edges[-1]), width=edges[1] - edges[-1])]
    for side, edge in edges.items():
        row, direction = list(route), 1
        while direction == 1:
            beside = [lane.on_left if side == 1 else lane.on_right for lane in row]
            known = [pair for pair in beside if pair is not None]
            if len(known) < len(beside) or len({pair[1] for pair in known}) > 1:
                break
            row, direction = [lanelets[pair[0]] for pair in known], known[0][1]
            far = border([lane.left if side == direction else lane.right for lane in row])
            outer = side * float((side * far).min())
            if side * (outer - edge) < _NARROWEST:
                break
            lanes.append(Lane(d=0.5 * (edge + outer), width=side * (outer - edge), direction=direction))
            edge = outer
    return lanes


def cruise_speed(
    path: Path, problem: PlanningProblem, goal: Goal, s_goal: float, speed: SpeedSettings
) -> float:
    """Find the speed with which an undisturbed ego is in time at its goal.

    Parameters
    ----------
    path : Path
        The route.
    problem : PlanningProblem
        Start.
    goal : Goal
        Window of time and speed.
    s_goal : float
        Path coordinate of the goal [m]; infinite if it is no place.
    speed : SpeedSettings
        How the ego accelerates and brakes.

    Returns
    -------
    cruise : float
        Of 0.5 to 36 m/s, and the initial speed, the wanted speed that misses window and speed at the goal
        least; among equals the one nearest to the initial speed [m/s]. Bends are driven more slowly.
    """
    v_x = problem.state.v_x
    start = float(path.project((problem.state.x, problem.state.y))[0])
    spare = min(_SPARE_TIME, 0.25 * (goal.t[1] - goal.t[0]))
    first, last = goal.t[0] + spare - problem.t, goal.t[1] - spare - problem.t
    slowest, fastest = goal.v_x or (-math.inf, math.inf)
    margin = min(_SPARE_SPEED, 0.25 * (fastest - slowest))
    slowest, fastest = slowest + margin, fastest - margin

    def miss(cruise: float) -> tuple[float, float]:
        t, v = _drive_freely(path, cruise, start, v_x, s_goal, last + _LATE, speed)
        late = max(first - t, t - last, 0.0) if math.isfinite(s_goal) else 0.0
        return round(late + max(slowest - v, v - fastest, 0.0), 3), abs(cruise - v_x)

    speeds = np.arange(_SPEED_STEP, _FASTEST + _SPEED_STEP, _SPEED_STEP).tolist()
    return float(min([max(v_x, _SPEED_STEP), *speeds], key=miss))


def _drive_freely(
    path: Path, cruise: float, s: float, v: float, s_goal: float, most: float, speed: SpeedSettings
) -> tuple[float, float]:
    """Time and speed at the goal, or at the end of the time, of an ego that meets nobody."""
    cap = squared_speed_limit(path, cruise, _BENDS, speed)
    t, a = 0.0, 0.0
    while s < s_goal and t < most:
        a = jerk_limited(profile_acceleration(s, v, cap, speed), a, _TIME_STEP, speed)
        s, v, t = s + v * _TIME_STEP, max(v + a * _TIME_STEP, 0.0), t + _TIME_STEP
    return t, v
