import numpy as np
import pytest

from cca_core import InputError
from cca_core.plot import DEFECTS, fig_12, fig_15, plot_defect

pytestmark = pytest.mark.requires("matplotlib")


def lines(axis: object) -> dict[str, np.ndarray]:
    return {line.get_label(): line.get_xydata() for line in axis.lines if line.get_label()[0] != "_"}


@pytest.mark.parametrize("defect", DEFECTS)
def test_each_defect_is_drawn_with_units_and_both_bands(defect: str) -> None:
    figure = plot_defect(defect)
    figure.draw_without_rendering()
    for axis in figure.axes:
        assert axis.get_xlabel().endswith("]")
        assert axis.get_ylabel().endswith("]")
        assert axis.get_legend().get_texts()
    labels = " ".join(label for axis in figure.axes for label in lines(axis))
    titles = " ".join(axis.get_title() for axis in figure.axes)
    assert "paper" in labels + titles
    assert "relax_band" in labels + titles


def test_unknown_defect() -> None:
    with pytest.raises(InputError, match="on the path"):
        plot_defect("color")


def test_on_the_path_only_the_relaxed_band_moves() -> None:
    left, right = (lines(axis) for axis in plot_defect("on the path").axes)
    assert np.abs(left["paper, one shot"][:, 1]).max() == 0.0
    needed = right["needed"][:, 1]
    assert left["relax_band"][:, 1].max() > needed.max()
    relaxed = right["relax_band"][:, 1]
    assert (relaxed >= needed).all()
    assert (relaxed < needed + 0.1).all()
    rises = np.diff(relaxed[right["relax_band"][:, 0] <= 0.0])
    assert (rises > 0.0).all()


def test_one_shot_peak_grows_with_the_mesh_and_the_relaxed_one_does_not() -> None:
    paper, relaxed = (
        [xy[:, 1].max() for xy in lines(axis).values()] for axis in plot_defect("mesh").axes
    )  # fmt: skip
    assert paper[2] > 3.0 * paper[1] > 9.0 * paper[0]
    assert max(relaxed) < 1.02 * min(relaxed)


def test_repeated_one_shot_flips() -> None:
    curves = lines(plot_defect("iteration").axes[1])
    (flips,) = (xy[:, 1] for label, xy in curves.items() if label.startswith("paper"))
    np.testing.assert_allclose(flips[3:], flips[1:-2], atol=1e-9)
    assert np.abs(np.diff(flips)).min() > 1.0
    ((solves, _),) = (xy[0] for label, xy in curves.items() if label.startswith("relax_band"))
    assert solves < 5


def test_only_the_relaxed_band_reaches_the_clearance() -> None:
    curves = lines(plot_defect("clearance").axes[1])
    asked = curves["asked"][0, 1]
    assert (curves["paper, in balance"][:, 1] < asked).all()
    assert (curves["relax_band"][:, 1] >= asked).all()


def test_only_the_string_has_corners() -> None:
    left, right = (lines(axis) for axis in plot_defect("pins").axes)
    jumps = {label: np.abs(np.diff(xy[:, 1])).max() for label, xy in left.items()}
    assert jumps["paper, one shot"] > 3.0
    assert jumps["relax_band"] < 0.4
    paper, relaxed = (np.abs(xy[:, 1]).max() for xy in right.values())
    assert paper > 8.0 * relaxed


def test_only_the_one_shot_band_changes_its_side() -> None:
    curves = lines(plot_defect("sides").axes[1])
    assert set(np.sign(curves["paper, one shot"][:, 1])) == {-1.0, 1.0}
    assert len(set(np.sign(curves["relax_band"][:, 1]))) == 1


def test_only_one_shot_nodes_move_along_the_route() -> None:
    paper, relaxed = lines(plot_defect("clustering").axes[1]).values()
    assert np.abs(paper[:, 1]).max() > 0.05
    assert np.abs(relaxed[:, 1]).max() < 1e-9


def test_fig_12_goes_around_the_car() -> None:
    above, below = fig_12().axes
    curves = lines(above)
    apart = np.linalg.norm(curves["band"] - curves["route"], axis=1)
    assert 1.5 < apart.max() < 2.0
    assert apart[[0, -1]].max() == 0.0
    assert above.get_aspect() == 1.0
    assert "asked 1 m" in below.get_title(loc="left")


def test_fig_15_shows_the_fast_band_shorter_and_harder() -> None:
    figure = fig_15()
    place, push = (lines(axis) for axis in figure.axes)
    length = {
        name: np.ptp(xy[np.abs(xy[:, 1]) > 0.05, 0]) for name, xy in place.items() if name != "passing R1"
    }
    assert length["fast"] < 0.9 * length["smooth"]
    fast, smooth = (np.abs(xy[:, 1]).max() for xy in push.values())
    assert fast > 1.3 * smooth
    for label, peak in zip(push, (fast, smooth), strict=True):
        assert f"peak {peak:.1f} m/s²" in label
