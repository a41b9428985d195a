"""Preview steering, alone and in a closed loop with the friction-limited plant."""

import copy
import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core.errors import InputError
from cca_core.follow import (
    InverseSteering,
    PreviewController,
    shipped_gains,
    single_track,
    steady_sideslip,
    steady_steering,
)
from cca_core.kernel.steering import SIDESLIP_FRACTION
from cca_core.path import Path, fit_path, interpolate_path
from cca_core.sim import SingleTrackPlant, lane_change_path, track_path
from cca_core.vehicle import VehicleParams, VehicleState

CAR = VehicleParams.bmw_320i()
UNDERSTEER = VehicleParams(m=1500.0, I_z=2500.0, l_f=1.2, l_r=1.5, C_f=80e3, C_r=110e3, length=4.5, width=1.8)
LINE = Path([0.0, 2000.0], [[[0, 0, 2000, 0], [0, 0, 0, 0]]])


def arc(radius: float, angle: float = 3.0, n: int = 601) -> Path:
    """Arc from the origin toward +x, left for a positive radius."""
    phi, sign = np.linspace(0.0, angle, n), math.copysign(1.0, radius)
    nodes = np.column_stack((abs(radius) * np.sin(phi), radius * (1.0 - np.cos(phi))))
    return interpolate_path(
        nodes, start_tangent=[1.0, 0.0], end_tangent=[math.cos(angle), sign * math.sin(angle)]
    )


LEFT, RIGHT = arc(300.0), arc(-300.0)


@given(st.floats(0.0, 40.0), st.floats(0.0, 1800.0))
def test_straight_path_needs_no_steering(v: float, x: float) -> None:
    assert PreviewController(CAR).steer(VehicleState(x=x, y=0.0, psi=0.0, v_x=v), LINE) == 0.0


@given(
    st.floats(-2.0, 2.0),
    st.floats(-0.2, 0.2),
    st.floats(0.0, 40.0),
    st.floats(-1.0, 1.0),
    st.floats(-0.3, 0.3),
)
def test_law_on_straight_path_equals_formula(d: float, psi: float, v: float, v_y: float, r: float) -> None:
    """delta = -k_p (d + l_s (sin psi + sin(0.3 beta))) - k_d (v sin psi + v_y cos psi + l_s r), clipped."""
    car = dataclasses.replace(CAR, delta_max=0.3)
    k_p, k_d, l_s = shipped_gains(CAR).at(v)
    slip = SIDESLIP_FRACTION * math.atan2(v_y, v) if v > 3.0 else 0.0
    delta = -k_p * (d + l_s * (math.sin(psi) + math.sin(slip))) - k_d * (
        v * math.sin(psi) + v_y * math.cos(psi) + l_s * r
    )
    state = VehicleState(x=50.0, y=d, psi=psi, v_x=v, v_y=v_y, r=r)
    controller = PreviewController(car, a_y_max=1e9)
    assert controller.steer(state, LINE) == pytest.approx(min(max(delta, -0.3), 0.3), abs=1e-12)


@pytest.mark.parametrize("car", [CAR, UNDERSTEER])
@pytest.mark.parametrize("v", [5.0, 15.0, 25.0])
def test_steady_turn_keeps_steady_steering(car: VehicleParams, v: float) -> None:
    """On the circle with sideslip beta_ss and r = v kappa only the feedforward remains."""
    kappa = 1.0 / 300.0
    car = dataclasses.replace(car, mu=1e3)  # tires as linear as those of the formulas
    beta = float(steady_sideslip(kappa, v, car))
    x, y = LEFT.position(400.0)
    psi = float(LEFT.heading(400.0)) - beta
    state = VehicleState(x=x, y=y, psi=psi, v_x=v, v_y=v * math.tan(beta), r=v * kappa)
    delta = PreviewController(car).steer(state, LEFT)
    assert delta == pytest.approx(float(steady_steering(kappa, v, car)), rel=2e-3)


