"""Curves in the kernel: both forms have the same bits; foot points against dense samples."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PPoly

from cca_core.kernel.curve import (
    curvature_at,
    curve_point,
    curve_points,
    foot_point,
    foot_points,
    nearest_point,
    nearest_points,
)
from cca_core.path import Path, fit_path, interpolate_path
from tests.support.kernel_curves import random_curve, random_path, random_samples
from tests.support.kernel_forms import FULL, QUICK, check_forms, needs_c

COUNTS = pytest.mark.parametrize("count", [QUICK, pytest.param(FULL, marks=pytest.mark.slow)])


def on_curve(random: np.random.Generator) -> tuple[object, ...]:
    path, curve = random_curve(random)
    return curve, float(random.uniform(path.start - 10.0, path.end + 10.0))


def near_curve(random: np.random.Generator) -> tuple[object, ...]:
    path, curve = random_curve(random)
    return curve, *random.uniform(-50.0, 300.0, 2), float(random.uniform(path.start, path.end))


def searched(random: np.random.Generator) -> tuple[object, ...]:
    path, curve = random_curve(random)
    return curve, random_samples(random, path), *random.uniform(-50.0, 300.0, 2)


def many_on_curve(random: np.random.Generator) -> tuple[object, ...]:
    path, curve = random_curve(random)
    n = int(random.integers(0, 6))
    s = random.uniform(path.start - 10.0, path.end + 10.0, n)
    return curve, n, s, *(np.empty((n, 2)) for _ in range(3))


def many_near_curve(random: np.random.Generator) -> tuple[object, ...]:
    path, curve = random_curve(random)
    n = int(random.integers(0, 6))
    x, y = random.uniform(-50.0, 300.0, (2, n))
    return curve, n, x, y, random.uniform(path.start, path.end, n), *(np.empty(n) for _ in range(4))


def many_searched(random: np.random.Generator) -> tuple[object, ...]:
    path, curve = random_curve(random)
    n = int(random.integers(0, 6))
    x, y = random.uniform(-50.0, 300.0, (2, n))
    return curve, random_samples(random, path), n, x, y, np.empty(n), np.empty(n)


@needs_c
@COUNTS
def test_curve_in_c_equals_python(count: int) -> None:
    check_forms(curve_point, on_curve, count)
    check_forms(curvature_at, on_curve, count)
    check_forms(curve_points, many_on_curve, count)
    check_forms(foot_point, near_curve, count)
    check_forms(foot_points, many_near_curve, count)


@needs_c
@COUNTS
def test_search_in_c_equals_python(count: int) -> None:
    check_forms(nearest_point, searched, count)
    check_forms(nearest_points, many_searched, count)


@pytest.mark.parametrize("seed", range(20))
def test_points_equal_piecewise_polynomials(seed: int) -> None:
    """On the path those of SciPy; beyond its ends straight lines."""
    random = np.random.default_rng(seed)
    path = random_path(random)
    s = random.uniform(path.start - 20.0, path.end + 20.0, 50)
    powers = path.coefficients / np.diff(path.breaks)[:, None, None] ** np.array([3.0, 2.0, 1.0, 0.0])
    curve = PPoly(powers.transpose(2, 0, 1), path.breaks)
    on = s.clip(path.start, path.end)
    expected = curve(on) + (s - on)[:, None] * curve(on, 1), curve(on, 1), curve(on, 2) * (s == on)[:, None]
    for part, reference in zip(path.derivatives(s), expected, strict=True):
        np.testing.assert_allclose(part, reference, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("seed", range(20))
def test_points_have_same_bits_alone_and_together(seed: int) -> None:
    """Whether the kernel is C or not: without C, NumPy computes them together."""
    random = np.random.default_rng(seed)
    path = random_path(random)
    s = np.append(random.uniform(path.start - 20.0, path.end + 20.0, 50), path.breaks)
    together = np.hstack(path.derivatives(s))
    alone = [path._cubics.at(u) for u in s.tolist()]
    np.testing.assert_array_equal(together, alone)
    assert path.curvature(s).tolist() == pytest.approx([path.curvature_at(u) for u in s.tolist()], abs=1e-11)


def test_foot_points_equal_single_ones() -> None:
    path = fit_path(np.column_stack((np.arange(0.0, 400.0, 10.0), 20.0 * np.sin(np.arange(0.0, 4.0, 0.1)))))
    random = np.random.default_rng(0)
    s = random.uniform(path.start, path.end, 60)
    xy = path.to_cartesian(s, random.uniform(-4.0, 4.0, 60))
    for found, single in zip(zip(*path.project(xy, s_guess=s + 0.5), strict=True), xy, strict=True):
        assert path.foot_point(*single.tolist(), float(found[0]))[:2] == pytest.approx(found, abs=1e-9)


@given(st.integers(0, 10_000), st.floats(-40.0, 40.0), st.floats(-40.0, 40.0))
def test_nearest_point_is_nearest(seed: int, x: float, y: float) -> None:
    """Of the path itself; beyond an end only where that end is the nearest point."""
    nodes = np.random.default_rng(seed).uniform(-15.0, 15.0, (6, 2))
    path = interpolate_path(nodes)
    s, d = path.project((x, y))
    on = path.position(np.linspace(path.start, path.end, 4001))
    nearest = float(np.hypot(*(on - (x, y)).T).min())
    end = path.position(min(max(float(s), path.start), path.end))
    assert math.dist(end, (x, y)) <= nearest + 1e-6
    assert abs(d) <= nearest + 1e-6


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_position_that_is_none_has_no_finite_offset(bad: float) -> None:
    path = Path([0.0, 10.0, 30.0], [[[0, 0, 10, 0], [0, 0, 0, 0]], [[0, 0, 20, 10], [0, 0, 0, 0]]])
    for offset in (path.foot_point(bad, 0.0, 5.0)[1], path.foot_point(3.0, bad, 5.0)[1]):
        assert not abs(offset) < math.inf


def test_segment_without_direction_gives_numbers() -> None:
    """Where the derivative is zero there is no foot point, and nothing is divided by zero."""
    path = Path([0.0, 10.0], [[[0, 0, 0, 3.0], [0, 0, 0, 4.0]]])
    s, d, heading, kappa = path.foot_point(0.0, 0.0, 5.0)
    assert (s, heading, kappa) == (5.0, 0.0, 0.0)
    assert abs(d) == 0.0
    assert math.isfinite(float(path.project((0.0, 0.0))[0]))


def test_nearest_points_do_not_depend_on_their_order() -> None:
    """A position is found from the last one, or anew; the result is that of a single search."""
    phi = np.arange(0.0, 3.5 * math.pi, 0.25)
    path = fit_path(np.column_stack(((12.0 + phi) * np.cos(phi), (12.0 + phi) * np.sin(phi))), tolerance=0.02)
    xy = np.random.default_rng(4).uniform(-90.0, 90.0, (200, 2))
    s, d = path.project(xy)
    assert [path.project(point) for point in xy] == list(zip(s, d, strict=True))
