"""The single track solved backwards: exact for a linear car, steady in a steady turn, never undefined."""

import copy
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cca_core.follow import InverseSteering, single_track, steady_sideslip, steady_steering
from cca_core.vehicle import VehicleParams

CARS = [VehicleParams.bmw_320i(), VehicleParams.ford_escort(), VehicleParams.vw_vanagon()]
LINEAR = [replace(car, mu=1e3) for car in CARS]


@pytest.mark.parametrize("car", LINEAR)
@pytest.mark.parametrize("v", [5.0, 15.0, 30.0])
def test_constant_curvature_gives_steady_turn(car: VehicleParams, v: float) -> None:
    """After any start the angle, the sideslip and the yaw rate are those of the steady turn."""
    kappa, inverse = 1.0 / 400.0, InverseSteering(car)
    inverse.advance(0.0, 0.0, v, 0.02)
    for k in range(1, 400):
        delta = inverse.advance(0.02 * v * k, kappa, v, 0.02)
    beta, r = inverse.motion_at(0.02 * v * 399)
    assert delta == pytest.approx(float(steady_steering(kappa, v, car)), rel=2e-3)
    assert r == pytest.approx(v * kappa, rel=1e-3)
    assert beta == pytest.approx(float(steady_sideslip(kappa, v, car)), rel=1e-2, abs=1e-6)


@pytest.mark.parametrize("car", LINEAR)
@pytest.mark.parametrize("v", [8.0, 20.0, 30.0])
def test_open_loop_keeps_linear_car_on_path(car: VehicleParams, v: float) -> None:
    """x' = A x + B delta + E kappa, driven through a lane change by the inverse alone."""
    dt, model, inverse = 0.002, single_track(car, v, 0.0), InverseSteering(car)
    length = 3.0 * v
    x, worst = np.zeros(4), 0.0
    for k in range(round(5.0 / dt)):
        s = v * dt * k
        share = min(max((s - v) / length, 0.0), 1.0)
        kappa = 3.5 / length**2 * (60.0 * share - 180.0 * share**2 + 120.0 * share**3)
        delta = inverse.advance(s, kappa, v, dt)
        x = x + dt * (model.A @ x + model.B * delta + model.E * kappa)
        worst = max(worst, abs(x[3]))
    assert worst < 0.01


@given(
    st.lists(st.tuples(st.floats(-0.05, 0.05), st.floats(0.0, 40.0)), min_size=2, max_size=30),
    st.sampled_from(CARS),
)
def test_mirrored_path_mirrors_steering(points: list[tuple[float, float]], car: VehicleParams) -> None:
    left, right, s = InverseSteering(car), InverseSteering(car), 0.0
    for kappa, v in points:
        s += 0.02 * v
        assert right.advance(s, -kappa, v, 0.02) == pytest.approx(-left.advance(s, kappa, v, 0.02), abs=1e-12)
        np.testing.assert_allclose(right.motion_at(s), -np.array(left.motion_at(s)), atol=1e-12)


@given(
    st.lists(st.tuples(st.floats(-10.0, 10.0), st.floats(0.0, 60.0)), min_size=1, max_size=60),
    st.sampled_from(CARS),
    st.floats(0.001, 1.0),
)
def test_steering_is_always_finite(points: list[tuple[float, float]], car: VehicleParams, dt: float) -> None:
    """From standstill to 60 m/s, with curvature no car can follow, and jumps of both."""
    inverse, s = InverseSteering(car), 0.0
    for kappa, v in points:
        s += dt * v
        assert abs(inverse.advance(s, kappa, v, dt)) < math.pi
        assert all(map(math.isfinite, inverse.motion_at(s - 5.0)))


@pytest.mark.parametrize("field", range(4))
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("v", [1.0, 20.0])
def test_input_that_is_no_number_holds_last_angle(field: int, bad: float, v: float) -> None:
    """In that call, which says so; the next one goes on as if it had not been."""
    inverse, sound = InverseSteering(CARS[0]), InverseSteering(CARS[0])
    for k in range(20):
        for each in (inverse, sound):
            last = each.advance(0.02 * v * k, 1e-3 * k, v, 0.02)
    given = [0.4 * v, 0.02, v, 0.02]
    given[field] = bad
    assert inverse.advance(*given) == last
    assert inverse.held
    assert repr(inverse).endswith("held)")
    assert inverse.motion_at(0.39 * v) == sound.motion_at(0.39 * v)
    assert inverse.advance(0.4 * v, 0.02, v, 0.02) == sound.advance(0.4 * v, 0.02, v, 0.02)
    assert not inverse.held


