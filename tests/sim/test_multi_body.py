"""Multi-body plant: agreement with simpler models, limits and errors."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cca_core import InputError, VehicleParams, VehicleState
from cca_core.follow import steady_yaw_rate
from cca_core.sim import MultiBodyPlant

pytestmark = pytest.mark.requires("vehiclemodels")


def state(v_x: float, **more: float) -> VehicleState:
    return replace(VehicleState(x=0.0, y=0.0, psi=0.0, v_x=v_x), **more)


def drive(plant: MultiBodyPlant, seconds: float, delta: float = 0.0, a_x: float = 0.0) -> list[VehicleState]:
    states = [plant.state]
    for _ in range(round(seconds / 0.02)):
        plant.step(delta, a_x, 0.02)
        states.append(plant.state)
    return states


def test_car_runs_straight() -> None:
    """Its tire law has a jump at zero camber, so straight running drifts by millimeters."""
    end = drive(MultiBodyPlant(state(20.0)), 3.0)[-1]
    assert end.x == pytest.approx(60.0, abs=0.3)
    assert abs(end.y) < 0.05
    assert end.v_x == pytest.approx(20.0, abs=0.15)


def test_start_state_is_kept() -> None:
    at = state(15.0, x=100.0, y=-20.0, psi=2.0)
    plant = MultiBodyPlant(at)
    assert (plant.state.x, plant.state.y, plant.state.psi, plant.state.v_x) == (100.0, -20.0, 2.0, 15.0)
    end = drive(plant, 1.0)[-1]
    assert (end.x, end.y) == pytest.approx(
        (100.0 + 15.0 * math.cos(2.0), -20.0 + 15.0 * math.sin(2.0)), abs=0.1
    )


def test_braking_distance_and_standstill() -> None:
    """5 m/s^2 from 20 m/s: 42.15 m instead of 40 m, because the wheels have inertia; and 2 m of lag."""
    states = drive(MultiBodyPlant(state(20.0), drive_lag=0.01), 6.0, a_x=-5.0)
    assert states[-1].v_x == 0.0
    assert states[-1].x == pytest.approx(42.15, abs=0.6)
    assert all(math.isfinite(s.x + s.y + s.psi + s.r) for s in states)
    assert states[-1] == states[-2]  # it stays at rest


@pytest.mark.parametrize("v", [15.0, 25.0])
def test_steady_yaw_rate_is_close_to_linear_model(v: float) -> None:
    """At 1 m/s^2; the car understeers by -0.05 degrees per g, the linear one is neutral."""
    car = VehicleParams.bmw_320i()
    delta = 1.0 / v**2 * (car.wheelbase + car.understeer_gradient * v**2)
    states = drive(MultiBodyPlant(state(v)), 3.0, delta=delta)
    r = float(np.mean([s.r for s in states[-50:]]))
    assert r == pytest.approx(float(steady_yaw_rate(delta, v, car)), rel=0.06)


def test_mirrored_steering_mirrors_motion() -> None:
    left = drive(MultiBodyPlant(state(20.0)), 1.0, delta=0.02)[-1]
    right = drive(MultiBodyPlant(state(20.0)), 1.0, delta=-0.02)[-1]
    assert right.y == pytest.approx(-left.y, abs=0.05)
    assert right.r == pytest.approx(-left.r, abs=0.01)


def test_low_friction_reduces_yaw_rate() -> None:
    max_a_y = {}
    for friction in (0.3, 1.0):
        plant, largest = MultiBodyPlant(state(20.0), friction=friction), 0.0
        for _ in range(60):
            plant.step(0.06, 0.0, 0.02)
            largest = max(largest, abs(plant.a_y))
        max_a_y[friction] = largest
    assert max_a_y[0.3] < 0.3 * 1.05 * 9.81 * 1.25
    assert max_a_y[1.0] > 6.0


def test_heavier_car_responds_slower() -> None:
    light, heavy = (drive(MultiBodyPlant(state(20.0), mass=m), 0.3, delta=0.03)[-1].r for m in (1.0, 1.3))
    assert 0.5 * light < heavy < light


def test_steering_has_lag_and_rate_limit() -> None:
    plant = MultiBodyPlant(state(20.0), steering_lag=0.1)
    plant.step(0.02, 0.0, 0.1)
    assert plant.state.delta == pytest.approx(0.02 * (1.0 - math.exp(-1.0)), rel=0.02)
    quick = MultiBodyPlant(state(10.0))
    quick.step(0.3, 0.0, 0.1)
    assert quick.state.delta <= 0.4 * 0.1 + 1e-6


@pytest.mark.parametrize("v", [0.0, 0.5, 1.9])
def test_car_rolls_to_rest_below_2_mps(v: float) -> None:
    plant = MultiBodyPlant(state(v))
    states = drive(plant, 3.0, delta=0.1, a_x=-1.0)
    assert all(math.isfinite(s.x + s.v_x) for s in states)
    assert states[-1].v_x == 0.0
    assert np.diff([s.x for s in states]).min() >= 0.0


def test_braking_is_limited_to_avoid_wheel_lock() -> None:
    states = drive(MultiBodyPlant(state(20.0)), 4.0, a_x=-20.0)
    assert states[-1].v_x == 0.0
    assert abs(states[-1].y) < 1.0
    assert max(abs(s.a_x) for s in states) <= 8.0


@pytest.mark.parametrize(
    ("arguments", "name"),
    [({"vehicle": 4}, "vehicle"), ({"friction": 0.0}, "friction"), ({"mass": -1.0}, "mass"),
     ({"steering_lag": 0.0}, "steering_lag"), ({"drive_lag": math.nan}, "drive_lag")],
)  # fmt: skip
def test_invalid_argument_raises(arguments: dict[str, float], name: str) -> None:
    with pytest.raises(InputError, match=f"^{name} must be"):
        MultiBodyPlant(state(20.0), **arguments)  # type: ignore[arg-type]
