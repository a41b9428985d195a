"""Dead reckoning with fixes: less error than the fixes, heading from drift, and an honest variance."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cca_core.errors import InputError
from cca_core.follow import PoseEstimator
from cca_core.vehicle import VehicleState

DT, SIGMA = 0.02, 0.1


def circle(t: float, v: float = 20.0, r: float = 0.1) -> VehicleState:
    """On a circle to the left, without sideslip."""
    psi = r * t
    return VehicleState(x=v / r * math.sin(psi), y=v / r * (1.0 - math.cos(psi)), psi=psi, v_x=v, r=r)


def run(
    seed: int, *, heading: float = 0.0, bias: float = 0.0, seconds: float = 20.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors of the estimate (along and across), of the heading, and of the fixes."""
    rng = np.random.default_rng(seed)
    estimator = PoseEstimator(replace(circle(0.0), psi=heading), fix_sigma=SIGMA)
    estimated, headings, fixes = [], [], []
    for k in range(1, round(seconds / DT)):
        true = circle(k * DT)
        now = estimator.predict(replace(circle((k - 0.5) * DT), r=true.r + bias), DT)
        if k % 5 == 0:
            x, y = rng.normal((true.x, true.y), SIGMA)
            now = estimator.correct(float(x), float(y))
            fixes.append((x - true.x, y - true.y))
        estimated.append((now.x - true.x, now.y - true.y))
        headings.append(math.remainder(now.psi - true.psi, 2.0 * math.pi))
    return np.array(estimated), np.array(headings), np.array(fixes)


@pytest.mark.parametrize("seed", range(5))
def test_estimate_has_less_error_than_fixes(seed: int) -> None:
    estimated, headings, fixes = run(seed)
    assert np.sqrt(np.mean(estimated**2)) < 0.6 * np.sqrt(np.mean(fixes**2))
    assert np.abs(headings[250:]).max() < 0.01


def test_wrong_heading_is_corrected_from_drift() -> None:
    _, headings, _ = run(1, heading=0.02)
    assert abs(headings[0]) > 0.019
    assert np.abs(headings[250:]).max() < 0.01


def test_biased_yaw_rate_keeps_error_bounded() -> None:
    """0.1 deg/s: over 20 s that is 2 degrees, and 7 m sideways, without fixes."""
    estimated, headings, _ = run(1, bias=math.radians(0.1))
    assert np.abs(headings).max() < 0.02
    assert np.abs(estimated).max() < 0.35


def test_standard_deviations_are_consistent() -> None:
    """Errors are sampled as the filter assumes: their square over its variance is 1 on average."""
    rng, ratios = np.random.default_rng(3), []
    for _ in range(60):
        state = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=20.0)
        estimator = PoseEstimator(
            replace(state, x=rng.normal(0.0, SIGMA), y=rng.normal(0.0, SIGMA), psi=rng.normal(0.0, 0.01)),
            fix_sigma=SIGMA, position_drift=0.02, heading_drift=0.002,
        )  # fmt: skip
        x = y = psi = 0.0  # truth: the random walk that the filter assumes
        for k in range(1, 301):
            psi += rng.normal(0.0, 0.002 * math.sqrt(DT))
            x += 20.0 * DT * math.cos(psi) + rng.normal(0.0, 0.02 * math.sqrt(DT))
            y += 20.0 * DT * math.sin(psi) + rng.normal(0.0, 0.02 * math.sqrt(DT))
            estimator.predict(state, DT)
            if k % 5 == 0:
                estimator.correct(x + rng.normal(0.0, SIGMA), y + rng.normal(0.0, SIGMA))
        now = estimator.state
        errors = np.array((now.x - x, now.y - y, now.psi - psi))
        ratios.append((errors / estimator.standard_deviations) ** 2)
    assert np.mean(ratios, axis=0) == pytest.approx([1.0, 1.0, 1.0], abs=0.55)  # 60 samples: sd 0.18


def test_fix_that_is_not_finite_is_ignored() -> None:
    estimator = PoseEstimator(circle(0.0))
    before = estimator.predict(circle(0.0), DT)
    for x, y in ((math.nan, 0.0), (0.0, math.inf), (math.nan, math.nan)):
        assert estimator.correct(x, y) == before


def test_without_fixes_estimate_is_dead_reckoned() -> None:
    estimator = PoseEstimator(circle(0.0))
    for k in range(500):
        now = estimator.predict(circle((k + 0.5) * DT), DT)
    true = circle(10.0)
    assert (now.x, now.y, now.psi) == pytest.approx((true.x, true.y, true.psi), abs=2e-3)


def test_other_measurements_pass_unchanged() -> None:
    measured = VehicleState(x=9.0, y=9.0, psi=1.0, v_x=11.0, v_y=0.2, r=0.1, delta=0.03, a_x=-1.0)
    now = PoseEstimator(circle(0.0)).predict(measured, DT)
    assert (now.v_x, now.v_y, now.r, now.delta, now.a_x) == (11.0, 0.2, 0.1, 0.03, -1.0)
    assert abs(now.x) < 1.0


@pytest.mark.parametrize("name", ["fix_sigma", "position_drift", "heading_drift"])
def test_invalid_estimator_input_raises(name: str) -> None:
    with pytest.raises(InputError, match=f"^{name} must be greater than 0"):
        PoseEstimator(circle(0.0), **{name: 0.0})


def test_repr_contains_pose_and_standard_deviations() -> None:
    estimator = PoseEstimator(VehicleState(x=1.0, y=2.0, psi=0.5, v_x=10.0), fix_sigma=0.2)
    assert repr(estimator) == (
        "PoseEstimator(x=1.00 m, y=2.00 m, psi=0.500 rad, standard deviations 0.20 m and 0.0100 rad)"
    )
