"""IMA: the ego yields to an occluded car; a driver sees it too late."""

import numpy as np
import pytest

from cca_core.sim import ima, simulate
from tests.support.paper_runs import simulated
from tests.support.sweeps import sweep

SEEDS = (1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (2, 3, 4, 5)))


@pytest.mark.parametrize("seed", SEEDS)
def test_ego_turns_after_red_passed(seed: int) -> None:
    log = simulated("ima", "left-turn", "v2v", seed=seed)
    passed = log.road_users[:, 0, 0] + 2.25 < 0.0  # its rear has left the conflict area
    in_its_lane = log.bodies()[0].corners()[:, 0, :, 1].max(axis=1) > 3.5
    assert not (in_its_lane & ~passed).any()
    assert log.ego[:, 3].min() < 1.5  # it waits
    assert -log.ego[:, 7].min() < 0.6  # by slowing evenly; to stop at the line takes 1.8 m/s^2
    assert in_its_lane.any()
    assert log.ego_frenet[-1, 0] > 90.0
    assert np.abs(log.a_y).max() <= 3.1


@pytest.mark.parametrize("seed", SEEDS)
def test_ego_waits_at_stop_line(seed: int) -> None:
    log = simulated("ima", "left-turn", "v2v", seed=seed)
    line = log.scenario.stop_line
    assert line is not None
    passed = log.road_users[:, 0, 0] + 2.25 < 0.0
    assert (log.ego_frenet[~passed, 0] + 2.25).max() <= line + 0.2


def test_red_is_occluded_until_too_late_for_driver() -> None:
    """Red becomes visible 1.08 s before the conflict point, less than the driver's reaction time."""
    log = simulated("ima", "left-turn", "driver")
    sees = int(np.searchsorted(log.t, log.time_of("first_visible", "red") - 1e-9))
    assert (log.road_users[sees, 0, 0] - 1.29) / log.road_users[sees, 0, 3] == pytest.approx(1.08, abs=0.15)
    log = simulated("ima", "crossing", "driver")
    assert log.t[-1] - log.time_of("first_visible", "red") < 1.25


def test_van_does_not_occlude_red() -> None:
    log = simulate(ima(ego_type="driver", truck=(5.3, 2.0)))
    assert not log.summary()["collided"]


@pytest.mark.parametrize("offset", sweep(-0.6, 0.6, -0.3, 0.3, quick=2))
def test_outcome_does_not_depend_on_arrival_time(offset: float) -> None:
    assert simulate(ima(ego_type="driver", offset=offset)).summary()["collided_with"] == "red"
    assert simulate(ima(offset=offset)).gaps().min() > 1.0


def test_low_visibility_limits_sensor_range() -> None:
    clear, fog = simulate(ima(ego_type="driver")), simulate(ima(ego_type="driver", visibility=8.0))
    assert clear.visible[:, 1].sum() > fog.visible[:, 1].sum()
