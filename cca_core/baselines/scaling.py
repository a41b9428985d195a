"""How the time of a method grows with its mesh, its horizon and the number of others."""

import math
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cca_core.baselines.csv_rows import append_row, read_rows
from cca_core.baselines.problem import Problem
from cca_core.baselines.worker import Planning, Worker

__all__ = ["ScalingPoint", "ScalingResult", "measure_scaling"]

_TIMES = 5
_ENOUGH = 0.5  # processor time after which no more are [s]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ScalingPoint:
    """One plan to be timed.

    Parameters
    ----------
    method : str
        Name of the method.
    axis : str
        What grows, in words.
    value : float
        How large it is here, in the unit of the axis [-].
    make : callable
        Makes the method, see `Worker`.
    problem : Problem
        What is to be planned.
    """

    method: str
    axis: str
    value: float
    make: Callable[[], Planning]
    problem: Problem


@dataclass(frozen=True, slots=True, kw_only=True)
class ScalingResult:
    """What it took.

    Parameters
    ----------
    method, axis : str
        Of the step.
    value : float
        Of the step [-].
    time_ms : float
        Median processor time of up to five plans after the first [ms].
    status : str
        Name of the plan's status, or why there is none.
    peak : float
        Largest lateral coordinate of the plan [m], left positive; NaN without plan.
    """

    method: str
    axis: str
    value: float
    time_ms: float
    status: str
    peak: float


def measure_scaling(
    steps: Sequence[ScalingPoint],
    *,
    out: Path | str,
    limit: float = 10.0,
    core: int | None = None,
    progress: Callable[[ScalingResult], None] | None = None,
) -> list[ScalingResult]:
    """Time plans of growing size.

    Parameters
    ----------
    steps : sequence of Step
        What is timed.
    out : path
        File to which each result is added at once; those that are there already are not made again.
    limit : float
        Time after which a plan is stopped [s].
    core : int, optional
        Processor core for the methods.
    progress : callable, optional
        Called with each new result.

    Returns
    -------
    results : list of Growth
        One for each step.
    """
    known = {(r.method, r.axis, r.value): r for r in read_rows(out, ScalingResult)}
    results = []
    for step in steps:
        result = known.get((step.method, step.axis, step.value))
        if result is None:
            result = _timed(step, limit, core)
            append_row(out, result)
            if progress is not None:
                progress(result)
        results.append(result)
    return results


def _timed(step: ScalingPoint, limit: float, core: int | None) -> ScalingResult:
    times: list[float] = []
    with Worker(step.make, limit=limit, core=core) as worker:
        plan, failure, _ = worker.plan(step.problem)
        while plan is not None and len(times) < _TIMES and sum(times) < _ENOUGH:
            plan, failure, spent = worker.plan(step.problem)
            times.append(spent)
    peak = math.nan
    if plan is not None and len(plan.xy):
        d = step.problem.road.path.project(plan.xy)[1]
        peak = float(d[np.abs(d).argmax()])
    return ScalingResult(
        method=step.method, axis=step.axis, value=step.value, peak=peak,
        time_ms=1e3 * statistics.median(times) if times else math.nan,
        status=failure if plan is None else plan.status.name,
    )  # fmt: skip
