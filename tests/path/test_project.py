"""Projection against brute force, where the road passes near itself; cutting a path."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq

from cca_core.errors import InputError
from cca_core.path import Path, fit_path, interpolate_path
from cca_core.vehicle import RemoteVehicle


def hairpin() -> Path:
    """Two legs 16 m apart, joined by a half circle of radius 8 m."""
    phi = np.arange(-0.5 * math.pi, 0.5 * math.pi, 0.2)
    out = np.arange(0.0, 200.0, 5.0)
    curve = np.column_stack((200.0 + 8.0 * np.cos(phi), 8.0 * np.sin(phi)))
    legs = np.column_stack((out, 0.0 * out - 8.0)), np.column_stack((out[::-1], 0.0 * out + 8.0))
    return fit_path(np.vstack((legs[0], curve, legs[1])), tolerance=0.05)


def roundabout() -> Path:
    """One and three quarter turns of a slowly widening roundabout of radius 12 m."""
    phi = np.arange(0.0, 3.5 * math.pi, 0.25)
    r = 12.0 + 0.15 * phi
    return fit_path(np.column_stack((r * np.cos(phi), r * np.sin(phi))), tolerance=0.02)


def eight() -> Path:
    phi = np.linspace(0.0, 2.0 * math.pi, 129)
    return fit_path(np.column_stack((100.0 * np.sin(phi), 50.0 * np.sin(2.0 * phi))), tolerance=0.05)


ROADS = pytest.mark.parametrize("make", [hairpin, roundabout, eight])


def brute(path: Path, xy: np.ndarray, low: float, high: float) -> tuple[float, float]:
    """Arc length and distance of the nearest point in [low, high], by dense search and bisection."""
    s = np.arange(low, high + 0.05, 0.05)
    i = int(np.argmin(np.hypot(*(path.position(s) - xy).T)))

    def slope(u: float) -> float:
        position, first, _ = path.derivatives(u)
        return float((position - xy) @ first)

    if slope(s[i] - 0.06) < 0.0 < slope(s[i] + 0.06):
        u = float(brentq(slope, s[i] - 0.06, s[i] + 0.06, xtol=1e-12))
    else:
        u = float(s[i])  # an end
    return u, float(np.hypot(*(path.position(u) - xy)))


@ROADS
def test_guess_preserves_branch(make: Callable[[], Path]) -> None:
    path = make()
    rng = np.random.default_rng(0)
    s = rng.uniform(path.start + 5.0, path.end - 5.0, 150)
    xy = path.to_cartesian(s, rng.uniform(-3.0, 3.0, 150))
    near = s + rng.uniform(-2.0, 2.0, 150)
    found, d = path.project(xy, s_guess=near)
    for i in range(150):
        at, distance = brute(path, xy[i], s[i] - 4.0, s[i] + 4.0)
        assert abs(abs(d[i]) - distance) <= 1e-6
        assert np.hypot(*(path.position(found[i]) - path.position(at))) <= 1e-6
        one = path.foot_point(*xy[i].tolist(), float(near[i]))
        assert one[:2] == pytest.approx((found[i], d[i]), abs=1e-8)


@ROADS
def test_search_finds_nearest_of_all_branches(make: Callable[[], Path]) -> None:
    path = make()
    rng = np.random.default_rng(1)
    low, high = path.sample(1.0).min(axis=0) - 30.0, path.sample(1.0).max(axis=0) + 30.0
    xy = np.vstack(
        (rng.uniform(low, high, (150, 2)), np.column_stack((np.linspace(5, 195, 50), np.zeros(50))))
    )
    _, d = path.project(xy)
    for i in range(len(xy)):
        _, distance = brute(path, xy[i], path.start, path.end)
        assert abs(d[i]) <= distance + 1e-6


@ROADS
def test_search_finds_nearest_point_far_away(make: Callable[[], Path]) -> None:
    path = make()
    rng = np.random.default_rng(2)
    xy = rng.uniform(-3e3, 3e3, (100, 2))
    on = path.position(np.linspace(path.start, path.end, 20_001))
    _, d = path.project(xy)
    for point, found in zip(xy, d, strict=True):
        assert abs(found) <= np.hypot(*(on - point).T).min() + 1e-6


def test_batch_equals_scalar() -> None:
    path = hairpin()
    s = np.random.default_rng(3).uniform(path.start, path.end, 20_000)
    found, d = path.project(path.to_cartesian(s, 2.0), s_guess=s + 0.3)
    np.testing.assert_allclose(found, s, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(d, 2.0, rtol=0.0, atol=1e-7)


# --- cut ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("start", "end"), [(10.3, 97.1), (0.0, 50.0), (31.0, 31.2), (3.0, 3.0 + 1e-6)])
def test_cut_is_same_curve(start: float, end: float) -> None:
    path = eight()
    part = path.cut(start, end)
    assert (part.start, part.end) == (start, end)
    s = np.linspace(start, end, 200)
    for mine, whole in zip(part.derivatives(s), path.derivatives(s), strict=True):
        np.testing.assert_allclose(mine, whole, rtol=0.0, atol=1e-7)


def test_cut_at_breaks_divides_no_segment() -> None:
    path = hairpin()
    np.testing.assert_array_equal(path.cut(path.start, path.end).coefficients, path.coefficients)
    inner = path.cut(path.breaks[3], path.breaks[9])
    np.testing.assert_array_equal(inner.breaks, path.breaks[3:10])


@pytest.mark.parametrize(("start", "end"), [(-1.0, 5.0), (5.0, 5.0), (6.0, 5.0), (5.0, 1e6), (math.nan, 5.0)])
def test_invalid_cut_raises(start: float, end: float) -> None:
    with pytest.raises(InputError, match=r"^(start|end) must"):
        hairpin().cut(start, end)


def test_one_position_gives_scalars() -> None:
    """Records reject arrays without axes."""
    path = interpolate_path([[0.0, 0.0], [10.0, 0.0], [20.0, 1.0]])
    s, d = path.project((5.0, 1.0))
    assert (isinstance(s, float), isinstance(d, float)) == (True, True)
    assert RemoteVehicle(id="A", x=s, y=d, psi=0.0, v_x=1.0).invalid_reason is None


@pytest.mark.parametrize("seed", range(12))
def test_nearest_point_of_tight_path_is_exact(seed: int) -> None:
    """Paths with radii of centimeters that pass themselves, against dense samples."""
    rng = np.random.default_rng(seed)
    nodes = rng.uniform(-6.0, 6.0, (int(rng.integers(4, 25)), 2))
    path = interpolate_path(nodes)
    xy = np.vstack((nodes, rng.uniform(-12.0, 12.0, (60, 2))))
    s, d = path.project(xy)
    on = path.position(np.linspace(path.start, path.end, 60_001))
    nearest = np.array([np.hypot(*(on - point).T).min() for point in xy])
    assert (np.abs(d) <= nearest + 1e-6).all()
    np.testing.assert_allclose(np.hypot(*(path.position(s) - xy).T), np.abs(d), rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("length", [1e6, 3e7])
def test_project_on_a_very_long_path_is_exact(length: float) -> None:
    x = np.linspace(0.0, length, 400)
    path = interpolate_path(np.column_stack((x, 5.0 * length / 400.0 * np.sin(x / (length / 60.0)))))
    s = np.random.default_rng(0).uniform(path.start, path.end, 20)
    found, d = path.project(path.to_cartesian(s, 30.0))
    np.testing.assert_allclose(found, s, rtol=0.0, atol=1e-3)
    np.testing.assert_allclose(d, 30.0, rtol=0.0, atol=1e-3)
