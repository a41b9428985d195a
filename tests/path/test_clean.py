"""Cleaning recorded routes: what is changed is reported, what is a road is left alone."""

import math
from pathlib import Path as FilePath

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core.errors import InputError
from cca_core.path import LocalFrame, clean_route, fit_path, read_waypoints

STRAIGHT = np.column_stack((np.arange(0.0, 200.0, 10.0), np.zeros(20)))


def recorded(data_dir: FilePath, name: str) -> np.ndarray:
    found = read_waypoints(data_dir / "gps" / name)
    middle = len(found.lat) // 2
    return LocalFrame(found.lat[middle], found.lon[middle]).to_local(found.lat, found.lon)


def roundabout() -> np.ndarray:
    """Into a roundabout of radius 12 m, once and a half around, and out; a point each 5 m."""
    phi = np.arange(-0.5 * math.pi, 2.5 * math.pi, 5.0 / 12.0)
    return np.vstack(
        (
            np.column_stack((np.arange(-60.0, -2.0, 5.0), np.full(12, -12.0))),
            12.0 * np.column_stack((np.cos(phi), np.sin(phi))),
            np.column_stack((np.arange(-8.0, -60.0, -5.0), np.full(11, 12.0))),
        )
    )


def hairpin() -> np.ndarray:
    phi = np.arange(-0.5 * math.pi, 0.5 * math.pi, 5.0 / 8.0)
    out = np.arange(0.0, 100.0, 5.0)
    curve = np.column_stack((100.0 + 8.0 * np.cos(phi), 8.0 * np.sin(phi)))
    return np.vstack(
        (np.column_stack((out, np.full(20, -8.0))), curve, np.column_stack((out[::-1], np.full(20, 8.0))))
    )


def eight() -> np.ndarray:
    phi = np.linspace(0.0, 2.0 * math.pi, 90)
    return np.column_stack((100.0 * np.sin(phi), 50.0 * np.sin(2.0 * phi)))


@pytest.mark.parametrize("road", [roundabout, hairpin, eight])
@pytest.mark.parametrize("seed", range(20))
def test_road_with_gps_noise_is_unchanged(road: object, seed: int) -> None:
    xy = road()  # type: ignore[operator]
    xy = xy + 0.3 * np.random.default_rng(seed).standard_normal(xy.shape)
    route = clean_route(xy)
    assert len(route.parts) == 1
    np.testing.assert_array_equal(route.parts[0], xy)
    assert route.report.closed == (road is eight)


def test_duplicates_are_merged() -> None:
    route = clean_route(np.repeat(STRAIGHT, 3, axis=0))
    np.testing.assert_array_equal(route.parts[0], STRAIGHT)
    np.testing.assert_array_equal(route.report.duplicates, [i for i in range(60) if i % 3])


def test_spike_is_dropped() -> None:
    xy = STRAIGHT.copy()
    xy[7] += (3.0, 80.0)
    route = clean_route(xy)
    np.testing.assert_array_equal(route.report.dropped, [7])
    np.testing.assert_array_equal(route.parts[0], np.delete(xy, 7, axis=0))
    np.testing.assert_array_equal(route.rows[0], np.delete(np.arange(20), 7))


def test_spike_beyond_max_gap_is_dropped_without_split() -> None:
    xy = STRAIGHT.copy()
    xy[7] += (0.0, 4000.0)
    route = clean_route(xy)
    assert len(route.parts) == 1
    np.testing.assert_array_equal(route.report.dropped, [7])


@pytest.mark.parametrize("i", [0, 1, 5, 17, 18])
def test_swapped_neighbors_are_reordered(i: int) -> None:
    xy = STRAIGHT.copy()
    xy[[i, i + 1]] = xy[[i + 1, i]]
    route = clean_route(xy)
    steps = np.diff(route.parts[0][:, 0])
    assert (steps > 0.0).all()
    assert len(route.report.reordered) + len(route.report.dropped) == 1
    if 0 < i < 18:
        np.testing.assert_array_equal(route.parts[0], STRAIGHT)


