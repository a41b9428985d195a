"""Run times; `make bench`. Compare ratios within one run: the reference is timed in the same one."""

import time
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import solve_banded

from cca_core import Lane, Path, Planner, PreviewController, RemoteVehicle, Road, VehicleParams, VehicleState
from cca_core.band import relax_band
from cca_core.evasion_settings import EvasionSettings
from cca_core.geometry import boxes
from cca_core.path import fit_path
from cca_core.sim import maneuver, simulate

CAR = replace(VehicleParams.bmw_320i(), length=4.5, width=1.8)
_REFERENCE_US = 16.6  # solve_banded, n = 100, two right-hand sides, on the machine of peers.md
Bench = Any


def _banded() -> tuple[Any, Any]:
    matrix = np.repeat(np.array([[-1.0], [2.0], [-1.0]]), 100, axis=1)
    return matrix, np.ones((100, 2))


@pytest.fixture(scope="module")
def slowness() -> float:
    """How much slower than the machine of peers.md this one is now, by `solve_banded`."""
    matrix, right = _banded()
    times = []
    for _ in range(2000):
        begun = time.perf_counter()
        solve_banded((1, 1), matrix, right)
        times.append(time.perf_counter() - begun)
    return max(1.0, float(np.median(times)) * 1e6 / _REFERENCE_US)


@pytest.fixture(scope="module")
def route() -> Path:
    s = np.arange(0.0, 1501.0, 10.0)
    return fit_path(1500.0 * np.column_stack((np.sin(s / 1500.0), 1.0 - np.cos(s / 1500.0))), tolerance=0.05)


def _state(path: Path, s: float, v_x: float = 20.0) -> VehicleState:
    x, y = path.position(s)
    return VehicleState(x=float(x), y=float(y), psi=float(path.heading(s)), v_x=v_x)


def test_reference_solve_banded(benchmark: Bench) -> None:
    matrix, right = _banded()
    u = benchmark(solve_banded, (1, 1), matrix, right)
    assert u.max() == pytest.approx(0.5 * 50.5**2, rel=0.01)


def test_band_problem_a(benchmark: Bench, slowness: float) -> None:
    """One stationary car, 100 m in 100 nodes."""
    nodes = np.column_stack((np.linspace(0.0, 100.0, 100), np.zeros(100)))
    band = benchmark(relax_band, nodes, [boxes(50.0, 0.0, 0.0, 4.5, 1.8)], side="left", vehicle=CAR)
    _band_facts(benchmark, band)
    assert band.status.name == "OK"
    assert benchmark.stats.stats.median * 1e6 < 3000.0 * slowness


def test_band_problem_b(benchmark: Bench, slowness: float) -> None:
    """Slalom, cars at (35, 0), (60, 3.5), (85, 0), over 120 m in 100 nodes."""
    nodes = np.column_stack((np.linspace(0.0, 120.0, 100), np.zeros(100)))
    cars = [boxes(x, y, 0.0, 4.5, 1.8) for x, y in ((35.0, 0.0), (60.0, 3.5), (85.0, 0.0))]
    band = benchmark(relax_band, nodes, cars, side="left", vehicle=CAR, clearance=0.3)
    _band_facts(benchmark, band)
    assert benchmark.stats.stats.median * 1e6 < 6000.0 * slowness


def _band_facts(benchmark: Bench, band: Any) -> None:
    benchmark.extra_info.update(
        clearance_m=round(band.clearance, 2), a_y_at_20=round(400.0 * band.curvature, 2),
        status=band.status.name, solves=band.solves,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("places", "news", "action"),
    [
        (((120.0, 0.0), (170.0, 3.5), (-60.0, 3.5)), False, "KEEP"),
        (((60.0, 0.0), (25.0, 3.5), (25.0, -3.5)), True, "FOLLOW"),
        (((55.0, 0.0),), True, "EVADE"),
    ],
    ids=["steers", "waits", "evades"],
)
def test_planner_step(
    benchmark: Bench, route: Path, places: tuple[tuple[float, float], ...], news: bool, action: str
) -> None:
    """A cycle: without news; looking for a way on two sides, in vain; renewing the band of a swerve."""
    road = Road(route, (Lane(d=0.0), Lane(d=3.5), Lane(d=-3.5)))
    planner = Planner(CAR, road, cruise_speed=20.0, evasion=EvasionSettings(known_range=np.inf))
    ego = _state(route, 20.0)
    others = []
    for i, (s, d) in enumerate(places):
        x, y = route.to_cartesian(s, d)
        v = 12.0 if d == 0.0 else 20.0
        others.append(RemoteVehicle(id=str(i), x=float(x), y=float(y), psi=float(route.heading(s)), v_x=v))
    clock = [0.0]

    def step() -> Any:
        clock[0] += 0.1 if news else 1e-4
        return planner.step(clock[0], ego, others if news else [replace(r, age=clock[0]) for r in others])

    command = benchmark(step)
    assert command.decision.action.name.startswith(action)


def test_foot_point(benchmark: Bench, route: Path) -> None:
    x, y = route.to_cartesian(700.0, 1.0).tolist()
    s, d, _, _ = benchmark(route.foot_point, x, y, 699.6)
    assert (s, d) == pytest.approx((700.0, 1.0), abs=1e-6)


def test_steer(benchmark: Bench, route: Path) -> None:
    controller = PreviewController(CAR)
    benchmark(controller.steer, _state(route, 500.0), route)


def test_case_2_in_real_time(benchmark: Bench, route: Path, slowness: float) -> None:
    """At least 20 times faster than real time, planner included."""
    scenario = maneuver("2", route)
    log = benchmark.pedantic(simulate, args=(scenario,), rounds=3, iterations=1, warmup_rounds=1)
    factor = log.t[-1] / benchmark.stats.stats.min
    benchmark.extra_info.update(
        realtime_factor=round(factor, 1), cycle_us_median=round(float(np.median(log.cycle_us))),
        cycle_us_p99=round(float(np.percentile(log.cycle_us, 99))), slowness=round(slowness, 2),
    )  # fmt: skip
    assert factor * slowness >= 20.0
