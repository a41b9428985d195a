"""RSS distances: hand values, the ad-rss library, and the worst case in small time steps."""

import math
import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import InputError
from cca_core.decide import (
    RSS_EGO,
    RSS_OTHER,
    RssSettings,
    rss_lateral,
    rss_opposite_direction,
    rss_same_direction,
)

SLOW = RssSettings(response_time=2.0)


@pytest.mark.parametrize(
    ("distance", "expected"),
    [
        (rss_same_direction(20.0, 20.0), 65.781),
        (rss_same_direction(30.0, 25.0, rear=SLOW), 199.062),
        (rss_opposite_direction(20.0, -20.0), 251.917),
        (rss_lateral(0.0, 0.0), 0.725),
        (rss_same_direction(0.0, 40.0), 0.0),
        (rss_same_direction(0.0, 40.0, rear=RssSettings(standstill_gap=2.0)), 2.0),
    ],
)
def test_distance_equals_hand_value(distance: Any, expected: float) -> None:
    assert float(distance) == pytest.approx(expected, abs=5e-4)


class Oracle:
    """The ad-rss library."""

    def __init__(self) -> None:
        pytest.importorskip("ad_physics")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            from ad_rss import physics, rss
        self.physics, self.rss = physics, rss

    def vehicle(self, s: RssSettings, v_x: float, v_right: float) -> Any:
        p = self.physics
        vehicle = self.rss.core.RelativeObjectState()
        vehicle.object_type = self.rss.world.ObjectType.OtherVehicle
        d = self.rss.world.RssDynamics()
        d.alpha_lon.accel_max, d.alpha_lon.brake_max = p.Acceleration(s.a_max), p.Acceleration(-s.b_max)
        d.alpha_lon.brake_min = p.Acceleration(-s.b_min)
        d.alpha_lon.brake_min_correct = p.Acceleration(-s.b_correct)
        d.alpha_lat.accel_max = p.Acceleration(s.a_lateral)
        d.alpha_lat.brake_min = p.Acceleration(-s.b_lateral)
        d.lateral_fluctuation_margin = p.Distance(s.fluctuation)
        d.response_time, d.max_speed_on_acceleration = p.Duration(s.response_time), p.Speed(s.v_max)
        d.min_longitudinal_safety_distance = p.Distance(s.standstill_gap)
        # these have no effect on the distances, but are required
        unused = d.unstructured_settings
        unused.pedestrian_turning_radius, unused.drive_away_max_angle = p.Distance(2.0), p.Angle(2.4)
        unused.vehicle_yaw_rate_change = p.AngularAcceleration(0.3)
        unused.vehicle_min_radius = p.Distance(3.5)
        unused.vehicle_trajectory_calculation_step = p.Duration(0.2)
        for name in dir(unused):
            if name.endswith("steps"):
                setattr(unused, name, 1)
        vehicle.dynamics = d
        unstructured = vehicle.unstructured_object_state
        unstructured.yaw = unstructured.steering_angle = p.Angle(0.0)
        unstructured.yaw_rate = p.AngularVelocity(0.0)
        unstructured.dimension.length, unstructured.dimension.width = p.Distance(4.5), p.Distance(1.8)
        unstructured.center_point.x = unstructured.center_point.y = p.Distance(0.0)
        unstructured.speed_range.minimum, unstructured.speed_range.maximum = p.Speed(0.0), p.Speed(50.0)
        structured = vehicle.structured_object_state
        structured.velocity.speed_lon_min = structured.velocity.speed_lon_max = p.Speed(v_x)
        structured.velocity.speed_lat_min = structured.velocity.speed_lat_max = p.Speed(v_right)
        structured.has_priority, structured.is_in_correct_lane = False, True
        structured.distance_to_enter_intersection = p.Distance(0.0)
        structured.distance_to_leave_intersection = p.Distance(1000.0)
        return vehicle

    def distance(self, name: str, first: Any, second: Any) -> float:
        out = self.physics.Distance(-1.0)
        assert getattr(self.rss.structured, f"calculateSafe{name}")(first, second, out)
        return float(out.mDistance)


@pytest.fixture(scope="module")
def oracle() -> Oracle:
    return Oracle()


def random_settings(rng: np.random.Generator) -> RssSettings:
    b_min = rng.uniform(1.0, 6.0)
    return RssSettings(
        response_time=rng.uniform(0.1, 3.0), a_max=rng.uniform(0.0, 5.0), b_min=b_min,
        b_max=b_min + rng.uniform(0.0, 5.0), b_correct=b_min * rng.uniform(0.3, 1.0),
        a_lateral=rng.uniform(0.0, 1.0), b_lateral=rng.uniform(0.3, 2.0), fluctuation=rng.uniform(0.0, 0.5),
        standstill_gap=rng.uniform(0.0, 4.0), v_max=rng.choice([100.0, rng.uniform(5.0, 40.0)]),
    )  # fmt: skip


