"""What run times are scaled by."""

import gc
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.linalg import solve_banded

_REFERENCE_US = 16.6  # solve_banded, n = 100, two right-hand sides, on the machine the targets are for


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


@pytest.fixture
def slowness() -> float:
    """How much slower than that machine this one is just now."""
    matrix, right = np.repeat(np.array([[-1.0], [2.0], [-1.0]]), 100, axis=1), np.ones((100, 2))
    return max(1.0, median_us(lambda: solve_banded((1, 1), matrix, right), 2000) / _REFERENCE_US)
