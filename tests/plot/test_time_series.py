from dataclasses import replace

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


def nearer(log: Log, gap: float) -> Log:
    """The run, with the first road user to come as near as `gap` [m], alongside and standing by."""
    users, frenet = log.road_users.copy(), log.user_frenet.copy()
    across = 0.5 * (log.scenario.vehicle.width + log.scenario.road_users[0].width) + gap
    users[:, 0], frenet[:, 0] = log.ego[:, :4], log.ego_frenet
    users[:, 0, :2] += across * np.column_stack((-np.sin(log.ego[:, 2]), np.cos(log.ego[:, 2])))
    return replace(log, road_users=users, user_frenet=frenet)


@pytest.mark.parametrize(("gap", "text"), [(0.013, "0.01 m"), (1.94, "1.9 m"), (12.3, "12.3 m")])
def test_smallest_gap_is_legible(run: Run, gap: float, text: str) -> None:
    """A gap of 1 cm and one of 2 m differ by more than a line is wide, and their numbers are given."""
    log = nearer(run("eebl", "C", "v2v"), gap)
    axis = panels(log)["gap between"]
    assert [each.get_text() for each in axis.texts] == [text]
    low, high = axis.get_ylim()
    assert low < 0.0
    assert max(10.0, 5.0 * gap) < high < max(12.0, 10.0 * gap)
    (mark,) = [line for line in axis.lines if line.get_marker() == "o"]
    assert mark.get_ydata()[0] == pytest.approx(log.gaps().min(), abs=1e-6)
    assert mark.get_ydata()[0] == pytest.approx(gap, abs=0.01)


def test_smallest_gap_of_a_collision_is_zero(run: Run) -> None:
    (text,) = panels(run("eebl", "A", "driver"))["gap between"].texts
    assert text.get_text() == "0.00 m"
