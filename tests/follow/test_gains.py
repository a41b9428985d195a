"""Gain design: the regions, the shipped tables, and margins that are those of the loop."""

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from cca_core.errors import InfeasibleError, InputError
from cca_core.follow import (
    PreviewGains,
    StabilityRegion,
    design_gains,
    discretized,
    gain_region,
    shipped_gains,
    single_track,
    stability_margins,
)
from cca_core.follow.bicycle import SingleTrack
from cca_core.kernel.steering import SIDESLIP_FRACTION
from cca_core.vehicle import VehicleParams

PRESETS = {
    "bmw_320i": VehicleParams.bmw_320i(),
    "ford_escort": VehicleParams.ford_escort(),
    "vw_vanagon": VehicleParams.vw_vanagon(),
}
BMW = PRESETS["bmw_320i"]
SPEEDS = [4.0, 8.0, 16.0, 25.0, 30.0, 40.0]
DELAY = 0.04


def open_loop(car: VehicleParams, gains: PreviewGains, v: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A, B and C from steering command to k_p e_y + k_d e_y', written independently: model, lag, law."""
    k_p, k_d, l_s = gains.at(v)
    model = single_track(car, v, l_s)
    A = np.block([
        [model.A, model.B[:, None]],
        [np.zeros((1, 4)), np.array([[-1.0 / car.steering_lag]])],
    ])  # fmt: skip
    B = np.array([0.0, 0.0, 0.0, 0.0, 1.0 / car.steering_lag])
    C = k_p * (np.eye(5)[3] + SIDESLIP_FRACTION * l_s * np.eye(5)[0]) + k_d * A[3]
    return A, B, C


def pade(delay: float, order: int) -> Any:
    control = pytest.importorskip("control")
    return control.ss(*control.ssdata(control.tf2ss(*control.pade(delay, order))))


@cache
def design(name: str) -> PreviewGains:
    return design_gains(PRESETS[name])


@pytest.mark.parametrize("name", PRESETS)
def test_shipped_tables_equal_design(name: str) -> None:
    shipped, made = shipped_gains(PRESETS[name]), design(name)
    assert made.speeds == shipped.speeds
    for column in ("k_p", "k_d", "l_s"):
        np.testing.assert_allclose(getattr(made, column), getattr(shipped, column), rtol=1e-3, atol=1e-9)


def test_body_and_friction_do_not_change_schedule() -> None:
    assert shipped_gains(replace(PRESETS["vw_vanagon"], length=5.5, mu=0.4)) == shipped_gains(
        PRESETS["vw_vanagon"]
    )


@pytest.mark.requires("control")
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", PRESETS)
def test_poles_of_every_vehicle_are_in_region(name: str) -> None:
    """With a Pade delay of order 4 instead of 2, at the grid speeds and in between."""
    region, gains = StabilityRegion(), shipped_gains(PRESETS[name])
    dead = pade(region.delay, 4)
    Ad, Bd, Cd, Dd = (np.asarray(m) for m in (dead.A, dead.B, dead.C, dead.D))
    grid = np.array(gains.speeds)
    for v in np.concatenate((grid, 0.5 * (grid[1:] + grid[:-1]))).tolist():
        l_s = gains.at(v)[2]
        between = v not in gains.speeds
        asked = min(region.decay, 0.5 * v / l_s) - (0.02 if between else 1e-3)
        for mass in (*region.mass, 1.1):
            for grip in (*region.friction, 0.8):
                car = PRESETS[name]
                car = replace(car, m=car.m * mass, I_z=car.I_z * mass, C_f=car.C_f * grip, C_r=car.C_r * grip)
                A, B, C = open_loop(car, gains, v)
                closed = np.block([
                    [A - np.outer(B, Dd @ C[None, :]), np.outer(B, Cd)],
                    [-np.outer(Bd, C), Ad],
                ])  # fmt: skip
                poles = np.linalg.eigvals(closed)
                assert -poles.real.max() >= asked, (v, mass, grip)
                damping = (-poles.real / np.abs(poles))[np.abs(poles) < 1.0 / region.delay]
                assert damping.min() >= region.damping - (0.03 if between else 1e-2), (v, mass, grip)


@pytest.mark.requires("control")
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("v", SPEEDS)
def test_margins_equal_python_control(name: str, v: float) -> None:
    import control

    car, gains = PRESETS[name], shipped_gains(PRESETS[name])
    margins = stability_margins(car, gains, v, delay=DELAY)
    A, B, C = open_loop(car, gains, v)
    loop = control.series(pade(DELAY, 6), control.ss(A, B[:, None], C[None, :], 0.0))
    gain, phase, _, _, crossover, _ = control.stability_margins(loop)
    assert margins.gain == pytest.approx(gain, rel=2e-3)
    assert math.degrees(margins.phase) == pytest.approx(phase, rel=2e-3)
    assert margins.crossover == pytest.approx(crossover, rel=2e-3)
    assert margins.delay == pytest.approx(math.radians(phase) / crossover, rel=3e-3)
    disk, _, _ = control.disk_margins(loop, np.geomspace(1e-2, 1e2, 3000), skew=0.0)
    assert margins.disk == pytest.approx(float(disk), rel=3e-3)


def growth(car: VehicleParams, gains: PreviewGains, v: float, delay: float, factor: float) -> float:
    """Growth rate of the linear loop [1/s], from the spectral radius with a line of held commands."""
    dt = delay / max(8, math.ceil(delay / 0.005))
    A, B, C = open_loop(car, gains, v)
    step = discretized(SingleTrack(A=A, B=B, E=np.zeros(5)), dt)
    n = round(delay / dt)
    # a command held for dt is half of dt late by itself
    M = np.zeros((5 + n, 5 + n))
    M[:5, :5], M[:5, 5 + n - 1] = step.A, step.B
    M[5, :5] = -factor * C
    M[np.arange(6, 5 + n), np.arange(5, 5 + n - 1)] = 1.0
    return math.log(np.abs(np.linalg.eigvals(M)).max()) / dt


@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("v", SPEEDS)
def test_margins_predict_onset_of_instability(name: str, v: float) -> None:
    """A delay line of held commands at 5 ms or less; stable below the margin, unstable above it."""
    car, gains = PRESETS[name], shipped_gains(PRESETS[name])
    margins = stability_margins(car, gains, v, delay=DELAY)
    assert growth(car, gains, v, DELAY, 1.0) < 0.0
    assert growth(car, gains, v, DELAY + 0.9 * margins.delay, 1.0) < 0.0
    assert growth(car, gains, v, DELAY + 1.15 * margins.delay, 1.0) > 0.0
    assert growth(car, gains, v, DELAY, 0.9 * margins.gain) < 0.0
    assert growth(car, gains, v, DELAY, 1.15 * margins.gain) > 0.0


def test_shipped_schedules_have_robust_margins() -> None:
    for car in PRESETS.values():
        for v in shipped_gains(car).speeds:
            margins = stability_margins(car, shipped_gains(car), v)
            assert margins.gain > 2.0
            assert margins.phase > math.radians(35.0)
            assert margins.disk > 0.5
            assert margins.delay > 0.1


def test_margins_have_the_delay_of_the_design_by_default() -> None:
    assert stability_margins(BMW, shipped_gains(BMW), 20.0) == stability_margins(
        BMW, shipped_gains(BMW), 20.0, delay=StabilityRegion().delay
    )


def test_unstable_loop_has_no_margin() -> None:
    """With much dead time the phase passes -180 degrees below the lowest frequency."""
    for delay in (0.5, 1.0, 2.0):
        margins = stability_margins(BMW, shipped_gains(BMW), 20.0, delay=delay)
        assert growth(BMW, shipped_gains(BMW), 20.0, delay, 1.0) > 0.0
        assert margins.delay < 0.0
        assert margins.phase < 0.0
        assert (margins.gain, margins.disk) == (0.0, 0.0)


def test_delay_reduces_margins() -> None:
    gains = shipped_gains(BMW)
    quick, slow = (stability_margins(BMW, gains, 25.0, delay=d) for d in (0.0, 0.1))
    assert slow.delay == pytest.approx(quick.delay - 0.1, abs=1e-6)
    assert slow.gain < quick.gain
    assert slow.disk < quick.disk


@pytest.mark.parametrize("v", [5.0, 20.0, 35.0])
@pytest.mark.parametrize(
    "stricter",
    [{"mass": (0.9, 1.6)}, {"friction": (0.4, 1.0)}, {"decay": 1.0}, {"damping": 0.7}],
    ids=lambda change: next(iter(change)),
)
def test_stricter_region_admits_no_new_gains(v: float, stricter: dict[str, Any]) -> None:
    loose = gain_region(BMW, v, max(v, 4.0), StabilityRegion())
    strict = gain_region(BMW, v, max(v, 4.0), replace(StabilityRegion(), **stricter))
    assert loose.admissible.any()
    assert not (strict.admissible & ~loose.admissible).any()
    assert strict.admissible.sum() <= loose.admissible.sum()


def test_selected_gains_are_admissible_and_fastest() -> None:
    region = StabilityRegion()
    found = gain_region(BMW, 20.0, 20.0, region)
    assert found.selected is not None
    at = (found.k_p == found.selected[0]) & (found.k_d == found.selected[1])
    assert found.admissible[at].all()
    assert found.decay[at][0] == found.decay[found.admissible].max()
    assert (found.decay[found.admissible] >= min(region.decay, 0.5 * 20.0 / 20.0)).all()
    assert (found.damping[found.admissible] >= region.damping).all()


def test_infeasible_design_reports_region() -> None:
    with pytest.raises(InfeasibleError, match=r"^no gains at 10 m/s with a preview of 11 m") as caught:
        design_gains(BMW, [10.0, 30.0], region=StabilityRegion(decay=0.1, damping=0.9, delay=0.5))
    assert caught.value.result.v_x == 10.0
    assert not caught.value.result.admissible.any()


def test_gains_decrease_with_delay() -> None:
    slow = design_gains(BMW, [10.0, 25.0], region=StabilityRegion(delay=0.19, damping=0.4))
    assert slow.k_p[1] < shipped_gains(BMW).at(25.0)[0]
    assert stability_margins(BMW, slow, 25.0, delay=0.19).gain > 1.5


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"decay": -0.1}, "^decay must be at least 0"),
        ({"damping": 1.1}, "^damping must be at most 1"),
        ({"delay": math.nan}, "^delay must be finite"),
        ({"mass": (1.2, 1.0)}, "^mass must be a pair of factors"),
        ({"friction": (0.0, 1.0)}, "^friction must be a pair of factors"),
        ({"friction": (1.0,)}, "^friction must be a pair of factors"),
        ({"mass": 1.2}, "^mass must be a pair of factors"),
        ({"mass": (1800.0, 2500.0)}, "^mass must be a pair of factors .* at most 10"),
        ({"mass": (1.0, "heavy")}, "^mass must be a real number"),
    ],
)
def test_invalid_region_raises(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        StabilityRegion(**changes)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [({"speeds": [0.0]}, "^speeds must"), ({"preview_time": 0.0}, "^preview_time must"),
     ({"min_preview": -1.0}, "^min_preview must"), ({"speeds": 20.0}, "^speeds must have shape"),
     ({"speeds": []}, "^speeds must not be empty"), ({"speeds": BMW}, "^speeds must")],
)  # fmt: skip
def test_invalid_design_input_raises(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        design_gains(BMW, **{"speeds": [10.0], **arguments})


def test_design_rejects_swapped_arguments() -> None:
    with pytest.raises(InputError, match=r"^vehicle must be VehicleParams, was list"):
        design_gains([10.0], BMW)  # type: ignore[arg-type]


def test_invalid_margin_input_raises() -> None:
    for arguments, word in (({"v_x": 0.0}, "v_x"), ({"v_x": 9.0, "delay": -1.0}, "delay")):
        with pytest.raises(InputError, match=f"^{word} must"):
            stability_margins(BMW, shipped_gains(BMW), **arguments)


def test_design_accepts_steering_without_lag() -> None:
    quick = replace(BMW, steering_lag=0.0)
    gains, nearly = (design_gains(replace(BMW, steering_lag=lag), [10.0, 30.0]) for lag in (0.0, 2e-3))
    np.testing.assert_allclose(gains.k_p, nearly.k_p, rtol=0.3)
    for car in (quick, replace(BMW, steering_lag=1e-12)):
        found = stability_margins(car, gains, 30.0)
        assert 0.5 < found.phase < 1.6
        assert found.gain > stability_margins(BMW, gains, 30.0).gain  # what lags has less of it


def test_longer_preview_lowers_gains() -> None:
    brisk, calm = (design_gains(BMW, [10.0, 30.0], preview_time=time) for time in (0.9, 1.6))
    assert (np.array(calm.k_p) < 0.8 * np.array(brisk.k_p)).all()
