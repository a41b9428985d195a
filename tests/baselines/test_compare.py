"""The comparison: every outcome is a row, an interrupted run continues, a failing method stops nothing."""

import dataclasses
import math
from pathlib import Path
from typing import Any

import pytest

from cca_core.baselines import ComparisonRow, RelaxedBand, compare, sample_problem
from cca_core.sim.study.store import Store
from tests.support.misbehaving_methods import CannotBeMade, Dies, Empty, Hangs, Raises, Straight

TWO = [sample_problem("one car", 1), sample_problem("blocked", 1)]


def test_rows_name_every_outcome_and_are_measured_once(tmp_path: Path) -> None:
    """A second run with one more method measures only that one."""
    methods = {"band": RelaxedBand, "straight": Straight}
    new: list[ComparisonRow] = []
    with Store(tmp_path / "rows.sqlite", "test") as store:
        first = compare({"band": RelaxedBand}, TWO, store=store, progress=new.append)
    assert [row.outcome for row in first] == ["solved", "rightly refused"]
    assert new == first
    new.clear()
    with Store(tmp_path / "rows.sqlite", "test") as store:
        rows = compare(methods, TWO, store=store, progress=new.append)
    assert [row.outcome for row in rows] == ["solved", "rightly refused", "false OK", "false OK"]
    assert new == rows[2:]
    assert [dataclasses.astuple(row)[:4] for row in rows[:2]] == [dataclasses.astuple(r)[:4] for r in first]
    assert rows[0] == first[0]
    assert "clearance -" in rows[2].message
    assert rows[2].driven_clearance < 0.0 < rows[0].driven_clearance
    assert rows[0].time_ms > 0.0
    assert math.isnan(rows[1].length)


@pytest.mark.parametrize(
    ("make", "outcome", "words"),
    [
        pytest.param(Raises, "ERROR", "ValueError", id="raises"),
        pytest.param(Dies, "ERROR", "ended", id="process ends", marks=pytest.mark.slow),
        pytest.param(CannotBeMade, "ERROR", "no license", id="cannot be made", marks=pytest.mark.slow),
        pytest.param(Empty, "false OK", "no trajectory", id="empty plan", marks=pytest.mark.slow),
    ],
)
def test_failing_method_is_a_row(make: Any, outcome: str, words: str) -> None:
    rows = compare({"bad": make, "good": RelaxedBand}, TWO[:1])
    assert [row.outcome for row in rows] == [outcome, "solved"]
    assert words in rows[0].message


def test_hanging_method_is_stopped() -> None:
    rows = compare({"bad": Hangs}, TWO[:1], limit=0.1)
    assert [row.outcome for row in rows] == ["TIMEOUT"]
