"""The kernel's bands equal those of the NumPy form, which is slow and has no warm start."""

import numpy as np
import pytest

from cca_core.band import relax_band
from tests.support.band_cases import Case, case
from tests.support.band_numpy import NumpyBand

SAME = 2e-7  # [m]
QUICK, FULL = 8, 1667  # cases for each number of obstacles


def compare(problem: Case, start: tuple[float, ...]) -> tuple[str, str, float]:
    """Status of both forms with the same sides, and how far their displacements differ."""
    asked = {"vehicle": problem.vehicle, "clearance": problem.clearance, "corridor": problem.corridor}
    band = relax_band(
        problem.nodes, problem.obstacles, curvature_limit=problem.curvature_limit, start=start, **asked
    )
    u, status = NumpyBand(problem, band.sides, start).relax()
    return band.status.name, status, float(np.abs(band.displacement - u).max())


@pytest.mark.parametrize("is_off_route", [False, True])
@pytest.mark.parametrize("count", [QUICK, pytest.param(FULL, marks=pytest.mark.slow)])
def test_band_equals_numpy_form(count: int, is_off_route: bool) -> None:
    found = []
    for obstacles in range(1, 7):
        for number in range(count):
            random = np.random.default_rng([4, obstacles, number])
            problem = case(random, obstacles)
            start = (0.0, 0.0, 0.0)
            if is_off_route:
                start = tuple(random.uniform(-1.0, 1.0) + random.normal(0.0, 0.03, 3))
            found.append(compare(problem, start))
    other_status = [pair for *pair, _ in found if pair[0] != pair[1]]
    assert len(other_status) <= 1e-3 * len(found)
    assert max(off for a, b, off in found if a == b) <= SAME
