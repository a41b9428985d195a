"""Single-track plant: closed forms, the friction limit, symmetry and convergence."""

import copy
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import InputError, VehicleParams, VehicleState
from cca_core.follow.bicycle import steady_yaw_rate
from cca_core.kernel.single_track import fiala_force
from cca_core.sim import SingleTrackPlant

G = 9.81
CARS = [VehicleParams.bmw_320i(), VehicleParams.ford_escort(), VehicleParams.vw_vanagon()]
BMW = CARS[0]


def plant(
    v_x: float, vehicle: VehicleParams = BMW, *, drive_lag: float = 0.1, **state: float
) -> SingleTrackPlant:
    return SingleTrackPlant(
        vehicle, VehicleState(**({"x": 0.0, "y": 0.0, "psi": 0.0, "v_x": v_x} | state)), drive_lag=drive_lag
    )


def drive(p: SingleTrackPlant, seconds: float, delta: float = 0.0, a_x: float = 0.0) -> list[VehicleState]:
    states = [p.state]
    for _ in range(round(seconds / 0.02)):
        p.step(delta, a_x, 0.02)
        states.append(p.state)
    return states


def planar_acceleration(p: SingleTrackPlant) -> tuple[float, float]:
    """Acceleration of the center of gravity by finite differences of the velocity in the world."""

    def velocity(s: VehicleState) -> np.ndarray[Any, Any]:
        c, n = math.cos(s.psi), math.sin(s.psi)
        return np.array([s.v_x * c - s.v_y * n, s.v_x * n + s.v_y * c])

    before = velocity(p.state)
    p.step(p.state.delta, p.state.a_x, 1e-4)
    a = (velocity(p.state) - before) / 1e-4
    return float(a[0]), float(a[1])


class TestStraight:
    @pytest.mark.parametrize("a_x", [-3.0, 0.0, 2.0])
    def test_acceleration_after_the_lag(self, a_x: float) -> None:
        states = drive(plant(20.0, drive_lag=0.1), 3.0, a_x=a_x)
        # x'' = a (1 - exp(-t/T)): closed form of a first-order lag
        lag, t = 0.1, 3.0
        v = 20.0 + a_x * (t - lag * (1.0 - math.exp(-t / lag)))
        x = 20.0 * t + a_x * (0.5 * t * t - lag * t + lag * lag * (1.0 - math.exp(-t / lag)))
        assert states[-1].v_x == pytest.approx(v, abs=1e-4)
        assert states[-1].x == pytest.approx(x, abs=1e-3)
        assert all(s.y == s.psi == s.v_y == s.r == 0.0 for s in states)

    def test_motion_follows_heading(self) -> None:
        s = drive(plant(10.0, psi=2.0), 1.0)[-1]
        assert (s.x, s.y) == pytest.approx((10.0 * math.cos(2.0), 10.0 * math.sin(2.0)))

    def test_car_stops_and_stays_stopped(self) -> None:
        p = plant(15.0, delta=0.05)
        states = drive(p, 6.0, delta=0.05, a_x=-6.0)
        stopped = next(i for i, s in enumerate(states) if s.v_x == 0.0)
        assert stopped * 0.02 == pytest.approx(15.0 / 6.0 + 0.1, abs=0.1)
        for s in states[stopped:]:
            assert (s.v_x, s.v_y, s.r) == (0.0, 0.0, 0.0)
            assert (s.x, s.y, s.psi) == pytest.approx((states[-1].x, states[-1].y, states[-1].psi), abs=2e-3)
        assert min(s.v_x for s in states) >= 0.0

    def test_car_moves_off_again(self) -> None:
        p = plant(0.0)
        drive(p, 1.0, a_x=-5.0)
        states = drive(p, 4.0, a_x=2.0)
        assert states[-1].v_x == pytest.approx(2.0 * 3.9, abs=0.1)

    def test_car_rests_without_command(self) -> None:
        states = drive(plant(0.0), 2.0, delta=0.3)
        assert (states[-1].x, states[-1].y, states[-1].psi) == (0.0, 0.0, 0.0)
        assert states[-1].delta == pytest.approx(0.3, abs=1e-3)


