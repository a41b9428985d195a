import numpy as np
import pytest

from cca_core.plot import plot_layout
from cca_core.sim import Log, Scenario, curbside, eebl, ima
from tests.support.paper_runs import Run

pytestmark = pytest.mark.requires("matplotlib")


@pytest.mark.parametrize("scenario", [eebl("C"), ima("left-turn"), curbside("fast")], ids=lambda s: s.name)
def test_layout_names_all_vehicles(scenario: Scenario) -> None:
    (axis,) = plot_layout(scenario).axes
    texts = " ".join(text.get_text() for text in axis.texts)
    assert all(f"{user.id}:" in texts for user in scenario.road_users)
    assert "ego:" in texts


def test_layout_names_distant_vehicles_at_the_border(run: Run) -> None:
    (axis,) = plot_layout(run("maneuver", "2", "v2v").scenario).axes
    assert "A: 35 m/s, 200 m behind" in " ".join(text.get_text() for text in axis.texts)


def test_layout_distances_are_to_scale() -> None:
    scenario = eebl("C")
    (axis,) = plot_layout(scenario).axes
    bodies = sorted(patch.get_xy()[:4, 0].min() for patch in axis.patches if len(patch.get_xy()) == 5)
    wanted = [scenario.start, *sorted(user.s for user in scenario.road_users)]
    np.testing.assert_allclose(np.diff(bodies)[-2:], np.diff(wanted), atol=1e-6)


def test_layout_without_other_vehicles_has_one_axis(alone: Log) -> None:
    assert len(plot_layout(alone.scenario).axes) == 1


def test_layout_names_oncoming_vehicles(run: Run) -> None:
    (axis,) = plot_layout(run("maneuver", "3", "v2v").scenario).axes
    assert "A: 20 m/s oncoming, 846 m ahead" in " ".join(text.get_text() for text in axis.texts)
