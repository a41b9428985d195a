"""Rapidly exploring random trees over Dubins curves, in OMPL."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from time import perf_counter
from types import ModuleType
from typing import Any, Literal, get_args

import numpy as np

from cca_core._checks import Array, Complex, check_real
from cca_core._optional import require_extra
from cca_core.baselines.methods.free_space import clearance_shortfall, sample_route
from cca_core.baselines.methods.road_space import STATION_STEP, Pose, RoadSpace, State
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.errors import InputError, Status
from cca_core.geometry import arc_length

Variant = Literal["rrt", "rrt_star"]
"""The tree as it grows (LaValle), or rewired to shorter paths (Karaman and Frazzoli)."""

_GOAL_TOLERANCE = 1e-6  # distance and heading [m, rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class Rrt:
    """Random tree from start to goal.

    Parameters
    ----------
    variant : str
        ``"rrt_star"`` or ``"rrt"``.
    seed : int
        Seed of all random numbers: equal seeds give equal plans unless time runs out.
    iterations : int
        Largest number of samples.
    refine : int
        Samples after the first solution, by which ``"rrt_star"`` shortens it.
    time_limit : float
        Time after which the search ends [s].
    reach : float
        Longest motion toward a sample, as a time at the wanted speed [s].
    rewire_factor : float
        Radius of the neighbors of ``"rrt_star"`` over that of OMPL for Euclidean space [-].
    goal_bias : float
        Fraction of the samples that are the goal [-].
    max_heading : float
        Largest heading of a sample relative to the road [rad].
    heading_spread : float
        Standard deviation of the sampled headings over the largest one [-].
    cell_width : float
        Width of the cells in the table of free poses [m].
    heading_step : float
        Distance between the headings of that table [rad].

    Raises
    ------
    InputError
        If a value is out of range.
    MissingExtraError
        If OMPL is not installed.

    Notes
    -----
    RRT and RRT* of OMPL [1]_ grow the tree in the Dubins space [2]_, in which the curvature jumps between
    zero and the limit to both sides. RRT* searches neighbors in a radius that shrinks as the tree grows.
    Samples are free poses, uniform over the road. A table of poses decides whether a state is valid: the body
    is between the edges and keeps the clearance to the other vehicles at the time at which its station passes
    at the wanted speed. The heading of a state relative to the road is at most that of a shift across the
    whole road. Direct motions between its states shorten the path found, which is then checked exactly. Its
    stations pass at the wanted speed.

    References
    ----------
    .. [1] I. A. Sucan, M. Moll, L. E. Kavraki, *The Open Motion Planning Library*, IEEE Robotics and
       Automation Magazine 19(4), 2012.
    .. [2] L. E. Dubins, *On curves of minimal length with a constraint on average curvature, and with
       prescribed initial and terminal positions and tangents*, American Journal of Mathematics 79(3), 1957.
    """

    variant: Variant = "rrt_star"
    seed: int = 1
    iterations: int = 20000
    refine: int = 0
    time_limit: float = 2.0
    reach: float = 1.5
    rewire_factor: float = 8.0
    goal_bias: float = 0.05
    max_heading: float = 0.6
    heading_spread: float = 0.4
    cell_width: float = 0.05
    heading_step: float = 0.0125

    def __post_init__(self) -> None:
        if self.variant not in get_args(Variant):
            raise InputError(f"variant must be one of {get_args(Variant)}, was {self.variant!r}")
        for name, lowest in (("seed", 0), ("iterations", 1), ("refine", 0)):
            value = getattr(self, name)
            if not isinstance(value, int) or isinstance(value, bool) or value < lowest:
                raise InputError(f"{name} must be a whole number, {name} >= {lowest}, was {value!r}")
        for name in ("time_limit", "reach", "rewire_factor", "heading_spread", "cell_width", "heading_step"):
            check_real(name, getattr(self, name), gt=0.0)
        check_real("max_heading", self.max_heading, gt=0.0, le=1.5)
        check_real("goal_bias", self.goal_bias, ge=0.0, le=1.0)
        require_extra("ompl", "rrt")

    def plan(self, problem: Problem) -> Plan:
        """Grow a tree until it reaches the goal.

        Parameters
        ----------
        problem : Problem
            The problem.

        Returns
        -------
        plan : Plan
            `Status.INFEASIBLE` if the road is blocked at a station, `Status.NOT_CONVERGED` if the tree did
            not reach the goal.
        """
        begun = perf_counter()
        space = RoadSpace.of(problem, self.cell_width, self.heading_step, self.max_heading)
        if space.message:
            return Plan(status=Status.INFEASIBLE, message=space.message)
        base, geometric, util = _ompl()
        level = util.getLogLevel()
        util.setLogLevel(util.LogLevel.LOG_NONE)
        try:
            poses, message = self._grow(problem, space, begun, base, geometric)
        finally:
            util.setLogLevel(level)
        if message:
            return Plan(status=Status.NOT_CONVERGED, message=message)
        return _plan_of(problem, poses)

    def _grow(
        self, problem: Problem, space: RoadSpace, begun: float, base: ModuleType, geometric: ModuleType
    ) -> tuple[Array, str]:
        """Poses (n, 3) along the path found, or the reason why there is none."""
        dubins, info = _dubins_space(base, space)
        star = self.variant == "rrt_star"
        budget = _Budget(left=self.iterations, refine=self.refine if star else 0)
        rng = np.random.default_rng(self.seed)
        definition = base.ProblemDefinition(info)
        start = dubins.allocState()
        start.setXY(*space.start[:2])
        start.setYaw(space.start[2])
        definition.addStartState(start)
        goal = _goal_region(
            base, info, space.goal, budget,
            lambda: space.samples(rng, 256, self.heading_spread, self.goal_bias),
        )  # fmt: skip
        definition.setGoal(goal)
        planner = geometric.RRTstar(info) if star else geometric.RRT(info)
        if star:
            planner.setKNearest(False)
            planner.setRewireFactor(self.rewire_factor)
        planner.setRange(self.reach * problem.v_x)
        planner.setGoalBias(1.0)  # every sample is one of the goal region, which samples the road
        planner.setProblemDefinition(definition)
        planner.setup()

        def is_exhausted() -> bool:
            budget.left -= 1
            return budget.left < 0 or perf_counter() - begun > self.time_limit

        planner.solve(base.PlannerTerminationCondition(is_exhausted))
        if not definition.hasExactSolution():
            return np.empty((0, 3)), f"the goal was not reached by {budget.sampled} samples"
        states = _shortened(definition.getSolutionPath().getStates(), info.checkMotion)
        return _sampled(dubins, states), ""


def _ompl() -> tuple[ModuleType, ...]:
    """Return the modules base, geometric and util of OMPL."""
    return tuple(require_extra(f"ompl.{part}", "rrt") for part in ("base", "geometric", "util"))


@dataclass(slots=True)
class _Budget:
    """Samples that are left, and that were taken."""

    left: int
    refine: int | None  # samples left once there is a solution; None after that
    sampled: int = 0


def _dubins_space(base: ModuleType, space: RoadSpace) -> tuple[Any, Any]:
    """Dubins space of a road with its validity check."""
    dubins = base.DubinsStateSpace(1.0 / space.kappa, False)
    bounds = base.RealVectorBounds(2)
    for axis, (low, high) in enumerate(space.bounds()):
        bounds.setLow(axis, low)
        bounds.setHigh(axis, high)
    dubins.setBounds(bounds)
    info = base.SpaceInformation(dubins)
    info.setStateValidityChecker(space.validity_check())
    info.setStateValidityCheckingResolution(STATION_STEP / dubins.getMaximumExtent())
    info.setup()
    return dubins, info


def _goal_region(
    base: ModuleType, info: Any, goal: Pose, budget: _Budget, sample: Callable[[], list[Pose]]
) -> Any:
    """Goal whose samples are those of the road."""
    samples: list[Pose] = []
    x, y, yaw = goal

    class Region(base.GoalSampleableRegion):  # type: ignore[name-defined, misc]
        """Region that OMPL asks for the distance to the goal and for samples."""

        def distanceGoal(self, state: State) -> float:  # noqa: N802
            turned = abs(state.getYaw() - yaw)
            distance: float = math.hypot(state.getX() - x, state.getY() - y) + turned
            if distance <= _GOAL_TOLERANCE and budget.refine is not None:
                budget.left, budget.refine = min(budget.left, budget.refine), None
            return distance

        def sampleGoal(self, state: State) -> None:  # noqa: N802
            if not samples:
                samples.extend(sample())
            px, py, angle = samples.pop()
            budget.sampled += 1
            state.setXY(px, py)
            state.setYaw(angle)

        def maxSampleCount(self) -> int:  # noqa: N802
            return 2**31 - 1

    region = Region(info)
    region.setThreshold(_GOAL_TOLERANCE)
    return region


def _shortened(states: list[State], free: Callable[[State, State], bool]) -> list[State]:
    """Omit states where the motion to a later one is free."""
    kept, i = [states[0]], 0
    while i < len(states) - 1:
        i = next((j for j in range(len(states) - 1, i + 1, -1) if free(states[i], states[j])), i + 1)
        kept.append(states[i])
    return kept


def _sampled(space: Any, states: list[State]) -> Array:
    """Poses (n, 3) along the motions between states, at most 0.25 m apart."""
    poses, at = [], space.allocState()
    for a, b in pairwise(states):
        n = max(math.ceil(space.distance(a, b) / 0.25), 1)
        for k in range(n):
            space.interpolate(a, b, k / n, at)
            poses.append((at.getX(), at.getY(), at.getYaw()))
    poses.append((states[-1].getX(), states[-1].getY(), states[-1].getYaw()))
    return np.array(poses)


def _plan_of(problem: Problem, poses: Array) -> Plan:
    """Plan along poses that passes the stations at the wanted speed, checked exactly."""
    path = problem.road.path
    length = arc_length(poses[:, :2])
    s, d = path.project(poses[:, :2], s_guess=np.minimum(problem.start + length, problem.goal))
    s[0], s[-1] = problem.start, problem.goal
    at = sample_route(problem, s)
    turn: Complex = np.exp(1j * poses[:, 2]) * at.tangent.conj()
    if not (np.diff(s) > 0.0).all() or (clearance_shortfall(problem, at, d, turn) > 0.0).any():
        return Plan(status=Status.NOT_CONVERGED, message="the path found failed the exact check")
    v_x = problem.v_x * (1.0 - at.kappa * d) / turn.real
    return Plan(status=Status.OK, t=at.t, xy=poses[:, :2], v_x=v_x)
