"""Tracks as public logs contain them: each gives a path that a car drives end to end, or a clear refusal."""

from pathlib import Path as FilePath

import numpy as np
import pytest

from cca_core.errors import InfeasibleError
from cca_core.path import LocalFrame, Path, clean_route, fit_path, read_waypoints
from tests.support.drives import drive_at_curve_speed
from tests.support.gps_tracks import KINDS, recorded
from tests.support.sweeps import sweep


def assert_drivable(path: Path) -> None:
    assert path.min_radius >= 6.0
    run = drive_at_curve_speed(path, 14.0)
    assert run.finished
    assert run.peak <= 1.5


@pytest.mark.parametrize("noise", sweep(0.3, 0.0, 1.0))
@pytest.mark.parametrize("kind", KINDS)
def test_track_of_kind_is_driven(kind: str, noise: float) -> None:
    parts = clean_route(recorded(kind, 0, noise)).parts
    assert len(parts) == 1
    assert_drivable(fit_path(parts[0]))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1, 6))
@pytest.mark.parametrize("noise", [0.5, 2.0])
@pytest.mark.parametrize("kind", KINDS)
def test_track_is_driven_or_refused(kind: str, noise: float, seed: int) -> None:
    for part in clean_route(recorded(kind, seed, noise)).parts:
        try:
            path = fit_path(part)
        except InfeasibleError:
            continue
        assert_drivable(path)


@pytest.mark.parametrize("seed", sweep(*range(10), quick=3))
def test_noisy_copy_of_recorded_drive_is_driven(seed: int, data_dir: FilePath) -> None:
    """The recorded drive with noise of 0.2 to 2 m, lost fixes, an outlier and a stop."""
    file = data_dir / "gps" / "around-visnjan-with-car.gpx"
    if not file.exists():
        pytest.skip("the recorded drive is not there")
    given = read_waypoints(file)
    xy = LocalFrame(given.lat[0], given.lon[0]).to_local(given.lat, given.lon)
    rng = np.random.default_rng(seed)
    xy = xy + rng.normal(0.0, 0.2 + 0.2 * seed, xy.shape)
    xy = xy[np.sort(rng.permutation(len(xy))[: len(xy) - seed])]
    stop = int(rng.integers(20, 80))
    xy[stop - 10] += rng.normal(0.0, 3.0, 2)
    xy = np.vstack((xy[:stop], xy[stop] + rng.normal(0.0, 1.0, (12, 2)), xy[stop:]))
    for part in clean_route(xy).parts:
        assert_drivable(fit_path(part))
