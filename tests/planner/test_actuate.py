"""Acceleration along a plan: as planned, and all that the tires give where less may not be enough."""

from dataclasses import replace

import numpy as np
import pytest

from cca_core import VehicleParams
from cca_core.follow import SpeedSettings
from cca_core.planner import EvasionSettings
from cca_core.planner.actuate import planned_acceleration
from cca_core.planner.certificate import Certificate, Grade
from cca_core.planner.limits import Limits, limits_of
from cca_core.planner.records import DrivenPlan
from cca_core.planner.scene import TIMES
from cca_core.vehicle import GRAVITY
from tests.support.driven_plan import plan

CAR = VehicleParams.bmw_320i()
CYCLE = 0.02


def limits_on(mu: float) -> tuple[Limits, float]:
    """Limits on a road, and the friction coefficient."""
    return limits_of(replace(CAR, mu=mu), SpeedSettings(), EvasionSettings()), mu


def ramp(grade: Grade, limits: Limits) -> DrivenPlan:
    """A plan that begins to brake fully at the jerk of emergencies."""
    a = np.maximum(-limits.jerk_emergency * (TIMES - TIMES[0] + TIMES[1]), -limits.b_max)
    return replace(plan(), a=a, a_0=0.0, certificate=Certificate(grade=grade))


def driven(plan: DrivenPlan, limits: Limits, mu: float) -> np.ndarray:
    """Accelerations of the cycles of the first second."""
    times = np.arange(0.0, 1.0, CYCLE).tolist()
    return np.array([planned_acceleration(plan, t, 20.0, 0.0, limits, mu) for t in times])


@pytest.mark.parametrize("mu", [0.3, 0.6, 1.0])
@pytest.mark.parametrize("grade", [Grade.RESPONSE, Grade.NOMINAL, Grade.SEVERITY, Grade.REFUSED])
def test_full_braking_builds_up_without_delay_to_all_grip(grade: Grade, mu: float) -> None:
    limits, mu = limits_on(mu)
    a_x = driven(ramp(grade, limits), limits, mu)
    change = np.diff(a_x)
    steepest = limits.jerk_emergency * CYCLE
    full = -min(SpeedSettings().b_max, mu * GRAVITY)
    assert a_x[-1] == pytest.approx(full)
    assert (change <= 1e-9).all()
    assert change.min() >= -2.0 * steepest
    # as soon as a ramp at that jerk
    assert np.count_nonzero(a_x > full + 1e-9) * CYCLE <= -full / limits.jerk_emergency + 2.0 * CYCLE


@pytest.mark.parametrize("grade", [Grade.COMFORTABLE, Grade.FULL])
def test_certified_plan_keeps_its_reserve_of_grip(grade: Grade) -> None:
    limits, mu = limits_on(0.6)
    assert driven(ramp(grade, limits), limits, mu).min() == pytest.approx(-limits.b_max)
    assert limits.b_max == pytest.approx(0.98 * mu * GRAVITY)


@pytest.mark.parametrize("grade", Grade)
def test_gentle_braking_is_that_of_the_plan(grade: Grade) -> None:
    limits, mu = limits_on(0.9)
    gentle = replace(plan(), a=np.maximum(-3.0 * TIMES, -2.0), certificate=Certificate(grade=grade))
    expected = np.interp(np.arange(0.0, 1.0, CYCLE), TIMES, np.concatenate(([0.0], gentle.a[:-1])))
    np.testing.assert_allclose(driven(gentle, limits, mu), expected, atol=1e-12)


def test_stationary_ego_only_holds_its_brakes() -> None:
    limits, mu = limits_on(0.9)
    assert planned_acceleration(plan(a=-5.0), 0.5, 0.0, 0.0, limits, mu) == -1.0