@pytest.mark.parametrize("default", [True, False])
def test_distances_equal_ad_rss(oracle: Oracle, default: bool) -> None:
    rng = np.random.default_rng(11)
    for _ in range(400):
        one, two = (RSS_EGO, RSS_OTHER) if default else (random_settings(rng), random_settings(rng))
        v_1, v_2 = rng.uniform(0.0, 45.0, 2) * rng.integers(0, 2, 2) ** 0.3
        w_1, w_2 = rng.uniform(-3.0, 3.0, 2)
        a, b = oracle.vehicle(one, v_1, -w_1), oracle.vehicle(two, v_2, -w_2)
        expected = [
            oracle.distance("LongitudinalDistanceSameDirection", b, a),
            oracle.distance("LongitudinalDistanceOppositeDirection", a, b),
            oracle.distance("LateralDistance", a, b),
        ]
        found = [
            float(rss_same_direction(v_1, v_2, rear=one, front=two)),
            float(rss_opposite_direction(v_1, -v_2, correct=one, opposite=two)),
            float(rss_lateral(w_1, w_2, left=one, right=two)),
        ]
        assert found == pytest.approx(expected, abs=1e-6)


def driven(v: float, s: RssSettings, braking: float, react: bool = True) -> Any:
    """Positions of a vehicle in the worst case, in steps of 1 ms."""
    t = np.arange(0.0, 40.0, 1e-3)
    end = v + s.a_max * s.response_time if react else v
    speed = np.minimum(v + s.a_max * t, end) - braking * np.maximum(t - s.response_time * react, 0.0)
    return np.concatenate(([0.0], np.cumsum(np.maximum(speed, 0.0)) * 1e-3))


@given(st.floats(0.0, 40.0), st.floats(0.0, 40.0))
def test_distance_equals_simulated_worst_case(v_rear: float, v_front: float) -> None:
    rear, front = driven(v_rear, RSS_EGO, RSS_EGO.b_min), driven(v_front, RSS_OTHER, RSS_OTHER.b_max, False)
    needed = max(float((rear - front)[-1]), 0.0)
    distance = float(rss_same_direction(v_rear, v_front))
    assert distance == pytest.approx(needed, abs=0.1)
    toward = driven(v_rear, RSS_EGO, RSS_EGO.b_correct)[-1] + driven(v_front, RSS_OTHER, 4.0)[-1]
    assert float(rss_opposite_direction(v_rear, v_front)) == pytest.approx(float(toward), abs=0.1)


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_lateral_distance_is_mirrored(v_left: float, v_right: float) -> None:
    mirrored = rss_lateral(-v_right, -v_left, left=RSS_OTHER, right=RSS_EGO)
    assert float(mirrored) == pytest.approx(float(rss_lateral(v_left, v_right)), abs=1e-12)


@given(st.floats(0.0, 40.0), st.floats(0.0, 40.0), st.floats(0.0, 5.0))
def test_larger_closing_speed_never_needs_less_distance(v_rear: float, v_front: float, more: float) -> None:
    base = float(rss_same_direction(v_rear, v_front + more))
    assert float(rss_same_direction(v_rear + more, v_front + more)) >= base - 1e-9
    assert float(rss_same_direction(v_rear, v_front)) >= base - 1e-9
    faster = rss_opposite_direction(v_rear + more, v_front)
    assert float(faster) >= float(rss_opposite_direction(v_rear, v_front)) - 1e-9


def test_distances_broadcast() -> None:
    table = rss_same_direction([[10.0], [20.0]], [5.0, 10.0, 20.0])
    assert table.shape == (2, 3)
    assert table[1, 2] == pytest.approx(65.781, abs=5e-4)
    assert rss_lateral([0.0, 1.0], 0.0).shape == (2,)
    assert rss_opposite_direction([], 1.0).shape == (0,)


@pytest.mark.parametrize("bad", [math.nan, math.inf, "fast", None])
def test_invalid_speed_raises(bad: Any) -> None:
    for function in (rss_same_direction, rss_opposite_direction, rss_lateral):
        with pytest.raises(InputError):
            function(bad, 1.0)  # type: ignore[operator]


@pytest.mark.parametrize("speeds", [(-1.0, 0.0), (0.0, [1.0, -1.0])])
def test_negative_speed_raises(speeds: Any) -> None:
    with pytest.raises(InputError, match="negative"):
        rss_same_direction(*speeds)


@pytest.mark.parametrize(
    "changes", [{"b_max": 3.0}, {"response_time": 0.0}, {"a_max": math.nan}, {"b_lateral": -0.8}]
)
def test_invalid_settings_raise(changes: dict[str, float]) -> None:
    with pytest.raises(InputError, match=next(iter(changes))):
        RssSettings(**changes)
