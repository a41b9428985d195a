"""Speeds and safe distances in the kernel: both forms have the same bits."""

import math

import numpy as np
import pytest

from cca_core.decide import RssSettings, rss_opposite_direction
from cca_core.follow import SpeedSettings, squared_speed_limit
from cca_core.kernel import bind
from cca_core.kernel.rss import RssReaction, lateral_distances, opposite_distances, same_direction_distances
from cca_core.kernel.speed import (
    arrival_times,
    interpolated,
    profile_acceleration,
    squared_speed_limits,
)
from cca_core.path import fit_path
from tests.support import numpy_forms
from tests.support.kernel_curves import random_curve
from tests.support.kernel_forms import FULL, QUICK, Filled, check_forms, needs_c


def arrivals(random: np.random.Generator) -> tuple[object, ...]:
    n = int(random.integers(0, 9))
    v, target = random.choice([0.0, 10.0, 20.0, float(random.uniform(0.0, 40.0))], 2).tolist()
    return n, v, target, random.normal(50.0, 60.0, n), 2.0, 2.5, np.empty(n)


def profile(random: np.random.Generator) -> tuple[object, ...]:
    path, curve = random_curve(random)
    n = int(random.integers(2, 9))
    s = np.linspace(path.start, path.end, n)
    return curve, n, float(random.uniform(5.0, 30.0)), 2.0, 2.5, s, np.empty(n)


def values(random: np.random.Generator) -> tuple[int, np.ndarray, np.ndarray, float]:
    n = int(random.integers(1, 9))
    return n, np.cumsum(random.uniform(0.5, 9.0, n)), random.normal(50, 90, n), float(random.uniform(-5, 60))


def accelerating(random: np.random.Generator) -> tuple[object, ...]:
    return *values(random), float(random.uniform(-0.5, 40.0)), 2.0, 2.5, 7.0


def reaction(random: np.random.Generator) -> Filled:
    names = ("response_time", "a_max", "b_min", "b_max", "b_correct", "a_lateral", "b_lateral", "fluctuation",
             "standstill_gap", "v_max")  # fmt: skip
    numbers = dict(zip(names, random.uniform(0.1, 9.0, 10).tolist(), strict=True))
    return Filled(RssReaction, {}, {**numbers, "a_max": numbers["a_max"] * float(random.integers(2))})


def two_speeds(random: np.random.Generator) -> tuple[object, ...]:
    n = int(random.integers(0, 9))
    return n, *random.normal(5.0, 12.0, (2, n)), reaction(random), reaction(random), np.empty(n)


@needs_c
@pytest.mark.parametrize("count", [QUICK, pytest.param(FULL, marks=pytest.mark.slow)])
def test_speeds_in_c_equal_python(count: int) -> None:
    check_forms(arrival_times, arrivals, count)
    check_forms(squared_speed_limits, profile, count)
    check_forms(interpolated, values, count)
    check_forms(profile_acceleration, accelerating, count)


@needs_c
@pytest.mark.parametrize("count", [QUICK, pytest.param(FULL, marks=pytest.mark.slow)])
def test_safe_distances_in_c_equal_python(count: int) -> None:
    for kernel in (same_direction_distances, opposite_distances, lateral_distances):
        check_forms(kernel, two_speeds, count)


def test_interpolation_equals_numpy() -> None:
    at = bind(interpolated)
    for seed in range(QUICK):
        n, s, value, x = values(np.random.default_rng(seed))
        for point in (x, float(s[0]), float(s[-1])):
            assert at(n, s, value, point) == pytest.approx(np.interp(point, s, value), rel=1e-12, abs=1e-12)
        assert math.isnan(at(n, s, value, math.nan))


@pytest.mark.parametrize(("v", "target"), [(20.0, 20.0), (20.0, 8.0), (3.0, 25.0), (0.5, 0.5)])
def test_arrival_times_equal_numpy_form(v: float, target: float) -> None:
    distance, t = np.linspace(-30.0, 400.0, 87), np.empty(87)
    bind(arrival_times)(87, v, target, distance, 2.0, 2.5, t)
    expected = numpy_forms.arrival_times(v, target, distance, 2.0 if target > v else -2.5)
    np.testing.assert_allclose(t, expected, rtol=0.0, atol=1e-11)


def test_speed_profile_equals_numpy_form() -> None:
    x = np.arange(0.0, 801.0, 10.0)
    path = fit_path(np.column_stack((x, 15.0 * np.sin(x / 40.0))), tolerance=0.05)
    s, squared = squared_speed_limit(path, 25.0, 2.0, SpeedSettings())
    expected = numpy_forms.squared_speeds(s[:-1], path.curvature(s[:-1]), 25.0, 2.0, 2.0)
    np.testing.assert_allclose(squared[:-1], expected, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("a", [0.0, 3.5])
def test_stopping_distance_equals_integral(a: float) -> None:
    """Both vehicles of opposite directions stop: the distance is the sum of two integrals of speed."""
    settings = RssSettings(response_time=1.5, a_max=a, v_max=30.0)
    v = np.array([0.0, 10.0, 27.0, 29.9, 30.0, 45.0])
    expected = numpy_forms.stopping(v, 1.5, a, 3.0, 30.0) + numpy_forms.stopping(v, 1.5, a, 4.0, 30.0)
    distance = rss_opposite_direction(v, -v, correct=settings, opposite=settings)
    np.testing.assert_allclose(distance, expected, rtol=0.0, atol=1e-4)
