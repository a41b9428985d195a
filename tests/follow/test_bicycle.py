"""The linear single track against a Jacobian, hand values and steady-state formulas."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import cont2discrete

from cca_core.errors import InputError
from cca_core.follow import (
    PreviewGains,
    discretized,
    kinematic_rates,
    shipped_gains,
    single_track,
    steady_sideslip,
    steady_steering,
    steady_turn,
    steady_yaw_rate,
)
from cca_core.path import interpolate_path
from cca_core.vehicle import VehicleParams

BMW = VehicleParams.bmw_320i()
PRESETS = [BMW, VehicleParams.ford_escort(), VehicleParams.vw_vanagon()]
UNDERSTEER = VehicleParams(m=1500.0, I_z=2500.0, l_f=1.2, l_r=1.5, C_f=80e3, C_r=110e3, length=4.5, width=1.8)
CARS = [*PRESETS, UNDERSTEER]


def nonlinear(
    x: np.ndarray, delta: float, rho: float, car: VehicleParams, v: float, l_s: float
) -> np.ndarray:
    """Bicycle with tan, sin and cos, linear tires and constant v_x, on a path of curvature rho.

    x = [beta, r, e_psi, h + l_s e_psi]; the foot point moves at (v_x cos e - v_y sin e) / (1 - h rho).
    """
    beta, r, e_psi, e_y = x
    v_y, h = v * math.tan(beta), e_y - l_s * e_psi
    F_f = -car.C_f * (math.atan2(v_y + car.l_f * r, v) - delta)
    F_r = -car.C_r * math.atan2(v_y - car.l_r * r, v)
    v_y_dot = (F_f * math.cos(delta) + F_r) / car.m - v * r
    r_dot = (car.l_f * F_f * math.cos(delta) - car.l_r * F_r) / car.I_z
    s_dot = (v * math.cos(e_psi) - v_y * math.sin(e_psi)) / (1.0 - h * rho)
    e_psi_dot = r - rho * s_dot
    h_dot = v * math.sin(e_psi) + v_y * math.cos(e_psi)
    return np.array([v_y_dot / v / (1.0 + (v_y / v) ** 2), r_dot, e_psi_dot, h_dot + l_s * e_psi_dot])


@pytest.mark.parametrize("car", CARS)
@pytest.mark.parametrize(("v", "l_s"), [(5.0, 5.0), (10.0, 10.0), (20.0, 0.0), (35.0, 35.0)])
def test_matrices_equal_jacobian_of_nonlinear_bicycle(car: VehicleParams, v: float, l_s: float) -> None:
    model, zero, step = single_track(car, v, l_s), np.zeros(4), 1e-6

    def slope(plus: np.ndarray, minus: np.ndarray) -> np.ndarray:
        return (plus - minus) / (2 * step)

    for j in range(4):
        e = step * np.eye(4)[j]
        column = slope(nonlinear(e, 0, 0, car, v, l_s), nonlinear(-e, 0, 0, car, v, l_s))
        np.testing.assert_allclose(model.A[:, j], column, rtol=1e-7, atol=1e-7)
    B = slope(nonlinear(zero, step, 0, car, v, l_s), nonlinear(zero, -step, 0, car, v, l_s))
    E = slope(nonlinear(zero, 0, step, car, v, l_s), nonlinear(zero, 0, -step, car, v, l_s))
    np.testing.assert_allclose(model.B, B, rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(model.E, E, rtol=1e-7, atol=1e-7)


def test_matrices_equal_hand_values() -> None:
    model = single_track(UNDERSTEER, 20.0, 10.0)
    moment, damping = 110e3 * 1.5 - 80e3 * 1.2, 80e3 * 1.44 + 110e3 * 2.25
    expected = [
        [-190e3 / 30e3, moment / (1500 * 400) - 1, 0, 0],
        [moment / 2500, -damping / 50e3, 0, 0],
        [0, 1, 0, 0],
        [20, 10, 20, 0],
    ]
    np.testing.assert_allclose(model.A, expected, rtol=1e-14)
    np.testing.assert_allclose(model.B, [80e3 / 30e3, 80e3 * 1.2 / 2500, 0, 0], rtol=1e-14)
    np.testing.assert_allclose(model.E, [0, 0, -20, -200], rtol=1e-14)


@pytest.mark.parametrize("car", CARS)
@given(
    st.floats(2.0, 40.0),
    st.floats(-0.02, 0.02),
    st.floats(0.0, 40.0),
    st.floats(0.002, 0.5),
    st.floats(0.0, 0.2),
)
def test_pd_steering_reaches_predicted_steady_state(
    car: VehicleParams, v: float, rho: float, l_s: float, k_p: float, k_d: float
) -> None:
    """A x + B delta + E rho = 0 with delta = -k_p e_y - k_d e_y': theory.md, Follow."""
    model = single_track(car, v, l_s)
    # e_y' = c x + e rho does not depend on delta, so the loop closes in one step
    gain = np.array([0.0, 0.0, 0.0, k_p]) + k_d * model.A[3]
    closed = model.A - np.outer(model.B, gain)
    x = np.linalg.solve(closed, -(model.E - model.B * k_d * model.E[3]) * rho)
    beta, r, e_psi, e_y = x
    delta_ss = float(steady_steering(rho, v, car))
    beta_ss = float(steady_sideslip(rho, v, car))
    L = car.wheelbase
    K = car.m / L * (car.l_r / car.C_f - car.l_f / car.C_r)
    assert delta_ss == pytest.approx(rho * (L + K * v * v), abs=1e-12)
    assert beta_ss == pytest.approx(rho * (car.l_r - car.l_f * car.m * v * v / (car.C_r * L)), abs=1e-12)
    assert r == pytest.approx(v * rho, abs=1e-9)
    assert beta == pytest.approx(beta_ss, abs=1e-9)
    assert e_psi == pytest.approx(-beta_ss, abs=1e-9)
    assert e_y == pytest.approx(-delta_ss / k_p, abs=1e-9 * max(1.0, 1.0 / k_p))
    assert e_y - l_s * e_psi == pytest.approx(-delta_ss / k_p + l_s * beta_ss, abs=1e-9 * max(1.0, 1.0 / k_p))


