import math

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from cca_core import InputError, VehicleParams
from cca_core.follow import StabilityRegion, gain_region, shipped_gains, stability_margins
from cca_core.plot import plot_gain_region, plot_margins

pytestmark = pytest.mark.requires("matplotlib")

CAR = VehicleParams.bmw_320i()
GAINS = shipped_gains(CAR)


@pytest.mark.parametrize("v", [5.0, 20.0])
def test_region_marks_selected_and_scheduled_gains(v: float) -> None:
    found = gain_region(CAR, v, max(v, 4.0), StabilityRegion())
    (axis,) = plot_gain_region(found, GAINS).axes
    points = {line.get_label(): line.get_xydata() for line in axis.lines}
    np.testing.assert_allclose(points["selected"], [found.selected])
    np.testing.assert_allclose(points["schedule"], [GAINS.at(v)[:2]])
    low, high = axis.get_xlim()
    assert low <= found.selected[0] <= high
    assert "[rad/m]" in axis.get_xlabel()
    assert f"{v:g} m/s" in axis.get_title(loc="left")


def test_region_without_admissible_gains() -> None:
    found = gain_region(CAR, 20.0, 20.0, StabilityRegion(damping=1.0, delay=0.5))
    assert found.selected is None
    (axis,) = plot_gain_region(found).axes
    assert "selected" not in {line.get_label() for line in axis.lines}


@pytest.mark.parametrize("region", [CAR, StabilityRegion(), None])
def test_region_of_another_type_names_the_function_that_makes_it(region: object) -> None:
    with pytest.raises(InputError, match=r"^region must be a GainRegion, the result of gain_region, was "):
        plot_gain_region(region)  # type: ignore[arg-type]


def test_schedule_of_another_type_raises() -> None:
    found = gain_region(CAR, 20.0, 20.0, StabilityRegion(damping=1.0, delay=0.5))
    with pytest.raises(InputError, match=r"^shipped must be PreviewGains, was 20\.0"):
        plot_gain_region(found, 20.0)  # type: ignore[arg-type]


def test_margins_are_shown_over_speed() -> None:
    margins = [stability_margins(CAR, GAINS, v) for v in GAINS.speeds]
    gain, phase, delay, disk = plot_margins(margins).axes
    assert all("[" in axis.get_ylabel() for axis in (gain, phase, delay, disk))
    np.testing.assert_array_equal(gain.lines[0].get_xdata(), GAINS.speeds)
    np.testing.assert_array_equal(disk.lines[0].get_ydata(), [m.disk for m in margins])
    np.testing.assert_allclose(phase.lines[0].get_ydata(), [math.degrees(m.phase) for m in margins])


def test_edge_of_admissible_gains_is_smooth() -> None:
    region = gain_region(VehicleParams.bmw_320i(), 20.0, 22.0, StabilityRegion())
    area = plot_gain_region(region).axes[0].collections[0].get_paths()[0]
    edge = area.to_polygons()[0] / [region.k_p.max(), region.k_d.max()]
    hull = edge[ConvexHull(edge).vertices]
    perimeter, shortest = (np.hypot(*np.diff(np.vstack((p, p[:1])), axis=0).T).sum() for p in (edge, hull))
    assert perimeter < 1.05 * shortest
