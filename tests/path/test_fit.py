"""Fitting: exact roads, joints, tolerance, symmetry; interpolation against SciPy."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

from cca_core.errors import InputError
from cca_core.path import fit_path, interpolate_path
from cca_core.path.path import Path
from tests.support.sweeps import sweep


def winding(n: int = 120, noise: float = 0.0, seed: int = 0) -> np.ndarray:
    """Waypoints of a winding road at uneven spacing of about 10 m."""
    rng = np.random.default_rng(seed)
    x = np.cumsum(rng.uniform(5.0, 15.0, n))
    y = 40.0 * np.sin(x / 150.0) + 15.0 * np.sin(x / 60.0)
    return np.column_stack((x, y)) + noise * rng.standard_normal((n, 2))


def circle(radius: float, n: int, sign: float = 1.0, turn: float = 2 * math.pi) -> np.ndarray:
    phi = np.linspace(0.0, turn, n, endpoint=turn < 6.0)
    return radius * np.column_stack((np.sin(phi), sign * (1.0 - np.cos(phi))))


def distance_to(path: Path, xy: np.ndarray) -> np.ndarray:
    """Distance of points to the curve by dense sampling (independent of `project`)."""
    s = np.linspace(path.start, path.end, int(path.length / 0.05) + 2)
    return cKDTree(path.position(s)).query(xy)[0]


def evaluate(path: Path, i: int, lam: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eqs (1) and (2) with derivatives by arc length, from the coefficients alone."""
    a, b, c, d = path.coefficients[i].T
    length = path.breaks[i + 1] - path.breaks[i]
    return (
        a * lam**3 + b * lam**2 + c * lam + d,
        (3 * a * lam**2 + 2 * b * lam + c) / length,
        (6 * a * lam + 2 * b) / length**2,
    )