class TestTurning:
    @pytest.mark.parametrize("vehicle", CARS)
    @pytest.mark.parametrize(("v", "a_y"), [(5.0, 0.2), (15.0, 0.3), (25.0, -0.3)])
    def test_steady_yaw_rate_at_low_lateral_acceleration(
        self, vehicle: VehicleParams, v: float, a_y: float
    ) -> None:
        delta = a_y / v**2 * (vehicle.wheelbase + vehicle.understeer_gradient * v * v)
        p = plant(v, vehicle)
        drive(p, 5.0, delta=delta)
        s = p.state
        assert s.r == pytest.approx(float(steady_yaw_rate(delta, s.v_x, vehicle)), rel=0.01)
        assert p.a_y == pytest.approx(s.v_x * s.r, rel=1e-3)

    def test_no_slip_at_walking_speed(self) -> None:
        p = plant(0.8)
        drive(p, 1.0, delta=0.4)
        before = p.state
        drive(p, 4.0, delta=0.4)
        s = p.state
        assert s.v_x == 0.8
        assert s.r == pytest.approx(0.8 * math.tan(0.4) / BMW.wheelbase, rel=1e-3)
        assert s.psi - before.psi == pytest.approx(4.0 * s.r, rel=1e-3)
        # the rear axle rolls: no velocity across the car there
        assert s.v_y - BMW.l_r * s.r == pytest.approx(0.0, abs=1e-12)
        # about a circle of radius sqrt(R^2 + l_r^2)
        radius = math.hypot(BMW.wheelbase / math.tan(0.4), BMW.l_r)
        chord = math.hypot(s.x - before.x, s.y - before.y)
        assert chord == pytest.approx(2.0 * radius * math.sin(0.5 * (s.psi - before.psi)), rel=2e-3)

    def test_steering_actuator(self) -> None:
        p = plant(10.0)
        states = drive(p, 3.0, delta=2.0)
        rates = np.diff([s.delta for s in states]) / 0.02
        assert rates.max() <= BMW.delta_rate_max + 1e-9
        assert states[-1].delta == pytest.approx(BMW.delta_max, abs=1e-6)
        assert max(s.delta for s in states) <= BMW.delta_max + 1e-12

    def test_car_slides_at_friction_limit(self) -> None:
        p = plant(25.0)
        peak = 0.0
        for _ in range(100):
            p.step(0.3, 0.0, 0.02)
            peak = max(peak, abs(p.a_y))
        assert 0.9 * BMW.mu * G < peak <= BMW.mu * G * 1.001


@given(
    st.sampled_from(CARS), st.floats(2.0, 45.0), st.floats(-0.6, 0.6), st.floats(-12.0, 12.0),
    st.floats(0.2, 1.0),
)  # fmt: skip
def test_acceleration_never_exceeds_friction(
    vehicle: VehicleParams, v: float, delta: float, a_x: float, mu: float
) -> None:
    p = plant(v, replace(vehicle, mu=mu))
    for k in range(25):
        p.step(delta, a_x, 0.02)
        if k % 5 == 0 and p.state.v_x > 1.5:
            assert math.hypot(*planar_acceleration(p)) <= mu * G * 1.01


@given(
    st.sampled_from(CARS),
    st.floats(2.0, 45.0),
    st.floats(-15.0, 15.0),
    st.floats(-4.0, 4.0),
    st.floats(-0.6, 0.6),
)
def test_tires_dissipate_energy(vehicle: VehicleParams, v: float, v_y: float, r: float, delta: float) -> None:
    """Coasting, whatever the slide: kinetic energy never grows."""
    p = plant(v, vehicle, v_y=v_y, r=r, delta=delta)
    energy = math.inf
    for _ in range(30):
        s = p.state
        now = 0.5 * vehicle.m * (s.v_x**2 + s.v_y**2) + 0.5 * vehicle.I_z * s.r**2
        assert now <= energy * (1.0 + 1e-6) + 1e-6
        energy = now
        p.step(delta, 0.0, 0.02)
        if p.state.v_x < 1.5:
            break


