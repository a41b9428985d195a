"""The road and the cruise speed that lead to the goal of a planning problem."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np

from cca_core._checks import Array, check_real
from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.follow import SpeedSettings, jerk_limited, profile_acceleration, squared_speed_limit
from cca_core.geometry import wrap_angle
from cca_core.path import Lane, Path, Road, fit_path
from cca_core.sim.commonroad.lanelets import Lanelet, centerline, extend_straight, find_route, inside
from cca_core.sim.commonroad.scenario import CommonRoadScenario, Goal, PlanningProblem

__all__ = ["GoalSettings", "cruise_speed", "goal_road"]

_STEP = 0.5  # between stations at which the region of a goal is measured [m]


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalSettings:
    """Settings of the road and the cruise speed to a goal; all are positive.

    Parameters
    ----------
    route_tolerance : float
        Maximum distance of the route from the lanelets' centerlines [m].
    overrun : float
        Length of the route beyond the goal [m], on top of the comfortable stopping distance.
    min_lane_width : float
        Minimum width of an adjacent lane [m].
    max_speed : float
        Maximum cruise speed [m/s]; a higher initial speed is kept.
    lateral_acceleration : float
        Lateral acceleration in curves [m/s^2].
    time_margin : float
        Distance of the planned arrival from both ends of the goal's time window [s], at most a quarter of it.
    speed_margin : float
        Distance of the planned speed from both ends of the goal's speed interval [m/s], at most a quarter of
        it.

    Raises
    ------
    InputError
        If a value is not positive.
    """

    route_tolerance: float = 0.1
    overrun: float = 30.0
    min_lane_width: float = 2.0
    max_speed: float = 36.0
    lateral_acceleration: float = 2.5
    time_margin: float = 0.1
    speed_margin: float = 0.2

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for field in fields(self):
            check_real(field.name, getattr(self, field.name), gt=0.0)


def goal_road(
    scenario: CommonRoadScenario,
    problem: PlanningProblem,
    speed: SpeedSettings,
    settings: GoalSettings,
    toward: int | None = None,
) -> tuple[Road, Goal, float]:
    """Return the road to the first reachable goal, that goal, and its station [m] (inf: no region)."""
    lanelets, state = scenario.lanelets, problem.state
    here = [lane for lane in lanelets.values() if inside(lane.outline, state.x, state.y)]
    off = {lane.id: abs(wrap_angle(lane.heading_at(state.x, state.y) - state.psi)) for lane in here}
    starts = sorted((id_ for id_ in off if off[id_] < 0.5 * math.pi), key=off.__getitem__)
    if not starts:
        raise InputError(f"planningProblem {problem.id} must start on a lanelet, in its direction")
    tail = settings.overrun + 0.5 * max(state.v_x, settings.max_speed) ** 2 / speed.b_comfort
    for goal in problem.goals:
        for start in starts:
            route, target = _find_goal_route(scenario, start, goal, toward)
            if not route:
                continue
            if target is None:
                distance = max(state.v_x, 1.0) * max(goal.t[1] - problem.t, 0.0)
                route = extend_straight(lanelets, route, distance)
            onward = extend_straight(lanelets, route, tail)
            path = _fit_route(lanelets, onward, problem, tail, settings.route_tolerance)
            s = float(path.project((state.x, state.y))[0])
            s_goal = math.inf if target is None else float(path.project(target)[0])
            if s_goal > s:
                end = path.end - tail if target is None else s_goal
                stations = np.linspace(s, end, 50)  # at which lanes are measured
                lanes = _lanes(
                    path, [lanelets[i] for i in route], lanelets, stations, settings.min_lane_width
                )
                return Road(path, lanes), goal, s_goal
    raise InputError(f"goalState of planningProblem {problem.id} must be reachable on the lanelets, was not")


def _find_goal_route(
    scenario: CommonRoadScenario, start: int, goal: Goal, toward: int | None
) -> tuple[tuple[int, ...], tuple[float, float] | None]:
    """Return the lanelets to a goal and the center of the region reached; no center without a region."""
    if not goal.regions:
        return find_route(scenario.lanelets, start, [start if toward is None else toward]), None
    for region in goal.regions:
        x, y = region.mean(axis=0).tolist()
        holding = [lane.id for lane in scenario.lanelets.values() if inside(lane.outline, x, y)]
        route = find_route(scenario.lanelets, start, holding)
        if route:
            return route, (x, y)
    return (), None


def _fit_route(
    lanelets: Mapping[int, Lanelet],
    route: Sequence[int],
    problem: PlanningProblem,
    tail: float,
    tolerance: float,
) -> Path:
    """Fit the centerline of the lanelets, extended straight where the map ends."""
    state = problem.state
    line = centerline(lanelets, route, (state.x, state.y), max(state.v_x, 1.0))
    ahead = line[-1] - line[-2]
    steps = np.arange(10.0, tail + 10.0, 10.0)[:, None]
    return fit_path(np.vstack((line, line[-1] + steps * ahead / math.hypot(*ahead))), tolerance=tolerance)


def _lanes(
    path: Path, route: Sequence[Lanelet], lanelets: Mapping[int, Lanelet], stations: Array, min_width: float
) -> list[Lane]:
    """Return the ego lane and the lanes adjacent to all lanelets, with their minimum widths."""
    if any(after.id not in lane.successors for lane, after in pairwise(route)):
        return [Lane(d=0.0, width=max(min(lane.width for lane in route), 0.2))]

    def offsets(bounds: list[Array]) -> Array:
        s, d = path.project(np.vstack(bounds))
        order = np.argsort(s)
        return np.interp(stations, s[order], d[order])

    edges = {  # by side; the ego lane is at least 0.2 m wide
        1: max(float(offsets([lane.left for lane in route]).min()), 0.1),
        -1: min(float(offsets([lane.right for lane in route]).max()), -0.1),
    }
    lanes = [Lane(d=0.5 * (edges[1] + edges[-1]), width=edges[1] - edges[-1])]
    for side, edge in edges.items():
        row, direction = list(route), 1
        while direction == 1:
            adjacent = [lane.on_left if side == 1 else lane.on_right for lane in row]
            known = [pair for pair in adjacent if pair is not None]
            if len(known) < len(adjacent) or len({pair[1] for pair in known}) > 1:
                break
            row, direction = [lanelets[pair[0]] for pair in known], known[0][1]
            far = offsets([lane.left if side == direction else lane.right for lane in row])
            outer = side * float((side * far).min())
            if side * (outer - edge) < min_width:
                break
            lanes.append(Lane(d=0.5 * (edge + outer), width=side * (outer - edge), direction=direction))
            edge = outer
    return lanes


def cruise_speed(
    path: Path,
    problem: PlanningProblem,
    goal: Goal,
    s_goal: float,
    speed: SpeedSettings,
    settings: GoalSettings,
) -> float:
    """Return the cruise speed [m/s] closest to the initial one that meets a goal's time, region and speed."""
    v_x, step = problem.state.v_x, 0.5
    start = float(path.project((problem.state.x, problem.state.y))[0])
    time_margin = min(settings.time_margin, 0.25 * (goal.t[1] - goal.t[0]))
    first, last = goal.t[0] + time_margin - problem.t, goal.t[1] - time_margin - problem.t
    slowest, fastest = goal.v_x or (-math.inf, math.inf)
    speed_margin = min(settings.speed_margin, 0.25 * (fastest - slowest))
    slowest, fastest = slowest + speed_margin, fastest - speed_margin
    s_in, s_out = _region(path, goal, start, s_goal)

    def miss(cruise: float) -> tuple[float, float]:
        limit = squared_speed_limit(path, cruise, settings.lateral_acceleration, speed, start=(start, v_x))
        t, s, v = _drive_freely(limit, start, v_x, s_in, (first, last + 5.0), speed)
        late = max(t - last, 0.0) + max(s - s_out, 0.0) / max(v_x, 1.0)
        return round(late + max(slowest - v, v - fastest, 0.0), 3), abs(cruise - v_x)

    speeds = np.arange(step, settings.max_speed + step, step).tolist()
    return float(min([max(v_x, step), *speeds], key=miss))


