"""Measure the paper's Table 1 and write docs/table1.md, its rows and its figures; called by `make table1`.

An interrupted run continues: its rows are in out/table1.sqlite. With ``--page`` nothing is measured: page and
figures are written from the rows in docs/table1.
"""

import argparse
import os
import platform
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from cca_core._optional import require_extra
from cca_core.baselines.problems.compare import ComparisonRow, compare
from cca_core.baselines.problems.sampling import KINDS, sample_problem
from cca_core.baselines.table1.closed_loop import ClosedLoop, drive_closed
from cca_core.baselines.table1.csv_rows import read_rows, write_rows
from cca_core.baselines.table1.experiment import AXES, methods, planners, scaling_points
from cca_core.baselines.table1.page import main_table, page
from cca_core.baselines.table1.scaling import ScalingResult, measure_scaling
from cca_core.baselines.table1.statistics import Statistics
from cca_core.plot.comparison import plot_scaling, plot_time_quality
from cca_core.sim import paper_scenarios
from cca_core.sim.study.source import source_digest
from cca_core.sim.study.store import Store

FILES: dict[str, type[Any]] = {
    "plans.csv": ComparisonRow, "scaling.csv": ScalingResult, "drives.csv": ClosedLoop
}  # fmt: skip


def main() -> int:
    """Measure, and write the page."""
    parser = argparse.ArgumentParser(prog="python -m cca_core.baselines.table1", description=__doc__)
    parser.add_argument("--docs", type=Path, default=Path("docs"), help="folder of the page")
    parser.add_argument(
        "--out", type=Path, default=Path("out"), help="folder of the rows of an unfinished run"
    )
    parser.add_argument("--page", action="store_true", help="write the page from the rows in docs")
    given = parser.parse_args()
    (given.docs / "table1").mkdir(parents=True, exist_ok=True)
    if not given.page:
        given.out.mkdir(parents=True, exist_ok=True)
        unfinished = given.out / "table1.sqlite"
        with Store(unfinished, source_digest()) as store:
            measured = measure(store)
        for name, rows in zip(FILES, measured, strict=True):
            write_rows(given.docs / "table1" / name, rows)
        today = datetime.now(tz=UTC).date()
        versions = f"Python {platform.python_version()}, sources {source_digest()[:12]}"
        text = f"Measured on {today}: {_processor()}, {versions}.\n"
        (given.docs / "table1" / "measured.txt").write_text(text, encoding="utf-8")
        unfinished.unlink()
    sys.stdout.write(write(given.docs) + "\n")
    return 0


def measure(store: Store) -> tuple[list[Any], ...]:
    """Return plans, scaling and drives; measure what is missing in the store."""
    begun = time.perf_counter()
    cores = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else [None]
    core = cores[-1]

    def report(line: str) -> None:
        sys.stdout.write(f"{time.perf_counter() - begun:5.0f} s  {line}\n")
        sys.stdout.flush()

    rows = compare(
        methods(), [sample_problem(kind, seed) for kind in KINDS for seed in range(1, 21)],
        store=store, core=core,
        progress=lambda r: report(f"{r.method}: {r.kind} {r.seed}: {r.outcome}") if r.seed == 20 else None,
    )  # fmt: skip
    scaling = measure_scaling(
        scaling_points(), store=store, core=core,
        progress=lambda r: report(f"{r.method}: {r.axis} {r.value:g}: {r.time_ms:.1f} ms"),
    )  # fmt: skip
    if core is not None:
        os.sched_setaffinity(0, {core})
    drives = drive_closed(
        planners(),
        [s for s in paper_scenarios() if s.name == "maneuver" and s.v2v and s.case != "1-smooth"],
        store=store,
        progress=lambda d: report(f"{d.planner}: maneuver {d.case}: {d.cycle_us:.0f} us per cycle"),
    )
    return rows, scaling, drives


def write(docs: Path) -> str:
    """Write page and figures from the rows in docs/table1; return the main table."""
    folder = docs / "table1"
    rows, scaling, drives = (read_rows(folder / name, kind) for name, kind in FILES.items())
    measured = (folder / "measured.txt").read_text(encoding="utf-8").strip()
    (docs / "table1.md").write_text(page(rows, scaling, drives, measured=measured), encoding="utf-8")
    with require_extra("matplotlib", "plot").rc_context(
        {"svg.hashsalt": "table1"}
    ):  # equal rows, equal files
        plot_time_quality(rows).savefig(folder / "quality.svg", metadata={"Date": None})
        plot_scaling(scaling, AXES).savefig(folder / "scaling.svg", metadata={"Date": None})
    return main_table(Statistics(rows))


def _processor() -> str:
    """Name of the processor."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{names[0] if names else platform.processor() or platform.machine()}, one core"


if __name__ == "__main__":
    sys.exit(main())
