"""Curb-side: the ego slows and evades the parked car at both speeds; driver and sensor come late."""

import numpy as np
import pytest

from cca_core.sim import CURBSIDE_CASES, curbside, simulate
from cca_core.v2x import ChannelSettings
from tests.support.paper_runs import gap, simulated

SEEDS = (1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (2, 3, 4, 5)))
IDEAL = ChannelSettings(latency=0.1)


@pytest.mark.parametrize("seed", SEEDS)
def test_fast_ego_evades(seed: int) -> None:
    log = simulated("curbside", "fast", "v2v", seed=seed)
    assert "EVADE_LEFT" in log.actions
    assert log.actions[-1] == "KEEP"
    assert log.ego[:, 3].min() > 20.0
    assert np.abs(log.a_y).max() <= 2.5
    assert abs(log.ego_frenet[-1, 1]) < 0.1


@pytest.mark.parametrize("seed", SEEDS)
def test_slow_ego_slows_and_evades(seed: int) -> None:
    log = simulated("curbside", "slow", "v2v", seed=seed)
    assert "EVADE_LEFT" in log.actions
    assert log.actions[-1] == "KEEP"
    assert len(log.actions) <= 6
    assert -log.ego[:, 7].min() <= 4.5  # yellow may be silent for a second
    assert np.abs(log.a_y).max() <= 2.5
    assert log.gaps()[:, 1].min() > 0.8


def test_slow_ego_brakes_gently_on_ideal_channel() -> None:
    log = simulate(curbside("slow", channel=IDEAL))
    assert -log.ego[:, 7].min() <= 2.5


@pytest.mark.parametrize(("case", "left"), [("fast", 1.62), ("slow", 1.77)])
def test_red_becomes_visible_late(case: str, left: float) -> None:
    log = simulated("curbside", case, "driver")
    v = log.scenario.v_x
    sees = int(np.searchsorted(log.t, log.time_of("first_visible", "red")))
    assert gap(log, 1, None)[sees] / v == pytest.approx(left, abs=0.2)


def test_yellow_passes_red() -> None:
    for case in CURBSIDE_CASES:
        log = simulated("curbside", case, "v2v")
        apart = np.hypot(*(log.road_users[:, 0, :2] - log.road_users[:, 1, :2]).T)
        alongside = np.abs(log.user_frenet[:, 0, 0] - log.user_frenet[:, 1, 0]) < 4.5
        assert (log.user_frenet[alongside, 0, 1] - log.user_frenet[alongside, 1, 1]).min() > 1.8
        assert apart.min() > 1.8


def test_parked_car_is_received_before_visible() -> None:
    log = simulated("curbside", "fast", "v2v")
    assert log.time_of("first_received", "red") < 2.0
    assert log.time_of("lateral_shift") < log.time_of("first_visible", "red")


def test_sensor_ego_is_slower_than_driver_at_collision() -> None:
    fast, slow = (simulated("curbside", case, "sensor") for case in CURBSIDE_CASES)
    assert fast.closing_speed() < simulated("curbside", "fast", "driver").closing_speed() - 4.0
    assert slow.closing_speed() < simulated("curbside", "slow", "driver").closing_speed() - 4.0
    assert fast.summary()["ego"] == "sensor"
    assert fast.summary()["v2v"] is False
