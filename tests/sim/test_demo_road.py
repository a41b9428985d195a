import numpy as np
import pytest

from cca_core import LocalFrame, Path, fit_path
from cca_core.sim import demo_route, longest_stretch


def winding_road() -> Path:
    """A straight, a curve of radius 80 m, and a longer straight."""
    turn = np.linspace(0.0, np.pi / 2.0, 60)
    curve = np.column_stack((300.0 + 80.0 * np.sin(turn), 80.0 - 80.0 * np.cos(turn)))
    before = np.column_stack((np.arange(0.0, 300.0, 5.0), np.zeros(60)))
    after = np.column_stack((np.full(100, 380.0), 85.0 + np.arange(0.0, 500.0, 5.0)))
    return fit_path(np.vstack((before, curve, after)), tolerance=0.05)


def longest_by_hand(path: Path, radius: float) -> tuple[float, float]:
    best, begin = (path.start, path.start), None
    for s in np.arange(path.start, path.end, 0.1):
        if abs(path.curvature_at(s)) > 1.0 / radius:
            begin = None
            continue
        begin = s if begin is None else begin
        if s - begin > best[1] - best[0]:
            best = (begin, s)
    return best


@pytest.fixture(scope="module")
def winding() -> Path:
    return winding_road()


@pytest.mark.parametrize("radius", [40.0, 75.0, 200.0, 1000.0])
def test_longest_stretch_equals_plain_search(winding: Path, radius: float) -> None:
    assert longest_stretch(winding, radius=radius) == pytest.approx(longest_by_hand(winding, radius), abs=1.1)


def test_longest_stretch_of_straight_road_is_all_of_it() -> None:
    path = fit_path([(10.0 * i, 0.0) for i in range(20)])
    assert longest_stretch(path, radius=1e6) == (path.start, path.end)


def test_roundabout_has_no_stretch() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 60)
    path = fit_path(30.0 * np.column_stack((np.cos(turn), np.sin(turn)))[:-1], closed=True)
    start, end = longest_stretch(path)
    assert start == end


def test_demo_route_has_no_tight_curve() -> None:
    route = demo_route()
    xy = LocalFrame(route.lat[0], route.lon[0]).to_local(route.lat, route.lon)
    chords = np.diff(xy, axis=0)
    turns = np.diff(np.unwrap(np.arctan2(chords[:, 1], chords[:, 0])))
    assert np.hypot(*chords.T).min() > 5.0
    assert np.abs(turns).max() < 0.2
    path = fit_path(xy)
    curvature = path.curvature(np.arange(path.start, path.end))
    assert 2400.0 < path.length < 2600.0
    assert longest_stretch(path, radius=600.0) == (path.start, path.end)
    assert curvature.min() < -1.0 / 1000.0
    assert curvature.max() > 1.0 / 1000.0
