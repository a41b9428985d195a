"""Run times of decisions among twenty vehicles, in situations in which there is much to decide."""

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cca_core import Planner
from tests.bench.timing import Budget
from tests.support.crowds import CROWDS, drive

Report = Callable[[str, object], None]
CYCLES, ROUNDS = 300, 3


def decision_times(name: str) -> np.ndarray:
    """Times of the decisions of a drive, the least of some rounds [ms]."""
    best = np.full(CYCLES, math.inf)
    for _ in range(ROUNDS):
        times: list[float] = []

        def timed(planner: Planner, *given: Any, times: list[float] = times) -> Any:
            # of this thread: the worst must not be the time of another process
            begun = time.thread_time()
            command = planner.step(*given)
            times.append(1e3 * (time.thread_time() - begun))
            return command

        drive(CROWDS[name](), CYCLES, timed)
        best = np.minimum(best, times)
    return best[::5]  # the planner decides each 0.1 s


@pytest.fixture(scope="module")
def decisions() -> dict[str, np.ndarray]:
    """Times of the decisions of all situations [ms]."""
    return {name: decision_times(name) for name in CROWDS}


@pytest.mark.parametrize(
    ("share", "limit"), [(50.0, 2.0), (99.0, 5.0), (100.0, 10.0)], ids=["p50", "p99", "worst"]
)
def test_decision(
    decisions: dict[str, np.ndarray], slowness: float, budget: Budget, record_property: Report, share: float,
    limit: float,
) -> None:  # fmt: skip
    """All situations together."""
    took = float(np.percentile(np.concatenate(list(decisions.values())), share))
    record_property("us", round(1e3 * took))
    budget(took, "ms", max_value=limit * slowness)


@pytest.mark.parametrize("name", CROWDS)
def test_decision_among_a_crowd(
    decisions: dict[str, np.ndarray], slowness: float, budget: Budget, record_property: Report, name: str
) -> None:
    """The worst decision of each situation."""
    took = float(decisions[name].max())
    record_property("us", round(1e3 * took))
    budget(took, "ms", max_value=5.0 * slowness)
