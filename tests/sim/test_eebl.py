"""EEBL: a driver cannot avoid the collision, messages can, a sensor comes late."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core import Action, Command, Decision, RemoteVehicle, VehicleState
from cca_core.sim import EEBL_CASES, Scenario, eebl, make_planner, simulate
from tests.support.paper_runs import gap, simulated
from tests.support.sweeps import sweep

SEEDS = (1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (2, 3, 4, 5)))
SEEDS_AND_PLANTS = [
    ("single_track", 1),
    *(pytest.param("single_track", seed, marks=pytest.mark.slow) for seed in (2, 3, 4, 5)),
    pytest.param("multi_body", 1, marks=pytest.mark.requires("vehiclemodels")),
]


class BrakesFully:
    """The planner, with full braking from the first detection of a braking vehicle on."""

    def __init__(self, scenario: Scenario) -> None:
        self.planner, self.a_x, self.begun = make_planner(scenario), 0.0, False

    def step(self, t: float, state: VehicleState, remotes: Iterable[RemoteVehicle], **kwargs: Any) -> Command:
        remotes = list(remotes)
        command = self.planner.step(t, state, remotes, **kwargs)
        self.begun = self.begun or any(remote.a_x <= -0.25 for remote in remotes)
        if not self.begun:
            return command
        self.a_x = max(self.a_x - 12.65 * 0.02, -7.0)
        braking = Decision(action=Action.BRAKE, reason="a vehicle brakes")
        return replace(command, a_x=self.a_x, decision=braking)


@pytest.mark.parametrize(("plant", "seed"), SEEDS_AND_PLANTS)
def test_ego_stops_within_its_deceleration(plant: str, seed: int) -> None:
    log = simulated("eebl", "C", "v2v", seed=seed, plant=plant)
    assert -log.ego[:, 7].min() <= 6.0
    assert log.ego[-1, 3] < 0.1
    assert gap(log, 0, None)[-1] >= 2.0


@pytest.mark.parametrize("case", EEBL_CASES)
def test_yellow_never_hits_red(case: str) -> None:
    log = simulated("eebl", case, "v2v")
    assert gap(log, 1, 0).min() > 2.0


@pytest.mark.parametrize("seed", SEEDS)
def test_gaps_stay_above_two_meters(seed: int) -> None:
    """Fig. 7: rear to front of each car over time."""
    log = simulated("eebl", "C", "v2v", seed=seed)
    assert gap(log, 0, None).min() > 2.0
    assert gap(log, 1, 0).min() > 2.0
    assert (log.road_users[-1, :, 3] == 0.0).all()


@pytest.mark.parametrize("case", EEBL_CASES)
def test_time_gap_is_fixed_until_hazard_is_known(case: str) -> None:
    log = simulated("eebl", case, "v2v")
    known = int(np.argmin(log.gap_held))
    assert log.t[known] > 2.0
    before = log.t < 2.0
    assert gap(log, 0, None)[before] / log.ego[before, 3] == pytest.approx(0.5, abs=0.005)
    assert log.gap_held[:known].all()
    assert not log.gap_held[known:].any()


def test_order_of_braking() -> None:
    log = simulated("eebl", "C", "v2v")
    assert log.time_of("gap_released") < log.time_of("brakes", "red") + 0.5
    assert log.time_of("brakes") < log.time_of("brakes", "yellow") + 0.5
    silent = simulated("eebl", "A", "v2v")
    red, yellow = (silent.time_of("brakes", name) for name in ("red", "yellow"))
    assert yellow - red == pytest.approx(1.25, abs=0.1)
    assert silent.time_of("brakes") - yellow == pytest.approx(1.25, abs=0.1)


def test_collision_speed_without_messages() -> None:
    """7 m/s^2 for the reaction time and the lag of the brakes: 7.0 x (1.25 + 0.1)."""
    log = simulated("eebl", "A", "v2v")
    assert log.closing_speed() == pytest.approx(7.0 * 1.35, abs=0.4)


def test_connected_yellow_alone_does_not_help() -> None:
    log = simulate(eebl("D"))
    assert log.summary()["collided_with"] == "yellow"
    assert log.time_of("brakes", "yellow") < 3.0


def test_connected_ego_alone_helps() -> None:
    log = simulate(eebl("B"))
    assert gap(log, 0, None).min() >= 2.0
    assert -log.ego[:, 7].min() <= 5.0
    assert not log.tracked[:, 0].any()
    assert log.tracked[:, 1].any()
    assert log.time_of("brakes") < log.time_of("brakes", "yellow")


@pytest.mark.parametrize(
    ("delay", "planner", "full"),
    sweep(
        (0.1, 4.22, 6.4), (0.4, -4.06, -4.1), (0.0, 4.45, 9.4), (0.2, 2.38, 3.5), (0.3, 0.59, 0.6), quick=2
    ),
)
def test_sensor_delay_decides_collision(delay: float, planner: float, full: float) -> None:
    """The table of the simulation page: gap at standstill [m], or minus the collision speed [m/s]."""
    scenario = replace(eebl("sensor"), sensor_delay=delay)
    for controller, expected in ((None, planner), (BrakesFully(scenario), full)):
        log = simulate(scenario, planner=controller)
        found = -log.closing_speed() if log.summary()["collided"] else float(log.gaps().min())
        assert found == pytest.approx(expected, abs=0.06)


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("v_x", "headway"), [(20.0, 0.5), (33.0, 0.5), (29.06, 0.7)])
def test_eebl_with_other_speeds_and_gaps(v_x: float, headway: float, seed: int) -> None:
    assert simulate(eebl("C", v_x=v_x, time_gap=headway), seed=seed).gaps().min() > 1.0
    assert simulate(eebl("A", v_x=v_x, time_gap=headway)).summary()["collided"]


def test_sensor_ego_brakes_before_driver() -> None:
    sensor, driver = simulate(eebl("sensor")), simulated("eebl", "A", "v2v")
    assert sensor.time_of("brakes") < driver.time_of("brakes") - 0.5
