"""The trials: their table lists all cases, the controls hold, broken cases are reported."""

import pytest

from tests.trials.closed_loop.episode import Episode
from tests.trials.closed_loop.families import FAMILIES
from tests.trials.faults import TABLE
from tests.trials.faults.table import Table, outcome

CONTROLS = [name for name, case in TABLE.cases.items() if case.group == "controls"]


def test_table_lists_all_cases(capsys: pytest.CaptureFixture[str]) -> None:
    assert TABLE.main("cases", ["--list"]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("  ")]
    assert [line.split()[0] for line in lines] == list(TABLE.cases)
    assert len(lines) == 69


def test_closed_loop_has_twenty_families() -> None:
    assert len(FAMILIES) == 20


def drives(seeds: range) -> list:
    """Seeds, those beyond the first three marked as slow."""
    return [pytest.param(i, marks=[pytest.mark.slow] * (i >= seeds.start + 3)) for i in seeds]


@pytest.mark.parametrize("seed", drives(range(40)))
def test_traffic_that_reacts_is_not_hit(seed: int) -> None:
    result = Episode(seed, "reacting").run()
    assert result["collision"] is None
    assert "error" not in result


@pytest.mark.parametrize(("family", "seed"), [("pedestrian", 313), ("crossing", 552)])
def test_slow_crossing_road_user_is_not_hit(family: str, seed: int) -> None:
    """They slow down, or start, where only the certified stop still clears them: comfort is no response."""
    assert Episode(seed, family).run()["collision"] is None


@pytest.mark.parametrize(
    ("family", "seed"),
    [
        pytest.param("stop_alongside", 277, id="reports-of-stopped-car-come-and-go"),
        pytest.param("cut_in", 507, id="slower-car-enters-passing-lane"),
    ],
)
def test_vehicle_ahead_is_not_hit(family: str, seed: int) -> None:
    assert Episode(seed, family).run()["collision"] is None


@pytest.mark.parametrize("name", CONTROLS)
def test_control_holds(name: str) -> None:
    result = outcome(TABLE.cases[name].checks)
    assert result.holds, result.measured


def example_table() -> Table:
    """A case that holds, one that misses its limit and one that raises."""
    table = Table()
    table.case("good", "met", "a limit that is met")(lambda: [("gap", 0.6, ">=", 0.5)])
    table.case("bad", "missed", "a limit that is missed")(lambda: [("gap", 0.4, ">=", 0.5)])
    table.case("bad", "broken", "a case that raises")(lambda: [("gap", 1.0 / 0.0, ">=", 0.5)])
    return table


def test_failing_case_is_reported(capsys: pytest.CaptureFixture[str]) -> None:
    assert example_table().main("example", []) == 2
    out = capsys.readouterr().out
    assert [line.split()[1] for line in out.splitlines() if "wanted" in line] == ["HOLDS", "FALLS", "FALLS"]
    assert "gap 0.4  |  wanted: gap >= 0.5" in out
    assert "ZeroDivisionError" in out
    assert "1 of 3 hold, 2 fall short" in out


def test_chosen_group_runs_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert example_table().main("example", ["good"]) == 0
    assert "1 of 1 hold" in capsys.readouterr().out


def test_unknown_case_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        example_table().main("example", ["nothing"])
    assert "no such case or group: nothing" in capsys.readouterr().err