def test_first_input_that_is_no_number_holds_zero() -> None:
    inverse = InverseSteering(CARS[0])
    assert inverse.advance(0.0, math.nan, 20.0, 0.02) == 0.0
    assert repr(inverse) == "InverseSteering(not started)"


@given(
    st.lists(st.tuples(st.floats(), st.floats(), st.floats(), st.floats(), st.floats()), max_size=10),
    st.sampled_from(CARS),
)
@example([(0.0, 1e200, 1e200, 0.02, 0.0), (0.0, 0.0, 1e200, 0.02, 0.0)], CARS[0])
def test_steering_is_finite_whatever_is_given(calls: list[tuple[float, ...]], car: VehicleParams) -> None:
    inverse = InverseSteering(car)
    for s, kappa, v, dt, passed in calls:
        assert abs(inverse.advance(s, kappa, v, dt)) < math.pi
        assert all(map(math.isfinite, inverse.motion_at(passed)))


def test_station_that_is_no_number_keeps_what_has_passed() -> None:
    inverse, sound = InverseSteering(CARS[0]), InverseSteering(CARS[0])
    for k in range(50):
        for each in (inverse, sound):
            each.advance(0.4 * k, 1e-3 * k, 20.0, 0.02)
    assert all(map(math.isfinite, inverse.motion_at(math.nan)))
    assert inverse.motion_at(9.9) == sound.motion_at(9.9)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy])
def test_copy_shares_no_state(copied: Callable[[InverseSteering], InverseSteering]) -> None:
    inverse, alone = InverseSteering(CARS[0]), InverseSteering(CARS[0])
    for k in range(20):
        for each in (inverse, alone):
            each.advance(0.4 * k, 1e-3 * k, 20.0, 0.02)
    twin = copied(inverse)
    twin.advance(8.0, -0.01, 5.0, 0.5)
    assert repr(inverse) == repr(alone)
    assert inverse.advance(8.0, 0.02, 20.0, 0.02) == alone.advance(8.0, 0.02, 20.0, 0.02)
    assert inverse.motion_at(7.9) == alone.motion_at(7.9)


def test_motion_is_stored_by_station() -> None:
    """The motion at an earlier station is that of its cycle, interpolated between cycles."""
    now, later = InverseSteering(CARS[0]), InverseSteering(CARS[0])
    passed: list[float] = []
    for k in range(100):
        now.advance(0.4 * k, 4e-5 * k, 20.0, 0.02)
        later.advance(0.4 * k, 4e-5 * k, 20.0, 0.02)
        passed.append(now.motion_at(0.4 * k)[1])
        if k >= 6:
            between = later.motion_at(0.4 * (k - 5.5))[1]
            assert between == pytest.approx(0.5 * (passed[k - 6] + passed[k - 5]), abs=1e-9)
            assert later.motion_at(0.4 * (k - 5))[1] == pytest.approx(passed[k - 5], abs=1e-9)


def test_jump_along_path_restarts_integration() -> None:
    inverse, fresh = InverseSteering(CARS[0]), InverseSteering(CARS[0])
    for k in range(50):
        inverse.advance(0.4 * k, -0.01, 20.0, 0.02)
    assert inverse.advance(500.0, 0.005, 20.0, 0.02) == fresh.advance(500.0, 0.005, 20.0, 0.02)
    assert inverse.motion_at(500.0) == fresh.motion_at(500.0)


def test_repr_contains_station() -> None:
    inverse = InverseSteering(VehicleParams.bmw_320i())
    assert repr(inverse) == "InverseSteering(not started)"
    inverse.advance(12.0, 0.01, 10.0, 0.02)
    assert repr(inverse) == "InverseSteering(s=12.0 m, kappa=0.0100 1/m, r=0.100 rad/s)"