@given(
    st.floats(0.0, 45.0), st.floats(-3.0, 3.0), st.floats(-1.0, 1.0),
    st.lists(st.tuples(st.floats(-0.6, 0.6), st.floats(-9.0, 4.0)), min_size=1, max_size=8),
)  # fmt: skip
def test_mirror_symmetry_is_exact(v: float, v_y: float, r: float, inputs: list[tuple[float, float]]) -> None:
    left, right = plant(v, v_y=v_y, r=r), plant(v, v_y=-v_y, r=-r)
    for delta, a_x in inputs:
        for _ in range(5):
            left.step(delta, a_x, 0.02)
            right.step(-delta, a_x, 0.02)
        a, b = left.state, right.state
        assert (a.x, a.v_x, a.a_x) == (b.x, b.v_x, b.a_x)
        assert (a.y, a.psi, a.v_y, a.r, a.delta) == (-b.y, -b.psi, -b.v_y, -b.r, -b.delta)
        assert left.a_y == -right.a_y


@pytest.mark.parametrize("v", [12.0, 25.0])
def test_result_converges_with_step(v: float) -> None:
    """Half the step, far less error: the scheme is of fourth order while the input is smooth."""
    ends = []
    for n in (1, 2, 4):
        p = plant(v)
        for k in range(300):
            # the plant sub-steps at 10 ms, so 10 ms is the coarsest
            for _ in range(n):
                p.step(0.02 * math.sin(0.01 * k), 0.5, 0.01 / n)
        ends.append(np.array([p.state.x, p.state.y, p.state.psi]))
    coarse, fine = np.abs(ends[0] - ends[1]).max(), np.abs(ends[1] - ends[2]).max()
    assert coarse < 1e-4
    assert fine < coarse / 8.0 + 1e-11


def test_long_step_equals_many_short_ones() -> None:
    a, b = plant(20.0), plant(20.0)
    a.step(0.02, 1.0, 0.5)
    for _ in range(50):
        b.step(0.02, 1.0, 0.01)
    assert (a.state.x, a.state.y, a.state.r) == pytest.approx((b.state.x, b.state.y, b.state.r), abs=1e-12)


class TestFiala:
    @pytest.mark.parametrize("stiffness", [5e4, 1.3e5])
    def test_fiala_slope_at_zero_is_stiffness(self, stiffness: float) -> None:
        for alpha in (1e-6, -1e-6):
            assert fiala_force(stiffness, alpha, 5e3) / alpha == pytest.approx(-stiffness, rel=1e-4)
        assert fiala_force(stiffness, 0.0, 5e3) == 0.0

    @given(st.floats(1e4, 3e5), st.floats(100.0, 2e4), st.floats(-1.5, 1.5))
    def test_fiala_force_is_odd_and_bounded(self, stiffness: float, f_max: float, alpha: float) -> None:
        force = fiala_force(stiffness, alpha, f_max)
        assert force == -fiala_force(stiffness, -alpha, f_max)
        assert abs(force) <= f_max * (1.0 + 1e-12)
        assert force * alpha <= 0.0

    def test_fiala_force_is_continuous_up_to_sliding(self) -> None:
        forces = [-fiala_force(1e5, a, 5e3) for a in np.linspace(0.0, 0.3, 400)]
        assert np.diff(forces).min() >= -1e-9
        assert forces[-1] == 5e3
        assert np.diff(forces).max() < 1e5 * 0.3 / 399 * 1.01


def test_invalid_lag_raises() -> None:
    with pytest.raises(InputError, match="drive_lag"):
        plant(10.0, drive_lag=-0.1)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy])
def test_copy_of_plant_shares_no_state(copied: Callable[[SingleTrackPlant], SingleTrackPlant]) -> None:
    original = plant(20.0)
    twin = copied(original)
    before = original.state
    assert twin.state == before
    twin.step(0.1, -3.0, 0.02)
    assert twin.state != before
    assert original.state == before
