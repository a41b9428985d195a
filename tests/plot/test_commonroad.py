"""The figure of a run in a recorded world shows the bodies at their positions."""

from pathlib import Path

import numpy as np
import pytest

from cca_core import InputError
from cca_core.sim.commonroad.drive import drive_commonroad
from cca_core.sim.commonroad.read import read_commonroad
from tests.support.commonroad_files import REGION, ROAD, document, goal, moving, problem, state, written

pytestmark = pytest.mark.requires("matplotlib")


def test_boxes_are_at_the_recorded_positions(tmp_path: Path) -> None:
    from cca_core.plot.commonroad import plot_commonroad

    car = moving(31, [state("state", k, 40.0 + 1.2 * k, 3.5, 12.0) for k in range(5, 21)])
    task = problem(goal((80, 100), REGION.format(y=0.0)))
    run = drive_commonroad(read_commonroad(written(tmp_path, document(ROAD, car, task))))
    figure = plot_commonroad(run, times=[0.0, 1.0, 3.0])
    shown = {p.get_gid(): p.get_xy() for axis in figure.axes for p in axis.patches if p.get_gid()}
    assert sorted(shown) == ["31@2", "ego@1", "ego@2", "ego@3"]  # the car is there from 0.5 s to 2.0 s
    np.testing.assert_allclose(shown["31@2"][:4].mean(axis=0), (52.0, 3.5))
    np.testing.assert_allclose(shown["ego@3"][:4].mean(axis=0), run.ego[150, :2])
    assert len(plot_commonroad(run).axes) == 4
    with pytest.raises(InputError, match="times"):
        plot_commonroad(run, times=[])
