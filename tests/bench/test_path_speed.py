"""Run times of paths, scaled by a reference timed in the same run; `make bench`."""

from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pytest

from cca_core.path import LocalFrame, Path, clean_route, fit_path, read_waypoints
from tests.bench.timing import Budget, median_us


@pytest.fixture(scope="module")
def road() -> Path:
    x = np.arange(0.0, 20_001.0, 20.0)
    return fit_path(np.column_stack((x, 150.0 * np.sin(x / 600.0))), tolerance=0.05)


def test_motorway_of_650_km(benchmark: Any, data_dir: FilePath, slowness: float, budget: Budget) -> None:
    """Cleaning of 10 000 vertices and a fit of each part."""
    found = read_waypoints(data_dir / "gps" / "I_80_Eastbound_Vertices.csv")
    middle = len(found.lat) // 2
    xy = LocalFrame(found.lat[middle], found.lon[middle]).to_local(found.lat, found.lon)

    def fit() -> list[Path]:
        return [fit_path(p, tolerance=0.5, curvature_limit=1.0 / 300.0) for p in clean_route(xy).parts]

    benchmark.pedantic(fit, rounds=3, iterations=1, warmup_rounds=1)
    budget(benchmark.stats.stats.min, "s", max_value=slowness)


def test_fit_costs_are_linear(budget: Budget) -> None:
    """At most 16 times the time for 8 times the points."""
    x = np.arange(0.0, 160_000.0, 10.0)
    xy = np.column_stack((x, 150.0 * np.sin(x / 600.0)))
    short, long = (median_us(lambda n=n: fit_path(xy[:n], tolerance=0.1), 3) for n in (2000, 16_000))
    budget(long / short, "times", max_value=8.0 * 2.0)


def test_million_foot_points_from_guess(benchmark: Any, road: Path, slowness: float, budget: Budget) -> None:
    rng = np.random.default_rng(0)
    s = rng.uniform(road.start, road.end, 1_000_000)
    xy, s_guess = road.to_cartesian(s, rng.uniform(-5.0, 5.0, len(s))), s + rng.uniform(-3.0, 3.0, len(s))
    benchmark.pedantic(road.project, args=(xy, s_guess), rounds=3, iterations=1)
    budget(benchmark.stats.stats.min, "s", max_value=slowness)


def test_foot_point_from_guess(benchmark: Any, road: Path, slowness: float, budget: Budget) -> None:
    x, y = road.to_cartesian(700.0, 1.0).tolist()
    s, _, _, _ = benchmark(road.foot_point, x, y, 699.6)
    assert s == pytest.approx(700.0, abs=1e-6)
    budget(1e6 * benchmark.stats.stats.median, "µs", max_value=15.0 * slowness)
