"""Run times of a cycle; `make bench`. The reference is timed in the same run."""

import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core import Lane, Path, Planner, RemoteVehicle, Road, VehicleParams, VehicleState
from cca_core.path import fit_path
from cca_core.planner.settings import EvasionSettings
from cca_core.sim import paper_scenarios, simulate
from tests.bench.timing import REFERENCE, Budget

CAR = replace(VehicleParams.bmw_320i(), length=4.5, width=1.8)
CASES = ("1-fast", "1-smooth", "2", "3")
Bench = Any


@pytest.fixture(scope="module")
def route() -> Path:
    s = np.arange(0.0, 1501.0, 10.0)
    return fit_path(1500.0 * np.column_stack((np.sin(s / 1500.0), 1.0 - np.cos(s / 1500.0))), tolerance=0.05)


def _state(path: Path, s: float, v_x: float = 20.0) -> VehicleState:
    x, y = path.position(s)
    return VehicleState(x=float(x), y=float(y), psi=float(path.heading(s)), v_x=v_x)


def test_reference_solve_banded(reference_us: float, record_property: Callable[[str, object], None]) -> None:
    """Scale of the budgets: 100 rows, two right-hand sides."""
    assert REFERENCE().max() == pytest.approx(0.5 * 50.5**2, rel=0.01)
    record_property("us", round(reference_us, 1))


@pytest.mark.parametrize(
    ("positions", "replans", "action"),
    [
        (((120.0, 0.0), (170.0, 3.5), (-60.0, 3.5)), False, "KEEP"),
        (((60.0, 0.0), (25.0, 3.5), (25.0, -3.5)), True, "FOLLOW"),
        (((75.0, 0.0),), True, "EVADE"),
    ],
    ids=["keeps", "follows", "evades"],
)
def test_planner_step(
    benchmark: Bench, route: Path, positions: tuple[tuple[float, float], ...], replans: bool, action: str
) -> None:
    """One cycle (keeps: no new decision; follows: rejected candidates on both sides; evades: replanning)."""
    road = Road(route, (Lane(d=0.0), Lane(d=3.5), Lane(d=-3.5)))
    planner = Planner(CAR, road, cruise_speed=20.0, evasion=EvasionSettings(awareness_range=np.inf))
    for t in (0.0, 0.1, 0.2, 0.3, 0.4):  # a maneuver begins ahead of the ego
        ego, others = _state(route, 20.0 + 20.0 * t), []
        for i, (s, d) in enumerate(positions):
            v = 12.0 if d == 0.0 else 20.0
            x, y = route.to_cartesian(s + v * t, d)
            psi = float(route.heading(s + v * t))
            others.append(RemoteVehicle(id=str(i), x=float(x), y=float(y), psi=psi, v_x=v))
        planner.step(t, ego, others)
    clock = [t]

    def step() -> Any:
        clock[0] += 0.1 if replans else 1e-4
        return planner.step(clock[0], ego, others if replans else [replace(r, age=clock[0]) for r in others])

    command = benchmark(step)
    assert command.decision.action.name.startswith(action)


@pytest.mark.parametrize("case", CASES)
def test_maneuver_in_real_time(benchmark: Bench, case: str, slowness: float, budget: Budget) -> None:
    """Speed relative to real time, with lossy channel; the goal is 60, the budget 60 / 1.3: times scatter."""
    (scenario,) = (s for s in paper_scenarios() if s.name == "maneuver" and s.v2v and s.case == case)
    log = benchmark.pedantic(simulate, args=(scenario,), rounds=3, iterations=1, warmup_rounds=1)
    factor = float(log.t[-1]) / benchmark.stats.stats.min
    benchmark.extra_info.update(
        realtime_factor=round(factor, 1), cycle_us_median=round(float(np.median(log.cycle_us))),
        cycle_us_p99=round(float(np.percentile(log.cycle_us, 99))),
    )  # fmt: skip
    budget(factor, "times", min_value=60.0 / 1.3 / slowness)


def test_import(benchmark: Any, slowness: float, budget: Any) -> None:
    """Import of the library in a fresh interpreter, NumPy included; the budget is for the best of five."""
    code = "from time import perf_counter as now; t = now(); import cca_core; print(now() - t)"

    def run() -> float:
        return float(subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout)

    took = min(run() for _ in range(5))
    benchmark.pedantic(run, rounds=1)
    budget(took, "s", max_value=0.4 * slowness)