@given(
    st.floats(20.0, 700.0), st.floats(-2.0, 2.0), st.floats(-0.3, 0.3), st.floats(0.0, 40.0),
    st.floats(-1.0, 1.0), st.floats(-0.5, 0.5),
)  # fmt: skip
def test_mirrored_path_mirrors_steering(s: float, d: float, e: float, v: float, v_y: float, r: float) -> None:
    (x, y), psi = LEFT.to_cartesian(s, d), float(LEFT.heading(s)) + e
    left = PreviewController(CAR).steer(VehicleState(x=x, y=y, psi=psi, v_x=v, v_y=v_y, r=r), LEFT)
    right = PreviewController(CAR).steer(VehicleState(x=x, y=-y, psi=-psi, v_x=v, v_y=-v_y, r=-r), RIGHT)
    assert right == pytest.approx(-left, abs=1e-12)


@given(st.floats(20.0, 700.0), st.floats(-2.0, 2.0), st.floats(-0.3, 0.3), st.floats(-3.1, 3.1))
def test_steering_is_rotation_invariant(s: float, d: float, e: float, turn: float) -> None:
    R = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    coefficients = np.einsum("ijk,jl->ilk", LEFT.coefficients, R)
    turned = Path(LEFT.breaks, coefficients)
    xy, psi = LEFT.to_cartesian(s, d), float(LEFT.heading(s)) + e
    x, y = xy @ R
    here = PreviewController(CAR).steer(VehicleState(x=xy[0], y=xy[1], psi=psi, v_x=20.0), LEFT)
    there = PreviewController(CAR).steer(VehicleState(x=x, y=y, psi=psi + turn, v_x=20.0), turned)
    assert there == pytest.approx(here, abs=1e-10)


@pytest.mark.parametrize("turns", [-3, -1, 1, 4])
def test_whole_turns_of_heading_have_no_effect(turns: int) -> None:
    one = VehicleState(x=50.0, y=0.3, psi=0.05, v_x=20.0)
    other = dataclasses.replace(one, psi=0.05 + 2 * math.pi * turns)
    assert PreviewController(CAR).steer(other, LINE) == pytest.approx(
        PreviewController(CAR).steer(one, LINE), abs=1e-12
    )


@pytest.mark.parametrize("y", [100.0, -100.0])
@pytest.mark.parametrize("limit", [0.2, 0.6])
def test_steering_angle_is_limited(y: float, limit: float) -> None:
    car = dataclasses.replace(CAR, delta_max=limit)
    state = VehicleState(x=50.0, y=y, psi=0.0, v_x=5.0)
    assert PreviewController(car).steer(state, LINE) == -math.copysign(limit, y)


def test_negative_speed_noise_counts_as_standstill() -> None:
    state = VehicleState(x=50.0, y=0.3, psi=0.0, v_x=-0.4)
    still = dataclasses.replace(state, v_x=0.0)
    assert PreviewController(CAR).steer(state, LINE) == PreviewController(CAR).steer(still, LINE)


def test_new_path_is_projected_again() -> None:
    controller = PreviewController(CAR)
    controller.steer(VehicleState(x=500.0, y=0.0, psi=0.0, v_x=20.0), LINE)
    other = Path([0.0, 2000.0], [[[0, 0, 2000, -1500.0], [0, 0, 0, 0.5]]])
    state = VehicleState(x=-1400.0, y=0.0, psi=0.0, v_x=20.0)
    assert controller.steer(state, other) == PreviewController(CAR).steer(state, other)


def drive(
    path: Path, car: VehicleParams, v: float, d0: float, seconds: float, s0: float = 10.0
) -> tuple[np.ndarray, np.ndarray]:
    """Closed loop at 50 Hz with speed held; returns lateral errors and steering."""
    x, y = path.to_cartesian(s0, d0)
    plant = SingleTrackPlant(car, VehicleState(x=x, y=y, psi=float(path.heading(s0)), v_x=v))
    controller, d, steering = PreviewController(car), [], []
    near = s0
    for _ in range(round(seconds / 0.02)):
        state = plant.state
        delta = controller.steer(state, path)
        near, error, _, _ = path.foot_point(state.x, state.y, near + 0.02 * v)
        d.append(error)
        steering.append(delta)
        plant.step(delta, 2.0 * (v - state.v_x), 0.02)
    return np.array(d), np.array(steering)


