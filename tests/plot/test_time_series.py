import numpy as np
import pytest

from cca_core.plot import plot_time_series
from cca_core.sim import Log
from tests.support.paper_runs import Run

pytestmark = pytest.mark.requires("matplotlib")


def panels(log: Log) -> dict[str, object]:
    return {axis.get_ylabel().split("\n")[0]: axis for axis in plot_time_series(log).axes}


def test_time_series_are_those_of_the_log(run: Run) -> None:
    waiting = run("maneuver", "2", "v2v")
    shown = panels(waiting)
    np.testing.assert_array_equal(shown["speed"].lines[0].get_ydata(), waiting.ego[:, 3])
    np.testing.assert_array_equal(shown["acceleration"].lines[1].get_ydata(), waiting.ego[:, 7])
    np.testing.assert_allclose(shown["road-wheel"].lines[0].get_ydata(), np.degrees(waiting.ego[:, 6]))
    np.testing.assert_array_equal(shown["lateral acc."].lines[0].get_ydata(), waiting.a_y)
    lowest = min(np.nanmin(line.get_ydata()) for line in shown["gap between"].lines[:3])
    assert lowest == pytest.approx(waiting.gaps().min())


def test_no_panel_is_empty(run: Run, alone: Log) -> None:
    for straight in (run("eebl", "C", "v2v"), run("curbside", "fast", "driver")):
        assert "lateral acc." not in panels(straight)
    assert {"gap between", "time to"}.isdisjoint(panels(alone))
    for log in (run("ima", "left-turn", "v2v"), run("curbside", "slow", "driver")):
        for axis in list(panels(log).values())[1:]:
            low, high = axis.get_ylim()
            assert any(((line.get_ydata() > low) & (line.get_ydata() < high)).any() for line in axis.lines)


def test_time_to_collision_of_a_crossing_is_named(run: Run) -> None:
    axis = panels(run("ima", "left-turn", "driver"))["time to"]
    assert axis.get_legend_handles_labels()[1] == ["crossing"]
    assert np.nanmin(axis.lines[0].get_ydata()) < 0.2


def test_change_of_the_lead_vehicle_is_no_jump_of_a_speed(run: Run) -> None:
    lead = panels(run("curbside", "fast", "v2v"))["speed"].lines[1].get_ydata()
    steps = np.abs(np.diff(lead))
    assert np.nanmax(steps) < 2.0
    assert {0.0, 25.0} <= set(np.round(lead[np.isfinite(lead)], 1))
