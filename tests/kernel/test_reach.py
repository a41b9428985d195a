"""Prediction in the kernel: both forms have the same bits; what is not a number never passes."""

import math

import numpy as np
import pytest

from cca_core.kernel import bind
from cca_core.kernel.reach import (
    danger_zones,
    distances_driven,
    occupancy_boxes,
    occupied_intervals,
    reachable_intervals,
    vehicle_boxes,
)
from cca_core.path import interpolate_path
from cca_core.predict import occupancy_boxes as occupancy_of
from tests.support import numpy_forms
from tests.support.kernel_curves import random_curve
from tests.support.kernel_forms import FULL, QUICK, check_forms, needs_c


def motions(random: np.random.Generator, vehicles: int) -> np.ndarray:
    """Rear, front, speed, age, rate, assumed braking and acceleration, reported acceleration."""
    given = random.normal(0.0, 20.0, (vehicles, 8))
    given[:, 1] = given[:, 0] + 5.0
    given[:, 3] = np.abs(given[:, 3]) * 0.05 * random.integers(0, 2, vehicles)
    given[:, 4] *= 0.2
    given[:, 5:7] = np.abs(given[:, 5:7]) * random.integers(0, 2, (vehicles, 2))
    given[:, 7] *= 0.2
    return given


def distances(random: np.random.Generator) -> tuple[object, ...]:
    n = int(random.integers(0, 9))
    return n, random.normal(2.0, 3.0, n), float(random.normal(8, 12)), float(random.normal(0, 4)), np.empty(n)


def reached(random: np.random.Generator) -> tuple[object, ...]:
    n = int(random.integers(0, 9))
    v, t, age, rate = random.normal(0.0, 3.0, (4, n))
    braking, acceleration = np.abs(random.normal(0.0, 4.0, 2)) * random.integers(0, 2, 2)
    return n, v, t, np.abs(age), rate, float(braking), float(acceleration), np.empty(n), np.empty(n)


def occupied(random: np.random.Generator) -> tuple[object, ...]:
    k, n = random.integers(0, 5, 2).tolist()
    return k, n, motions(random, k), random.normal(3.0, 4.0, n), np.empty((k, n)), np.empty((k, n))


def zones(random: np.random.Generator) -> tuple[object, ...]:
    k, n = random.integers(0, 5, 2).tolist()
    return k, n, motions(random, k), random.uniform(0.0, 9.0, n), random.uniform(0, 200, n), np.empty((k, 2))


def covered(random: np.random.Generator) -> tuple[object, ...]:
    path, curve = random_curve(random)
    n = int(random.integers(0, 9))
    s = random.uniform(path.start - 20.0, path.end + 20.0, n)
    rear = s + random.normal(0.0, 20.0, n)
    front = rear + random.normal(8.0, 10.0, n)
    return curve, n, s, rear, front, random.normal(0, 4, n), random.uniform(0.5, 3, n), np.empty((n, 5))


def covered_together(random: np.random.Generator) -> tuple[object, ...]:
    path, curve = random_curve(random)
    k, n = random.integers(0, 4, 2).tolist()
    s = random.uniform(path.start - 20.0, path.end + 20.0, n)
    rear = s + random.normal(0.0, 20.0, (k, n))
    front = rear + random.normal(8.0, 10.0, (k, n))
    return (
        curve,
        k,
        n,
        s,
        rear,
        front,
        random.normal(0, 4, k),
        random.uniform(0.5, 3, k),
        np.empty((k * n, 5)),
    )


@needs_c
@pytest.mark.parametrize("count", [QUICK, pytest.param(FULL, marks=pytest.mark.slow)])
def test_prediction_in_c_equals_python(count: int) -> None:
    check_forms(distances_driven, distances, count)
    check_forms(reachable_intervals, reached, count)
    check_forms(occupied_intervals, occupied, count)
    check_forms(danger_zones, zones, count)
    check_forms(occupancy_boxes, covered, count)
    check_forms(vehicle_boxes, covered_together, count)


@pytest.mark.parametrize("column", range(7))
def test_zone_of_what_is_no_number_blocks_the_road(column: int) -> None:
    """A lane is free only where it is known to be free."""
    motion = np.array([[50.0, 55.0, 10.0, 0.2, -1.0, 8.0, 3.0, 0.0]])
    motion[0, column] = math.nan
    zone = np.empty((1, 2))
    bind(danger_zones)(1, 2, motion, np.array([0.0, 4.0]), np.array([0.0, 80.0]), zone)
    assert not (zone[0, 0] > -1e9 and zone[0, 1] < 1e9)
    assert not zone[0, 0] > -1e9 or column == 1
    assert not zone[0, 1] < 1e9 or column == 0


