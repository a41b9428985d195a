"""Sampled scenarios: ranges, repeatability, and what the planner knows."""

import math
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from cca_core.errors import InputError
from cca_core.sim import BrakeAction, ParameterRanges, ReactToLeadAction, Scenario, simulate
from cca_core.sim.study.parameters import sample_scenario, without_v2v
from cca_core.sim.study.sampling import STUDY_SCENARIOS


def sample(name: str, index: int = 0, seed: int = 1) -> tuple[Scenario, dict[str, Any]]:
    scenario, _, samples = sample_scenario(ParameterRanges(scenario=name), seed, index)
    return scenario, samples


@pytest.mark.parametrize("name", STUDY_SCENARIOS)
def test_sample_depends_on_seed_and_number_alone(name: str) -> None:
    (first, samples), (again, same) = sample(name, 7), sample(name, 7)
    assert samples == same
    assert [(u.id, u.s, u.v_x) for u in first.road_users] == [(u.id, u.s, u.v_x) for u in again.road_users]
    assert sample(name, 8)[1] != samples
    assert sample(name, 7, seed=2)[1] != samples


@pytest.mark.parametrize("name", STUDY_SCENARIOS)
def test_samples_fill_their_ranges(name: str) -> None:
    runs = [sample(name, i) for i in range(60)]
    variation = ParameterRanges(scenario=name)
    for field in fields(variation)[1:]:
        low, high = (
            variation.radio_range_bounds if field.name == "radio_range" else getattr(variation, field.name)
        )
        values = np.array([samples[field.name] for _, samples in runs])
        assert low <= values.min() < low + 0.15 * (high - low)
        assert high - 0.15 * (high - low) < values.max() <= high
    for scenario, samples in runs:
        channel, limit = scenario.channel, samples["friction"] * 9.81
        assert channel is not None
        assert (channel.latency, channel.loss_probability, channel.range) == (
            samples["latency"], samples["loss"], samples["radio_range"],
        )  # fmt: skip
        assert scenario.vehicle.mu == samples["friction"]
        assert scenario.vehicle.m == pytest.approx(1093.3 * samples["mass"])
        assert scenario.reaction_time == samples["ego_reaction_time"]
        for user in scenario.road_users:
            assert user.deceleration <= limit
            braking = [
                action for action in user.actions if isinstance(action, BrakeAction | ReactToLeadAction)
            ]
            assert all(action.deceleration <= limit for action in braking)
    assert len({scenario.case for scenario, _ in runs}) == {"curbside": 1, "maneuver": 4}.get(name, 2)


def test_default_radio_range_depends_on_scenario() -> None:
    assert ParameterRanges(scenario="ima").radio_range_bounds == (50.0, 400.0)
    assert ParameterRanges(scenario="maneuver").radio_range_bounds == (300.0, 1000.0)
    assert ParameterRanges(scenario="maneuver", radio_range=(9.0, 10.0)).radio_range_bounds == (9.0, 10.0)


@pytest.mark.parametrize("name", STUDY_SCENARIOS)
def test_equal_bounds_fix_value(name: str) -> None:
    held = ParameterRanges(scenario=name, latency=(0.2, 0.2), loss=(0.0, 0.0))
    assert {sample_scenario(held, 1, i)[2]["latency"] for i in range(5)} == {0.2}


def test_nominal_vehicle_has_true_friction_and_nominal_mass() -> None:
    scenario, car, _ = sample_scenario(ParameterRanges(scenario="curbside"), 1, 0)
    assert car.m == 1093.3
    assert car.mu == scenario.vehicle.mu
    assert replace(car, m=scenario.vehicle.m, I_z=scenario.vehicle.I_z) == scenario.vehicle


def test_without_v2v_road_users_get_no_warning() -> None:
    scenario = next(s for s, _ in (sample("eebl", i) for i in range(9)) if s.case == "C")
    silent = without_v2v(scenario, "driver")
    reaction = next(
        action for action in silent.road_users[0].actions if isinstance(action, ReactToLeadAction)
    )
    assert math.isinf(reaction.warning_delay)
    assert not silent.v2v
    log = simulate(silent)
    assert log.received == ()
    assert log.time_of("brakes", "yellow") - log.time_of("brakes", "red") >= reaction.reaction_time - 0.1


@pytest.mark.parametrize(
    "change",
    [
        {"scenario": "zebra"}, {"loss": (0.5, 0.2)}, {"loss": (0.0, 0.95)}, {"latency": (-0.1, 0.0)},
        {"mass": (math.nan, 1.0)}, {"radio_range": (5.0,)},
    ],
)  # fmt: skip
def test_invalid_range_raises(change: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=rf"\b{next(iter(change))}\b"):
        ParameterRanges(**{"scenario": "eebl", **change})


def test_negative_index_raises() -> None:
    with pytest.raises(InputError, match="index"):
        sample("eebl", -1)