def test_zig_zag_of_stationary_car_is_thinned() -> None:
    jitter = np.array([[100.3, 0.4], [99.6, -0.3], [100.1, 0.6], [99.8, 0.1]])
    route = clean_route(np.vstack((STRAIGHT[:11], jitter, STRAIGHT[11:])))
    assert len(route.parts) == 1
    assert len(route.report.reversals) == 0
    assert set(route.report.dropped.tolist()) <= set(range(9, 16))
    for row in STRAIGHT[[0, 5, 12, 19]]:
        assert (route.parts[0] == row).all(axis=1).any()


def test_gaps_split_and_isolated_points_are_reported() -> None:
    far = np.array([[1000.0, 0.0]])
    xy = np.vstack((STRAIGHT, far, STRAIGHT + 2.0 * far))
    route = clean_route(xy, max_gap=300.0)
    assert [len(part) for part in route.parts] == [20, 20]
    np.testing.assert_array_equal(route.report.gaps, [19, 20])
    np.testing.assert_array_equal(route.report.isolated, [20])
    np.testing.assert_array_equal(route.rows[1], np.arange(21, 41))
    assert len(clean_route(xy, max_gap=2000.0).parts) == 1


def test_reversing_car_is_preserved_and_reported() -> None:
    back = np.column_stack((np.arange(0.0, -60.0, -10.0), np.zeros(6)))
    ahead = np.column_stack((np.arange(-45.0, 200.0, 10.0), np.arange(25) * 1.0 + 4.0))
    route = clean_route(np.vstack((back, ahead)))
    assert len(route.report.reversals) == 1
    assert abs(int(route.report.reversals[0]) - 5) <= 1


@given(
    st.lists(st.tuples(st.floats(-60.0, 60.0), st.floats(-60.0, 60.0)), min_size=2, max_size=40),
    st.sampled_from([0.0, 0.05, 5.0]),
    st.sampled_from([30.0, 80.0, 500.0]),
)
def test_second_cleaning_changes_nothing(
    points: list[tuple[float, float]], min_spacing: float, max_gap: float
) -> None:
    try:
        route = clean_route(points, min_spacing=min_spacing, max_gap=max_gap)
    except InputError:
        return  # nothing was left
    every = [row for part in route.rows for row in part.tolist()]
    report = route.report
    lost = np.concatenate((report.duplicates, report.dropped, report.isolated, report.stationary)).tolist()
    assert sorted(every + lost) == list(range(len(points)))  # each row is in a part or in the report, once
    for part in route.parts:
        again = clean_route(part, min_spacing=min_spacing, max_gap=max_gap)
        assert len(again.parts) == 1
        np.testing.assert_array_equal(again.parts[0], part)


def test_recorded_drive_is_one_part(data_dir: FilePath) -> None:
    route = clean_route(recorded(data_dir, "around-visnjan-with-car.gpx"))
    assert len(route.parts) == 1
    np.testing.assert_array_equal(route.report.dropped, [2, 3, 70, 71])
    np.testing.assert_array_equal(route.report.reversals, [98])


def test_recorded_drive_is_drivable(data_dir: FilePath) -> None:
    """Least radius 5.5 m; within 1.5 m of the points of the road, and 7 m where the car was parked."""
    xy = clean_route(recorded(data_dir, "around-visnjan-with-car.gpx")).parts[0]
    path = fit_path(xy, tolerance=0.3, curvature_limit=1.0 / 5.5)
    s = np.linspace(path.start, path.end, 20_001)
    assert np.abs(path.curvature(s)).max() <= 1.0 / 5.5
    assert np.abs(np.hypot(*path.derivatives(s)[1].T) - 1.0).max() <= 1e-3
    nodes = path.position(s)
    off = np.array([np.hypot(*(nodes - point).T).min() for point in xy])
    assert off[4:-8].max() <= 1.5
    assert off.max() <= 7.5
    assert path.length <= 1.01 * np.hypot(*np.diff(xy, axis=0).T).sum()  # no loops


def test_recorded_motorway_has_small_curvature(data_dir: FilePath) -> None:
    route = clean_route(recorded(data_dir, "I_80_Eastbound_Vertices.csv"))
    assert len(route.report.gaps) == 34
    off = []
    for part in route.parts:
        path = fit_path(part, tolerance=0.5, curvature_limit=1.0 / 300.0)
        s = np.linspace(path.start, path.end, max(10, int(path.length)))
        assert np.abs(path.curvature(s)).max() <= 1.0 / 300.0
        assert np.abs(np.hypot(*path.derivatives(s)[1].T) - 1.0).max() <= 1e-3
        off.append(np.abs(path.project(part)[1]))
    every = np.concatenate(off)
    assert np.percentile(every, 99) <= 0.5
    assert every.max() <= 4.0
    assert (every > 0.5 + 1e-3).sum() <= 20  # where the curvature limit wins: one shift of the lane


