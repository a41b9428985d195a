import numpy as np
import pytest

from cca_core import InputError
from cca_core.plot import DEFECTS, plot_defect

pytestmark = pytest.mark.requires("matplotlib")


def lines(axis: object) -> dict[str, np.ndarray]:
    return {line.get_label(): line.get_xydata() for line in axis.lines if line.get_label()[0] != "_"}


@pytest.mark.parametrize("defect", DEFECTS)
def test_defect_shows_units_and_both_bands(defect: str) -> None:
    figure = plot_defect(defect)
    figure.draw_without_rendering()
    for axis in figure.axes:
        assert axis.get_xlabel().endswith("]")
        assert axis.get_ylabel().endswith("]")
        assert axis.get_legend().get_texts()
    labels = " ".join(label for axis in figure.axes for label in lines(axis))
    titles = " ".join(axis.get_title(loc="left") for axis in figure.axes)
    assert "paper" in labels + titles
    assert "relax_band" in labels + titles


def test_unknown_defect_raises() -> None:
    with pytest.raises(InputError, match="on the path"):
        plot_defect("color")


def test_car_on_route_moves_only_the_relaxed_band() -> None:
    left, right = (lines(axis) for axis in plot_defect("on the path").axes)
    assert np.abs(left["paper, one shot"][:, 1]).max() == 0.0
    required = right["required"][:, 1]
    assert left["relax_band"][:, 1].max() > required.max()
    relaxed = right["relax_band"][:, 1]
    assert (relaxed >= required).all()
    assert (relaxed < required + 0.1).all()
    rises = np.diff(relaxed[right["relax_band"][:, 0] <= 0.0])
    assert (rises > 0.0).all()


def test_finer_mesh_changes_only_the_one_shot_peak() -> None:
    paper, relaxed = (
        [xy[:, 1].max() for xy in lines(axis).values()] for axis in plot_defect("mesh").axes
    )  # fmt: skip
    assert paper[2] > 3.0 * paper[1] > 9.0 * paper[0]
    assert max(relaxed) < 1.02 * min(relaxed)


def test_repeated_one_shot_alternates() -> None:
    curves = lines(plot_defect("iteration").axes[1])
    (flips,) = (xy[:, 1] for label, xy in curves.items() if label.startswith("paper"))
    np.testing.assert_allclose(flips[3:], flips[1:-2], atol=1e-9)
    assert np.abs(np.diff(flips)).min() > 1.0
    ((solves, _),) = (xy[0] for label, xy in curves.items() if label.startswith("relax_band"))
    assert solves < 5


def test_relaxed_band_alone_reaches_the_clearance() -> None:
    curves = lines(plot_defect("clearance").axes[1])
    limit = curves["limit"][0, 1]
    assert (curves["paper, in balance"][:, 1] < limit).all()
    assert (curves["relax_band"][:, 1] >= limit).all()


def test_one_shot_band_alone_has_corners() -> None:
    left, right = (lines(axis) for axis in plot_defect("pins").axes)
    jumps = {label: np.abs(np.diff(xy[:, 1])).max() for label, xy in left.items()}
    assert jumps["paper, one shot"] > 3.0
    assert jumps["relax_band"] < 0.4
    paper, relaxed = (np.abs(xy[:, 1]).max() for xy in right.values())
    assert paper > 8.0 * relaxed


def test_one_shot_band_alone_changes_its_side() -> None:
    curves = lines(plot_defect("sides").axes[1])
    assert set(np.sign(curves["paper, one shot"][:, 1])) == {-1.0, 1.0}
    assert len(set(np.sign(curves["relax_band"][:, 1]))) == 1


def test_one_shot_nodes_alone_move_along_the_route() -> None:
    paper, relaxed = lines(plot_defect("clustering").axes[1]).values()
    assert np.abs(paper[:, 1]).max() > 0.05
    assert np.abs(relaxed[:, 1]).max() < 1e-9