def _region(path: Path, goal: Goal, start: float, s_goal: float) -> tuple[float, float]:
    """Return the stations ahead between which the route is well inside a goal's region."""
    if not math.isfinite(s_goal):
        return -math.inf, math.inf
    s = np.arange(start, path.end, _STEP)
    inside_at = np.array(
        [any(inside(region, x, y) for region in goal.regions) for x, y in path.position(s).tolist()]
    )
    if not inside_at.any():
        return s_goal, s_goal
    s = s[inside_at.argmax() :]
    rest = s[~inside_at[inside_at.argmax() :]]
    first, last = float(s[0]), float(rest[0] if len(rest) else s[-1])
    margin = 0.25 * (last - first)
    return first + margin, last - margin


def _drive_freely(
    limit: tuple[Array, Array], s: float, v: float, s_goal: float, window: tuple[float, float],
    speed: SpeedSettings,
) -> tuple[float, float, float]:  # fmt: skip
    """Return time, station and speed at the goal, or at the end of the time, without other vehicles."""
    t, a, dt = 0.0, 0.0, 0.05
    while (s < s_goal or t < window[0]) and t < window[1]:
        a = jerk_limited(profile_acceleration(s, v, limit, speed), a, dt, speed)
        s, v, t = s + v * dt, max(v + a * dt, 0.0), t + dt
    return t, s, v