def test_results_are_read_only_and_readable() -> None:
    route = clean_route(np.vstack((STRAIGHT[:3], STRAIGHT[2:])))
    assert repr(route) == "CleanedRoute(1 parts of 20 points, CleaningReport(duplicates 1 [3]))"
    assert repr(clean_route(STRAIGHT).report) == "CleaningReport(nothing changed)"
    with pytest.raises(ValueError, match="read-only"):
        route.parts[0][0, 0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        route.report.duplicates[0] = 1


@pytest.mark.parametrize(
    ("xy", "options", "words"),
    [
        ([[0.0, 0.0]], {}, "^xy must have at least 2"),
        ([[0.0, 0.0], [0.0, 0.0]], {}, "^xy must have two different points"),
        ([[0.0, 0.0], [1000.0, 0.0]], {}, "^xy must have two different points"),
        ([[0.0, 0.0], [math.nan, 0.0]], {}, "^xy must be finite"),
        (STRAIGHT, {"max_gap": 0.0}, "^max_gap must"),
        (STRAIGHT, {"min_spacing": -1.0}, "^min_spacing must"),
        (STRAIGHT, {"min_spacing": 600.0}, "^min_spacing must"),
        (STRAIGHT, {"max_turn": 1.0}, "^max_turn must"),
        (STRAIGHT, {"max_turn": 4.0}, "^max_turn must"),
    ],
)
def test_invalid_route_raises(xy: object, options: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        clean_route(xy, **options)  # type: ignore[arg-type]


def stop_of_receiver(noise: float, n: int, seed: int = 0) -> np.ndarray:
    """A street with a stop at its 10th point."""
    jitter = np.random.default_rng(seed).normal(0.0, noise, (n, 2))
    return np.vstack((STRAIGHT[:10], STRAIGHT[10] + jitter, STRAIGHT[11:]))


@pytest.mark.parametrize("noise", [0.5, 2.0, 4.0])
def test_jitter_of_stop_is_thinned_and_reported(noise: float) -> None:
    route = clean_route(stop_of_receiver(noise, 40))
    report = route.report
    assert len(report.stationary) >= 25
    assert set(report.stationary.tolist()) <= set(range(9, 52))
    assert len(route.parts[0]) <= 30
    assert "stationary" in repr(report)
    assert fit_path(route.parts[0]).min_radius >= 6.0


def test_stop_is_recognized_by_speed() -> None:
    """A receiver that drifts by 0.2 m/s without jitter."""
    drift = STRAIGHT[10] + np.column_stack((np.zeros(60), 0.2 * np.arange(60)))
    xy = np.vstack((STRAIGHT[:10], drift, STRAIGHT[11:]))
    t = np.arange(len(xy)) * 1.0
    assert len(clean_route(xy).report.stationary) == 0
    report = clean_route(xy, t=t).report
    assert len(report.stationary) >= 30
    assert set(report.stationary.tolist()) <= set(range(8, 72))
    assert len(clean_route(STRAIGHT, t=np.arange(len(STRAIGHT))).report.stationary) == 0


@pytest.mark.parametrize("t", [[0.0], [math.nan] * len(STRAIGHT), "a"])
def test_invalid_times_raise(t: object) -> None:
    with pytest.raises(InputError, match=r"^t must"):
        clean_route(STRAIGHT, t=t)


def test_reversal_and_hairpin_are_not_stationary() -> None:
    phi = np.arange(0.0, math.pi, 0.4)
    hairpin = np.column_stack((200.0 + 5.0 * np.sin(phi), 5.0 * (1.0 - np.cos(phi))))
    back = STRAIGHT[::-1] + np.array([0.0, 10.0])
    for xy in (np.vstack((STRAIGHT, STRAIGHT[-2::-1])), np.vstack((STRAIGHT, hairpin, back))):
        assert len(clean_route(xy).report.stationary) == 0
