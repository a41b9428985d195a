"""Run times of the band, scaled by a reference timed in the same run, and of two peers; `make bench`.

Sides are given, as to the peers. Beside each time stands what was bought with it: least distance to the cars,
largest curvature, and the lateral acceleration at 20 m/s.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from cca_core import Path, VehicleParams
from cca_core.band import Band, BandStiffness, equilibrium, relax_band, smooth_band
from cca_core.band.corridor import Corridor, make_corridor
from cca_core.band.stiffness import deformed
from cca_core.geometry import Boxes, box_gap, boxes
from cca_core.path import interpolate_path
from tests.bench.conftest import Budget, median_us
from tests.bench.peers import LENGTH, SPEED, WIDTH, Peer, Place, fiss, nmpc

pytestmark = pytest.mark.benchmark(disable_gc=True, min_rounds=100, warmup=True, warmup_iterations=20)

CAR = replace(VehicleParams.bmw_320i(), length=LENGTH, width=WIDTH)
Within = Callable[..., None]
STRING, DRIVABLE = BandStiffness(k_s=1.0, k_c=0.0, k_e=0.05), BandStiffness()
TOLERANCE = 1.3  # what a run may scatter
BATCH = 64


@dataclass(frozen=True)
class Problem:
    """Cars that stand on or beside a straight road, and the room asked."""

    length: float
    cars: tuple[Place, ...]
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

    def many(self) -> tuple[np.ndarray, list[Boxes]]:
        """Nodes and obstacles of a batch in which each car stands elsewhere by up to 3 m."""
        ahead = np.random.default_rng(0).uniform(-3.0, 3.0, (len(self.cars), BATCH, 1))
        placed = [boxes(x + off, y, 0.0, LENGTH, WIDTH) for (x, y), off in zip(self.cars, ahead, strict=True)]
        return np.repeat(self.nodes[None], BATCH, axis=0), placed


SLALOM = ((35.0, 0.0), (60.0, 3.5), (85.0, 0.0))
A, A_CLOSE = Problem(100.0, ((50.0, 0.0),), 1.0), Problem(100.0, ((50.0, 0.0),), 0.5)
B = Problem(120.0, SLALOM, 0.3)  # over 100 m it cannot be driven at 20 m/s
EACH = pytest.mark.parametrize("problem", [A, A_CLOSE, B], ids=["A_1.0", "A_0.5", "B_0.3"])
TWO = pytest.mark.parametrize("problem", [A, B], ids=["A_1.0", "B_0.3"])


def driven(path: Path) -> np.ndarray:
    """Middle of the body, heading and curvature along a path, shape (n, 4)."""
    s = np.linspace(path.start, path.end, 2000)
    psi = path.heading(s)
    xy = path.position(s) + CAR.box_offset * np.column_stack((np.cos(psi), np.sin(psi)))
    return np.column_stack((xy, psi, path.curvature(s)))


def keep(benchmark: Any, problem: Problem, way: np.ndarray, **more: Any) -> float:
    """Note what a way keeps beside its time; returns its clearance [m]."""
    x, y, psi, kappa = way.T
    clearance = min(float(box_gap(boxes(x, y, psi, LENGTH, WIDTH), o).min()) for o in problem.obstacles)
    most = float(np.abs(kappa).max())
    benchmark.extra_info.update(
        clearance_m=round(clearance, 3), curvature=round(most, 5), a_y_at_20=round(SPEED**2 * most, 2), **more
    )
    return clearance


@pytest.fixture
def within(benchmark: Any, slowness: float, budget: Budget) -> Within:
    """At most so many microseconds a band on the reference machine, of which a run makes `share`."""

    def judge(most: float, share: int = 1) -> None:
        spent = 1e6 * benchmark.stats.stats.median / share
        budget(spent, "µs a band", most=most * slowness * TOLERANCE)

    return judge


def corridor_of(problem: Problem, nodes: np.ndarray, obstacles: list[Boxes]) -> Callable[[], Corridor]:
    """How the corridor of a straight road is found, given what a planner has at hand."""
    base = nodes.view(np.complex128).reshape(-1, nodes.shape[-2])
    tangents, leading = np.ones_like(base), nodes.shape[:-2]
    return lambda: make_corridor(base, tangents, obstacles, None, CAR, problem.clearance, 0.0, leading)


def contact(stiffness: BandStiffness, spacing: float) -> tuple[np.ndarray, float]:
    return stiffness.stencil(spacing), stiffness.k_e * spacing


# --- one band -----------------------------------------------------------------------------------------


@EACH
def test_string(benchmark: Any, problem: Problem, within: Within) -> None:
    """Contact under tension alone, between bounds that are given."""
    nodes = problem.nodes
    bounds = corridor_of(problem, nodes, problem.obstacles)().bounds(np.array(problem.lefts)[:, None])
    row, force = contact(STRING, nodes[1, 0])
    u, solves, settled = benchmark(equilibrium, row, force, *bounds)
    assert settled.all()
    bent = interpolate_path(deformed(nodes, np.column_stack((0.0 * u[0], u[0]))))
    keep(benchmark, problem, driven(bent), status="not judged", solves=int(solves[0]))
    within(60.0 if problem is B else 30.0)


@EACH
def test_drivable(benchmark: Any, problem: Problem, within: Within) -> None:
    """Contact of the band that bends, with the corridor found."""
    nodes = problem.nodes
    find, lefts = corridor_of(problem, nodes, problem.obstacles), np.array(problem.lefts)[:, None]
    row, force = contact(DRIVABLE, nodes[1, 0])
    u, solves, settled = benchmark(lambda: equilibrium(row, force, *find().bounds(lefts)))
    assert settled.all()
    bent = deformed(nodes, np.column_stack((0.0 * u[0], u[0])))
    flat = {"start_tangent": (1.0, 0.0), "end_tangent": (1.0, 0.0)}
    keep(
        benchmark, problem, driven(interpolate_path(bent, **flat)), status="not judged", solves=int(solves[0])
    )
    within(150.0 if problem is B else 80.0)


@EACH
def test_certified_path(benchmark: Any, problem: Problem, within: Within) -> None:
    """Arguments checked, the band that bends, its certificate and its path."""
    nodes, obstacles, sides = problem.nodes, problem.obstacles, problem.sides

    def run() -> tuple[Band, Path]:
        band = relax_band(nodes, obstacles, side=sides, vehicle=CAR, clearance=problem.clearance)
        return band, band.path()

    band, path = benchmark(run)
    kept = keep(benchmark, problem, driven(path), status=band.status.name, solves=band.solves)
    spline = median_us(lambda: CubicSpline(nodes[:, 0], band.nodes), 500)
    benchmark.extra_info["scipy_CubicSpline_us"] = round(spline, 1)
    assert band.status.name == "OK"
    assert kept >= problem.clearance - 1e-9
    within(300.0 if problem is B else 250.0)


@EACH
def test_smoothed(benchmark: Any, problem: Problem, within: Within) -> None:
    """The same, smoothed by a quadratic program in PIQP."""
    nodes, obstacles, sides = problem.nodes, problem.obstacles, problem.sides

    def run() -> Band:
        band = relax_band(nodes, obstacles, side=sides, vehicle=CAR, clearance=problem.clearance)
        return smooth_band(band, solver="piqp")

    band = benchmark(run)
    kept = keep(benchmark, problem, driven(band.path()), status=band.status.name)
    assert band.status.name == "OK"
    assert band.qp_residual is not None
    assert kept >= problem.clearance - 1e-9
    within(1400.0 if problem is B else 1200.0)


# --- many bands, long bands ---------------------------------------------------------------------------


@TWO
def test_batch_of_strings(benchmark: Any, problem: Problem, within: Within) -> None:
    nodes, obstacles = problem.many()
    lefts = np.repeat(np.array(problem.lefts)[:, None], BATCH, axis=1)
    bounds = corridor_of(problem, nodes, obstacles)().bounds(lefts)
    row, force = contact(STRING, nodes[0, 1, 0])
    _, _, settled = benchmark(equilibrium, row, force, *bounds)
    assert settled.all()
    within(10.0, BATCH)


@TWO
def test_batch_of_drivable_bands(benchmark: Any, problem: Problem, within: Within) -> None:
    nodes, obstacles = problem.many()
    find, lefts = (
        corridor_of(problem, nodes, obstacles),
        np.repeat(np.array(problem.lefts)[:, None], BATCH, 1),
    )
    row, force = contact(DRIVABLE, nodes[0, 1, 0])
    _, _, settled = benchmark(lambda: equilibrium(row, force, *find().bounds(lefts)))
    assert settled.all()
    within(40.0, BATCH)


@TWO
def test_batch_of_certified_bands(benchmark: Any, problem: Problem, within: Within) -> None:
    """Cheaper by the band than one by one."""
    nodes, obstacles = problem.many()
    band = benchmark(
        relax_band, nodes, obstacles, side=problem.sides, vehicle=CAR, clearance=problem.clearance
    )
    assert band.ok.all()
    most = float(band.curvature.max())
    benchmark.extra_info.update(
        clearance_m=round(float(band.clearance.min()), 3), curvature=round(most, 5),
        a_y_at_20=round(SPEED**2 * most, 2), status=f"{int(band.ok.sum())} OK",
    )  # fmt: skip
    within(300.0 if problem is B else 250.0, BATCH)


def test_ten_thousand_nodes(benchmark: Any, budget: Budget) -> None:
    """A hundred times the nodes cost at most 150 times as much."""
    x = np.arange(10_000.0)
    nodes, car = np.column_stack((x, 0.0 * x)), [boxes(5000.0, 0.0, 0.0, LENGTH, WIDTH)]
    long = benchmark.pedantic(
        lambda: relax_band(nodes, car, side="left", vehicle=CAR).path(), rounds=15, warmup_rounds=2
    )
    short = median_us(lambda: A.relaxed().path(), 500)
    times = 1e6 * benchmark.stats.stats.median / short
    keep(benchmark, Problem(10_000.0, ((5000.0, 0.0),), 1.0), driven(long))
    budget(times, "times", most=150.0)


# --- peers --------------------------------------------------------------------------------------------


def against(benchmark: Any, peer: Peer, problem: Problem) -> float:
    """Time a peer, ours before and after it, and note the ratio of the medians; the peer must not collide."""

    def ours() -> Path:
        return relax_band(nodes, obstacles, side=sides, vehicle=CAR, clearance=problem.clearance).path()

    nodes, obstacles, sides = problem.nodes, problem.obstacles, problem.sides
    band = problem.relaxed()
    before = median_us(ours, 300)
    way = peer.driven(benchmark(peer.run))
    spent = 0.5 * (before + median_us(ours, 300))
    assert band.status.name == "OK"
    assert way is not None
    ratio = 1e6 * benchmark.stats.stats.median / spent
    kept = keep(
        benchmark, problem, way, ours_us=round(spent, 1), times_ours=round(ratio, 2),
        ours_clearance_m=round(band.clearance, 3), ours_a_y_at_20=round(SPEED**2 * band.curvature, 2),
    )  # fmt: skip
    assert kept > 0.0
    return ratio


@TWO
def test_nmpc_takes_8_times_as_long(benchmark: Any, problem: Problem, budget: Budget) -> None:
    peer = nmpc(problem.length, problem.cars, problem.lefts)
    budget(against(benchmark, peer, problem), "times ours", least=8.0)


def test_fiss_takes_as_long(benchmark: Any, budget: Budget) -> None:
    """With its safety rules relaxed so far that it finds a way."""
    peer = fiss(A.cars, least_time_to_collision=0.5)
    budget(against(benchmark, peer, A), "times ours", least=1.0)


@pytest.mark.parametrize("least", [0.0, None], ids=["no_time_to_collision", "no_rules"])
def test_fiss_without_rules(benchmark: Any, least: float | None) -> None:
    """For the record: less than the meter that ours keeps is what its speed then costs."""
    against(benchmark, fiss(A.cars, least_time_to_collision=least), A)
    assert benchmark.extra_info["clearance_m"] < A.clearance