@pytest.mark.parametrize("v", [5.0, 10.0, 20.0, 25.0])
@pytest.mark.parametrize("path", [LEFT, RIGHT])
@pytest.mark.parametrize("d0", [0.0, 0.5, -0.5])
def test_steering_converges_on_circle(path: Path, v: float, d0: float) -> None:
    seconds = min(12.0, (path.length - 60.0) / v)
    d, steering = drive(path, CAR, v, d0, seconds)
    tail = len(d) - 100
    assert np.abs(d[tail:]).max() < 0.05
    assert np.ptp(d[tail:]) < 0.02
    assert np.ptp(steering[tail:]) < 2e-3
    assert np.abs(d).max() < abs(d0) + 0.35


@pytest.mark.parametrize("v", [30.0, 35.0])
def test_steering_converges_on_tight_circle(v: float) -> None:
    """R = 300 m, where the tires are no longer linear (a_y = 3.0 and 4.1 m/s^2)."""
    d, _ = drive(arc(300.0, 6.0, 1201), CAR, v, 0.5, 12.0)
    assert np.ptp(d[-100:]) < 0.02
    assert np.abs(d[-100:]).max() < 0.05


@pytest.mark.parametrize("car", [CAR, UNDERSTEER])
@pytest.mark.parametrize("v", [5.0, 20.0, 35.0])
def test_linear_car_has_no_error_on_circle(car: VehicleParams, v: float) -> None:
    """x' = A x + B delta + E rho of theory.md, steered by the controller: h -> 0 although l_s beta is not."""
    kappa, dt, path = 1.0 / 300.0, 0.01, arc(300.0, 6.0, 1201)
    car = dataclasses.replace(car, mu=1e3)
    model, controller = single_track(car, v, 0.0), PreviewController(car)
    x, delta, s = np.array([0.0, 0.0, 0.0, 0.5]), 0.0, 10.0
    for _ in range(min(round(40.0 / dt), round(1750.0 / v / dt))):
        xy, beta = path.to_cartesian(s, x[3]), x[0]
        state = VehicleState(
            x=xy[0], y=xy[1], psi=float(path.heading(s)) + x[2], v_x=v, v_y=v * beta, r=x[1], delta=delta
        )
        delta += dt / car.steering_lag * (controller.steer(state, path, dt) - delta)
        x = x + dt * (model.A @ x + model.B * delta + model.E * kappa)
        s += v * dt
    assert abs(x[3]) < 0.01
    assert x[1] == pytest.approx(v * kappa, rel=1e-3)
    assert delta == pytest.approx(float(steady_steering(kappa, v, car)), rel=2e-2)
    assert x[0] == pytest.approx(float(steady_sideslip(kappa, v, car)), abs=5e-4)


@pytest.mark.parametrize("v", [5.0, 10.0, 20.0, 30.0, 35.0])
@pytest.mark.parametrize("car", [CAR, UNDERSTEER, VehicleParams.ford_escort(), VehicleParams.vw_vanagon()])
def test_offset_on_straight_road_decays_without_overshoot(v: float, car: VehicleParams) -> None:
    d, _ = drive(LINE, car, v, 0.5, 12.0)
    assert np.abs(d[-100:]).max() < 0.01
    assert d.min() > -0.1
    assert d.max() < 0.5 + 1e-9


