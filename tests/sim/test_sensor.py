"""Line of sight against shapely and by construction; detections of the sensor."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import Lane, Road, VehicleState
from cca_core.path import interpolate_path
from cca_core.sim import RoadUser, Scenario, Sensor, visible_fraction
from cca_core.sim.scenarios.eebl import CAR

PI = math.pi


def scenario(*users: RoadUser, **kwargs: Any) -> Scenario:
    path = interpolate_path([[0.0, 0.0], [400.0, 0.0]])
    settings: dict[str, Any] = {"ego_type": "sensor", "sensor_delay": 0.4} | kwargs
    return Scenario(
        name="test", case=None, road=Road(path, [Lane(d=0.0), Lane(d=3.5)]), vehicle=CAR, start=50.0,
        v_x=10.0, cruise_speed=10.0, road_users=users, **settings,
    )  # fmt: skip


def rows(*poses: tuple[float, ...]) -> list[tuple[float, ...]]:
    return [(*p, 0.0, 0.0, 0.0, 0.0)[:6] for p in poses]


EGO = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=10.0)
A, B = (RoadUser(id=name, s=0.0, d=0.0, v_x=0.0) for name in "AB")


class TestShare:
    def test_unobstructed_body_is_fully_visible(self) -> None:
        assert visible_fraction(0j, 0.0, PI / 3.0, (30.0, 0.0, 0.0, 4.5, 1.8), []) == pytest.approx(1.0)

    def test_equal_body_occludes_fully(self) -> None:
        body, front = (30.0, 0.0, 0.0, 4.5, 1.8), (15.0, 0.0, 0.0, 4.5, 1.8)
        assert visible_fraction(0j, 0.0, PI / 3.0, body, [front]) == pytest.approx(0.0)
        # and the front body is not occluded by one behind it
        assert visible_fraction(0j, 0.0, PI / 3.0, front, [body]) == pytest.approx(1.0)

    def test_half_occluded_body(self) -> None:
        """A wall to the right of the line of sight occludes the right half."""
        body, wall = (40.0, 0.0, 0.5 * PI, 4.0, 0.01), (20.0, -5.0, 0.5 * PI, 10.0, 0.01)
        assert visible_fraction(0j, 0.0, PI / 3.0, body, [wall]) == pytest.approx(0.5, abs=0.01)

    def test_field_of_view_limits_visibility(self) -> None:
        body = (0.0, 40.0, 0.0, 4.0, 0.01)  # at 90 degrees
        assert visible_fraction(0j, 0.0, PI / 3.0, body, []) == pytest.approx(0.0)
        assert visible_fraction(0j, 0.5 * PI, PI / 3.0, body, []) == pytest.approx(1.0)
        assert visible_fraction(0j, 0.0, 0.5 * PI, body, []) == pytest.approx(0.5, abs=1e-9)

    def test_body_behind_does_not_occlude(self) -> None:
        body, behind = (30.0, 0.0, 0.0, 4.5, 1.8), (-15.0, 0.0, 0.0, 4.5, 1.8)
        assert visible_fraction(0j, 0.0, PI, body, [behind]) == pytest.approx(1.0)

    def test_overlapping_occluders_count_once(self) -> None:
        body = (40.0, 0.0, 0.5 * PI, 4.0, 0.01)
        wall, nearer = (20.0, -5.0, 0.5 * PI, 10.0, 0.01), (10.0, -2.5, 0.5 * PI, 5.0, 0.01)
        assert visible_fraction(0j, 0.0, PI, body, [wall, nearer]) == pytest.approx(0.5, abs=0.01)

    @given(st.integers(0, 2**32 - 1))
    def test_visible_fraction_equals_shapely_rays(self, seed: int) -> None:
        shapely = pytest.importorskip("shapely")
        affinity = pytest.importorskip("shapely.affinity")
        rng = np.random.default_rng(seed)

        def draw() -> tuple[float, ...]:
            r, angle = rng.uniform(12.0, 60.0), rng.uniform(-PI, PI)
            return (
                r * math.cos(angle), r * math.sin(angle), rng.uniform(-PI, PI), rng.uniform(3.0, 9.0),
                rng.uniform(1.5, 2.6),
            )  # fmt: skip

        def polygon(b: tuple[float, ...]) -> Any:
            box = shapely.box(-0.5 * b[3], -0.5 * b[4], 0.5 * b[3], 0.5 * b[4])
            return affinity.translate(affinity.rotate(box, b[2], origin=(0, 0), use_radians=True), *b[:2])

        bodies = [draw() for _ in range(4)]
        shapes = [polygon(b) for b in bodies]
        if any(shapes[i].intersects(shapes[j]) for i in range(4) for j in range(i)):
            return
        psi, half = rng.uniform(-PI, PI), rng.uniform(0.5, 3.0)
        to = math.atan2(bodies[0][1], bodies[0][0])
        corners = [math.remainder(math.atan2(y, x) - to, math.tau) for x, y in shapes[0].exterior.coords]
        angles = to + np.linspace(min(corners), max(corners), 203)[1:-1]
        free = 0
        for angle in angles:
            ray = shapely.LineString([(0.0, 0.0), (100.0 * math.cos(angle), 100.0 * math.sin(angle))])
            distance = [shapely.Point(0.0, 0.0).distance(ray.intersection(s)) for s in shapes]
            hit = [math.inf if math.isnan(d) else d for d in distance]
            in_view = abs(math.remainder(angle - psi, math.tau)) <= half
            free += in_view and hit[0] <= min(hit[1:])
        assert visible_fraction(0j, psi, half, bodies[0], bodies[1:]) == pytest.approx(free / 201, abs=0.02)


class TestSensor:
    def test_range_weather_and_field_of_view(self) -> None:
        sensor = Sensor(scenario(A, B))
        assert sensor.visible(rows((99.0, 0.0), (101.0, 20.0)), EGO) == [True, False]
        assert sensor.visible(rows((-20.0, 0.0), (20.0, 50.0)), EGO) == [False, False]
        fog = Sensor(scenario(A, B, visibility=50.0))
        assert fog.visible(rows((49.0, 0.0), (51.0, 20.0)), EGO) == [True, False]

    def test_lead_vehicle_occludes_downstream_vehicle(self) -> None:
        sensor = Sensor(scenario(A, B))
        assert sensor.visible(rows((20.0, 0.0), (50.0, 0.0)), EGO) == [True, False]
        assert sensor.visible(rows((20.0, 3.0), (50.0, 0.0)), EGO) == [True, True]

    def test_building_occludes(self) -> None:
        sensor = Sensor(scenario(A, occluders=((15.0, 0.0, 0.0, 4.0, 4.0),)))
        assert sensor.visible(rows((30.0, 0.0)), EGO) == [False]
        assert sensor.visible(rows((10.0, 0.0)), EGO) == [True]

    def test_detections_are_delayed_and_dead_reckoned(self) -> None:
        sensor = Sensor(scenario(A))
        for k in range(40):
            t = 0.02 * k
            now = [(30.0 + 20.0 * t - 2.0 * t * t, 0.0, 0.0, 20.0 - 4.0 * t, -4.0, 0.0)]
            found = sensor.detections(t, now, [True])
            assert bool(found) == (t >= 0.4 - 1e-9)
            for remote in found:
                assert remote.source == "sensor"
                assert remote.age == pytest.approx(0.4)
                assert remote.x == pytest.approx(now[0][0])
                assert remote.v_x == pytest.approx(now[0][3])

    def test_change_is_detected_after_delay_and_lost_if_occluded(self) -> None:
        sensor = Sensor(scenario(A))
        known = []
        for k in range(100):
            a_x = -7.0 if k >= 50 else 0.0
            found = sensor.detections(0.02 * k, [(30.0, 0.0, 0.0, 20.0, a_x, 0.0)], [k < 80])
            known.append(found[0].a_x if found else None)
        assert known[20:70] == [0.0] * 50
        assert known[70] == -7.0
        assert known[99] == -7.0

    def test_driver_has_no_sensor_delay(self) -> None:
        sensor = Sensor(replace(scenario(A), ego_type="driver"))
        assert sensor.detections(0.0, rows((30.0, 0.0)), [True])[0].age == 0.0
