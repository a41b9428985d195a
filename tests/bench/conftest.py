"""Scale of the run times, and the assertion of budgets."""

import math
from collections.abc import Callable

import pytest

from tests.bench.timing import REFERENCE, REFERENCE_US, Budget, median_us


@pytest.fixture(scope="session", autouse=True)
def reference_us() -> float:
    """Time of the reference, measured once before all tests, so that one run has one number [us]."""
    return median_us(REFERENCE, 20_000)


@pytest.fixture(scope="session")
def slowness(reference_us: float) -> float:
    """Factor by which this machine is slower than the reference machine; at least 1."""
    return max(1.0, reference_us / REFERENCE_US)


@pytest.fixture
def budget(record_property: Callable[[str, object], None]) -> Budget:
    """Assert a budget and record it for docs/performance.md; the last line of a test."""

    def check(value: float, unit: str, *, max_value: float = math.inf, min_value: float = 0.0) -> None:
        bound = f"at least {min_value:.4g}" if math.isinf(max_value) else f"at most {max_value:.4g}"
        record_property("budget", f"{value:.4g} {unit}, {bound}")
        assert min_value <= value <= max_value

    return check
