"""Textbook steering laws: formulas in a steady turn, symmetry, the Riccati equation, a closed loop."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, Path, VehicleParams, VehicleState
from cca_core.baselines import LqrSteering, PurePursuit, Stanley
from cca_core.follow import discretized, single_track, steady_sideslip, steady_steering
from cca_core.path import interpolate_path
from cca_core.sim import SingleTrackPlant, lane_change_path, track_path

CAR = VehicleParams.bmw_320i()
UNDERSTEER = VehicleParams(m=1500.0, I_z=2500.0, l_f=1.2, l_r=1.5, C_f=80e3, C_r=110e3, length=4.5, width=1.8)
LINE = Path([0.0, 2000.0], [[[0, 0, 2000, 0], [0, 0, 0, 0]]])
LAWS = [PurePursuit, Stanley, LqrSteering]


def arc(radius: float, angle: float = 2.0, n: int = 401) -> Path:
    phi = np.linspace(0.0, angle, n)
    nodes = np.column_stack((abs(radius) * np.sin(phi), radius * (1.0 - np.cos(phi))))
    end = [math.cos(angle), math.copysign(math.sin(angle), radius)]
    return interpolate_path(nodes, start_tangent=[1.0, 0.0], end_tangent=end)


LEFT, RIGHT = arc(200.0), arc(-200.0)


def in_turn(path: Path, s: float, v: float, car: VehicleParams, ahead: float) -> VehicleState:
    """Steady turn of kappa with the point `ahead` of the center of gravity on the path."""
    kappa = float(path.curvature(s))
    beta = float(steady_sideslip(kappa, v, car))
    (x, y), psi = path.position(s), float(path.heading(s))
    psi -= beta + ahead * kappa  # velocity of that point along the path, small angles
    return VehicleState(
        x=float(x) - ahead * math.cos(psi), y=float(y) - ahead * math.sin(psi), psi=psi,
        v_x=v, v_y=v * math.tan(beta), r=v * kappa,
    )  # fmt: skip


@pytest.mark.parametrize("law", LAWS)
def test_straight_path_needs_no_steering(law: Any) -> None:
    for v in (0.0, 5.0, 30.0):
        state = VehicleState(x=50.0, y=0.0, psi=0.0, v_x=v)
        assert law(CAR).steer(state, LINE) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("v", [0.0, 3.0, 20.0])
def test_law_steers_back_and_is_symmetric(law: Any, v: float) -> None:
    state = VehicleState(x=50.0, y=0.5, psi=0.0, v_x=v)
    delta = law(CAR).steer(state, LINE)
    assert delta < 0.0
    assert law(CAR).steer(dataclasses.replace(state, y=-0.5), LINE) == pytest.approx(-delta, abs=1e-12)
    x, y = LEFT.to_cartesian(100.0, 0.4).tolist()
    state = VehicleState(x=x, y=y, psi=float(LEFT.heading(100.0)) + 0.03, v_x=v, v_y=0.1, r=0.05)
    mirrored = dataclasses.replace(state, y=-y, psi=-state.psi, v_y=-0.1, r=-0.05)
    assert law(CAR).steer(mirrored, RIGHT) == pytest.approx(-law(CAR).steer(state, LEFT), abs=1e-9)


@pytest.mark.parametrize("law", LAWS)
def test_steering_angle_is_limited(law: Any) -> None:
    state = VehicleState(x=50.0, y=30.0, psi=2.0, v_x=5.0)
    assert abs(law(CAR).steer(state, LINE)) <= CAR.delta_max


def test_pure_pursuit_is_circle_to_goal_point() -> None:
    """On a circle with the rear axle on it and along it: delta = atan(L / R) for every look-ahead."""
    psi, (x, y) = float(LEFT.heading(100.0)), LEFT.position(100.0).tolist()
    state = VehicleState(x=x + CAR.l_r * math.cos(psi), y=y + CAR.l_r * math.sin(psi), psi=psi, v_x=1.0)
    for look_ahead in (4.0, 10.0, 40.0):
        law = PurePursuit(CAR, min_look_ahead=look_ahead)
        assert law.steer(state, LEFT) == pytest.approx(math.atan(CAR.wheelbase / 200.0), rel=1e-4)


def test_stanley_equals_formula() -> None:
    """e and psi of the front axle on a straight road."""
    psi, e, v, r = 0.05, 0.4, 10.0, 0.02
    state = VehicleState(x=50.0, y=e - CAR.l_f * math.sin(psi), psi=psi, v_x=v, r=r)
    law = Stanley(CAR, gain=2.0, softening=1.0, yaw_damping=0.3)
    assert law.steer(state, LINE) == pytest.approx(-psi - math.atan(2.0 * e / (1.0 + v)) - 0.3 * r, abs=1e-12)


@pytest.mark.parametrize("car", [CAR, UNDERSTEER])
@pytest.mark.parametrize("v", [5.0, 15.0])
def test_stanley_and_lqr_hold_steady_turn(car: VehicleParams, v: float) -> None:
    expected = float(steady_steering(1.0 / 200.0, v, car))
    for law, ahead in ((Stanley(car), car.l_f), (LqrSteering(car), 0.0)):
        delta = law.steer(in_turn(LEFT, 100.0, v, car, ahead), LEFT)
        assert delta == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("v", [3.0, 10.0, 30.0])
def test_lqr_gains_are_optimal(v: float) -> None:
    """No change of a gain by a hundredth lowers the cost of x_0 with the weights given."""
    law = LqrSteering(CAR, q_d=0.05, q_rate=0.001, q_psi=0.7)
    model, k = discretized(single_track(CAR, v, 0.0), 0.02), law.gains(v)
    rate = np.array([v, 0.0, v, 0.0])
    Q = 0.001 * np.outer(rate, rate) + np.diag([0.0, 0.0, 0.7, 0.05])

    def cost(k: np.ndarray) -> float:
        x, total = np.array([0.01, 0.02, 0.03, 0.5]), 0.0
        for _ in range(3000):
            u = -float(k @ x)
            total += float(x @ Q @ x) + u * u
            x = model.A @ x + model.B * u
        return total

    best = cost(k)
    for i in range(4):
        for factor in (0.99, 1.01):
            changed = k.copy()
            changed[i] *= factor
            assert cost(changed) > best


@pytest.mark.parametrize("law", LAWS)
def test_law_follows_lane_change(law: Any) -> None:
    plant = SingleTrackPlant(CAR, VehicleState(x=0.0, y=0.0, psi=0.0, v_x=14.0))
    run = track_path(plant, law(CAR).steer, lane_change_path(3.5, 60.0), 14.0)
    assert run.peak < 0.15


@pytest.mark.parametrize(
    ("law", "name", "value"),
    [(PurePursuit, "look_ahead_time", 0.0), (PurePursuit, "min_look_ahead", -1.0), (Stanley, "gain", -1.0),
     (Stanley, "softening", math.nan), (Stanley, "yaw_damping", -0.1), (LqrSteering, "q_d", 0.0),
     (LqrSteering, "q_rate", -1.0), (LqrSteering, "q_psi", -1.0), (LqrSteering, "cycle_time", 0.0),
     (LqrSteering, "min_speed", 0.0)],
)  # fmt: skip
def test_error_names_setting(law: Any, name: str, value: float) -> None:
    with pytest.raises(InputError, match=f"^{name} must"):
        law(CAR, **{name: value})
