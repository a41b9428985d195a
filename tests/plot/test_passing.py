import numpy as np
import pytest

from cca_core import InputError
from cca_core.plot import plot_passing
from cca_core.sim import Log
from tests.support.paper_runs import Run

pytestmark = pytest.mark.requires("matplotlib")


@pytest.fixture(scope="module")
def passing(run: Run) -> tuple[Log, Log]:
    return run("curbside", "fast", "driver"), run("curbside", "fast", "v2v")


def test_paths_are_those_of_the_log(passing: tuple[Log, Log]) -> None:
    *strips, paths, lateral = plot_passing(passing, "red", outcomes=["collides", "passes"]).axes
    assert len(strips) == 2
    for log in passing:
        label = {"driver": "driver without V2V", "v2v": "with V2V"}[log.scenario.ego_type]
        line = next(line for line in paths.lines if line.get_label() == label)
        s, d = line.get_xydata().T
        red = log.user_frenet[-1, 1, 0]
        np.testing.assert_allclose(np.interp(s + red, *log.ego_frenet.T), d, atol=1e-6)
        assert f"{label}: {np.abs(log.a_y).max():.1f} m/s²" in {each.get_label() for each in lateral.lines}
    assert strips[0].get_aspect() == 1.0
    assert strips[0].get_title(loc="left") == "Driver without V2V: collides"


def test_runs_of_one_ego_type_are_distinct(passing: tuple[Log, Log]) -> None:
    log = passing[1]
    figure = plot_passing([log, log], "red")
    *_, paths, lateral = figure.axes
    titles = [axis.get_title(loc="left") for axis in figure.axes[:2]]
    assert titles == ["Run 1, with V2V", "Run 2, with V2V"]
    for axis in (paths, lateral):
        lines = [line for line in axis.lines if "V2V" in line.get_label()]
        assert len({(line.get_color(), line.get_linestyle()) for line in lines}) == 2


def test_passing_without_runs_raises() -> None:
    with pytest.raises(InputError, match="at least one run"):
        plot_passing([], "red")


def test_passing_unknown_obstacle_raises(passing: tuple[Log, Log]) -> None:
    with pytest.raises(InputError, match="obstacle_id must be one of yellow, red, was 'blue'"):
        plot_passing(passing, "blue")
