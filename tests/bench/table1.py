"""Measure the paper's Table 1: run all methods on all problems and write docs/table1.md. `make table1`.

Resumable: what an interrupted run has measured stays in out/table1 until the page is written.
"""

import os
import platform
import shutil
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from cca_core.baselines import (
    LinearMpc,
    MotionPrimitives,
    MpcPlanner,
    MpcSettings,
    NonlinearMpc,
    OneShotBand,
    RelaxedBand,
    Rrt,
    SmoothedBand,
)
from cca_core.baselines.closed_loop import ClosedLoop, drive_closed
from cca_core.baselines.compare import ComparisonRow, compare
from cca_core.baselines.sampled_problems import KINDS, parked, sample_problem
from cca_core.baselines.scaling import ScalingPoint, ScalingResult, measure_scaling
from cca_core.plot.comparison import plot_growth, plot_time_quality
from cca_core.sim import Scenario, paper_scenarios
from cca_core.sim.loop import make_planner
from tests.bench.fiss_method import INSTALLED, Fiss
from tests.bench.table1_numbers import AXES, SEEDS
from tests.bench.table1_page import page

ROOT = Path(__file__).resolve().parents[2]
FILES = "plans.csv", "growth.csv", "drives.csv"
OUT, DOCS = ROOT / "out" / "table1", ROOT / "docs"
TREE = 40_000  # samples of a random tree: half a second or so
METHODS: dict[str, Callable[[], Any]] = {
    "band, eq 9": OneShotBand,
    "band, relaxed": RelaxedBand,
    "band, QP": SmoothedBand,
    "primitives": MotionPrimitives,
    "RRT": partial(Rrt, variant="rrt", iterations=TREE, time_limit=8.0),
    "RRT*": partial(Rrt, variant="rrt_star", iterations=TREE, time_limit=8.0),
    "LTV MPC": LinearMpc,
    "NMPC, FATROP": partial(NonlinearMpc, MpcSettings(solver="fatrop")),
    "NMPC, IPOPT": NonlinearMpc,
}
if INSTALLED:
    METHODS["FISS"] = Fiss


def predictive(method: Any, solver: Any, scenario: Scenario) -> MpcPlanner:
    return MpcPlanner(
        scenario.vehicle, scenario.road, cruise_speed=scenario.cruise_speed, method=method,
        settings=MpcSettings(solver=solver), speed=scenario.speed,
    )  # fmt: skip


PLANNERS: dict[str, Callable[[Scenario], Any]] = {
    "band": make_planner,
    "LTV MPC": partial(predictive, "linear", "ipopt"),
    "NMPC, FATROP": partial(predictive, "nonlinear", "fatrop"),
    "NMPC, IPOPT": partial(predictive, "nonlinear", "ipopt"),
}


def steps() -> list[ScalingPoint]:
    """What grows: nodes over 120 m, meters at the same spacing, and cars on 300 m."""
    nodes, meters, cars = AXES
    found = []

    def add(axis: str, value: float, length: float, others: int, n: int) -> None:
        spacing = length / value if axis == nodes else 1.0
        made: dict[str, Callable[[], Any]] = {
            "band, relaxed": partial(RelaxedBand, spacing=spacing),
            "band, QP": partial(SmoothedBand, spacing=spacing),
            "LTV MPC": partial(LinearMpc, MpcSettings(intervals=n)),
            "NMPC, FATROP": partial(NonlinearMpc, MpcSettings(intervals=n, solver="fatrop")),
        }
        if axis != nodes:
            made |= {name: METHODS[name] for name in METHODS if name in ("primitives", "RRT", "FISS")}
        elif value <= 60:
            made["primitives"] = partial(MotionPrimitives, step=length / 20.0 / value)
        for name, make in made.items():
            found.append(
                ScalingPoint(method=name, axis=axis, value=value, make=make, problem=parked(others, length))
            )

    for n in (30, 60, 120):
        add(nodes, n, 120.0, 1, n)
    for length in (100.0, 200.0, 400.0):
        add(meters, length, length, 1, round(length / 4.0))
    for others in (1, 2, 4, 6):
        add(cars, others, 300.0, others, 75)
    example = sample_problem("one car", 1).problem
    for seed in range(1, 11):
        tree = partial(Rrt, variant="rrt", seed=seed, iterations=TREE, time_limit=8.0)
        found.append(ScalingPoint(method="RRT", axis=SEEDS, value=seed, make=tree, problem=example))
    return found


def main() -> int:
    """Measure what is not measured yet, then write the page and its pictures."""
    begun = time.perf_counter()
    cores = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else [None]
    core = cores[-1]

    def told(line: str) -> None:
        sys.stdout.write(f"{time.perf_counter() - begun:5.0f} s  {line}\n")
        sys.stdout.flush()

    problems = [sample_problem(kind, seed) for kind in KINDS for seed in range(1, 21)]
    rows = compare(
        METHODS, problems, out=OUT / "plans.csv", core=core,
        progress=lambda r: told(f"{r.method}: {r.kind} {r.seed}: {r.outcome}") if r.seed == 20 else None,
    )  # fmt: skip
    growth = measure_scaling(
        steps(), out=OUT / "growth.csv", core=core,
        progress=lambda g: told(f"{g.method}: {g.axis} {g.value:g}: {g.time_ms:.1f} ms"),
    )  # fmt: skip
    scenarios = [s for s in paper_scenarios() if s.name == "maneuver" and s.v2v and s.case != "1-smooth"]
    if core is not None:
        os.sched_setaffinity(0, {core})
    drives = drive_closed(
        PLANNERS, scenarios, out=OUT / "drives.csv",
        progress=lambda d: told(f"{d.planner}: maneuvering {d.case}: {d.cycle_us:.0f} us a cycle"),
    )  # fmt: skip
    folder = DOCS / "table1"
    folder.mkdir(exist_ok=True)
    sys.stdout.write(write(rows, growth, drives) + "\n")
    for name in FILES:
        shutil.move(OUT / name, folder / name)
    told(f"wrote {DOCS / 'table1.md'}")
    return 0


def write(rows: list[ComparisonRow], growth: list[ScalingResult], drives: list[ClosedLoop]) -> str:
    """Write page and pictures; return the main table."""
    machine = f"{_processor()}, Python {platform.python_version()}"
    text, table = page(rows, growth, drives, machine=machine, modules=ROOT / "cca_core")
    (DOCS / "table1.md").write_text(text, encoding="utf-8")
    for name, figure in (
        ("quality.svg", plot_time_quality(rows)), ("growth.svg", plot_growth(growth, AXES)),
    ):  # fmt: skip
        figure.savefig(DOCS / "table1" / name, metadata={"Date": None})
    return table


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{names[0] if names else platform.processor() or platform.machine()}, one core"


if __name__ == "__main__":
    sys.exit(main())
