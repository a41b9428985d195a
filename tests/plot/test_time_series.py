import numpy as np
import pytest

from cca_core.plot import plot_time_series
from cca_core.sim import Log
from tests.support.paper_runs import Run

pytestmark = pytest.mark.requires("matplotlib")


def test_time_series_are_those_of_the_log(run: Run) -> None:
    waiting = run("maneuver", "2", "v2v")
    speed, steer, lateral, gap = plot_time_series(waiting).axes
    np.testing.assert_array_equal(speed.lines[0].get_ydata(), waiting.ego[:, 3])
    np.testing.assert_allclose(steer.lines[0].get_ydata(), np.degrees(waiting.ego[:, 6]))
    np.testing.assert_array_equal(lateral.lines[0].get_ydata(), waiting.a_y)
    lowest = min(np.nanmin(line.get_ydata()) for line in gap.lines[:3])
    assert lowest == pytest.approx(waiting.gaps().min())
    assert all("[" in axis.get_ylabel() for axis in (speed, steer, lateral, gap))


def test_time_series_without_other_vehicles_has_four_axes(alone: Log) -> None:
    assert len(plot_time_series(alone).axes) == 4
