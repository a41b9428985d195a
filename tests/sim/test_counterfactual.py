"""Avoidability by closed forms: braking from v with b takes v^2 / 2b and the time of building up."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from cca_core.errors import InputError
from cca_core.sim import Log, curbside, eebl, ima, make_planner, simulate
from cca_core.sim.study.counterfactual import avoiding_action, first_hazard_cycle
from cca_core.v2x import ChannelSettings


@cache
def curb(radio_range: float, **change: float) -> Log:
    """A run of an ego that detects red by messages alone."""
    blind = replace(curbside("fast", channel=ChannelSettings(range=radio_range), **change), sensor_range=0.0)
    return simulate(blind)


@pytest.mark.parametrize("make", [eebl, ima, curbside])
def test_paper_scenarios_are_avoidable(make: Any) -> None:
    assert avoiding_action(simulate(make())) == "brake"


def test_braking_needs_its_distance() -> None:
    """25^2 / 14 = 44.6 m, and (0.55 / 2 + 0.1) s, half of the ramp and the lag, at 25 m/s: 54 m."""
    touching = 4.5  # distance of the centers of two bodies that touch
    assert avoiding_action(curb(touching + 63.0)) == "brake"
    assert avoiding_action(curb(touching + 51.0)) == "evade"


def test_evading_needs_its_distance() -> None:
    """0.95 m in 1 s take 5.8 x 0.95 = 5.5 m/s^2, which mu = 0.9 gives; in half a second 22 m/s^2."""
    assert avoiding_action(curb(4.5 + 27.5)) == "evade"
    assert avoiding_action(curb(4.5 + 14.0)) == ""


def test_no_evading_without_adjacent_lane() -> None:
    log = curb(4.5 + 40.0)
    assert avoiding_action(log) == "evade"
    narrow = curbside("fast", channel=ChannelSettings(range=44.5))
    road = type(narrow.road)(narrow.road.path, speed_limit=narrow.road.speed_limit)
    assert avoiding_action(simulate(replace(narrow, road=road))) == ""


@pytest.mark.filterwarnings("ignore:yellow drives into adjacent:UserWarning")
def test_evading_into_another_vehicle_does_not_count() -> None:
    scenario = curbside("fast", channel=ChannelSettings(range=44.5))
    red = scenario.road_users[1]
    adjacent = replace(red, id="adjacent", d=2.6, connected=False)
    assert avoiding_action(simulate(replace(scenario, road_users=(*scenario.road_users, adjacent)))) == ""


def test_run_without_hazard_message_is_not_avoidable() -> None:
    log = curb(1.0)
    assert first_hazard_cycle(log) is None
    assert avoiding_action(log) == ""


def test_first_hazard_is_first_delivered_message() -> None:
    late = ChannelSettings(latency=0.3)
    log = simulate(eebl(channel=late))
    hazard = first_hazard_cycle(log)
    assert hazard is not None
    # red brakes at 2 s and has 0.4 g at 2.31 s; then up to 0.1 s until it sends
    assert 2.31 + 0.3 - 0.02 <= log.t[hazard] <= 2.31 + 0.1 + 0.3 + 0.04
    assert hazard == min(k for k, _ in log.received if log.t[k] >= log.time_of("hazard_received", "red"))


def test_run_is_repeated_exactly_until_hazard(monkeypatch: pytest.MonkeyPatch) -> None:
    import cca_core.sim.study.counterfactual as module

    log, again = simulate(eebl()), []
    drive = module.run_loop
    monkeypatch.setattr(module, "run_loop", lambda *a, **k: again.append(drive(*a, **k)) or again[-1])
    assert avoiding_action(log) == "brake"
    hazard = first_hazard_cycle(log)
    assert hazard is not None
    np.testing.assert_array_equal(again[0].ego[: hazard + 1], log.ego[: hazard + 1])
    np.testing.assert_array_equal(again[0].road_users[: hazard + 1], log.road_users[: hazard + 1])
    assert again[0].received[: len(log.received) // 4] == log.received[: len(log.received) // 4]
    assert again[0].ego[:, 7].min() == pytest.approx(-7.0, abs=0.05)


def test_collision_of_deaf_ego_was_avoidable() -> None:
    """An ego that ignores its messages collides, although braking would have avoided it."""
    scenario = eebl("C")
    deaf = make_planner(scenario)
    step = deaf.step
    deaf.step = lambda t, state, remotes, **k: step(t, state, [], **k)  # type: ignore[method-assign]
    log = simulate(scenario, planner=deaf)
    assert log.summary()["collided"]
    assert avoiding_action(log) == "brake"


def test_run_without_messages_raises() -> None:
    with pytest.raises(InputError, match="messages"):
        avoiding_action(simulate(eebl("A")))