@given(st.floats(2.0, 40.0), st.floats(-0.02, 0.02))
def test_exact_feedforward_leaves_error_l_s_beta(v: float, rho: float) -> None:
    """With e_y = 0 the car has a lateral error of l_s beta_ss."""
    l_s, car = 15.0, UNDERSTEER
    model = single_track(car, v, l_s)
    x = np.array([steady_sideslip(rho, v, car), v * rho, -steady_sideslip(rho, v, car), 0.0], dtype=float)
    rate = model.A @ x + model.B * float(steady_steering(rho, v, car)) + model.E * rho
    np.testing.assert_allclose(rate, 0.0, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("car", CARS)
@given(st.floats(1.0, 40.0), st.floats(-0.05, 0.05))
def test_steady_yaw_rate_solves_lateral_dynamics(car: VehicleParams, v: float, delta: float) -> None:
    model = single_track(car, v, 0.0)
    beta, r = np.linalg.solve(model.A[:2, :2], -model.B[:2] * delta)
    assert float(steady_yaw_rate(delta, v, car)) == pytest.approx(r, abs=1e-9)
    kappa = r / v
    assert float(steady_steering(kappa, v, car)) == pytest.approx(delta, abs=1e-9)
    assert float(steady_sideslip(kappa, v, car)) == pytest.approx(beta, abs=1e-9)


def test_steady_turn_at_low_speed_is_kinematic() -> None:
    assert float(steady_yaw_rate(0.1, 1e-3, UNDERSTEER)) == pytest.approx(1e-3 * 0.1 / 2.7, rel=1e-6)
    assert float(steady_sideslip(0.01, 0.0, UNDERSTEER)) == pytest.approx(0.015, abs=1e-15)


def test_steady_formulas_broadcast() -> None:
    v, k = np.array([[5.0], [10.0]]), np.array([0.0, 0.01, 0.02])
    for f in (steady_steering, steady_sideslip, steady_yaw_rate):
        assert f(k, v, UNDERSTEER).shape == (2, 3)
        assert float(f(k, v, UNDERSTEER)[1, 2]) == pytest.approx(float(f(0.02, 10.0, UNDERSTEER)), rel=1e-14)


@pytest.mark.parametrize("radius", [200.0, -400.0])
def test_steady_turn_has_no_rates(radius: float) -> None:
    """All rates of the linear model are zero."""
    angle = np.linspace(0.0, 1.0, 60)
    circle = interpolate_path(np.column_stack((abs(radius) * np.sin(angle), radius * (1.0 - np.cos(angle)))))
    state = steady_turn(circle, 80.0, 15.0, BMW)
    beta, e_psi = state.v_y / state.v_x, state.psi - float(circle.heading(80.0))
    model = single_track(BMW, 15.0, 0.0)
    rates = model.A @ [beta, state.r, e_psi, 0.0] + model.B * state.delta + model.E / radius
    assert np.abs(rates).max() < 1e-5
    assert state.r * radius == pytest.approx(15.0, rel=1e-4)
    assert (state.x, state.y) == tuple(circle.position(80.0))
    assert state.delta * radius > 0.0


def test_invalid_steady_turn_raises() -> None:
    road = interpolate_path([[0.0, 0.0], [50.0, 0.0]])
    with pytest.raises(InputError, match=r"^v_x must be at least 0"):
        steady_turn(road, 10.0, -1.0, BMW)
    with pytest.raises(InputError, match=r"^s must be finite"):
        steady_turn(road, math.nan, 1.0, BMW)


@pytest.mark.parametrize(
    ("v", "l_s", "words"),
    [(0.0, 1.0, "^v_x must be greater than 0"), (-5.0, 1.0, "^v_x must"), (math.nan, 1.0, "^v_x must"),
     (5.0, -1.0, "^l_s must be at least 0"), (5.0, math.inf, "^l_s must"), (None, 1.0, "^v_x must")],
)  # fmt: skip
def test_invalid_model_input_raises(v: object, l_s: float, words: str) -> None:
    with pytest.raises(InputError, match=words):
        single_track(UNDERSTEER, v, l_s)  # type: ignore[arg-type]


# --- the default schedule -----------------------------------------------------------------------------


def poles(car: VehicleParams, v: float, lag: float = 0.1) -> np.ndarray:
    """Closed loop with the steering actuator as a fifth state."""
    k_p, k_d, l_s = shipped_gains(VehicleParams.bmw_320i()).at(v)
    model = single_track(car, v, l_s)
    full = np.zeros((5, 5))
    full[:4, :4], full[:4, 4] = model.A, model.B
    full[4, :4] = -(k_p * np.eye(4)[3] + k_d * model.A[3]) / lag
    full[4, 4] = -1.0 / lag
    return np.linalg.eigvals(full)


@pytest.mark.parametrize("v", [4.0, 5.0, 7.0, 10.0, 11.5, 15.0, 18.0, 20.0, 25.0, 30.0, 32.5])
def test_default_gains_are_d_stable_for_vehicle_2(v: float) -> None:
    """Re < -0.8 1/s and a damping of at least 0.6 (theory.md, Follow), between the grid points too."""
    roots = poles(VehicleParams.bmw_320i(), v)
    assert roots.real.max() < -0.8
    assert (-roots.real / np.abs(roots)).min() >= 0.6


@pytest.mark.parametrize("v", [35.0, 37.5, 40.0])
def test_default_gains_are_d_stable_up_to_end_of_schedule(v: float) -> None:
    """The schedule covers 2 to 40 m/s."""
    roots = poles(VehicleParams.bmw_320i(), v)
    assert roots.real.max() < -0.8
    assert (-roots.real / np.abs(roots)).min() >= 0.6


@pytest.mark.parametrize("v", [2.0, 3.0])
def test_default_gains_at_walking_pace_are_damped(v: float) -> None:
    roots = poles(VehicleParams.bmw_320i(), v)
    assert roots.real.max() < -0.3  # at 2 m/s Re < -0.8 would be a settling length of 2.5 m
    assert (-roots.real / np.abs(roots)).min() >= 0.6


@pytest.mark.parametrize("car", PRESETS[1:])
@pytest.mark.parametrize("v", [5.0, 10.0, 20.0, 30.0])
def test_default_gains_stabilize_other_presets(car: VehicleParams, v: float) -> None:
    roots = poles(car, v)
    assert roots.real.max() < -0.8
    assert (-roots.real / np.abs(roots)).min() >= 0.6


def test_gains_are_linear_inside_grid_and_held_outside() -> None:
    gains = PreviewGains(speeds=(10.0, 20.0), k_p=(0.4, 0.2), k_d=(0.04, 0.0), l_s=(5.0, 15.0))
    assert gains.at(10.0) == (0.4, 0.04, 5.0)
    assert gains.at(12.5) == pytest.approx((0.35, 0.03, 7.5), abs=1e-15)
    assert gains.at(20.0) == (0.2, 0.0, 15.0)
    assert gains.at(0.0) == (0.4, 0.04, 5.0)
    assert gains.at(99.0) == (0.2, 0.0, 15.0)
    single = PreviewGains(speeds=(10.0,), k_p=(0.4,), k_d=(0.04,), l_s=(5.0,))
    assert single.at(3.0) == single.at(10.0) == single.at(30.0) == (0.4, 0.04, 5.0)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"k_p": (0.1,)}, r"^k_p must have one value per speed \(2\), had 1"),
        ({"speeds": (), "k_p": (), "k_d": (), "l_s": ()}, "^speeds must"),
        ({"speeds": (20.0, 10.0)}, "^speeds must increase"),
        ({"speeds": (10.0, 10.0)}, "^speeds must increase"),
        ({"speeds": (0.0, 10.0)}, "^speeds must"),
        ({"speeds": (-1.0, 10.0)}, "^speeds must"),
        ({"k_d": (-0.1, 0.0)}, "^k_d must be at least 0"),
        ({"l_s": (5.0, math.nan)}, "^l_s must be finite"),
        ({"k_p": 0.1}, "^k_p must"),
    ],
)
def test_invalid_gains_raise(changes: dict, words: str) -> None:
    good = {"speeds": (10.0, 20.0), "k_p": (0.4, 0.2), "k_d": (0.04, 0.0), "l_s": (5.0, 15.0)}
    with pytest.raises(InputError, match=words):
        PreviewGains(**{**good, **changes})


