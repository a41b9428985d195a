"""Timing of calls, and the reference to which budgets are scaled."""

import gc
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import solve_banded

REFERENCE = partial(
    solve_banded, (1, 1), np.repeat(np.array([[-1.0], [2.0], [-1.0]]), 100, axis=1), np.ones((100, 2))
)
REFERENCE_US = 16.6  # its time on the reference machine, for which the budgets are meant
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
