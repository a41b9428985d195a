"""Methods against problems: every plan is timed, judged and driven, row by row into a file."""

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cca_core.baselines.csv_rows import append_row, read_rows
from cca_core.baselines.drive import drive_plan
from cca_core.baselines.problem import Plan, Problem
from cca_core.baselines.sampled_problems import SampledProblem
from cca_core.baselines.verify import Tolerances, verify_plan
from cca_core.baselines.worker import Planning, Worker
from cca_core.errors import Status

__all__ = ["ComparisonRow", "compare"]

_WARM = 3  # plans made after the first
_ENOUGH = 0.3  # processor time after which no more are [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonRow:
    """One method on one problem.

    Parameters
    ----------
    method : str
        Name of the method.
    kind : str
        Kind of the problem.
    seed : int
        Its seed.
    outcome : str
        ``"solved"`` (claimed and confirmed), ``"false OK"`` (claimed and refuted), ``"refused"`` (not claimed
        where a way exists), ``"rightly refused"``, ``"TIMEOUT"`` or ``"ERROR"``.
    message : str
        What the judge found, or why there is no plan.
    first_ms : float
        Processor time of the first plan for this problem [ms].
    time_ms : float
        Median of the plans for the same problem after that, if any [ms].
    length : float
        Length of the way [m].
    clearance, edge : float
        Least distance to the others and to the edges as planned [m].
    a_y, jerk : float
        Largest lateral acceleration [m/s^2] and jerk [m/s^3] as planned.
    swings : int
        Changes of the lateral acceleration to the other side.
    driven_clearance, driven_edge : float
        Distances when driven [m].
    driven_a_y, driven_jerk : float
        As planned, when driven [m/s^2], [m/s^3].
    tracking : float
        Largest distance of the driven car from the plan [m].
    finished : bool
        Whether it could be driven to its end.

    Notes
    -----
    Where there is no plan that claims to be good all measures are NaN, which a file holds as nothing.
    """

    method: str
    kind: str
    seed: int
    outcome: str
    message: str = ""
    first_ms: float = math.nan
    time_ms: float = math.nan
    length: float = math.nan
    clearance: float = math.nan
    edge: float = math.nan
    a_y: float = math.nan
    jerk: float = math.nan
    swings: int = 0
    driven_clearance: float = math.nan
    driven_edge: float = math.nan
    driven_a_y: float = math.nan
    driven_jerk: float = math.nan
    tracking: float = math.nan
    finished: bool = False


def compare(
    methods: Mapping[str, Callable[[], Planning]],
    problems: Sequence[SampledProblem],
    *,
    out: Path | str,
    tolerances: Tolerances | None = None,
    limit: float = 10.0,
    core: int | None = None,
    progress: Callable[[ComparisonRow], None] | None = None,
) -> list[ComparisonRow]:
    """Let every method plan every problem.

    Parameters
    ----------
    methods : mapping of str to callable
        Makes each method, see `Worker`.
    problems : sequence of Drawn
        What is to be planned.
    out : path
        File of comma-separated values to which each row is added at once. Rows that are there already are
        not made again, so that an interrupted run goes on.
    tolerances : Tolerances, optional
        Of the judge.
    limit : float
        Time after which a plan is stopped [s].
    core : int, optional
        Processor core for the methods.
    progress : callable, optional
        Called with each new row.

    Returns
    -------
    rows : list of Row
        Those of the file that were asked for, by method and problem.

    Notes
    -----
    A method that raises or does not return is an entry of the table. A problem is planned once and then up to
    three times again, fewer where that takes more than 0.3 s; results but not times are the same for equal
    problems.
    """
    known = {(row.method, row.kind, row.seed): row for row in read_rows(out, ComparisonRow)}
    rows = []
    for name, make in methods.items():
        with Worker(make, limit=limit, core=core) as worker:
            for drawn in problems:
                row = known.get((name, drawn.kind, drawn.seed))
                if row is None:
                    row = _row(name, drawn, worker, tolerances)
                    append_row(out, row)
                    if progress is not None:
                        progress(row)
                rows.append(row)
    return rows


def _row(name: str, drawn: SampledProblem, worker: Worker, tolerances: Tolerances | None) -> ComparisonRow:
    plan, failure, first = worker.plan(drawn.problem)
    head: dict[str, Any] = {"method": name, "kind": drawn.kind, "seed": drawn.seed, "first_ms": 1e3 * first}
    if plan is None:
        return ComparisonRow(**head, outcome=failure.split()[0], message=failure)
    times: list[float] = []
    while len(times) < _WARM and first + sum(times) < _ENOUGH:
        again, failure, spent = worker.plan(drawn.problem)
        if again is None:
            return ComparisonRow(**head, outcome=failure.split()[0], message=failure)
        times.append(spent)
    time_ms = 1e3 * (statistics.median(times) if times else first)
    if plan.status is not Status.OK:
        outcome = "rightly refused" if drawn.proof is None else "refused"
        return ComparisonRow(
            **head, outcome=outcome, time_ms=time_ms, message=f"{plan.status.name}: {plan.message}"
        )
    return ComparisonRow(**head, time_ms=time_ms, **_measured(drawn.problem, plan, tolerances))


def _measured(problem: Problem, plan: Plan, tolerances: Tolerances | None) -> dict[str, Any]:
    """Everything about a plan that claims to be good."""
    verdict = verify_plan(problem, plan, tolerances)
    seen: dict[str, Any] = {
        "outcome": "solved" if verdict.passed else "false OK", "message": "; ".join(verdict.violations),
        "length": verdict.length, "clearance": verdict.clearance, "edge": verdict.edge, "a_y": verdict.a_y,
        "jerk": verdict.jerk, "swings": verdict.a_y_reversals,
    }  # fmt: skip
    if "no trajectory" in verdict.violations:
        return seen
    driven = drive_plan(problem, plan)
    return seen | {
        "driven_clearance": driven.clearance, "driven_edge": driven.edge, "driven_a_y": driven.a_y,
        "driven_jerk": driven.jerk, "tracking": driven.tracking, "finished": driven.finished,
    }  # fmt: skip
