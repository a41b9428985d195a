import numpy as np
import pytest

from cca_core import InputError
from cca_core.plot import plot_crossing
from cca_core.sim import Log, first_collision
from tests.support.paper_runs import Run

pytestmark = pytest.mark.requires("matplotlib")


@pytest.fixture(scope="module")
def crossing(run: Run) -> tuple[Log, Log]:
    return run("ima", "left-turn", "driver"), run("ima", "left-turn", "v2v")


def outline(axis: object, gid: str) -> np.ndarray:
    (patch,) = (patch for patch in axis.patches if patch.get_gid() == gid)
    return patch.get_xy()[:4]


def test_bodies_are_at_their_logged_positions(crossing: tuple[Log, Log]) -> None:
    figure = plot_crossing(crossing)
    for log, axis in zip(crossing, figure.axes[:2], strict=True):
        row = int(np.argmin(np.abs(log.t - 4.0)))
        np.testing.assert_allclose(outline(axis, "ego@4.0").mean(axis=0), log.ego[row, :2], atol=0.01)
    assert any("collision with red" in text.get_text() for text in figure.axes[0].texts)
    assert not any("collision" in text.get_text() for text in figure.axes[1].texts)


def test_runs_of_one_ego_type_are_distinct(crossing: tuple[Log, Log]) -> None:
    log = crossing[1]
    figure = plot_crossing([log, log])
    *_, below = figure.axes
    titles = [axis.get_title(loc="left") for axis in figure.axes[:2]]
    assert titles == ["Run 1, with V2V", "Run 2, with V2V"]
    egos = [line for line in below.lines if line.get_label().startswith("ego")]
    assert [line.get_label() for line in egos] == ["ego, run 1, with V2V", "ego, run 2, with V2V"]
    assert len({(line.get_color(), line.get_linestyle()) for line in egos}) == 2


def test_ego_enters_conflict_area_only_in_a_collision(crossing: tuple[Log, Log]) -> None:
    axis = plot_crossing(crossing).axes[2]
    area = axis.collections[0].get_paths()
    egos = [line for line in axis.lines if line.get_label().startswith("ego")]
    for log, ego in zip(crossing, egos, strict=True):
        np.testing.assert_array_equal(ego.get_xdata(), log.t)
        inside = any(part.contains_points(ego.get_xydata(), radius=0.5).any() for part in area)
        assert inside == (first_collision(log) is not None)


def test_crossing_without_runs_or_road_users_raises(alone: Log) -> None:
    with pytest.raises(InputError, match="at least one run"):
        plot_crossing([])
    with pytest.raises(InputError, match="other road users"):
        plot_crossing([alone])
