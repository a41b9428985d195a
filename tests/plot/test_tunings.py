import numpy as np
import pytest

from cca_core import InputError
from cca_core.plot import plot_tunings
from tests.support.paper_runs import Run

pytestmark = pytest.mark.requires("matplotlib")


def test_tunings_show_both_paths_of_the_log(run: Run) -> None:
    runs = run("maneuver", "1-fast", "v2v"), run("maneuver", "1-smooth", "v2v")
    (axis,) = plot_tunings(*runs).axes
    curves = [line for line in axis.lines if len(line.get_xdata()) == len(runs[0].t)]
    for log, curve in zip(runs, curves, strict=True):
        np.testing.assert_array_equal(curve.get_xydata(), log.ego_frenet)
        assert f"{np.abs(log.a_y).max():.2f} m/s" in curve.get_label()


def test_tunings_without_lane_change_raises(run: Run) -> None:
    with pytest.raises(InputError, match="leaves its lane"):
        plot_tunings(run("maneuver", "1-fast", "v2v"), run("maneuver", "2", "sensor"))
