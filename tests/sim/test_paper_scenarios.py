"""All of the paper's scenarios: collisions without messages, none with them, regressions."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from cca_core.errors import InputError
from cca_core.sim import (
    LOSSY_CHANNEL,
    ParameterRanges,
    Scenario,
    curbside,
    eebl,
    ima,
    make_planner,
    overtaking,
    paper_scenarios,
    simulate,
)
from cca_core.sim.study.parameters import sample_scenario
from tests.support.paper_runs import simulated
from tests.support.sweeps import sweep

SEEDS = (1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (2, 3, 4, 5)))
MULTI_BODY = pytest.param("multi_body", marks=[pytest.mark.requires("vehiclemodels"), pytest.mark.slow])
WITHOUT = [
    ("eebl", "A", "yellow"), ("ima", "left-turn", "red"), ("ima", "crossing", "red"),
    ("curbside", "fast", "red"), ("curbside", "slow", "red"),
]  # fmt: skip
WITH = [
    ("eebl", "C"), ("ima", "left-turn"), ("ima", "crossing"), ("curbside", "fast"), ("curbside", "slow"),
]  # fmt: skip


def test_lossy_channel_parameters() -> None:
    assert LOSSY_CHANNEL.latency == 0.1
    assert LOSSY_CHANNEL.loss_probability == 0.3
    assert LOSSY_CHANNEL.mean_burst_length > 1.0 / (1.0 - LOSSY_CHANNEL.loss_probability)


@pytest.mark.parametrize("plant", ["single_track", MULTI_BODY])
@pytest.mark.parametrize(("name", "case", "hit"), WITHOUT)
def test_driver_collides(name: str, case: str, hit: str, plant: str) -> None:
    log = simulated(name, case, "driver", plant=plant)
    summary = log.summary()
    assert summary["collided_with"] == hit
    assert (summary["ego"], summary["v2v"], summary["plant"]) == ("driver", False, plant)
    assert not log.tracked.any()
    assert log.received == ()


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("name", "case"), WITH)
def test_no_collision_with_v2v(name: str, case: str, seed: int) -> None:
    log = simulated(name, case, "v2v", seed=seed)
    assert log.gaps().min() >= 1.0
    assert log.t[-1] == pytest.approx(log.scenario.duration)
    assert not any("internal error" in reason for _, _, reason in log.decisions)
    assert log.scenario.channel is LOSSY_CHANNEL
    lost = 1.0 - log.messages["delivered"] / log.messages["sent"]
    assert 0.1 < lost < 0.5
    assert log.messages["ego_sent"] == pytest.approx(10.0 * log.scenario.duration, abs=1.0)


@pytest.mark.requires("vehiclemodels")
@pytest.mark.parametrize(("name", "case"), sweep(*WITH, quick=2))
def test_no_collision_with_v2v_multi_body(name: str, case: str) -> None:
    log = simulated(name, case, "v2v", plant="multi_body")
    assert log.gaps().min() >= 1.0
    assert log.t[-1] == pytest.approx(log.scenario.duration)
    if name == "ima":  # it moves off again
        assert log.ego[-1, 3] > 5.0


@pytest.mark.parametrize("index", [328, pytest.param(553, marks=pytest.mark.slow)])
def test_lead_braking_harder_than_downstream_vehicle(index: int) -> None:
    """Red brakes with 4 to 5 m/s^2, and yellow, late, with 7."""
    scenario, nominal, _ = sample_scenario(ParameterRanges(scenario="eebl"), 2, index)
    planner = make_planner(replace(scenario, vehicle=nominal))
    assert simulate(scenario, planner=planner).gaps().min() > 0.0


@pytest.mark.parametrize("index", [347, pytest.param(1594, marks=pytest.mark.slow)])
def test_full_braking_for_late_crossing_vehicle(index: int) -> None:
    """The first message leaves just the distance for full braking."""
    scenario, nominal, _ = sample_scenario(ParameterRanges(scenario="ima"), 2, index)
    planner = make_planner(replace(scenario, vehicle=nominal))
    log = simulate(scenario, planner=planner)
    assert log.gaps().min() > 0.0
    assert "BRAKE" in log.actions


@pytest.mark.parametrize(
    ("name", "seed", "index"),
    [
        # first message 26 m ahead: only evading at the limit helps
        pytest.param("curbside", 3, 268, id="evade-at-the-limit"),
        # first message 40 m ahead, with a bound of 0.9 m: no space next to it
        pytest.param("curbside", 21, 602, id="no-space-next-to-bound"),
        # position errors place red outside the lane
        pytest.param("curbside", 3, 646, id="position-error-1", marks=pytest.mark.slow),
        pytest.param("curbside", 5, 1392, id="position-error-2", marks=pytest.mark.slow),
        # a visible lead vehicle sends nothing, R1 is behind
        pytest.param("maneuver", 4, 3, id="silent-lead-1"),
        pytest.param("maneuver", 4, 46, id="silent-lead-2", marks=pytest.mark.slow),
        pytest.param("maneuver", 4, 58, id="silent-lead-3", marks=pytest.mark.slow),
        pytest.param("maneuver", 6, 283, id="return-planned-for-speed-after-abort", marks=pytest.mark.slow),
        # canceled during the return, with vehicles alongside
        pytest.param("maneuver", 7, 56, id="cancel-during-return-1", marks=pytest.mark.slow),
        pytest.param("maneuver", 7, 221, id="cancel-during-return-2", marks=pytest.mark.slow),
        # the bound of red reaches the ego at its first message
        pytest.param("ima", 27, 1228, id="bound-reaches-ego"),
        # first message late: braking would stop in the path of red, continuing just avoids it
        pytest.param("ima", 27, 0, id="continue-instead-of-brake-1"),
        pytest.param("ima", 27, 1299, id="continue-instead-of-brake-2", marks=pytest.mark.slow),
        pytest.param("ima", 27, 1635, id="continue-instead-of-brake-3", marks=pytest.mark.slow),
        pytest.param("eebl", 9, 445, id="full-braking-just-helps"),
        pytest.param("eebl", 29, 542, id="all-grip-just-helps", marks=pytest.mark.slow),
        pytest.param("eebl", 29, 1512, id="full-braking-without-delay"),
        pytest.param("maneuver", 8, 64, id="vehicle-alongside-leaves-view", marks=pytest.mark.slow),
        pytest.param("maneuver", 9, 511, id="brake-release-ahead-of-R2", marks=pytest.mark.slow),
        # abort behind a slower vehicle that is already behind; braking ahead of A, stale behind
        pytest.param("maneuver", 21, 106, id="abort-or-brake-ahead-of-A-1", marks=pytest.mark.slow),
        pytest.param("maneuver", 21, 125, id="abort-or-brake-ahead-of-A-2", marks=pytest.mark.slow),
        pytest.param("maneuver", 21, 1221, id="abort-or-brake-ahead-of-A-3", marks=pytest.mark.slow),
        # R2 stale for seconds, 100 m ahead: full braking for its bound, ahead of R1
        pytest.param("maneuver", 22, 858, id="stale-lead-far-ahead-1", marks=pytest.mark.slow),
        pytest.param("maneuver", 22, 1650, id="stale-lead-far-ahead-2", marks=pytest.mark.slow),
        pytest.param("maneuver", 24, 1002, id="return-too-sharp-while-leaving-lane", marks=pytest.mark.slow),
        pytest.param("maneuver", 25, 364, id="early-return-as-fast-as-R1", marks=pytest.mark.slow),
        pytest.param("maneuver", 24, 370, id="slow-return-ahead-of-R1", marks=pytest.mark.slow),
        pytest.param("maneuver", 8, 423, id="stale-A-dead-reckoned-into-lane", marks=pytest.mark.slow),
        # after the pass of R1 it braked for the gap to A, 500 m ahead, which it would meet back in its lane
        pytest.param("maneuver", 29, 1699, id="gap-to-A-back-in-lane", marks=pytest.mark.slow),
        # it followed A, whose bound came near the lane: the pass was given up and taken up again
        pytest.param("maneuver", 30, 118, id="follows-oncoming-A-in-next-lane", marks=pytest.mark.slow),
        # the bound of A, with a position error of 1.3 m, reached into the lane to which the ego returned
        pytest.param("maneuver", 31, 392, id="bound-of-A-in-ego-lane", marks=pytest.mark.slow),
    ],
)
def test_collision_regressions(name: str, seed: int, index: int) -> None:
    scenario, nominal, _ = sample_scenario(ParameterRanges(scenario=name), seed, index)
    log = simulate(scenario, planner=make_planner(replace(scenario, vehicle=nominal)))
    assert log.gaps().min() > 0.0
    assert np.abs(log.ego_frenet[:, 1]).max() < 5.25


def test_paper_scenarios_are_distinct() -> None:
    scenarios = paper_scenarios()
    names = [(s.name, s.case, s.ego_type) for s in scenarios]
    assert len(set(names)) == len(names) == 19
    assert {name for name, _, _ in names} == {"eebl", "ima", "curbside", "maneuver"}
    assert all(s.paper_figures for s in scenarios)
    again = simulate(scenarios[0])
    assert again.seed == scenarios[0].seed


@pytest.mark.parametrize("make", [eebl, ima, curbside])
def test_unknown_case_raises(make: Callable[..., Scenario]) -> None:
    with pytest.raises(InputError, match="case"):
        make("no such case")


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: eebl(v_x=-1.0), "v_x"), (lambda: eebl(time_gap=0.0), "time_gap"),
        (lambda: ima(ego_type="cat"), "ego_type"), (lambda: ima(v_red=0.0), "v_red"),
        (lambda: ima(offset=9.0), "offset"),
        (lambda: curbside(lane_intrusion=5.0), "lane_intrusion"), (lambda: curbside(radius=10.0), "radius"),
        (lambda: overtaking("5", None), "case"),
    ],
)  # fmt: skip
def test_invalid_argument_raises(make: Callable[[], Scenario], named: str) -> None:
    with pytest.raises(InputError, match=rf"\b{named}\b"):
        make()
