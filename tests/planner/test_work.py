"""Work of a decision: the number of its bands is bounded, whatever is around the ego."""

from typing import Any

import numpy as np
import pytest

from cca_core import Lane
from cca_core.planner import maneuvers
from cca_core.vehicle import VehicleState
from tests.support.crowds import CROWDS, drive
from tests.support.planner_drives import car, ego_state, make_planner

MAX_BANDS = 48  # 3 groups, 2 sides, 2 corridors; in comfort, hard, and narrow twice
MAX_COMFORTABLE = 12  # of these
MAX_BANDS_AT_WALKING_PACE = 60  # comfortable ones twice as well


@pytest.fixture
def bands(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Number of bands that have been bent so far."""
    count, relax = [0], maneuvers.relax_band

    def counted(*args: Any, **kwargs: Any) -> Any:
        count[0] += 1
        return relax(*args, **kwargs)

    monkeypatch.setattr(maneuvers, "relax_band", counted)
    return count


@pytest.mark.parametrize("n", [4, 30])
def test_bands_that_all_fail_attain_their_bound(bands: list[int], n: int) -> None:
    planner = make_planner((Lane(d=0.0, width=9.0), Lane(d=9.0, width=9.0), Lane(d=-9.0, width=9.0)))
    planner.step(0.0, ego_state(), [car(32.0 + 8.0 * i, 0.0, 0.0, id=f"R{i}") for i in range(n)])
    assert bands[0] == MAX_BANDS


def test_walking_pace_adds_tight_bands(bands: list[int]) -> None:
    planner = make_planner((Lane(d=0.0, width=9.0), Lane(d=9.0, width=9.0), Lane(d=-9.0, width=9.0)))
    others = [car(26.0 + 8.0 * i, 0.0, 0.0, id=f"R{i}") for i in range(4)]
    planner.step(0.0, VehicleState(x=20.0, y=0.0, psi=0.0, v_x=1.0), others)
    assert MAX_COMFORTABLE < bands[0] <= MAX_BANDS_AT_WALKING_PACE


def test_random_decisions_keep_bound_of_bands(bands: list[int]) -> None:
    random = np.random.default_rng(8)
    for _ in range(40):
        width = float(random.uniform(3.0, 9.0))
        planner = make_planner(tuple(Lane(d=d * width, width=width) for d in (0, 1, -1)))
        x, d, v = random.uniform((10.0, -1.5 * width, 0.0), (200.0, 1.5 * width, 15.0), (12, 3)).T.tolist()
        others = [car(*each, id=f"R{i}") for i, each in enumerate(zip(x, d, v, strict=True))]
        for k in range(3):
            bands[0] = 0
            planner.step(0.1 * k, VehicleState(x=20.0 + 2.0 * k, y=0.0, psi=0.0, v_x=20.0), others)
            assert bands[0] <= MAX_BANDS


@pytest.mark.parametrize("name", ["dense", "slow queue"])
def test_crowds_keep_bound_of_bands(bands: list[int], name: str) -> None:
    def counted(planner: Any, *given: Any) -> Any:
        bands[0] = 0
        command = planner.step(*given)
        assert bands[0] <= MAX_BANDS
        return command

    drive(CROWDS[name](), 100, counted)