def test_zone_without_known_travel_blocks_the_road() -> None:
    motion = np.array([[50.0, 55.0, 10.0, 0.2, -1.0, 8.0, 3.0, 0.0]])
    zone = np.empty((1, 2))
    bind(danger_zones)(1, 2, motion, np.array([0.0, 4.0]), np.array([0.0, math.nan]), zone)
    assert zone.tolist() == [[-math.inf, math.inf]]


@pytest.mark.parametrize(("b", "a"), [(0.0, 0.0), (8.0, 3.0), (0.0, 2.0), (5.0, 0.0)])
def test_intervals_equal_numpy_form(b: float, a: float) -> None:
    random = np.random.default_rng(1)
    v, t, age, rate = random.normal(0.0, 5.0, (4, 500))
    age, (low, high) = np.abs(age), np.empty((2, 500))
    bind(reachable_intervals)(500, v, t, age, rate, b, a, low, high)
    expected = numpy_forms.reachable(v, t, age, rate, b, a)
    np.testing.assert_allclose((low, high), expected, rtol=0.0, atol=1e-11)


def test_occupied_and_blocked_intervals_equal_reachable_ones() -> None:
    random = np.random.default_rng(2)
    motion, t, travel = motions(random, 30), np.linspace(0.0, 8.0, 9), np.linspace(0.0, 160.0, 9)
    motion[:, 5:7] = 8.0, 3.0
    rear, front, zone = np.empty((30, 9)), np.empty((30, 9)), np.empty((30, 2))
    bind(occupied_intervals)(30, 9, motion, t, rear, front)
    bind(danger_zones)(30, 9, motion, t, travel, zone)
    low, high = numpy_forms.reachable(motion[:, 2:3], t, motion[:, 3:4], motion[:, 4:5], 8.0, 3.0)
    np.testing.assert_allclose(rear, motion[:, :1] + low, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(front, motion[:, 1:2] + high, rtol=0.0, atol=1e-11)
    expected = np.stack(((rear - travel).min(axis=1), (front - travel).max(axis=1)), axis=-1)
    np.testing.assert_allclose(zone, expected, rtol=0.0, atol=1e-11)


def test_boxes_cover_interval_of_curved_road() -> None:
    """Points of the interval at both offsets lie inside its box."""
    s = np.arange(0.0, 301.0, 5.0)
    road = interpolate_path(80.0 * np.column_stack((np.sin(s / 80.0), 1.0 - np.cos(s / 80.0))))
    boxes = occupancy_of(road, 100.0, 95.0, 112.0, 1.5, 0.9)
    edge = road.to_cartesian(np.repeat(np.linspace(95.0, 112.0, 50), 2), np.tile([0.6, 2.4], 50))
    turned = (edge - (float(boxes.x), float(boxes.y))) @ np.array([[1.0], [1j]]) * np.exp(-1j * boxes.psi)
    along, across = turned.real, turned.imag
    assert np.abs(along).max() <= 0.5 * boxes.length + 0.2
    assert np.abs(across).max() <= 0.5 * boxes.width + 1e-6


def test_boxes_of_vehicles_equal_single_ones() -> None:
    """Two vehicles at three times."""
    s = np.arange(0.0, 301.0, 5.0)
    road = interpolate_path(80.0 * np.column_stack((np.sin(s / 80.0), 1.0 - np.cos(s / 80.0))))
    random = np.random.default_rng(3)
    at, rear = np.array([90.0, 100.0, 110.0]), random.uniform(60.0, 140.0, (2, 3))
    front, d, half_width = (
        rear + random.uniform(4.0, 40.0, (2, 3)),
        np.array([0.0, 3.5]),
        np.array([0.9, 1.2]),
    )
    boxes = np.empty((6, 5))
    bind(vehicle_boxes)(road.curve, 2, 3, at, rear, front, d, half_width, boxes)
    single = occupancy_of(road, at, rear, front, d[:, None], half_width[:, None])
    expected = np.stack((single.x, single.y, single.psi, single.length, single.width), axis=-1)
    np.testing.assert_array_equal(boxes, expected.reshape(6, 5))
