"""Run times of the kernels of a cycle, of steering, and of first steps among other vehicles."""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core import Path, Planner, PreviewController, RemoteVehicle, Road, VehicleState
from cca_core.frenet import to_frenet
from cca_core.kernel import bind
from cca_core.kernel.box_gaps import box_gaps
from cca_core.kernel.reach import danger_zones, occupancy_boxes, occupied_intervals
from cca_core.path import fit_path
from tests.bench.timing import Budget, median_us
from tests.support.random_situations import CAR, SETTINGS, START, roads, situation

Report = Callable[[str, object], None]
VEHICLES, TIMES = 20, 60


@pytest.fixture(scope="module")
def route() -> Path:
    s = np.arange(0.0, 1501.0, 10.0)
    return fit_path(1500.0 * np.column_stack((np.sin(s / 1500.0), 1.0 - np.cos(s / 1500.0))), tolerance=0.05)


def kernel_calls(path: Path) -> dict[str, tuple[Callable[[], object], float]]:
    """Calls for 20 vehicles at 60 times, and their budgets [us]."""
    random, pairs = np.random.default_rng(0), VEHICLES * TIMES
    motion = random.uniform(1.0, 6.0, (VEHICLES, 8))
    motion[:, 1] = motion[:, 0] + 4.5
    t, travel = np.linspace(0.0, 8.0, TIMES), np.linspace(0.0, 160.0, TIMES)
    rear, front = np.empty((2, VEHICLES, TIMES))
    zone, ego, gap = np.empty((VEHICLES, 2)), random.uniform(1.0, 6.0, (TIMES, 5)), np.empty(pairs)
    s, boxes = np.tile(200.0 + travel, VEHICLES), np.empty((pairs, 5))
    flat, d, half_width = (rear.reshape(-1), front.reshape(-1)), np.full(pairs, 3.5), np.full(pairs, 0.9)
    others = random.uniform(1.0, 6.0, (pairs, 5))
    x, y = path.to_cartesian(700.0, 1.0).tolist()
    foot, project = path.foot_point, path.project
    interval, blocked, cover, apart = map(bind, (occupied_intervals, danger_zones, occupancy_boxes, box_gaps))
    return {
        "foot point": (lambda: foot(x, y, 699.6), 1.0),
        "nearest point": (lambda: project((x, y)), 25.0),
        "occupied intervals": (lambda: interval(VEHICLES, TIMES, motion, t, rear, front), 15.0),
        "danger zones": (lambda: blocked(VEHICLES, TIMES, motion, t, travel, zone), 15.0),
        "occupancy boxes": (lambda: cover(path.curve, pairs, s, *flat, d, half_width, boxes), 200.0),
        "box gaps": (lambda: apart(pairs, TIMES, ego, others, gap), 100.0),
    }


@pytest.mark.parametrize("name", list(kernel_calls(Path([0.0, 900.0], [[[0, 0, 900, 0], [0, 0, 0, 0]]]))))
def test_kernel(route: Path, slowness: float, budget: Budget, record_property: Report, name: str) -> None:
    call, limit = kernel_calls(route)[name]
    took = median_us(call, 500)
    record_property("us", round(took, 2))
    budget(took, "µs", max_value=limit * slowness)


def test_steer(route: Path, slowness: float, budget: Budget, record_property: Report) -> None:
    controller, (x, y) = PreviewController(CAR), route.position(500.0).tolist()
    state = VehicleState(x=x, y=y, psi=float(route.heading(500.0)), v_x=20.0)
    took = median_us(lambda: controller.steer(state, route), 5000)
    record_property("us", round(took, 2))
    budget(took, "µs", max_value=5.0 * slowness)


def test_step_without_news(route: Path, slowness: float, budget: Budget, record_property: Report) -> None:
    """A cycle between two decisions: the reports of three vehicles grow older."""
    planner = Planner(CAR, Road(route), cruise_speed=20.0, evasion=SETTINGS)
    others = [
        RemoteVehicle(id=str(i), x=x, y=y, psi=float(route.heading(s)), v_x=v)
        for i, (s, d, v) in enumerate(((120.0, 0.0, 12.0), (170.0, 3.5, 20.0), (-60.0, 3.5, 20.0)))
        for x, y in (route.to_cartesian(s, d).tolist(),)
    ]
    x, y = route.position(20.0).tolist()
    ego = VehicleState(x=x, y=y, psi=float(route.heading(20.0)), v_x=20.0)
    rounds = 900
    reports = iter([[replace(r, age=1e-4 * k) for r in others] for k in range(rounds + 1)])
    clock = iter(1e-4 * k for k in range(rounds + 1))
    took = median_us(lambda: planner.step(next(clock), ego, next(reports)), rounds)
    record_property("us", round(took, 1))
    budget(took, "µs", max_value=40.0 * slowness)


def test_new_ids(route: Path, slowness: float, budget: Budget, record_property: Report) -> None:
    """Twenty vehicles that have no station yet."""
    stations = np.linspace(100.0, 1400.0, VEHICLES)
    positions = route.to_cartesian(stations, 3.0).tolist()
    remotes = [
        RemoteVehicle(id=str(i), x=x, y=y, psi=float(route.heading(s)), v_x=20.0)
        for i, (s, (x, y)) in enumerate(zip(stations, positions, strict=True))
    ]
    known = to_frenet(remotes, route, last := {})
    took_known = median_us(lambda: to_frenet(remotes, route, last), 300)
    took = median_us(lambda: to_frenet(remotes, route, {}), 300)
    assert len(known[0]) == VEHICLES
    record_property("us", round(took, 1))
    budget((took - took_known) / VEHICLES, "µs for each", max_value=5.0 * slowness)


@pytest.fixture(scope="module")
def first_steps() -> np.ndarray:
    """Times of the first steps of 400 situations, the least of three [ms]."""
    # of this thread: the worst of 400 must not be the time of another process
    made, times = roads(), np.full(400, np.inf)
    for i in range(400):
        case = situation(np.random.default_rng([0, i]), made[i % len(made)])
        x, y = case.road.path.position(START).tolist()
        state = VehicleState(x=x, y=y, psi=float(case.road.path.heading(START)), v_x=case.v_x)
        remotes = [other.remote for other in case.others]
        for _ in range(3):
            planner: Any = Planner(CAR, case.road, cruise_speed=case.cruise, evasion=SETTINGS)
            begun = time.thread_time()
            planner.step(0.0, state, remotes)
            times[i] = min(times[i], 1e3 * (time.thread_time() - begun))
    return times


@pytest.mark.parametrize(("share", "limit"), [(99.0, 5.0), (100.0, 10.0)], ids=["p99", "worst"])
def test_first_step(
    first_steps: np.ndarray,
    slowness: float,
    budget: Budget,
    record_property: Report,
    share: float,
    limit: float,
) -> None:
    """A new planner among up to seven vehicles, one of which it must pass or follow."""
    took = float(np.percentile(first_steps, share))
    record_property("us", round(1e3 * took))
    budget(took, "ms", max_value=limit * slowness)
