"""Methods compared: every plan is timed, verified and driven, and kept as a row of a store."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

from cca_core._repr import short_repr
from cca_core.baselines.problems.drive import drive_plan
from cca_core.baselines.problems.kept_row import kept_row
from cca_core.baselines.problems.problem import Plan, PlanningMethod, Problem
from cca_core.baselines.problems.sampling import SampledProblem
from cca_core.baselines.problems.verify import Tolerances, verify_plan
from cca_core.baselines.problems.worker import Worker
from cca_core.errors import Status
from cca_core.sim.study.store import Store


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
        Seed of the problem.
    outcome : str
        ``"solved"`` (claimed, and verified), ``"false OK"`` (claimed, but not verified), ``"refused"`` (not
        claimed although a plan exists), ``"rightly refused"``, ``"TIMEOUT"`` or ``"ERROR"``.
    message : str
        Violations, or the reason why there is no plan.
    first_ms : float
        Processor time of the first plan for this problem [ms].
    time_ms : float
        Median processor time of the repeated plans for it [ms].
    length : float
        Length of the trajectory [m].
    clearance, edge : float
        Smallest distance to the other vehicles and to the road edges as planned [m].
    a_y, jerk : float
        Largest lateral acceleration [m/s^2] and jerk [m/s^3] as planned.
    a_y_reversals : int
        Number of sign changes of the lateral acceleration.
    driven_clearance, driven_edge : float
        Distances when driven [m].
    driven_a_y, driven_jerk : float
        Largest lateral acceleration [m/s^2] and jerk [m/s^3] when driven.
    tracking : float
        Largest distance of the driven car from the plan [m].
    finished : bool
        Whether the car reached the end of the plan.

    Notes
    -----
    Without a plan that is claimed, all figures are NaN.
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
    a_y_reversals: int = 0
    driven_clearance: float = math.nan
    driven_edge: float = math.nan
    driven_a_y: float = math.nan
    driven_jerk: float = math.nan
    tracking: float = math.nan
    finished: bool = False

    __repr__ = short_repr


def compare(
    methods: Mapping[str, Callable[[], PlanningMethod]],
    problems: Sequence[SampledProblem],
    *,
    store: Store | None = None,
    tolerances: Tolerances | None = None,
    limit: float = 10.0,
    core: int | None = None,
    progress: Callable[[ComparisonRow], None] | None = None,
) -> list[ComparisonRow]:
    """Plan every problem with every method.

    Parameters
    ----------
    methods : mapping of str to callable
        Makes each method, an object with ``plan(problem)``, in a process of its own. The callable must be
        importable by name: a class, or a `functools.partial` of one.
    problems : sequence of SampledProblem
        The problems.
    store : Store, optional
        Rows on disk (`cca_core.sim.study.store.Store`). New rows are added at once, and rows that it holds
        are not made again: an interrupted run can be continued.
    tolerances : Tolerances, optional
        Of the verification.
    limit : float
        Time after which a plan is stopped [s].
    core : int, optional
        Processor core for the methods.
    progress : callable, optional
        Called with each new row.

    Returns
    -------
    rows : list of ComparisonRow
        By method, then by problem.

    Notes
    -----
    A method that raises or does not return is a row of its own. Each problem is planned once, and up to three
    times again until 0.3 s are spent. Plans, but not times, are the same for equal problems.
    """
    rows = []
    for name, make in methods.items():
        with Worker(make, limit=limit, core=core) as worker:
            for sampled in problems:
                measure = partial(_row, name, sampled, worker, tolerances)
                key = ("plan", name, sampled.kind, sampled.seed)
                rows.append(kept_row(store, key, ComparisonRow, measure, progress))
    return rows


def _row(name: str, sampled: SampledProblem, worker: Worker, tolerances: Tolerances | None) -> ComparisonRow:
    """Row of one method on one problem."""
    timed = worker.time(sampled.problem, repeats=3, enough=0.3)
    head: dict[str, Any] = {"method": name, "kind": sampled.kind, "seed": sampled.seed}
    head["first_ms"] = 1e3 * timed.first
    if timed.plan is None:
        return ComparisonRow(**head, outcome=timed.failure.split()[0], message=timed.failure)
    head["time_ms"] = 1e3 * timed.median
    if timed.plan.status is not Status.OK:
        outcome = "rightly refused" if sampled.proof is None else "refused"
        message = f"{timed.plan.status.name}: {timed.plan.message}"
        return ComparisonRow(**head, outcome=outcome, message=message)
    return ComparisonRow(**head, **_measured(sampled.problem, timed.plan, tolerances))


def _measured(problem: Problem, plan: Plan, tolerances: Tolerances | None) -> dict[str, Any]:
    """Figures of a plan with status OK."""
    found = verify_plan(problem, plan, tolerances)
    figures = asdict(found) | {
        "outcome": "solved" if found.passed else "false OK", "message": "; ".join(found.violations),
    }  # fmt: skip
    del figures["violations"]
    if "no trajectory" in found.violations:
        return figures
    driven = drive_plan(problem, plan)
    return figures | {
        "driven_clearance": driven.clearance, "driven_edge": driven.edge, "driven_a_y": driven.a_y,
        "driven_jerk": driven.jerk, "tracking": driven.tracking, "finished": driven.finished,
    }  # fmt: skip
