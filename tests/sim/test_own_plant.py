"""Plants of a user in the closed loop."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, VehicleParams, VehicleState
from cca_core.follow import steady_turn
from cca_core.path import Path
from cca_core.sim import Scenario, SingleTrackPlant, overtaking, simulate


class Kinematic:
    """A plant without slip."""

    def __init__(self, vehicle: VehicleParams, state: VehicleState) -> None:
        self.vehicle, self.state, self.a_y = vehicle, state, 0.0

    def step(self, delta: float, a_x: float, dt: float) -> None:
        car, old = self.vehicle, self.state
        v = max(old.v_x + a_x * dt, 0.0)
        r = v * math.tan(delta) / (car.l_f + car.l_r)
        psi, self.a_y = old.psi + r * dt, v * r
        course = psi + math.atan(car.l_r * math.tan(delta) / (car.l_f + car.l_r))
        self.state = VehicleState(
            x=old.x + v * dt * math.cos(course), y=old.y + v * dt * math.sin(course),
            psi=psi, v_x=v, r=r, delta=delta, a_x=a_x,
        )  # fmt: skip


def start_of(scenario: Scenario) -> VehicleState:
    return steady_turn(scenario.road.path, scenario.start, scenario.v_x, scenario.vehicle)


@pytest.fixture
def scenario(road: Callable[[str], Path]) -> Scenario:
    return replace(overtaking("1-fast", road("straight")), duration=6.0)


def test_own_plant_is_driven(scenario: Scenario) -> None:
    plant = Kinematic(scenario.vehicle, start_of(scenario))
    log = simulate(scenario, plant=plant)
    assert log.plant == "Kinematic"
    assert log.summary()["plant"] == "Kinematic"
    assert log.t[-1] == pytest.approx(6.0)
    assert (plant.state.x, plant.state.y) != tuple(log.ego[0, :2])
    assert np.abs(log.ego[:, 6]).max() > 0.0


def test_plant_of_a_class_begins_at_the_start(scenario: Scenario) -> None:
    one = simulate(scenario, plant=Kinematic)
    two = simulate(scenario, plant=Kinematic(scenario.vehicle, start_of(scenario)))
    assert one.ego.tobytes() == two.ego.tobytes()
    assert one.plant == two.plant == "Kinematic"


def test_library_plant_as_object_equals_its_name(scenario: Scenario) -> None:
    named = simulate(scenario)
    given = simulate(scenario, plant=SingleTrackPlant(scenario.vehicle, start_of(scenario)))
    assert named.ego.tobytes() == given.ego.tobytes()


class NoState:
    """Lacks its state."""

    a_y = 0.0

    def step(self, delta: float, a_x: float, dt: float) -> None: ...


class WrongState(NoState):
    """Has a state of another kind."""

    state = (0.0, 0.0)


class NoStep:
    """Has a step that cannot be called."""

    a_y, step, state = 0.0, 3.0, VehicleState(x=0.0, y=0.0, psi=0.0, v_x=1.0)


@pytest.mark.parametrize(
    ("plant", "message"),
    [
        ("toy", "plant must be one of single_track, multi_body, was 'toy'"),
        (None, "plant must be .* has no state"),
        (3.0, "plant must be .* has no state"),
        (NoState(), "plant must be .* has no state"),
        (NoStep(), "plant must be .* has no method step"),
        (WrongState(), "plant.state must be a VehicleState"),
        (lambda vehicle, state: None, "plant must be .* has no state"),
    ],
)
def test_invalid_plant_raises(scenario: Scenario, plant: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        simulate(scenario, plant=plant)


def test_plant_without_a_number_as_a_y_raises(scenario: Scenario) -> None:
    plant = Kinematic(scenario.vehicle, start_of(scenario))
    plant.a_y = math.nan
    with pytest.raises(InputError, match=r"plant\.a_y must be finite"):
        simulate(scenario, plant=plant)


def test_used_plant_raises(scenario: Scenario) -> None:
    plant = Kinematic(scenario.vehicle, start_of(scenario))
    simulate(scenario, plant=plant)
    with pytest.raises(InputError, match=r"plant\.state must be at the scenario's start.* new plant"):
        simulate(scenario, plant=plant)


def test_plant_against_the_route_raises(scenario: Scenario) -> None:
    start = start_of(scenario)
    with pytest.raises(InputError, match=r"plant\.state must be at the scenario's start"):
        simulate(scenario, plant=Kinematic(scenario.vehicle, replace(start, psi=start.psi + math.pi)))
