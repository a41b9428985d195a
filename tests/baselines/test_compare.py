"""The harness: every outcome is a row, interrupted runs go on, and what fails does not stop the rest."""

import dataclasses
import math
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, Status
from cca_core.baselines import OneShotBand, RelaxedBand, SmoothedBand
from cca_core.baselines.problems.compare import ComparisonRow, compare
from cca_core.baselines.problems.csv_rows import append_row, read_rows
from cca_core.baselines.problems.problem import Problem
from cca_core.baselines.problems.sampling import parked, sample_problem
from cca_core.baselines.problems.verify import verify_plan
from cca_core.baselines.table1.closed_loop import ClosedLoop, drive_closed
from cca_core.baselines.table1.scaling import ScalingPoint, measure_scaling
from cca_core.plot.comparison import plot_growth, plot_plans, plot_time_quality
from cca_core.sim import paper_scenarios
from cca_core.sim.loop import make_planner
from tests.support.misbehaving_methods import CannotBeMade, Dies, Empty, Hangs, Raises, Straight
from tests.support.table1_problems import BLOCKED, CASES, SLALOM
from tests.support.table1_problems import judge as independent

TWO = [sample_problem("one car", 1), sample_problem("blocked", 1)]
BANDS = pytest.mark.parametrize(
    "method",
    [RelaxedBand(), pytest.param(SmoothedBand(), marks=pytest.mark.requires("piqp"))],
    ids=["relaxed", "QP"],
)


@BANDS
@pytest.mark.parametrize("task", [*CASES.values(), SLALOM], ids=[*CASES, "slalom"])
def test_a_band_keeps_limits_and_clearance(method: Any, task: Problem) -> None:
    plan = method.plan(task)
    assert plan.status is Status.OK
    gap, edge = independent(task, plan)
    assert gap >= task.clearance - 5e-3
    assert edge >= -5e-3
    assert verify_plan(task, plan).passed


@BANDS
def test_a_band_refuses_a_blocked_road(method: Any) -> None:
    plan = method.plan(BLOCKED)
    assert plan.status is Status.INFEASIBLE
    assert plan.message
    assert not len(plan.t)


def test_eq_9_as_printed_bends_away_and_knows_no_failure() -> None:
    plans = [OneShotBand().plan(sample_problem("one car", seed).problem) for seed in range(1, 6)]
    assert all(plan.status is Status.OK for plan in plans)
    assert max(np.abs(plan.xy[:, 1]).max() for plan in plans) > 1.0
    assert OneShotBand().plan(BLOCKED).status is Status.OK


@pytest.mark.parametrize(
    ("make", "name"),
    [(partial(OneShotBand, spacing=0.0), "spacing"), (partial(OneShotBand, ratio=-1.0), "ratio"),
     (partial(RelaxedBand, spacing=math.nan), "spacing"), (partial(SmoothedBand, spacing=-1.0), "spacing")],
)  # fmt: skip
def test_bad_settings(make: Any, name: str) -> None:
    with pytest.raises(InputError, match=f"^{name} must"):
        make()


def test_every_outcome_is_a_row_and_an_interrupted_run_goes_on(tmp_path: Path) -> None:
    out = tmp_path / "new" / "rows.csv"
    methods = {"band": RelaxedBand, "straight": Straight}
    seen: list[ComparisonRow] = []
    first = compare({"band": RelaxedBand}, TWO, out=out, progress=seen.append)
    assert [row.outcome for row in first] == ["solved", "rightly refused"]
    assert first == seen
    out.write_bytes(out.read_bytes() + b"straight,one car,1,solv")  # interrupted while it was written
    seen.clear()
    rows = compare(methods, TWO, out=out, progress=seen.append)
    assert [row.outcome for row in rows] == ["solved", "rightly refused", "false OK", "false OK"]
    assert [row.method for row in seen] == ["straight", "straight"]
    assert "clearance -" in rows[2].message
    assert rows[2].driven_clearance < 0.0 < rows[0].driven_clearance
    assert 0.0 < rows[0].time_ms < 1000.0
    assert math.isnan(rows[1].length)
    seen.clear()
    again = compare(methods, TWO, out=out, progress=seen.append)
    assert not seen
    assert [dataclasses.astuple(row)[:4] for row in again] == [dataclasses.astuple(row)[:4] for row in rows]
    assert len(out.read_text().splitlines()) == 5


