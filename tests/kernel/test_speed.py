"""Speeds and safe distances in the kernel: both forms have the same bits."""

import numpy as np
import pytest

from cca_core.kernel import bind
from cca_core.kernel.rss import RssReaction, lateral_distances, opposite_distances, same_direction_distances
from cca_core.kernel.speed import (
    SpeedLimits,
    arrival_times,
    interpolated,
    profile_acceleration,
    squared_speed_limits,
)
from tests.support.kernel_curves import random_curve
from tests.support.kernel_forms import FULL, QUICK, Filled, check_forms, needs_c


def limits(random: np.random.Generator) -> Filled:
    numbers = zip(("a_max", "b_comfort", "b_max"), random.uniform(0.5, 8.0, 3).tolist(), strict=True)
    return Filled(SpeedLimits, {}, dict(numbers))


def arrivals(random: np.random.Generator) -> tuple[object, ...]:
    n = int(random.integers(0, 9))
    v, target = random.choice([0.0, 10.0, 20.0, float(random.uniform(0.0, 40.0))], 2).tolist()
    return n, v, target, random.normal(50.0, 60.0, n), limits(random), np.empty(n)


def profile(random: np.random.Generator) -> tuple[object, ...]:
    path, curve = random_curve(random)
    n = int(random.integers(2, 9))
    s = np.linspace(path.start, path.end, n)
    return curve, n, float(random.uniform(5.0, 30.0)), 2.0, limits(random), s, np.empty(n)


def values(random: np.random.Generator) -> tuple[int, np.ndarray, np.ndarray, float]:
    n = int(random.integers(1, 9))
    return n, np.cumsum(random.uniform(0.5, 9.0, n)), random.normal(50, 90, n), float(random.uniform(-5, 60))


def accelerating(random: np.random.Generator) -> tuple[object, ...]:
    return *values(random), float(random.uniform(-0.5, 40.0)), limits(random)


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