def assert_c2(path: Path, closed: bool = False) -> None:
    n = len(path.coefficients)
    joints = [(i, i + 1) for i in range(n - 1)] + ([(n - 1, 0)] if closed else [])
    assert joints
    for before, after in joints:
        p0, t0, c0 = evaluate(path, before, 1.0)
        p1, t1, c1 = evaluate(path, after, 0.0)
        np.testing.assert_allclose(p0, p1, rtol=0.0, atol=1e-8 if closed else 1e-9)
        turn = math.atan2(t0[0] * t1[1] - t0[1] * t1[0], t0 @ t1)
        assert abs(turn) < 1e-9
        k0 = (t0[0] * c0[1] - t0[1] * c0[0]) / np.hypot(*t0) ** 3
        k1 = (t1[0] * c1[1] - t1[1] * c1[0]) / np.hypot(*t1) ** 3
        assert abs(k0 - k1) < 1e-9
        # and the motion along it: speed and second derivative, which is more than heading and curvature
        np.testing.assert_allclose(t0, t1, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(c0, c1, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("direction", [0.0, 1.0, 2.5, -2.0])
@pytest.mark.parametrize("tolerance", [0.0, 0.3])
def test_straight_road_is_exact(direction: float, tolerance: float) -> None:
    rng = np.random.default_rng(2)
    s = np.concatenate(([0.0], np.cumsum(rng.uniform(3.0, 30.0, 40))))
    unit = np.array([math.cos(direction), math.sin(direction)])
    path = fit_path([100.0, -50.0] + s[:, None] * unit, tolerance=tolerance)
    at = np.linspace(0.0, s[-1], 333)
    assert path.length == pytest.approx(s[-1], abs=1e-7)
    np.testing.assert_allclose(path.position(at), [100.0, -50.0] + at[:, None] * unit, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(path.heading(at), direction, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(path.curvature(at), 0.0, rtol=0.0, atol=1e-10)


def test_two_points_give_straight_path() -> None:
    path = fit_path([[1.0, 2.0], [4.0, 6.0]])
    assert path.length == pytest.approx(5.0, abs=1e-7)
    np.testing.assert_allclose(path.position([0.0, 2.5, 5.0]), [[1, 2], [2.5, 4], [4, 6]], atol=1e-7)
    np.testing.assert_allclose(path.curvature([0.0, 2.5, 5.0]), 0.0, atol=1e-9)


@pytest.mark.parametrize("radius", [60.0, 300.0, 1500.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_arc_has_curvature_of_its_circle(radius: float, sign: float) -> None:
    xy = circle(radius, 81, sign, turn=2.0)
    path = fit_path(xy, tolerance=0.01)
    at = np.linspace(0.05, 0.95, 200) * path.length
    np.testing.assert_allclose(path.curvature(at) * sign * radius, 1.0, rtol=0.0, atol=0.03)
    assert path.length == pytest.approx(2.0 * radius, abs=0.021)  # each end may move by the tolerance
    np.testing.assert_allclose(
        np.hypot(*(path.position(at) - [0.0, sign * radius]).T), radius, rtol=0.0, atol=0.011
    )


@pytest.mark.parametrize("noise", [0.0, 0.3])
@pytest.mark.parametrize("tolerance", [0.0, 0.1, 1.0])
def test_joints_are_c2_continuous(noise: float, tolerance: float) -> None:
    path = fit_path(winding(noise=noise), tolerance=tolerance)
    assert len(path.coefficients) > 5
    assert_c2(path)


@settings(max_examples=25)
@given(
    st.integers(0, 10_000),
    st.sampled_from([0.05, 0.3, 1.0]),
    st.sampled_from([0.0, 0.1, 0.5]),
    st.integers(1, 8),
)
def test_tolerance_is_kept(seed: int, tolerance: float, noise: float, per_segment: int) -> None:
    xy = winding(60, noise, seed)
    path = fit_path(xy, tolerance=tolerance, points_per_segment=per_segment)
    # dense sampling overestimates the distance by at most step^2 / (8 tolerance)
    assert distance_to(path, xy).max() <= tolerance + 0.05**2 / (8 * tolerance) + 1e-6
    assert_c2(path)


def test_tolerance_zero_interpolates() -> None:
    xy = winding(60, 0.2, 3)
    path = fit_path(xy, tolerance=0.0)
    _, d = path.project(xy)
    assert np.abs(d).max() < 1e-5
    assert distance_to(path, xy).max() < 0.03


def test_larger_tolerance_gives_smoother_path() -> None:
    xy = winding(100, 0.2, 4)

    def roughness(tolerance: float) -> float:
        path = fit_path(xy, tolerance=tolerance)
        kappa = path.curvature(np.linspace(20.0, path.length - 20.0, 4000))
        return float(np.abs(np.diff(kappa)).sum())

    tight, middle, loose = (roughness(tolerance) for tolerance in (0.05, 0.4, 1.0))
    assert tight > middle > loose


@pytest.mark.parametrize(("n", "per_segment"), [(81, 4), (81, 8), (82, 4), (100, 3), (10, 4), (3, 4)])
def test_segments_hold_equal_point_counts(n: int, per_segment: int) -> None:
    """Counts differ by at most one where n - 1 is no multiple (the paper's segments of equal point count)."""
    xy = np.column_stack((np.linspace(0.0, 10.0 * (n - 1), n), np.zeros(n)))
    path = fit_path(xy, points_per_segment=per_segment)
    counts = np.histogram(xy[1:, 0] - 5.0, bins=path.breaks)[0]
    assert counts.sum() == n - 1
    assert counts.max() - counts.min() <= (0 if (n - 1) % per_segment == 0 else 1)
    assert abs(counts.mean() - min(per_segment, n - 1)) < 1.0
    assert counts.mean() >= min(per_segment, n - 1)  # whole segments, none nearly empty


def test_coefficients_reproduce_position() -> None:
    path = fit_path(winding())
    rng = np.random.default_rng(0)
    for i in rng.integers(0, len(path.coefficients), 20):
        lam = float(rng.uniform())
        s = path.breaks[i] + lam * (path.breaks[i + 1] - path.breaks[i])
        position, first, second = evaluate(path, i, lam)
        np.testing.assert_allclose(path.position(s), position, rtol=0.0, atol=1e-9)
        found = path.derivatives(s)
        np.testing.assert_allclose(found[1], first, rtol=0.0, atol=1e-11)
        np.testing.assert_allclose(found[2], second, rtol=0.0, atol=1e-11)
        assert float(path.heading(s)) == pytest.approx(math.atan2(first[1], first[0]), abs=1e-12)


@pytest.mark.parametrize("noise", [0.0, 0.2])
def test_s_is_arc_length(noise: float) -> None:
    path = fit_path(winding(noise=noise), tolerance=0.5)
    at = np.linspace(0.0, path.length, 20_001)
    speed = np.hypot(*path.derivatives(at)[1].T)
    assert np.abs(speed - 1.0).max() < 0.01
    steps = np.hypot(*np.diff(path.position(at), axis=0).T)
    assert steps.sum() == pytest.approx(path.length, rel=1e-4)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("repeat_first", [False, True])
def test_closed_circle_is_periodic(sign: float, repeat_first: bool) -> None:
    radius = 100.0
    xy = circle(radius, 88, sign)
    if repeat_first:
        xy = np.vstack((xy, xy[:1]))
    path = fit_path(xy, tolerance=0.01, closed=True)
    assert path.length == pytest.approx(2 * math.pi * radius, rel=1e-4)
    at = np.linspace(0.0, path.length, 500)
    np.testing.assert_allclose(path.curvature(at) * sign * radius, 1.0, rtol=0.0, atol=0.03)
    np.testing.assert_allclose(path.position(0.0), path.position(path.length), rtol=0.0, atol=1e-6)
    assert np.cos(path.heading(0.0) - path.heading(path.length)) == pytest.approx(1.0, abs=1e-12)
    assert float(path.curvature(0.0)) == pytest.approx(float(path.curvature(path.length)), abs=1e-6)


@pytest.mark.parametrize("tolerance", sweep(0.4, 1.0))
@pytest.mark.parametrize("seed", [5, 29, 45, 47])
def test_closed_circuit_is_smooth_at_lap_end(seed: int, tolerance: float) -> None:
    """A closed road that is no circle, with noise: it 'ends where it starts, same heading and curvature'."""
    rng = np.random.default_rng(seed)
    phi = np.sort(rng.uniform(0.0, 2 * math.pi, int(rng.integers(7, 100))))
    xy = np.column_stack((150 * np.cos(phi), 80 * np.sin(phi) + 20 * np.sin(2 * phi)))
    xy += 0.2 * rng.standard_normal(xy.shape)
    path = fit_path(xy, tolerance=tolerance, closed=True)
    ends = np.array([path.start, path.end])
    p, h, k = path.position(ends), path.heading(ends), path.curvature(ends)
    assert distance_to(path, xy).max() <= tolerance + 1e-3
    assert np.hypot(*(p[1] - p[0])) < 1e-3
    assert abs(math.remainder(h[1] - h[0], 2 * math.pi)) < 1e-4
    assert abs(k[1] - k[0]) < 1e-4


@pytest.mark.parametrize("tolerance", [0.1, 0.5])
def test_fit_is_rotation_invariant(tolerance: float) -> None:
    xy, turn = winding(80, 0.1, 6), 1.234
    R = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    here, there = fit_path(xy, tolerance=tolerance), fit_path(xy @ R + [500.0, -300.0], tolerance=tolerance)
    at = np.linspace(0.0, here.length - 1e-3, 1000)
    assert there.length == pytest.approx(here.length, abs=1e-6)
    np.testing.assert_allclose(
        there.position(at), here.position(at) @ R + [500.0, -300.0], rtol=0.0, atol=1e-6
    )
    np.testing.assert_allclose(there.curvature(at), here.curvature(at), rtol=0.0, atol=1e-7)


def test_fit_is_mirror_symmetric() -> None:
    xy = winding(80, 0.1, 7)
    here, there = fit_path(xy), fit_path(xy * [1.0, -1.0])
    at = np.linspace(0.0, here.length, 1000)
    np.testing.assert_allclose(there.position(at), here.position(at) * [1.0, -1.0], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(there.curvature(at), -here.curvature(at), rtol=0.0, atol=1e-10)


def test_reversed_waypoints_give_same_road() -> None:
    xy = winding(81, 0.0)  # 80 chords: the knots fall on the same points both ways
    there, back = fit_path(xy), fit_path(xy[::-1])
    assert back.length == pytest.approx(there.length, abs=1e-4)
    at = np.linspace(0.0, there.length, 500)
    np.testing.assert_allclose(back.position(there.length - at), there.position(at), rtol=0.0, atol=1e-2)


def test_long_gap_is_bridged_straight() -> None:
    left = np.column_stack((np.arange(0.0, 101.0, 10.0), np.zeros(11)))
    right = left + np.array([600.0, 0.0])
    right[:, 1] = 0.02 * (right[:, 0] - 600.0) ** 2 / 10.0
    path = fit_path(np.vstack((left, right)), tolerance=0.3)
    _, d = path.project(np.column_stack((np.linspace(150.0, 550.0, 41), np.zeros(41))))
    assert np.abs(d).max() < 0.3


@pytest.mark.parametrize(
    ("xy", "words"),
    [
        ([], r"^xy must have shape \(n, 2\)"),
        ([[0.0, 0.0]], r"^xy must have at least 2 points, had 1"),
        ([0.0, 1.0], r"^xy must have shape"),
        ([[0.0, 1.0, 2.0], [1.0, 1.0, 2.0]], r"^xy must have shape"),
        ([[0.0, 0.0], [math.nan, 1.0]], r"^xy must be finite, was nan at \[1, 0\]"),
        ([[0.0, 0.0], [1.0, math.inf]], r"^xy must be finite"),
        ([["a", "b"], ["c", "d"]], r"^xy must be an array"),
        ([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [2.0, 0.0]], r"^xy must not repeat a point, row 1 equals"),
    ],
)
@pytest.mark.parametrize("closed", [False, True])
def test_invalid_waypoints_raise(xy: object, words: str, closed: bool) -> None:
    with pytest.raises(InputError, match=words):
        fit_path(xy, closed=closed)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "value"),
    [("tolerance", -0.1), ("tolerance", math.nan), ("tolerance", "a"), ("points_per_segment", 0),
     ("points_per_segment", -3), ("points_per_segment", math.nan), ("points_per_segment", 2.5)],
)  # fmt: skip
def test_invalid_settings_raise(name: str, value: object) -> None:
    with pytest.raises(InputError, match=rf"^{name} must be"):
        fit_path(winding(20), **{name: value})


@pytest.mark.parametrize("xy", [[[0.0, 0.0], [10.0, 0.0]], [[0.0, 0.0], [10.0, 0.0], [0.0, 0.0]]])
def test_two_points_cannot_be_closed(xy: list) -> None:
    with pytest.raises(InputError, match=r"^xy must"):
        fit_path(xy, closed=True)


def test_hairpin_of_gps_points_is_fitted() -> None:
    """Reversed neighbors occur in logs: the fit stays finite and keeps its tolerance."""
    xy = winding(60, 0.0)
    xy[[30, 31]] = xy[[31, 30]]
    path = fit_path(xy, tolerance=0.3)
    assert np.isfinite(path.coefficients).all()
    assert distance_to(path, xy).max() <= 0.3 + 2e-3


# --- interpolate_path ---------------------------------------------------------------------------------


def test_interpolation_passes_through_nodes() -> None:
    nodes = winding(50, 0.3)
    path = interpolate_path(nodes, start=1000.0)
    assert path.start == 1000.0
    assert len(path.coefficients) == 49
    np.testing.assert_allclose(path.position(path.breaks), nodes, rtol=0.0, atol=1e-9)
    chord = np.hypot(*np.diff(nodes, axis=0).T)
    np.testing.assert_allclose(np.diff(path.breaks), chord, rtol=1e-12)
    assert_c2(path)


@pytest.mark.parametrize("ends", ["natural", "clamped", "start", "end"])
def test_interpolation_equals_scipy(ends: str) -> None:
    nodes = winding(30, 0.2)
    s = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(nodes, axis=0).T))))
    first, last = np.array([1.0, 2.0]), np.array([3.0, -1.0])  # not of length 1: only their direction counts
    natural = (2, np.zeros(2))
    start = (1, first / np.hypot(*first)) if ends in ("clamped", "start") else natural
    end = (1, last / np.hypot(*last)) if ends in ("clamped", "end") else natural
    reference = CubicSpline(s, nodes, bc_type=(start, end))
    path = interpolate_path(
        nodes, start_tangent=first if start[0] == 1 else None, end_tangent=last if end[0] == 1 else None
    )
    at = np.linspace(0.0, s[-1], 700)
    for found, order in zip(path.derivatives(at), (0, 1, 2), strict=True):
        np.testing.assert_allclose(found, reference(at, order), rtol=0.0, atol=1e-9)
    if start[0] == 1:
        assert float(path.heading(0.0)) == pytest.approx(math.atan2(2.0, 1.0), abs=1e-12)
    else:
        assert abs(float(path.curvature(0.0))) < 1e-12
    if end[0] == 1:
        assert float(path.heading(path.end)) == pytest.approx(math.atan2(-1.0, 3.0), abs=1e-12)
    else:
        assert abs(float(path.curvature(path.end))) < 1e-12


def test_interpolated_two_nodes_are_line_or_cubic() -> None:
    path = interpolate_path([[0.0, 0.0], [3.0, 4.0]])
    np.testing.assert_allclose(path.position([0.0, 2.5, 5.0]), [[0, 0], [1.5, 2], [3, 4]], atol=1e-12)
    bent = interpolate_path([[0.0, 0.0], [4.0, 0.0]], start_tangent=[0.0, 1.0], end_tangent=[0.0, -1.0])
    np.testing.assert_allclose(bent.derivatives([0.0, 4.0])[1], [[0.0, 1.0], [0.0, -1.0]], atol=1e-12)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"nodes": [[0.0, 0.0]]}, r"^nodes must have at least 2"),
        ({"nodes": [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]]}, r"^nodes must not repeat a point, row 1"),
        ({"nodes": [[0.0, 0.0], [1.0, math.nan]]}, r"^nodes must be finite"),
        ({"start": math.nan}, r"^start must be"),
        ({"start": "a"}, r"^start must be"),
        ({"start_tangent": [0.0, 0.0]}, r"^start_tangent must"),
        ({"start_tangent": [1.0, 0.0, 0.0]}, r"^start_tangent must"),
        ({"end_tangent": [math.nan, 0.0]}, r"^end_tangent must"),
        ({"end_tangent": [0.0, 0.0]}, r"^end_tangent must"),
    ],
)
def test_invalid_interpolation_raises(arguments: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        interpolate_path(**{"nodes": [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], **arguments})