@pytest.mark.parametrize("v", [10.0, 20.0])
def test_closed_loop_is_mirror_symmetric(v: float) -> None:
    left, steer_left = drive(LEFT, CAR, v, 0.5, 8.0)
    right, steer_right = drive(RIGHT, CAR, v, -0.5, 8.0)
    np.testing.assert_allclose(right, -left, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(steer_right, -steer_left, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("v", [10.0, 20.0])
def test_winding_road_is_tracked(v: float) -> None:
    x = np.arange(0.0, 600.0, 10.0)
    path = fit_path(np.column_stack((x, 8.0 * np.sin(x / 60.0))), tolerance=0.1)  # least radius 450 m
    d, _ = drive(path, CAR, v, 0.0, 500.0 / v)
    assert np.abs(d).max() < 0.1


# --- low speed, limits, windup, the other reading ------------------------------------------------------


@pytest.mark.parametrize("v", [0.0, 0.01, 0.5, 2.9, 3.1])
def test_steering_is_finite_down_to_standstill(v: float) -> None:
    xy, psi = LEFT.to_cartesian(100.0, 0.3), float(LEFT.heading(100.0))
    state = VehicleState(x=xy[0], y=xy[1], psi=psi + 0.02, v_x=v, v_y=0.01, r=0.01)
    controller = PreviewController(CAR)
    for _ in range(100):
        assert abs(controller.steer(state, LEFT)) <= CAR.delta_max


@pytest.mark.parametrize("name", ["x", "y", "psi", "v_x", "v_y", "r", "dt"])
@pytest.mark.parametrize("value", [1e3, 1e100, 1e160, 1e308])
def test_absurd_value_does_not_stay(name: str, value: float) -> None:
    assert_recovery(name, value)


@pytest.mark.parametrize("dt", [math.inf, math.nan])
def test_time_step_that_is_no_number_does_not_stay(dt: float) -> None:
    assert_recovery("dt", dt)


def assert_recovery(name: str, value: float) -> None:
    """Steer once with an absurd value of either sign: it is finite, and soon as if nothing had been."""
    controller, sound = PreviewController(CAR), {"x": 20.0, "y": 0.6, "psi": 0.07, "v_x": 20.0}
    expected = controller.steer(VehicleState(**sound), LEFT)
    for absurd in (value,) if name == "v_x" else (value, -value):  # a state refuses a negative speed
        state, dt = (sound, absurd) if name == "dt" else (sound | {name: absurd}, 0.02)
        assert abs(controller.steer(VehicleState(**state), LEFT, dt)) <= CAR.delta_max
        for _ in range(60):
            angle = controller.steer(VehicleState(**sound), LEFT)
        assert angle == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy])
def test_copy_of_controller_shares_no_state(
    copied: Callable[[PreviewController], PreviewController],
) -> None:
    """Neither steers the other's wheels, integral or ideal car."""
    controller, alone = PreviewController(CAR), PreviewController(CAR)
    here, there = (VehicleState(x=20.0, y=y, psi=0.07, v_x=20.0) for y in (0.6, 0.9))
    for _ in range(5):
        for each in (controller, alone):
            each.steer(here, LEFT)
    twin = copied(controller)
    assert copied(twin).steer(there, LEFT) == copied(controller).steer(there, LEFT)
    for _ in range(50):
        twin.steer(VehicleState(x=30.0, y=-2.0, psi=-0.1, v_x=9.0), RIGHT)
    assert controller.steer(there, LEFT) == alone.steer(there, LEFT)


def test_standstill_with_error_does_not_wind_up() -> None:
    """Ten seconds of standstill with a lateral error do not change the law."""
    state = VehicleState(x=50.0, y=0.08, psi=0.0, v_x=0.0)
    controller = PreviewController(CAR)
    first = controller.steer(state, LINE)
    for _ in range(500):
        last = controller.steer(state, LINE)
    assert last == first


def test_saturated_steering_does_not_wind_up() -> None:
    """A command that the limits cut adds nothing to the integral."""
    tight = dataclasses.replace(CAR, delta_max=1e-4)
    controller = PreviewController(tight)
    state = VehicleState(x=50.0, y=0.09, psi=0.0, v_x=20.0)
    for _ in range(500):
        controller.steer(state, LINE)
    on = dataclasses.replace(state, y=0.0)
    assert controller.steer(on, LINE) == pytest.approx(0.0, abs=1e-12)