# --- discrete and kinematic; an independent single track -------------------------------------------------


@pytest.mark.parametrize("car", CARS)
@pytest.mark.parametrize(("v", "dt"), [(3.0, 0.02), (20.0, 0.02), (35.0, 0.1)])
def test_discretization_is_zero_order_hold(car: VehicleParams, v: float, dt: float) -> None:
    model = single_track(car, v, 10.0)
    B = np.column_stack((model.B, model.E))
    Ad, Bd, *_ = cont2discrete((model.A, B, np.eye(4), np.zeros((4, 2))), dt, method="zoh")
    model = discretized(model, dt)
    np.testing.assert_allclose(model.A, Ad, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(np.column_stack((model.B, model.E)), Bd, rtol=1e-10, atol=1e-12)


def test_two_half_steps_equal_one_step() -> None:
    model = single_track(UNDERSTEER, 15.0, 15.0)
    half, whole = discretized(model, 0.05), discretized(model, 0.1)
    np.testing.assert_allclose(half.A @ half.A, whole.A, atol=1e-12)
    np.testing.assert_allclose(half.A @ half.B + half.B, whole.B, atol=1e-12)
    with pytest.raises(InputError, match=r"^dt must be greater than 0"):
        discretized(model, 0.0)


@given(st.floats(-3.0, 3.0), st.floats(0.1, 20.0), st.floats(-0.5, 0.5))
def test_kinematic_rates_roll_without_slip(psi: float, v: float, delta: float) -> None:
    """The rear axle moves along the body, the front axle along its wheels."""
    x, y, r = (float(a) for a in kinematic_rates(psi, v, delta, UNDERSTEER))
    forward, left = np.array([math.cos(psi), math.sin(psi)]), np.array([-math.sin(psi), math.cos(psi)])
    center = np.array([x, y])
    rear = center - UNDERSTEER.l_r * r * left
    front = center + UNDERSTEER.l_f * r * left
    np.testing.assert_allclose(rear, v * forward, atol=1e-9)
    assert math.atan2(front @ left, front @ forward) == pytest.approx(delta, abs=1e-12)


def test_kinematic_rates_broadcast() -> None:
    x, _, r = kinematic_rates(np.zeros((3, 1)), 10.0, np.array([0.0, 0.1]), UNDERSTEER)
    assert x.shape == (3, 2)
    assert r.shape == (2,)


@pytest.mark.requires("vehiclemodels")
@pytest.mark.parametrize("v", [10.0, 20.0, 30.0])
def test_model_equals_linearized_commonroad_single_track(v: float) -> None:
    """States there: x, y, delta, v, psi, psi', beta; the steering angle is a state."""
    from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
    from vehiclemodels.vehicle_dynamics_st import vehicle_dynamics_st

    p, step = parameters_vehicle2(), 1e-5

    def rates(beta: float, r: float, delta: float) -> np.ndarray:
        f = vehicle_dynamics_st([0.0, 0.0, delta, v, 0.0, r, beta], [0.0, 0.0], p)
        return np.array([f[6], f[5]])

    columns = [(rates(*e) - rates(*-e)) / (2.0 * step) for e in step * np.eye(3)]
    model = single_track(VehicleParams.bmw_320i(), v, 0.0)
    # the moment of the two axles about the center of gravity is the small difference of large numbers
    moment = max(BMW.C_f * BMW.l_f, BMW.C_r * BMW.l_r) / BMW.I_z
    scale = np.array([[abs(model.A[0, 0]), 1.0], [moment, abs(model.A[1, 1])]])
    np.testing.assert_allclose(np.column_stack(columns[:2]) / scale, model.A[:2, :2] / scale, atol=5e-4)
    np.testing.assert_allclose(columns[2], model.B[:2], rtol=5e-4)
