"""Path tracking: paths, delay, noise and true errors."""

import math

import numpy as np
import pytest

from cca_core import InputError, Path, PreviewController, VehicleParams, VehicleState
from cca_core.sim import SingleTrackPlant, lane_change_path, track_path

CAR = VehicleParams.bmw_320i()
LINE = Path([0.0, 400.0], [[[0, 0, 400, 0], [0, 0, 0, 0]]])


def plant(v_x: float = 20.0, y: float = 0.0) -> SingleTrackPlant:
    return SingleTrackPlant(CAR, VehicleState(x=0.0, y=y, psi=0.0, v_x=v_x))


def straight_on(state: VehicleState, path: Path) -> float:
    return 0.0


@pytest.mark.parametrize(("width", "length"), [(3.5, 44.0), (3.5, 60.0), (-3.0, 50.0)])
def test_lane_change_path_is_quintic(width: float, length: float) -> None:
    path = lane_change_path(width, length)
    s = np.arange(path.start, path.end, 0.1)
    xy = path.position(s)
    share = np.clip((xy[:, 0] - 80.0) / length, 0.0, 1.0)
    np.testing.assert_allclose(
        xy[:, 1], width * share**3 * (10.0 - 15.0 * share + 6.0 * share**2), rtol=0.0, atol=1e-3
    )
    assert np.abs(path.curvature(s)).max() == pytest.approx(5.7735 * abs(width) / length**2, rel=0.03)
    assert path.position(path.end)[1] == pytest.approx(width)
    assert float(path.heading(path.end)) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [((math.nan, 50.0, 80.0, 150.0), "width"), ((3.5, 0.0, 80.0, 150.0), "length"),
     ((3.5, 50.0, -1.0, 150.0), "before"), ((3.5, 50.0, 80.0, 0.0), "after")],
)  # fmt: skip
def test_invalid_lane_change_raises(arguments: tuple[float, float, float, float], name: str) -> None:
    width, length, before, after = arguments
    with pytest.raises(InputError, match=f"^{name} must"):
        lane_change_path(width, length, before=before, after=after)


def test_error_is_lateral_offset() -> None:
    run = track_path(plant(y=0.7), straight_on, LINE, 20.0)
    assert run.finished
    np.testing.assert_allclose(run.d, 0.7, atol=1e-9)
    assert run.peak == pytest.approx(0.7)
    assert run.rms == pytest.approx(0.7)
    assert run.s[0] == pytest.approx(0.0, abs=1e-9)
    assert run.s[-1] == pytest.approx(340.0, abs=0.41)


def test_run_that_leaves_path_is_unfinished() -> None:
    curve = lane_change_path(30.0, 80.0)
    run = track_path(plant(), straight_on, curve, 20.0)
    assert not run.finished
    assert run.peak == run.rms == math.inf
    assert np.abs(run.d).max() < 6.0


def test_delay_is_dead_time() -> None:
    """The wheels begin to turn after as many cycles."""

    def turn(state: VehicleState, path: Path) -> float:
        return 0.01

    begins = [
        int(np.argmax(track_path(plant(), turn, LINE, 20.0, delay=delay, margin=350.0).delta > 0.0))
        for delay in (0.0, 0.1, 0.2)
    ]
    assert begins == [1, 6, 11]


def test_noise_affects_controller_not_metrics() -> None:
    estimates: list[float] = []

    def steer(state: VehicleState, path: Path) -> float:
        estimates.append(state.y)
        return 0.0

    run = track_path(plant(), steer, LINE, 20.0, fix_sigma=0.2)
    assert run.peak < 1e-9
    assert 0.01 < np.std(estimates) < 0.2
    first = list(estimates)
    estimates.clear()
    track_path(plant(), steer, LINE, 20.0, fix_sigma=0.2)
    assert estimates == first  # the same seed
    estimates.clear()
    track_path(plant(), steer, LINE, 20.0, fix_sigma=0.2, seed=2)
    assert estimates != first


def test_speed_profile_is_followed() -> None:
    """v^2 falls from 400 to 100 over 150 m: 1 m/s^2."""
    s = np.array([0.0, 100.0, 250.0, 500.0])
    squared = np.array([400.0, 400.0, 100.0, 100.0])
    car = plant()
    run = track_path(car, PreviewController(CAR).steer, LINE, (s, squared))
    assert run.finished
    assert car.state.v_x == pytest.approx(10.0, abs=0.3)


def test_run_is_repeatable() -> None:
    one, two = (
        track_path(plant(), PreviewController(CAR).steer, lane_change_path(3.5, 60.0), 20.0) for _ in range(2)
    )
    np.testing.assert_array_equal(one.d, two.d)
    np.testing.assert_array_equal(one.delta, two.delta)


@pytest.mark.parametrize("name", ["delay", "fix_sigma", "margin"])
def test_invalid_argument_raises(name: str) -> None:
    with pytest.raises(InputError, match=f"^{name} must be at least 0"):
        track_path(plant(), straight_on, LINE, 20.0, **{name: -1.0})