def test_start_and_stop_on_circle_is_tracked() -> None:
    """From standstill to 8 m/s and back on a radius of 30 m."""
    path = arc(30.0)
    plant = SingleTrackPlant(CAR, VehicleState(x=0.0, y=0.0, psi=0.0, v_x=0.0))
    controller, s, errors, before = PreviewController(CAR), 0.0, [], None
    for k in range(700):
        state = plant.state
        s, d, _, _ = path.foot_point(state.x, state.y, s)
        delta = controller.steer(state, path)
        assert math.isfinite(delta)
        if before is not None:
            assert abs(delta - before) <= CAR.delta_rate_max * 0.02 + 1e-12
        before = delta
        errors.append(abs(d))
        a_x = 2.0 if k < 200 else -2.0 if k > 400 else 0.0
        plant.step(delta, a_x, 0.02)
    assert plant.state.v_x == 0.0
    assert max(errors[150:]) < 0.1  # the wheels have first to be turned
    assert max(errors) < 0.25


def test_steering_rate_is_limited() -> None:
    controller = PreviewController(CAR)
    controller.steer(VehicleState(x=50.0, y=0.0, psi=0.0, v_x=10.0), LINE)
    jumped = controller.steer(VehicleState(x=50.2, y=-5.0, psi=0.0, v_x=10.0), LINE)
    assert jumped == pytest.approx(CAR.delta_rate_max * 0.02, abs=1e-12)


@pytest.mark.parametrize("v", [10.0, 20.0, 30.0])
def test_lateral_acceleration_is_limited(v: float) -> None:
    """In the steady turn, and of the front tires before the car has begun to turn."""
    controller = PreviewController(CAR, a_y_max=3.0)
    plant = SingleTrackPlant(CAR, VehicleState(x=50.0, y=-50.0, psi=0.0, v_x=v))
    deltas, a_y = [], []
    for _ in range(60):
        deltas.append(controller.steer(plant.state, LINE))
        plant.step(deltas[-1], 0.0, 0.02)
        a_y.append(plant.a_y)
    steady = math.atan(3.0 / v**2 * (CAR.wheelbase + max(CAR.understeer_gradient, 0.0) * v**2))
    assert deltas[0] == pytest.approx(max(steady, InverseSteering(CAR).front_slip(3.0 / (9.81 * CAR.mu))))
    assert max(a_y) < 4.0
    assert a_y[-1] == pytest.approx(3.0, rel=0.1)


def test_sudden_maneuver_may_exceed_steady_turn_angle() -> None:
    """At 25 m/s, 2.5 m in 37 m, which takes 6.6 m/s^2: with that limit alone it is 0.47 m off."""
    path = lane_change_path(2.5, 37.0)
    plant = SingleTrackPlant(CAR, VehicleState(x=0.0, y=0.0, psi=0.0, v_x=25.0))
    assert track_path(plant, PreviewController(CAR).steer, path, 25.0).peak < 0.25


def test_tangent_reference_tracks_better() -> None:
    """The path at the preview point anticipates a curve: an error while the curvature changes."""
    peaks = {}
    path = lane_change_path(3.5, 60.0)
    for error in ("tangent", "ahead"):
        plant = SingleTrackPlant(CAR, VehicleState(x=0.0, y=0.0, psi=0.0, v_x=20.0))
        peaks[error] = track_path(plant, PreviewController(CAR, error=error).steer, path, 20.0).peak  # type: ignore[arg-type]
    assert peaks["tangent"] < 0.05
    assert peaks["ahead"] > 3.0 * peaks["tangent"]


def test_invalid_controller_input_raises() -> None:
    for changes in ({"error": "nose"}, {"delay": -0.1}, {"a_y_max": 0.0}):
        with pytest.raises(InputError, match=f"^{next(iter(changes))} must"):
            PreviewController(CAR, **changes)  # type: ignore[arg-type]


def test_steering_without_lag_converges() -> None:
    quick = dataclasses.replace(CAR, steering_lag=0.0)
    state = VehicleState(x=0.0, y=1.0, psi=0.0, v_x=20.0)
    path = interpolate_path([[-10.0, 0.0], [200.0, 0.0]])
    delta = PreviewController(quick).steer(state, path)
    assert math.isfinite(delta)
    assert delta < 0.0
