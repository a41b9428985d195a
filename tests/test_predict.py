"""Prediction of other vehicles: closed forms on straight and circular roads."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from cca_core.geometry import wrap_angle
from cca_core.path import fit_path, interpolate_path
from cca_core.path.path import Path
from cca_core.predict import predict_along, predict_distance, reachable_interval
from cca_core.vehicle import RemoteVehicle

STRAIGHT = Path([0.0, 200.0], [[[0, 0, 200, 0], [0, 0, 0, 0]]])
RADIUS = 100.0


@pytest.fixture(scope="module")
def circle() -> Path:
    """Left-hand circle about (0, R), from the origin toward +x, two thirds of a turn."""
    phi = np.linspace(0.0, 4.0, 401)
    nodes = RADIUS * np.column_stack((np.sin(phi), 1.0 - np.cos(phi)))
    return interpolate_path(nodes, start_tangent=[1.0, 0.0], end_tangent=[math.cos(4.0), math.sin(4.0)])


def remote(**changes: object) -> RemoteVehicle:
    return RemoteVehicle(**{"id": "A", "x": 0.0, "y": 0.0, "psi": 0.0, "v_x": 20.0, **changes})


@given(st.floats(0.1, 50.0), st.floats(-10.0, -1.001), st.floats(0.0, 30.0))
def test_distance_while_braking_is_integral_of_speed(v: float, a: float, t: float) -> None:
    stop = v / -a
    speed_integral = quad(lambda tau: max(v + a * tau, 0.0), 0.0, t, points=[min(stop, t)])[0]
    assert float(predict_distance(v, a, t)) == pytest.approx(speed_integral, abs=1e-8)
    assert float(predict_distance(v, a, t)) <= v * v / (-2.0 * a) + 1e-12


@given(st.floats(-20.0, 60.0), st.floats(-1.0, 10.0), st.floats(-5.0, 30.0))
def test_distance_without_braking_is_linear(v: float, a: float, t: float) -> None:
    assert float(predict_distance(v, a, t)) == v * t


def test_distance_equals_hand_values() -> None:
    np.testing.assert_allclose(
        predict_distance(20.0, -5.0, [0.0, 1.0, 4.0, 9.0]), [0.0, 17.5, 40.0, 40.0], atol=1e-13
    )
    np.testing.assert_allclose(predict_distance(20.0, -5.0, [-2.0, -0.5]), [-40.0, -10.0], atol=1e-13)
    np.testing.assert_allclose(predict_distance(0.0, -5.0, [-1.0, 3.0]), [0.0, 0.0])
    np.testing.assert_allclose(predict_distance(-3.0, -5.0, [2.0]), [-6.0])
    assert predict_distance(20.0, -5.0, np.ones((2, 3))).shape == (2, 3)


def test_vehicle_on_straight_road_keeps_offset() -> None:
    t = np.linspace(-1.0, 5.0, 13)
    found = predict_along(remote(x=30.0, y=3.5), STRAIGHT, 30.0, 3.5, t)
    np.testing.assert_allclose(found.x, 30.0 + 20.0 * t, atol=1e-12)
    np.testing.assert_allclose(found.y, np.full(13, 3.5), atol=1e-12)
    np.testing.assert_allclose(found.psi, 0.0, atol=1e-12)


def test_oncoming_vehicle_drives_toward_smaller_s() -> None:
    t = np.array([0.0, 1.0, 2.0])
    found = predict_along(remote(psi=math.pi), STRAIGHT, 150.0, 3.5, t)
    np.testing.assert_allclose(found.x, [150.0, 130.0, 110.0], atol=1e-12)
    np.testing.assert_allclose(np.cos(found.psi), -1.0, atol=1e-12)
    np.testing.assert_allclose(found.y, 3.5, atol=1e-12)


def test_braking_oncoming_vehicle_stops() -> None:
    found = predict_along(remote(psi=-math.pi, a_x=-5.0), STRAIGHT, 150.0, 0.0, [4.0, 10.0])
    np.testing.assert_allclose(found.x, [110.0, 110.0], atol=1e-12)


@pytest.mark.parametrize("d", [-3.5, 0.0, 3.5])
def test_vehicle_on_circle_keeps_lane_and_turns_with_road(circle: Path, d: float) -> None:
    t = np.linspace(0.0, 8.0, 9)
    found = predict_along(remote(), circle, 50.0, d, t)
    phi = np.arctan2(found.x, RADIUS - found.y)  # angle about the center
    np.testing.assert_allclose(np.hypot(found.x, found.y - RADIUS), RADIUS - d, atol=1e-5)
    np.testing.assert_allclose(wrap_angle(found.psi - phi - (found.psi - phi)[0]), 0.0, atol=1e-5)
    np.testing.assert_allclose(np.diff(np.unwrap(found.psi)), np.diff(np.unwrap(phi)), atol=1e-5)


@pytest.mark.parametrize("d", [-7.0, -3.5, 3.5])
def test_vehicle_speed_differs_from_foot_point_speed(circle: Path, d: float) -> None:
    """In t seconds a vehicle at offset d drives v t meters, (1 - d kappa) for each meter of the road."""
    t = np.linspace(0.0, 8.0, 81)
    found = predict_along(remote(psi=float(circle.heading(50.0))), circle, 50.0, d, t)
    driven = np.hypot(np.diff(found.x), np.diff(found.y)).sum()
    assert driven == pytest.approx(20.0 * 8.0, rel=1e-3)


@pytest.mark.parametrize("relative", [0.0, 0.5, math.pi / 3, -math.pi / 3, 2.5, math.pi])
def test_speed_along_road_is_velocity_component(relative: float) -> None:
    """The formula of the docstring."""
    found = predict_along(remote(psi=relative), STRAIGHT, 100.0, 0.0, [0.0, 1.0])
    assert found.x[1] - found.x[0] == pytest.approx(20.0 * math.cos(relative), abs=1e-9)


def test_box_keeps_angle_to_road(circle: Path) -> None:
    heading = float(circle.heading(50.0))
    found = predict_along(remote(psi=heading + 0.1), circle, 50.0, 0.0, [0.0, 2.0, 4.0])
    np.testing.assert_allclose(
        wrap_angle(found.psi - circle.heading(50.0 + 20.0 * np.array([0.0, 2.0, 4.0]))), 0.1, atol=0.05
    )
    assert float(wrap_angle(found.psi[0] - heading)) == pytest.approx(0.1, abs=1e-12)


def test_box_grows_by_two_sigma_on_each_side() -> None:
    plain = predict_along(remote(length=4.5, width=1.8), STRAIGHT, 0.0, 0.0, [1.0])
    grown = predict_along(
        remote(length=4.5, width=1.8, sigma_along=1.5, sigma_across=0.2), STRAIGHT, 0.0, 0.0, [1.0]
    )
    assert float(plain.length) == 4.5
    assert float(plain.width) == 1.8
    assert float(grown.length) == pytest.approx(4.5 + 2 * 2 * 1.5, abs=1e-14)
    assert float(grown.width) == pytest.approx(1.8 + 2 * 2 * 0.2, abs=1e-14)
    np.testing.assert_array_equal(plain.x, grown.x)


def test_prediction_is_rotation_invariant() -> None:
    turn = 2.1
    c, s = math.cos(turn), math.sin(turn)
    R = np.array([[c, s], [-s, c]])
    xs = np.linspace(0.0, 200.0, 41)
    xy = np.column_stack((xs, 15.0 * np.sin(xs / 40.0)))
    here, there = fit_path(xy), fit_path(xy @ R)
    t = np.linspace(0.0, 5.0, 6)
    a = predict_along(remote(psi=0.3), here, 40.0, -3.5, t)
    b = predict_along(remote(psi=0.3 + turn), there, 40.0, -3.5, t)
    np.testing.assert_allclose(np.column_stack((a.x, a.y)) @ R, np.column_stack((b.x, b.y)), atol=1e-6)
    np.testing.assert_allclose(wrap_angle(b.psi - a.psi - turn), 0.0, atol=1e-6)


def test_denormal_braking_equals_no_braking() -> None:
    low, _ = reachable_interval(20.0, [1.0, 4.0], braking=5e-324, acceleration=0.0)
    np.testing.assert_allclose(low, [20.0, 80.0])