@pytest.mark.parametrize(
    ("make", "outcome", "words"),
    [(Raises, "ERROR", "of its own"), (Dies, "ERROR", "ended"), (CannotBeMade, "ERROR", "no license"),
     (Empty, "false OK", "no trajectory")],
)  # fmt: skip
def test_a_failing_method_is_an_entry(make: Any, outcome: str, words: str, tmp_path: Path) -> None:
    rows = compare({"bad": make, "good": RelaxedBand}, TWO[:1], out=tmp_path / "rows.csv")
    assert [row.outcome for row in rows] == [outcome, "solved"]
    assert words in rows[0].message


def test_a_hanging_method_is_stopped(tmp_path: Path) -> None:
    begun = time.perf_counter()
    rows = compare({"bad": Hangs}, TWO, out=tmp_path / "rows.csv", limit=0.5)
    assert [row.outcome for row in rows] == ["TIMEOUT", "TIMEOUT"]
    assert time.perf_counter() - begun < 30.0


def test_rows_are_the_same_when_read_again(tmp_path: Path) -> None:
    row = ComparisonRow(
        method="a, b",
        kind="one car",
        seed=3,
        outcome="solved",
        message="two\nlines",
        length=1.5,
        finished=True,
    )
    append_row(tmp_path / "rows.csv", row)
    (again,) = read_rows(tmp_path / "rows.csv", ComparisonRow)
    assert again.method == "a, b"
    assert again.message == "two lines"
    assert again.finished is True
    assert again.seed == 3
    assert again.length == 1.5
    assert math.isnan(again.clearance)
    assert read_rows(tmp_path / "none.csv", ComparisonRow) == []
    (tmp_path / "other.csv").write_text("method,seed\na,1\n")
    assert read_rows(tmp_path / "other.csv", ComparisonRow) == []


@pytest.mark.requires("matplotlib")
def test_growth_is_timed_and_kept(tmp_path: Path) -> None:
    steps = [
        ScalingPoint(method="band", axis="cars", value=n, make=RelaxedBand, problem=parked(n, 200.0))
        for n in (1, 2)
    ] + [ScalingPoint(method="bad", axis="cars", value=1, make=Raises, problem=parked(1, 200.0))]
    found = measure_scaling(steps, out=tmp_path / "growth.csv")
    assert [r.status[:5] for r in found] == ["OK", "OK", "ERROR"]
    assert found[0].peak > 1.0
    assert found[0].time_ms > 0.0
    assert math.isnan(found[2].time_ms)
    seen: list[Any] = []
    measure_scaling(steps, out=tmp_path / "growth.csv", progress=seen.append)
    assert not seen
    assert plot_growth(found[:2], ["cars"]).axes


def test_closed_loop_is_measured_and_kept(tmp_path: Path) -> None:
    whole = next(s for s in paper_scenarios() if s.name == "maneuver" and s.case == "1-fast")
    short, out = dataclasses.replace(whole, duration=2.0), tmp_path / "drives.csv"
    (drive,) = drive_closed({"band": make_planner}, [short], out=out)
    assert drive.planner == "band"
    assert not drive.completed
    assert math.isnan(drive.time)
    assert drive.clearance > 10.0
    assert 0.0 < drive.cycle_us <= drive.p99_us <= drive.worst_us
    seen: list[ClosedLoop] = []
    (again,) = drive_closed({"band": make_planner}, [short], out=out, progress=seen.append)
    assert not seen
    assert again.completed is False


@pytest.mark.requires("matplotlib")
def test_figures_show_every_method() -> None:
    measured = {"time_ms": 2.0, "driven_jerk": 9.0}
    rows = [
        ComparisonRow(method=m, kind=k, seed=1, outcome=o, **measured)  # type: ignore[arg-type]
        for m, k, o in (
            ("a", "one car", "solved"),
            ("a", "blocked", "rightly refused"),
            ("b", "one car", "refused"),
        )
    ]
    figure = plot_time_quality(rows)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["a", "b"]
    heights = [
        line.get_ydata()[0] for line in figure.axes[0].get_lines() if line.get_marker() not in ("None", "")
    ]
    assert heights == [100.0, 0.0]
    task = CASES["oncoming"]
    axis = plot_plans(task, {"band": RelaxedBand().plan(task), "none": RelaxedBand().plan(BLOCKED)})
    assert len(axis.patches) >= 3
    assert next(iter(axis.get_lines())).get_label() == "band"
