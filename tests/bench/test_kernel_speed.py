"""Run times of calls of the kernel from Python, and of the kernel without its compiled form."""

import os
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cca_core import kernel
from cca_core.kernel import bind
from cca_core.kernel.box_gaps import oriented_box_gap
from cca_core.kernel.curve import Curve, curvature_at
from cca_core.kernel.memory import lend
from cca_core.kernel.speed import arrival_times
from tests.bench.timing import Budget, median_us

NEEDS_C = pytest.mark.skipif(kernel.COMPILED is None, reason=kernel.backend_reason())
CALLS = 1000  # at once: a call is shorter than the clock's step
NUMPY_US = {"A": 309.0, "B": 496.0}  # of the library before its kernel, where the reference took 14.3 us
PYTHON_FORM = """
import sys
from tests.bench import test_band_speed as band
from tests.bench.timing import median_us
problem = getattr(band, sys.argv[1])
nodes, cars, sides = problem.nodes, problem.obstacles, problem.sides
asked = {"side": sides, "vehicle": band.CAR, "clearance": problem.clearance}
print(median_us(lambda: band.relax_band(nodes, cars, **asked).path(), 300))
"""


def call_of(name: str, form: str) -> Callable[[], Any]:
    """Return a call whose work is as small as its kernel allows."""
    if name == "ten numbers":
        gap, numbers = bind(oriented_box_gap, form), (9.0, 1.0, 1.0, 0.0, 1.0, 0.0, 2.0, 1.0, 2.0, 1.0)
        return lambda: gap(*numbers)
    if name == "two arrays":
        times, distance, t = bind(arrival_times, form), np.array([50.0]), np.empty(1)
        return lambda: times(1, 10.0, 20.0, distance, 2.0, 2.0, t)
    lent, curvature = lend(Curve, form, segments=1), bind(curvature_at, form)
    lent.arrays["breaks"][:] = 0.0, 100.0
    lent.arrays["powers"][0, 4] = 1.0
    return lambda: curvature(lent.workspace, 50.0)


@NEEDS_C
@pytest.mark.parametrize(("name", "limit"), [("ten numbers", 0.25), ("two arrays", 1.0), ("workspace", 0.4)])
def test_call(
    name: str, limit: float, slowness: float, budget: Budget, record_property: Callable[[str, object], None]
) -> None:
    """Call from Python, its overhead and next to no work."""
    call = call_of(name, "c")

    def calls() -> None:
        for _ in range(CALLS):
            call()

    took = median_us(calls, 50) / CALLS
    record_property("us", round(took, 3))
    record_property("python_form_us", round(median_us(call_of(name, "python"), 1000), 2))
    budget(took, "µs", max_value=limit * slowness)


@pytest.mark.parametrize("name", NUMPY_US)
def test_band_without_compiler(
    name: str, reference_us: float, budget: Budget, record_property: Callable[[str, object], None]
) -> None:
    """Certified path in the kernel's Python: at most 2.5 times the NumPy form that it has replaced."""
    run = [sys.executable, "-c", PYTHON_FORM, name]
    found = subprocess.run(run, capture_output=True, check=True, env=os.environ | {"CCA_KERNEL": "python"})
    took = float(found.stdout)
    record_property("us", round(took))
    budget(took / (NUMPY_US[name] * reference_us / 14.3), "times", max_value=2.5)
