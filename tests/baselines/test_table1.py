"""Table 1: scaling, closed loop, rows as files, the page."""

import dataclasses
import math
import sys
from pathlib import Path
from typing import Any

import pytest

from cca_core.baselines import ComparisonRow, RelaxedBand
from cca_core.baselines.problems.sampling import KINDS, parked
from cca_core.baselines.table1.__main__ import main
from cca_core.baselines.table1.closed_loop import ClosedLoop, drive_closed
from cca_core.baselines.table1.csv_rows import read_rows, write_rows
from cca_core.baselines.table1.experiment import methods, planners, scaling_points
from cca_core.baselines.table1.page import page
from cca_core.baselines.table1.scaling import ScalingPoint, ScalingResult, measure_scaling
from cca_core.plot.comparison import plot_plans, plot_scaling, plot_time_quality
from cca_core.sim import paper_scenarios
from cca_core.sim.loop import make_planner
from cca_core.sim.study.store import Store
from tests.support.misbehaving_methods import Raises
from tests.support.table1_problems import BLOCKED, CASES

ROOT = Path(__file__).resolve().parents[2]
ROWS = ROOT / "docs" / "table1"


def test_csv_rows_are_read_as_written(tmp_path: Path) -> None:
    row = ComparisonRow(
        method="a, b",
        kind="one car",
        seed=3,
        outcome="solved",
        message="two\nlines",
        length=1.5,
        finished=True,
    )
    write_rows(tmp_path / "rows.csv", [row, row])
    again, _ = read_rows(tmp_path / "rows.csv", ComparisonRow)
    assert again.message == "two lines"
    assert math.isnan(again.clearance)
    assert (again.method, again.seed, again.length, again.finished) == ("a, b", 3, 1.5, True)


@pytest.mark.requires("matplotlib")
def test_scaling_is_timed_once(tmp_path: Path) -> None:
    points = [
        ScalingPoint(method="band", axis="cars", value=1, make=RelaxedBand, problem=parked(1, 200.0)),
        ScalingPoint(method="bad", axis="cars", value=1, make=Raises, problem=parked(1, 200.0)),
    ]
    with Store(tmp_path / "rows.sqlite", "test") as store:
        found = measure_scaling(points, store=store)
        again: list[Any] = []
        measure_scaling(points, store=store, progress=again.append)
    assert not again
    assert [r.status[:5] for r in found] == ["OK", "ERROR"]
    assert found[0].peak > 1.0
    assert found[0].time_ms > 0.0
    assert math.isnan(found[1].time_ms)
    assert plot_scaling(found[:1], ["cars"]).axes


def test_closed_loop_is_measured_once(tmp_path: Path) -> None:
    whole = next(s for s in paper_scenarios() if s.name == "maneuver" and s.case == "1-fast")
    short = dataclasses.replace(whole, duration=2.0)
    with Store(tmp_path / "rows.sqlite", "test") as store:
        (drive,) = drive_closed({"band": make_planner}, [short], store=store)
        again: list[ClosedLoop] = []
        drive_closed({"band": make_planner}, [short], store=store, progress=again.append)
    assert not again
    assert drive.planner == "band"
    assert not drive.completed
    assert math.isnan(drive.time)
    assert drive.clearance > 10.0
    assert 0.0 < drive.cycle_us <= drive.p99_us <= drive.worst_us


@pytest.mark.requires("casadi", "piqp", "ompl")
def test_experiment_names_are_those_of_the_stored_rows() -> None:
    rows = read_rows(ROWS / "plans.csv", ComparisonRow)
    scaling = read_rows(ROWS / "scaling.csv", ScalingResult)
    drives = read_rows(ROWS / "drives.csv", ClosedLoop)
    assert {r.method for r in rows} - {"FISS"} == set(methods()) - {"FISS"}
    assert {r.kind for r in rows} == set(KINDS)
    assert {(r.method, r.axis, r.value) for r in scaling if r.method != "FISS"} == {
        (p.method, p.axis, p.value) for p in scaling_points() if p.method != "FISS"
    }
    assert {d.planner for d in drives} == set(planners())


def test_page_is_written_from_stored_rows() -> None:
    """The page in docs is what its rows give, but for the lines of code of the methods."""
    text = page(
        read_rows(ROWS / "plans.csv", ComparisonRow), read_rows(ROWS / "scaling.csv", ScalingResult),
        read_rows(ROWS / "drives.csv", ClosedLoop), measured=(ROWS / "measured.txt").read_text().strip(),
    )  # fmt: skip
    stored = (ROOT / "docs" / "table1.md").read_text(encoding="utf-8")

    def comparable(text: str) -> list[str]:
        return [line for line in text.splitlines() if "lines of code" not in line.lower()]

    assert comparable(text) == comparable(stored)


@pytest.mark.requires("matplotlib")
def test_command_writes_page_and_figures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "table1").mkdir()
    for file in (*ROWS.glob("*.csv"), ROWS / "measured.txt"):
        (tmp_path / "table1" / file.name).write_bytes(file.read_bytes())
    monkeypatch.setattr(sys, "argv", ["table1", "--page", "--docs", str(tmp_path)])
    assert main() == 0
    assert "## Results" in (tmp_path / "table1.md").read_text(encoding="utf-8")
    assert {f.name for f in (tmp_path / "table1").glob("*.svg")} == {"quality.svg", "scaling.svg"}


@pytest.mark.requires("matplotlib")
def test_figures_show_every_method() -> None:
    figures = {"time_ms": 2.0, "driven_jerk": 9.0}
    rows = [
        ComparisonRow(method=m, kind=k, seed=1, outcome=o, **figures)  # type: ignore[arg-type]
        for m, k, o in (
            ("a", "one car", "solved"), ("a", "blocked", "rightly refused"), ("b", "one car", "refused")
        )
    ]  # fmt: skip
    figure = plot_time_quality(rows)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["a", "b"]
    heights = [
        line.get_ydata()[0] for line in figure.axes[0].get_lines() if line.get_marker() not in ("None", "")
    ]
    assert heights == [100.0, 0.0]
    problem = CASES["oncoming"]
    axis = plot_plans(problem, {"band": RelaxedBand().plan(problem), "none": RelaxedBand().plan(BLOCKED)})
    assert len(axis.patches) >= 3
    assert next(iter(axis.get_lines())).get_label() == "band"
