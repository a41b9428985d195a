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
from cca_core.baselines.methods.road_space import STATION, RoadSpace, State
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.errors import InputError, Status

__all__ = ["Rrt", "Variant"]

Variant = Literal["rrt", "rrt_star"]
"""The tree as it grows (LaValle), or rewired to shorter paths (Karaman and Frazzoli)."""

_THERE = 1e-6  # from the goal [m, rad]
_REWIRE = 8.0  # of the radius in which RRT* looks for neighbors, over OMPL's for Euclidean space
_BLOCK = 256  # samples drawn at once
_FINE = 0.25  # between samples of the plan [m]


@dataclass(frozen=True, slots=True, kw_only=True)
class Rrt:
    """Random tree from the start to the goal.

    Parameters
    ----------
    variant : str
        ``"rrt_star"`` or ``"rrt"``.
    seed : int
        Of all that is random: equal seeds give equal plans unless time runs out.
    iterations : int
        Most samples.
    refine : int
        Samples after the first solution, by which ``"rrt_star"`` shortens it.
    time_limit : float
        Time after which it gives up [s].
    reach : float
        Longest motion toward a sample, as a time at the wanted speed [s].

    Raises
    ------
    InputError
        If a value is out of range.
    MissingExtraError
        If OMPL is not installed.

    Notes
    -----
    OMPL's RRT and RRT* [1]_ grow the tree in its Dubins space [2]_, whose curvature jumps between the limit
    to either side and zero; that is the method's. RRT* looks for neighbors within a radius that shrinks as
    the tree grows. Samples are free poses, uniform over the road, with headings spread around the road's; one
    in twenty is the goal. A state is valid if a table of poses says that the body is between the edges and
    keeps the clearance to the others where they are when its station is passed at the wanted speed, and if
    its heading is no more off the road's than a shift across the whole road needs. The path found is
    shortened by direct motions between its states, checked exactly and given with the speeds at which
    stations are passed at the wanted one.

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

    def __post_init__(self) -> None:
        if self.variant not in get_args(Variant):
            raise InputError(f"variant must be one of {get_args(Variant)}, was {self.variant!r}")
        for name in ("seed", "iterations", "refine"):
            value = getattr(self, name)
            if not isinstance(value, int) or isinstance(value, bool) or value < (name == "iterations"):
                raise InputError(
                    f"{name} must be a whole number, {name} >= {int(name == 'iterations')}, was {value!r}"
                )
        check_real("time_limit", self.time_limit, gt=0.0)
        check_real("reach", self.reach, gt=0.0)
        require_extra("ompl", "rrt")

    def plan(self, problem: Problem) -> Plan:
        """Grow a tree until it reaches the goal.

        Parameters
        ----------
        problem : Problem
            What is to be driven.

        Returns
        -------
        plan : Plan
            `Status.INFEASIBLE` if the road is blocked at a station, `Status.NOT_CONVERGED` if the tree did
            not reach the goal.
        """
        begun = perf_counter()
        corridor = RoadSpace.of(problem)
        if corridor.message:
            return Plan(status=Status.INFEASIBLE, message=corridor.message)
        poses, message = self._quietly(problem, corridor, begun)
        if message:
            return Plan(status=Status.NOT_CONVERGED, message=message)
        return _driven(problem, poses)

    def _quietly(self, problem: Problem, corridor: RoadSpace, begun: float) -> tuple[Array, str]:
        """Grow the tree while OMPL logs nothing."""
        base, geometric, util = (
            require_extra(f"ompl.{part}", "rrt") for part in ("base", "geometric", "util")
        )
        level = util.getLogLevel()
        util.setLogLevel(util.LogLevel.LOG_NONE)
        try:
            return self._grow(problem, corridor, begun, base, geometric)
        finally:
            util.setLogLevel(level)

    def _grow(
        self, problem: Problem, corridor: RoadSpace, begun: float, base: ModuleType, geometric: ModuleType
    ) -> tuple[Array, str]:
        """Poses (n, 3) along the path found, or why there is none."""
        space = base.DubinsStateSpace(1.0 / corridor.kappa, False)
        bounds = base.RealVectorBounds(2)
        for axis, (low, high) in enumerate(corridor.bounds()):
            bounds.setLow(axis, low)
            bounds.setHigh(axis, high)
        space.setBounds(bounds)
        info = base.SpaceInformation(space)
        info.setStateValidityChecker(corridor.check())
        info.setStateValidityCheckingResolution(STATION / space.getMaximumExtent())
        info.setup()
        rng, samples = np.random.default_rng(self.seed), list[tuple[float, float, float]]()
        count, left = 0, self.iterations
        x, y, yaw = corridor.goal

        class Guide(base.GoalSampleableRegion):  # type: ignore[name-defined, misc]
            """Goal that the tree is drawn to by way of samples of the road."""

            def distanceGoal(self, state: State) -> float:  # noqa: N802
                nonlocal left, refine
                turned = abs(state.getYaw() - yaw)
                distance: float = math.hypot(state.getX() - x, state.getY() - y) + turned
                if distance <= _THERE and refine is not None:
                    left, refine = min(left, refine), None
                return distance

            def sampleGoal(self, state: State) -> None:  # noqa: N802
                nonlocal count
                if not samples:
                    samples.extend(corridor.samples(rng, _BLOCK))
                px, py, angle = samples.pop()
                count += 1
                state.setXY(px, py)
                state.setYaw(angle)

            def maxSampleCount(self) -> int:  # noqa: N802
                return 2**31 - 1

        refine: int | None = self.refine if self.variant == "rrt_star" else 0

        def ended() -> bool:
            nonlocal left
            left -= 1
            return left < 0 or perf_counter() - begun > self.time_limit

        definition = base.ProblemDefinition(info)
        start = space.allocState()
        start.setXY(*corridor.start[:2])
        start.setYaw(corridor.start[2])
        definition.addStartState(start)
        goal = Guide(info)
        goal.setThreshold(_THERE)
        definition.setGoal(goal)
        planner = geometric.RRTstar(info) if self.variant == "rrt_star" else geometric.RRT(info)
        if self.variant == "rrt_star":
            planner.setKNearest(False)
            planner.setRewireFactor(_REWIRE)
        planner.setRange(self.reach * problem.v_x)
        planner.setGoalBias(1.0)
        planner.setProblemDefinition(definition)
        planner.setup()
        planner.solve(base.PlannerTerminationCondition(ended))
        if not definition.hasExactSolution():
            return np.empty((0, 3)), f"the goal was not reached by {count} samples"
        states = _shortened(definition.getSolutionPath().getStates(), info.checkMotion)
        return _sampled(space, states), ""


def _shortened(states: list[State], free: Callable[[State, State], bool]) -> list[State]:
    """Leave out states where the motion to a later one is free."""
    kept, i = [states[0]], 0
    while i < len(states) - 1:
        i = next((j for j in range(len(states) - 1, i + 1, -1) if free(states[i], states[j])), i + 1)
        kept.append(states[i])
    return kept


def _sampled(space: Any, states: list[State]) -> Array:
    """Poses (n, 3) along the motions between states."""
    poses, at = [], space.allocState()
    for a, b in pairwise(states):
        n = max(math.ceil(space.distance(a, b) / _FINE), 1)
        for k in range(n):
            space.interpolate(a, b, k / n, at)
            poses.append((at.getX(), at.getY(), at.getYaw()))
    poses.append((states[-1].getX(), states[-1].getY(), states[-1].getYaw()))
    return np.array(poses)


def _driven(problem: Problem, poses: Array) -> Plan:
    """Check a path exactly, and give it the times of its stations."""
    path = problem.road.path
    length = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T))))
    s, d = path.project(poses[:, :2], s_guess=np.minimum(problem.start + length, problem.goal))
    s[0], s[-1] = problem.start, problem.goal
    at = sample_route(problem, s)
    turn: Complex = np.exp(1j * poses[:, 2]) * at.along.conj()
    if not (np.diff(s) > 0.0).all() or (clearance_shortfall(problem, at, d, turn) > 0.0).any():
        return Plan(status=Status.NOT_CONVERGED, message="the path found failed the exact check")
    v_x = problem.v_x * (1.0 - at.kappa * d) / turn.real
    return Plan(status=Status.OK, t=at.t, xy=poses[:, :2], v_x=v_x)
