"""Run times of the band and of two peers, scaled by a reference timed in the same run; `make bench`.

The sides are given, as for the peers. Each time comes with the quality of the result: smallest distance to
the cars, largest curvature, lateral acceleration at 20 m/s.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from cca_core import Path, VehicleParams
from cca_core.band import Band, BandStiffness, equilibrium, relax_band, smooth_band
from cca_core.band.solver import borrow, measure
from cca_core.band.stiffness import deformed
from cca_core.geometry import Boxes, box_gap, boxes
from cca_core.kernel import bind
from cca_core.kernel.band_batch import relax_bands
from cca_core.kernel.band_workspace import CODES, GIVEN_SIDES, OK, REALS, REALS_PER_NODE
from cca_core.path import interpolate_path
from tests.bench.peers import LENGTH, SPEED, WIDTH, Peer, Point, fiss, nmpc
from tests.bench.timing import Budget, median_us

pytestmark = pytest.mark.benchmark(disable_gc=True, min_rounds=100, warmup=True, warmup_iterations=20)

CAR = replace(VehicleParams.bmw_320i(), length=LENGTH, width=WIDTH)
Within = Callable[..., None]
STRING, DRIVABLE = BandStiffness(k_s=1.0, k_c=0.0, k_e=0.05), BandStiffness()
TOLERANCE = 1.3  # scatter of a run
# of calls that last longer than the machine leaves a process alone
PROCESSOR_TIME = pytest.mark.benchmark(disable_gc=True, timer=time.process_time)
BATCH = 64


@dataclass(frozen=True)
class Problem:
    """Stationary cars on a straight road, and the clearance."""

    length: float
    cars: tuple[Point, ...]
    clearance: float

    @property
    def lefts(self) -> tuple[bool, ...]:
        return tuple(y <= 0.0 for _, y in self.cars)

    @property
    def sides(self) -> tuple[Any, ...]:
        return tuple("left" if left else "right" for left in self.lefts)

    @property
    def nodes(self) -> np.ndarray:
        return np.column_stack((np.linspace(0.0, self.length, 100), np.zeros(100)))

    @property
    def obstacles(self) -> list[Boxes]:
        return [boxes(x, y, 0.0, LENGTH, WIDTH) for x, y in self.cars]

    def relaxed(self) -> Band:
        return relax_band(self.nodes, self.obstacles, side=self.sides, vehicle=CAR, clearance=self.clearance)

    def batch(self, count: int = BATCH) -> tuple[np.ndarray, list[Boxes]]:
        """Nodes and obstacles of a batch in which each car is shifted by up to 3 m."""
        ahead = np.random.default_rng(0).uniform(-3.0, 3.0, (len(self.cars), count, 1))
        shifted = [
            boxes(x + off, y, 0.0, LENGTH, WIDTH) for (x, y), off in zip(self.cars, ahead, strict=True)
        ]
        return np.repeat(self.nodes[None], count, axis=0), shifted


SLALOM = ((35.0, 0.0), (60.0, 3.5), (85.0, 0.0))
A, A_CLOSE = Problem(100.0, ((50.0, 0.0),), 1.0), Problem(100.0, ((50.0, 0.0),), 0.5)
B = Problem(120.0, SLALOM, 0.3)  # over 100 m it cannot be driven at 20 m/s
EACH = pytest.mark.parametrize("problem", [A, A_CLOSE, B], ids=["A_1.0", "A_0.5", "B_0.3"])
TWO = pytest.mark.parametrize("problem", [A, B], ids=["A_1.0", "B_0.3"])


def trajectory_of(path: Path) -> np.ndarray:
    """Middle of the body, heading and curvature along a path, shape (n, 4)."""
    s = np.linspace(path.start, path.end, 2000)
    psi = path.heading(s)
    xy = path.position(s) + CAR.box_offset * np.column_stack((np.cos(psi), np.sin(psi)))
    return np.column_stack((xy, psi, path.curvature(s)))


def record_quality(benchmark: Any, problem: Problem, trajectory: np.ndarray, **more: Any) -> float:
    """Record the quality of a trajectory with its time; return its clearance [m]."""
    x, y, psi, kappa = trajectory.T
    clearance = min(float(box_gap(boxes(x, y, psi, LENGTH, WIDTH), o).min()) for o in problem.obstacles)
    curvature = float(np.abs(kappa).max())
    benchmark.extra_info.update(
        clearance_m=round(clearance, 3),
        curvature=round(curvature, 5),
        a_y_at_20=round(SPEED**2 * curvature, 2),
        **more,
    )
    return clearance


@pytest.fixture
def within(benchmark: Any, slowness: float, budget: Budget) -> Within:
    """Assert the time per band on the reference machine [us], of which a run computes `count`."""

    def check(max_us: float, count: int = 1) -> None:
        spent = 1e6 * benchmark.stats.stats.median / count
        budget(spent, "µs per band", max_value=max_us * slowness * TOLERANCE)

    return check


def bounds_of(problem: Problem, nodes: np.ndarray, obstacles: list[Boxes]) -> tuple[np.ndarray, np.ndarray]:
    """Bounds that the corridor leaves each band of a batch, on the sides of the problem."""
    relaxed = relax_band(nodes, obstacles, side=problem.sides, vehicle=CAR, clearance=problem.clearance)
    lefts = np.array(problem.lefts)
    found = [measure(relaxed.problem.select([i]), passes_left=lefts) for i in range(len(nodes))]
    return np.array([each.lower for each in found]), np.array([each.upper for each in found])


def stencil_and_penalty(stiffness: BandStiffness, spacing: float) -> tuple[np.ndarray, float]:
    return stiffness.stencil(spacing), stiffness.k_e * spacing


# --- one band -----------------------------------------------------------------------------------------


@EACH
def test_string(benchmark: Any, problem: Problem, within: Within) -> None:
    """Equilibrium under tension alone, between given bounds."""
    nodes = problem.nodes
    bounds = bounds_of(problem, nodes[None], problem.obstacles)
    row, force = stencil_and_penalty(STRING, nodes[1, 0])
    u, solves, converged = benchmark(equilibrium, row, force, *bounds)
    assert converged.all()
    path = interpolate_path(deformed(nodes, np.column_stack((0.0 * u[0], u[0]))))
    record_quality(benchmark, problem, trajectory_of(path), status="not certified", n_solves=int(solves[0]))
    within(60.0 if problem is B else 30.0)


@EACH
def test_drivable(benchmark: Any, problem: Problem, within: Within) -> None:
    """Equilibrium of the relaxed band, between given bounds."""
    nodes = problem.nodes
    bounds = bounds_of(problem, nodes[None], problem.obstacles)
    row, force = stencil_and_penalty(DRIVABLE, nodes[1, 0])
    u, solves, converged = benchmark(equilibrium, row, force, *bounds)
    assert converged.all()
    moved = deformed(nodes, np.column_stack((0.0 * u[0], u[0])))
    flat = {"start_tangent": (1.0, 0.0), "end_tangent": (1.0, 0.0)}
    record_quality(
        benchmark,
        problem,
        trajectory_of(interpolate_path(moved, **flat)),
        status="not certified",
        n_solves=int(solves[0]),
    )
    within(150.0 if problem is B else 80.0)


@EACH
def test_certified_path(benchmark: Any, problem: Problem, within: Within) -> None:
    """Relaxed band with checked arguments, its certificate and its path."""
    nodes, obstacles, sides = problem.nodes, problem.obstacles, problem.sides

    def run() -> tuple[Band, Path]:
        band = relax_band(nodes, obstacles, side=sides, vehicle=CAR, clearance=problem.clearance)
        return band, band.path()

    band, path = benchmark(run)
    clearance = record_quality(
        benchmark, problem, trajectory_of(path), status=band.status.name, n_solves=band.n_solves
    )
    spline = median_us(lambda: CubicSpline(nodes[:, 0], band.nodes), 500)
    benchmark.extra_info["scipy_CubicSpline_us"] = round(spline, 1)
    assert band.status.name == "OK"
    assert clearance >= problem.clearance - 1e-9
    within(80.0 if problem is B else 60.0)


@TWO
def test_certified_band_in_the_kernel(benchmark: Any, problem: Problem, within: Within) -> None:
    """Relaxed band and its certificate without the checks of the arguments."""
    space = borrow(problem.relaxed().problem)
    space.take(problem.relaxed().problem, GIVEN_SIDES, np.array(problem.lefts)[:, None], None)
    reals, codes = np.empty(REALS + REALS_PER_NODE * 100), np.empty(CODES, dtype=np.int32)
    given = space.kernel_arguments
    benchmark(bind(relax_bands), *given, 1, len(reals), reals, codes)
    assert codes[0] == OK
    within(30.0 if problem is B else 15.0)


@EACH
def test_smoothed(benchmark: Any, problem: Problem, within: Within) -> None:
    """Certified path, smoothed by a quadratic program in PIQP."""
    nodes, obstacles, sides = problem.nodes, problem.obstacles, problem.sides

    def run() -> Band:
        band = relax_band(nodes, obstacles, side=sides, vehicle=CAR, clearance=problem.clearance)
        return smooth_band(band, solver="piqp")

    band = benchmark(run)
    clearance = record_quality(benchmark, problem, trajectory_of(band.path()), status=band.status.name)
    assert band.status.name == "OK"
    assert band.qp_residual is not None
    assert clearance >= problem.clearance - 1e-9
    within(1400.0 if problem is B else 1200.0)


# --- batches, long bands ------------------------------------------------------------------------------


@TWO
def test_batch_of_strings(benchmark: Any, problem: Problem, within: Within) -> None:
    nodes, obstacles = problem.batch()
    bounds = bounds_of(problem, nodes, obstacles)
    row, force = stencil_and_penalty(STRING, nodes[0, 1, 0])
    _, _, converged = benchmark(equilibrium, row, force, *bounds)
    assert converged.all()
    within(10.0, BATCH)


@TWO
def test_batch_of_drivable_bands(benchmark: Any, problem: Problem, within: Within) -> None:
    nodes, obstacles = problem.batch()
    bounds = bounds_of(problem, nodes, obstacles)
    row, force = stencil_and_penalty(DRIVABLE, nodes[0, 1, 0])
    _, _, converged = benchmark(equilibrium, row, force, *bounds)
    assert converged.all()
    within(40.0, BATCH)


@TWO
@PROCESSOR_TIME
def test_batch_of_certified_bands(benchmark: Any, problem: Problem, within: Within) -> None:
    """Cheaper per band than one at a time."""
    nodes, obstacles = problem.batch()
    band = benchmark(
        relax_band, nodes, obstacles, side=problem.sides, vehicle=CAR, clearance=problem.clearance
    )
    assert band.ok.all()
    curvature = float(band.curvature.max())
    benchmark.extra_info.update(
        clearance_m=round(float(band.clearance.min()), 3), curvature=round(curvature, 5),
        a_y_at_20=round(SPEED**2 * curvature, 2), status=f"{int(band.ok.sum())} OK",
    )  # fmt: skip
    within(60.0 if problem is B else 25.0, BATCH)


@TWO
@PROCESSOR_TIME
def test_batch_of_1024_bands(benchmark: Any, problem: Problem, within: Within) -> None:
    """Relaxed bands with checked arguments and certificates, in one thread."""
    nodes, obstacles = problem.batch(1024)
    asked = {"side": problem.sides, "vehicle": CAR, "clearance": problem.clearance}
    band = benchmark.pedantic(relax_band, (nodes, obstacles), asked, rounds=15, warmup_rounds=2)
    assert band.ok.all()
    within(55.0 if problem is B else 20.0, 1024)


# --- growth -------------------------------------------------------------------------------------------


def processor_ms(run: Callable[[], Any]) -> float:
    """Time that a call takes of the processor [ms]."""
    begun = time.process_time()
    run()
    return 1e3 * (time.process_time() - begun)


def passing(count: int, n: int, alternating: bool) -> Band:
    """Band that touches so many rotated cars on a road of n meters."""
    random = np.random.default_rng(3)
    cars = [
        boxes(100.0 + (n - 200.0) * i / count, random.uniform(-0.8, 0.8), random.uniform(-0.2, 0.2), 4.5, 1.8)
        for i in range(count)
    ]
    x = np.arange(float(n))
    sides: Any = [("left", "right")[i % 2] for i in range(count)] if alternating else "left"
    return relax_band(np.column_stack((x, 0.0 * x)), cars, side=sides, vehicle=CAR, clearance=0.5)


@PROCESSOR_TIME
@pytest.mark.parametrize("alternating", [False, True], ids=["one_side", "both_sides"])
def test_fifty_touching_obstacles(benchmark: Any, budget: Budget, alternating: bool) -> None:
    """At most 10 times the time of 5 on the same road."""
    assert benchmark.pedantic(passing, (50, 1000, alternating), rounds=30, warmup_rounds=2).ok
    few = [processor_ms(lambda: passing(5, 1000, alternating)) for _ in range(30)]
    budget(1e3 * benchmark.stats.stats.median / float(np.median(few)), "times", max_value=10.0)


@PROCESSOR_TIME
def test_six_obstacles_with_free_sides(benchmark: Any, within: Within) -> None:
    """All 64 assignments of sides are compared."""
    random = np.random.default_rng(0)
    cars = [boxes(40.0 + 28.0 * i, random.uniform(-0.5, 0.5), 0.0, 4.5, 1.8) for i in range(6)]
    x = np.arange(240.0)
    route = np.column_stack((x, 0.0 * x))
    assert benchmark.pedantic(
        relax_band, (route, cars), {"vehicle": CAR, "clearance": 0.5}, rounds=30, warmup_rounds=2
    ).ok
    within(5000.0)


def test_ten_thousand_nodes(benchmark: Any, budget: Budget) -> None:
    """At most 150 times the time for 100 times the nodes."""
    x = np.arange(10_000.0)
    nodes, car = np.column_stack((x, 0.0 * x)), [boxes(5000.0, 0.0, 0.0, LENGTH, WIDTH)]
    long = benchmark.pedantic(
        lambda: relax_band(nodes, car, side="left", vehicle=CAR).path(), rounds=15, warmup_rounds=2
    )
    short = median_us(lambda: A.relaxed().path(), 500)
    times = 1e6 * benchmark.stats.stats.median / short
    record_quality(benchmark, Problem(10_000.0, ((5000.0, 0.0),), 1.0), trajectory_of(long))
    budget(times, "times", max_value=150.0)


# --- peers --------------------------------------------------------------------------------------------


def time_peer(benchmark: Any, peer: Peer, problem: Problem) -> float:
    """Time a peer, and the band before and after it; record the ratio. The peer must not collide."""

    def band_path() -> Path:
        return relax_band(nodes, obstacles, side=sides, vehicle=CAR, clearance=problem.clearance).path()

    nodes, obstacles, sides = problem.nodes, problem.obstacles, problem.sides
    band = problem.relaxed()
    before = median_us(band_path, 300)
    trajectory = peer.trajectory(benchmark(peer.run))
    spent = 0.5 * (before + median_us(band_path, 300))
    assert band.status.name == "OK"
    assert trajectory is not None
    ratio = 1e6 * benchmark.stats.stats.median / spent
    clearance = record_quality(
        benchmark, problem, trajectory, band_us=round(spent, 1), times_band=round(ratio, 2),
        band_clearance_m=round(band.clearance, 3), band_a_y_at_20=round(SPEED**2 * band.curvature, 2),
    )  # fmt: skip
    assert clearance > 0.0
    return ratio


@TWO
def test_nmpc_time_over_band(benchmark: Any, problem: Problem, budget: Budget) -> None:
    peer = nmpc(problem.length, problem.cars, problem.lefts)
    budget(time_peer(benchmark, peer, problem), "times the band", min_value=50.0)


def test_fiss_time_over_band(benchmark: Any, budget: Budget) -> None:
    """With safety rules relaxed until FISS finds a trajectory."""
    peer = fiss(A.cars, min_ttc=0.5)
    budget(time_peer(benchmark, peer, A), "times the band", min_value=8.0)


@pytest.mark.parametrize("min_ttc", [0.0, None], ids=["no_time_to_collision", "no_rules"])
def test_fiss_without_rules(benchmark: Any, min_ttc: float | None) -> None:
    """No budget: its clearance is then less than that of the band."""
    time_peer(benchmark, fiss(A.cars, min_ttc=min_ttc), A)
    assert benchmark.extra_info["clearance_m"] < A.clearance
