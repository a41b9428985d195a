"""Fits with chosen tolerance: noise, outliers, ordinary receivers; fits of any points are bounded."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cca_core.errors import InfeasibleError
from cca_core.path import FitReport, Path, clean_route, fit_path
from tests.support.drives import drive_at_curve_speed
from tests.support.gps_tracks import ordinary_receiver, winding


def fitted(points: np.ndarray) -> Path:
    return fit_path(clean_route(points).parts[0])


@pytest.mark.parametrize("seed", range(5))
def test_ordinary_receiver_gives_true_radius(seed: int) -> None:
    path = fitted(ordinary_receiver(seed))
    assert 0.7 * 111.0 <= path.min_radius <= 1.3 * 111.0
    run = drive_at_curve_speed(path, 20.0)
    assert run.finished
    assert run.peak <= 0.1


@pytest.mark.parametrize("noise", [0.1, 0.5, 1.0, 2.0])
def test_noise_estimate_is_near_truth(noise: float) -> None:
    xy = winding(300, 8.0, 111.0) + np.random.default_rng(3).normal(0.0, noise, (300, 2))
    xy[100] += 30.0 * noise
    report = fit_path(xy).fit_report
    assert report is not None
    assert report.noise is not None
    assert 0.7 * noise <= report.noise <= 1.2 * noise


@pytest.mark.parametrize(("n", "spacing", "noise"), [(1200, 2.0, 1.0), (1200, 2.0, 2.0), (600, 4.0, 2.0)])
def test_dense_noisy_log_gives_true_radius(n: int, spacing: float, noise: float) -> None:
    xy = winding(n, spacing, 111.0) + np.random.default_rng(0).normal(0.0, noise, (n, 2))
    assert 0.7 * 111.0 <= fitted(xy).min_radius <= 1.3 * 111.0


def test_far_corner_of_sparse_route_is_no_outlier() -> None:
    y = [0, 0, 10, 10, 200, 10, 0, 0, 10, 10, 200, 10, 0]
    path = fit_path(np.column_stack((200 * np.arange(13), y)))
    report = path.fit_report
    assert report is not None
    assert report.max_deviation <= 10.0
    assert len(report.outliers) == 0


def test_clean_waypoints_have_tolerance_of_0_3_m() -> None:
    xy = winding(100, 8.0, 111.0)
    chosen, given_tolerance = fit_path(xy), fit_path(xy, tolerance=0.3)
    assert chosen.fit_report is not None
    assert chosen.fit_report.tolerance == 0.3
    assert abs(chosen.min_radius / given_tolerance.min_radius - 1.0) < 0.02


def test_equal_waypoints_give_equal_path() -> None:
    xy = ordinary_receiver(7)
    np.testing.assert_array_equal(fitted(xy).coefficients, fitted(xy).coefficients)


@pytest.mark.parametrize("offset", [4.0, 8.0])
def test_single_outlier_is_ignored_and_named(offset: float) -> None:
    xy = winding(120, 8.0, 200.0)
    xy[60] += [0.0, offset]
    path = fit_path(xy)
    report = path.fit_report
    assert report is not None
    assert path.min_radius >= 140.0
    assert report.outliers.tolist() == [60]
    assert report.missed.tolist() == [60]
    assert 0.5 * offset <= report.max_deviation <= offset + 0.3
    assert "60 by" in repr(report)


def test_outlier_beyond_max_deviation_is_refused() -> None:
    xy = winding(120, 8.0, 200.0)
    xy[60] += [0.0, 8.0]
    with pytest.raises(InfeasibleError, match=r"row 60 by \d\.\d m") as error:
        fit_path(xy, max_deviation=3.0)
    assert isinstance(error.value.result, Path)


def test_report_shows_tolerance_and_deviation_in_the_same_digits() -> None:
    none = np.zeros(0, dtype=np.intp)
    report = FitReport(
        tolerance=4.013, noise=1.216, max_deviation=4.01, s_max_deviation=154.4, missed=none,
        missed_by=np.zeros(0), outliers=none,
    )  # fmt: skip
    assert repr(report) == "FitReport(tolerance 4.01 m; noise 1.2 m; max deviation 4.01 m at s=154.4)"
    assert "tolerance 0.015 m" in repr(replace(report, tolerance=0.015))


def test_report_and_repr_name_deviation_and_radius() -> None:
    phi = np.arange(0.0, 1.5, 0.1)
    path = fit_path(80.0 * np.column_stack((np.sin(phi), 1.0 - np.cos(phi))), tolerance=0.3)
    assert path.min_radius == pytest.approx(80.0, rel=0.05)
    assert path.fit_report is not None
    assert path.fit_report.max_deviation <= 0.3
    assert "min radius" in repr(path)
    assert "max deviation" in repr(path)
    assert Path(path.breaks, path.coefficients).fit_report is None


def zigzag(spec: tuple[int, int, float, str]) -> np.ndarray:
    """Any waypoints: scattered, wandering, or a noisy road."""
    seed, n, size, kind = spec
    rng = np.random.default_rng(seed)
    if kind == "scattered":
        return rng.uniform(-size, size, (n, 2))
    if kind == "wandering":
        return np.cumsum(rng.normal(0.0, size, (n, 2)), axis=0)
    return np.cumsum(np.array([size, 0.0]) + rng.normal(0.0, 0.4 * size, (n, 2)), axis=0)


def any_points(max_n: int) -> st.SearchStrategy[np.ndarray]:
    return st.builds(
        zigzag,
        st.tuples(
            st.integers(0, 10_000), st.integers(2, max_n), st.sampled_from([0.3, 3.0, 20.0]),
            st.sampled_from(["scattered", "wandering", "road"]),
        ),
    )  # fmt: skip


@settings(max_examples=8, deadline=None)
@given(any_points(16), st.floats(0.05, 2.0), st.floats(1.05, 8.0))
def test_larger_tolerance_is_no_worse(xy: np.ndarray, tolerance: float, factor: float) -> None:
    """It works where the smaller one does, with no sharper curve, and both keep their tolerance."""
    try:
        before = fit_path(xy, tolerance=tolerance)
    except InfeasibleError:
        return
    after = fit_path(xy, tolerance=factor * tolerance)
    for path, limit in ((before, tolerance), (after, factor * tolerance)):
        assert path.fit_report is not None
        assert path.fit_report.max_deviation <= limit + 0.011
    assert after.min_radius >= min(0.97 * before.min_radius, 195.0)


@settings(max_examples=15, deadline=None)
@given(any_points(60), st.sampled_from([None, 0.3, 2.0]), st.sampled_from([0.05, 0.15]))
def test_limit_is_kept_near_waypoints_or_refused(
    xy: np.ndarray, tolerance: float | None, limit: float
) -> None:
    try:
        path = fit_path(xy, tolerance=tolerance, curvature_limit=limit)
    except InfeasibleError:
        return
    report = path.fit_report
    assert report is not None
    bound = max(10.0, 3.0 * report.tolerance, 0.6 / limit + report.tolerance)
    on = path.sample(0.2)
    assert max(float(np.hypot(*(on - p).T).min()) for p in xy) <= bound + 0.1
    assert path.min_radius >= 0.999 / limit
    far = [row for row in range(len(xy)) if np.hypot(*(on - xy[row]).T).min() > report.tolerance + 0.15]
    assert set(far) <= set(report.missed.tolist())  # every waypoint that is missed is named


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(any_points(200), st.floats(0.05, 2.0), st.floats(1.05, 8.0))
def test_larger_tolerance_is_no_worse_for_many_points(
    xy: np.ndarray, tolerance: float, factor: float
) -> None:
    try:
        before = fit_path(xy, tolerance=tolerance)
    except InfeasibleError:
        return
    after = fit_path(xy, tolerance=factor * tolerance)
    assert after.min_radius >= min(0.97 * before.min_radius, 195.0)


@pytest.mark.parametrize("width", [3.0, 4.0, 8.0])
def test_narrow_u_turn_gets_arcs_or_is_refused(width: float) -> None:
    """Once the limit turned a road out and back into the chord from its first to its last point."""
    x = np.arange(0.0, 301.0, 10.0)
    xy = np.vstack((np.column_stack((x, 0.0 * x)), np.column_stack((x[::-1], 0.0 * x + width))))
    path = fit_path(xy, tolerance=1.0, curvature_limit=0.15)
    assert path.length >= 600.0
    assert path.min_radius >= 1.0 / 0.15
    on = path.sample(0.2)
    off = np.array([np.hypot(*(on - p).T).min() for p in xy])
    assert off.max() <= 7.0
    assert off[np.abs(xy[:, 0] - 300.0) > 60.0].max() <= 1.0  # every other position is kept
    assert path.fit_report is not None
    np.testing.assert_allclose(path.fit_report.max_deviation, off.max(), atol=0.05)


def test_unreachable_waypoints_are_named_and_refused() -> None:
    xy = np.array([[0, 0], [100, 0], [200, 0], [200, 4], [100, 4], [0, 4]], dtype=float)
    with pytest.raises(InfeasibleError, match=r"^no path with a radius .* missed are \d+: row \d") as error:
        fit_path(xy, tolerance=0.3, curvature_limit=1.0 / 60.0, max_deviation=2.0)
    assert isinstance(error.value.result, Path)
    assert error.value.result.fit_report is not None
    assert math.isfinite(error.value.result.fit_report.max_deviation)
