"""Time of a plan over the size of the problem: mesh, length, number of vehicles."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np

from cca_core.baselines.problems.kept_row import kept_row
from cca_core.baselines.problems.problem import PlanningMethod, Problem
from cca_core.baselines.problems.worker import Worker
from cca_core.sim.study.store import Store


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ScalingPoint:
    """One method on one problem of a given size."""

    method: str
    axis: str  # the size that grows, in words
    value: float  # in the unit of the axis
    make: Callable[[], PlanningMethod]
    problem: Problem


@dataclass(frozen=True, slots=True, kw_only=True)
class ScalingResult:
    """Median processor time of up to five plans after the first, and the plan."""

    method: str
    axis: str
    value: float
    time_ms: float
    status: str  # of the plan, or the reason why there is none
    peak: float  # lateral offset of the plan with the largest magnitude [m]; NaN without plan


def measure_scaling(
    points: Iterable[ScalingPoint],
    *,
    store: Store | None = None,
    limit: float = 10.0,
    core: int | None = None,
    progress: Callable[[ScalingResult], None] | None = None,
) -> list[ScalingResult]:
    """Time the plan of each point that the store does not hold yet."""
    return [
        kept_row(
            store, ("scaling", point.method, point.axis, point.value), ScalingResult,
            partial(_timed, point, limit, core), progress,
        )
        for point in points
    ]  # fmt: skip


def _timed(point: ScalingPoint, limit: float, core: int | None) -> ScalingResult:
    """Time of one point."""
    with Worker(point.make, limit=limit, core=core) as worker:
        timed = worker.time(point.problem, repeats=5, enough=2.0)  # a program is built in 0.5 s
    plan, peak = timed.plan, math.nan
    if plan is not None and len(plan.xy):
        d = point.problem.road.path.project(plan.xy)[1]
        peak = float(d[np.abs(d).argmax()])
    return ScalingResult(
        method=point.method, axis=point.axis, value=point.value, peak=peak,
        time_ms=math.nan if plan is None else 1e3 * timed.median,
        status=timed.failure if plan is None else plan.status.name,
    )  # fmt: skip
