"""Run times of the planning methods of Table 1 against matching peers.

A peer that runs here is timed in the same run. The time of another one was measured on the reference machine
and is scaled by the reference.
"""

import statistics
from typing import Any

import pytest

from cca_core import Status
from cca_core.baselines import LinearMpc, MotionPrimitives, MpcSettings, NonlinearMpc, Problem, Rrt
from tests.bench.peers import nmpc
from tests.bench.timing import Budget, median_us
from tests.support.table1_problems import problem

pytestmark = pytest.mark.benchmark(disable_gc=True, min_rounds=20, warmup=True, warmup_iterations=3)

CARS = {"one": ((50.0, 0.0),), "slalom": ((35.0, 0.0), (60.0, 3.5), (85.0, 0.0))}
LENGTHS = {"one": 100.0, "slalom": 120.0}
EACH = pytest.mark.parametrize("name", CARS)
BOUND = 1.5  # times the peer


def task(name: str) -> Problem:
    return problem([(s, d, 0.0) for s, d in CARS[name]], goal=LENGTHS[name])


def solver_call(planner: NonlinearMpc, given: Problem) -> Any:
    """The part of a plan that a peer has, too: the solver, from a guess that has chosen the sides."""
    program, calls = planner.program(len(given.others)), []
    run = program.run

    def recorded(*arguments: Any) -> Any:
        calls.append(arguments)
        return run(*arguments)

    program.run = recorded  # type: ignore[method-assign, assignment]
    try:
        assert planner.plan(given).status is Status.OK
    finally:
        program.run = run  # type: ignore[method-assign, assignment]
    return lambda: run(*calls[0])


@EACH
def test_nonlinear_mpc_by_ipopt(benchmark: Any, budget: Budget, name: str) -> None:
    peer = nmpc(LENGTHS[name], CARS[name], [d <= 0.0 for _, d in CARS[name]])
    planner, given = NonlinearMpc(MpcSettings(intervals=20)), task(name)
    before = median_us(peer.run, 20)
    benchmark(solver_call(planner, given))
    peer_us = 0.5 * (before + median_us(peer.run, 20))
    spent = 1e6 * benchmark.stats.stats.median
    whole = median_us(lambda: planner.plan(given), 20)
    benchmark.extra_info |= {
        "times_the_peer": round(spent / peer_us, 2), "peer_us": round(peer_us), "whole_plan_us": round(whole)
    }  # fmt: skip
    budget(1e-3 * spent, "ms", max_value=1e-3 * BOUND * peer_us)


@EACH
def test_nonlinear_mpc_by_fatrop(benchmark: Any, slowness: float, budget: Budget, name: str) -> None:
    peer_us = {"one": 1273.0, "slalom": 1997.0}[name] * slowness
    planner, given = NonlinearMpc(MpcSettings(intervals=20, solver="fatrop")), task(name)
    benchmark(solver_call(planner, given))
    spent = 1e6 * benchmark.stats.stats.median
    whole = median_us(lambda: planner.plan(given), 20)
    benchmark.extra_info |= {"times_the_peer": round(spent / peer_us, 2), "whole_plan_us": round(whole)}
    budget(1e-3 * spent, "ms", max_value=1e-3 * BOUND * peer_us)


@EACH
def test_random_tree_over_dubins_curves(benchmark: Any, slowness: float, budget: Budget, name: str) -> None:
    """Median over ten seeds of the first solution."""
    peer_us = {"one": 46_000.0, "slalom": 140_000.0}[name] * slowness
    given = task(name)

    def seeds() -> list[Any]:
        return [Rrt(seed=seed, time_limit=10.0).plan(given).status for seed in range(1, 11)]

    found = benchmark.pedantic(seeds, rounds=1)
    spent = statistics.median(
        median_us(lambda seed=seed: Rrt(seed=seed, time_limit=10.0).plan(given), 1)  # type: ignore[misc]
        for seed in range(1, 11)
    )
    benchmark.extra_info["times_the_peer"] = round(spent / peer_us, 2)
    assert found.count(Status.OK) == len(found)
    budget(1e-3 * spent, "ms", max_value=1e-3 * BOUND * peer_us)


@EACH
@pytest.mark.parametrize("method", [LinearMpc, MotionPrimitives], ids=["linear MPC", "primitives"])
def test_methods_without_matching_peer(benchmark: Any, method: Any, name: str) -> None:
    """No budget: these methods choose sides and check the result, which no peer does."""
    planner, given = method(), task(name)
    plan = benchmark(planner.plan, given)
    assert plan.status is Status.OK
