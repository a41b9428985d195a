"""What run times are scaled by, and how a budget is asserted."""

import gc
import math
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from scipy.linalg import solve_banded

REFERENCE = partial(
    solve_banded, (1, 1), np.repeat(np.array([[-1.0], [2.0], [-1.0]]), 100, axis=1), np.ones((100, 2))
)
REFERENCE_US = 16.6  # what it takes on the reference machine, the one that budgets are meant for
Budget = Callable[..., None]


def median_us(run: Callable[[], Any], rounds: int) -> float:
    """Median time of a call, without garbage collection [us]."""
    times = np.empty(rounds)
    run()
    gc.disable()
    try:
        for i in range(rounds):
            begun = time.perf_counter()
            run()
            times[i] = time.perf_counter() - begun
    finally:
        gc.enable()
    return 1e6 * float(np.median(times))


@pytest.fixture(scope="session", autouse=True)
def reference_us() -> float:
    """What the reference takes here, measured once and before all tests: one run has one number [us]."""
    return median_us(REFERENCE, 20_000)


@pytest.fixture(scope="session")
def slowness(reference_us: float) -> float:
    """How much slower than the reference machine this one is; at least 1."""
    return max(1.0, reference_us / REFERENCE_US)


@pytest.fixture
def budget(record_property: Callable[[str, object], None]) -> Budget:
    """Assert a budget, and note for docs/performance.md what was compared with what. A test's last line."""

    def judge(value: float, unit: str, *, most: float = math.inf, least: float = 0.0) -> None:
        bound = f"at least {least:.4g}" if math.isinf(most) else f"at most {most:.4g}"
        record_property("budget", f"{value:.4g} {unit}, {bound}")
        assert least <= value <= most

    return judge
