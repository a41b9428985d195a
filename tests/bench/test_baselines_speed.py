"""Run times of the planning methods of Table 1 against the rows of other tools that match them.

A row of another tool that is run here is timed in the same run; one that is known from a measurement on the
reference machine is scaled by the reference that both machines have timed.
"""

import statistics
from typing import Any

import pytest

from cca_core import Status
from cca_core.baselines import LinearMpc, MotionPrimitives, MpcSettings, NonlinearMpc, Problem, Rrt
from tests.bench.conftest import Budget, median_us
from tests.bench.peers import nmpc
from tests.support.table1_problems import problem

pytestmark = pytest.mark.benchmark(disable_gc=True, min_rounds=20, warmup=True, warmup_iterations=3)

PLACES = {"one": ((50.0, 0.0),), "slalom": ((35.0, 0.0), (60.0, 3.5), (85.0, 0.0))}
LENGTHS = {"one": 100.0, "slalom": 120.0}
EACH = pytest.mark.parametrize("name", PLACES)
BOUND = 1.5  # times the row of the peer


def task(name: str) -> Problem:
    return problem([(s, d, 0.0) for s, d in PLACES[name]], goal=LENGTHS[name])


def solving(planner: NonlinearMpc, given: Problem) -> Any:
    """The part of a plan that the peers' rows are: the solver, begun at a guess that has chosen the sides."""
    built, kept = planner.program(len(given.others)), []
    run = built.run

    def noted(*arguments: Any) -> Any:
        kept.append(arguments)
        return run(*arguments)

    built.run = noted  # type: ignore[method-assign]
    try:
        assert planner.plan(given).status is Status.OK
    finally:
        built.run = run  # type: ignore[method-assign]
    return lambda: run(*kept[0])


@EACH
def test_nonlinear_mpc_by_ipopt(benchmark: Any, budget: Budget, name: str) -> None:
    peer = nmpc(LENGTHS[name], PLACES[name], [d <= 0.0 for _, d in PLACES[name]])
    planner, given = NonlinearMpc(MpcSettings(intervals=20)), task(name)
    before = median_us(peer.run, 20)
    benchmark(solving(planner, given))
    row = 0.5 * (before + median_us(peer.run, 20))
    spent = 1e6 * benchmark.stats.stats.median
    whole = median_us(lambda: planner.plan(given), 20)
    benchmark.extra_info |= {
        "times_the_peer": round(spent / row, 2), "peer_us": round(row), "whole_plan_us": round(whole)
    }  # fmt: skip
    budget(1e-3 * spent, "ms", most=1e-3 * BOUND * row)


@EACH
def test_nonlinear_mpc_by_fatrop(benchmark: Any, slowness: float, budget: Budget, name: str) -> None:
    row = {"one": 1273.0, "slalom": 1997.0}[name] * slowness
    planner, given = NonlinearMpc(MpcSettings(intervals=20, solver="fatrop")), task(name)
    benchmark(solving(planner, given))
    spent = 1e6 * benchmark.stats.stats.median
    whole = median_us(lambda: planner.plan(given), 20)
    benchmark.extra_info |= {"times_the_peer": round(spent / row, 2), "whole_plan_us": round(whole)}
    budget(1e-3 * spent, "ms", most=1e-3 * BOUND * row)


@EACH
def test_random_tree_over_dubins_curves(benchmark: Any, slowness: float, budget: Budget, name: str) -> None:
    """Median over seeds of the first solution."""
    row = {"one": 46_000.0, "slalom": 140_000.0}[name] * slowness
    given = task(name)

    def seeds() -> list[Any]:
        return [Rrt(seed=seed, time_limit=10.0).plan(given).status for seed in range(1, 11)]

    found = benchmark.pedantic(seeds, rounds=1)
    spent = statistics.median(
        median_us(lambda seed=seed: Rrt(seed=seed, time_limit=10.0).plan(given), 1)  # type: ignore[misc]
        for seed in range(1, 11)
    )
    benchmark.extra_info["times_the_peer"] = round(spent / row, 2)
    assert found.count(Status.OK) == len(found)
    budget(1e-3 * spent, "ms", most=1e-3 * BOUND * row)


@EACH
@pytest.mark.parametrize("method", [LinearMpc, MotionPrimitives], ids=["linear MPC", "primitives"])
def test_those_without_a_matching_row(benchmark: Any, method: Any, name: str) -> None:
    """For the record: sides chosen, result checked, neither of which other rows contain."""
    planner, given = method(), task(name)
    plan = benchmark(planner.plan, given)
    assert plan.status is Status.OK
