import numpy as np
import pytest

from cca_core.plot import fig_12, fig_15

pytestmark = pytest.mark.requires("matplotlib")


def lines(axis: object) -> dict[str, np.ndarray]:
    return {line.get_label(): line.get_xydata() for line in axis.lines if line.get_label()[0] != "_"}


def test_fig_12_band_passes_the_car() -> None:
    above, below = fig_12().axes
    curves = lines(above)
    offset = np.linalg.norm(curves["band"] - curves["route"], axis=1)
    assert 1.5 < offset.max() < 2.0
    assert offset[[0, -1]].max() == 0.0
    assert above.get_aspect() == 1.0
    assert "limit 1.00 m" in below.get_title(loc="left")


def test_fig_15_fast_band_is_shorter_and_harder() -> None:
    figure = fig_15()
    offset, lateral = (lines(axis) for axis in figure.axes)
    length = {
        name: np.ptp(xy[np.abs(xy[:, 1]) > 0.05, 0]) for name, xy in offset.items() if name != "passing R1"
    }
    assert length["fast"] < 0.9 * length["smooth"]
    fast, smooth = (np.abs(xy[:, 1]).max() for xy in lateral.values())
    assert fast > 1.3 * smooth
    for label, peak in zip(lateral, (fast, smooth), strict=True):
        assert f"peak {peak:.1f} m/s²" in label
