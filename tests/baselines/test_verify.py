"""Verification: closed forms, an independent measurement, the proofs of all problems; driven plans."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, Status
from cca_core.baselines import MotionPrimitives, Plan, Problem, RelaxedBand
from cca_core.baselines.problems.drive import drive_plan
from cca_core.baselines.problems.sampling import KINDS, parked, sample_problem
from cca_core.baselines.problems.verify import Tolerances, count_reversals, max_jerk, verify_plan
from tests.support import table1_problems as independent
from tests.support.misbehaving_methods import Straight
from tests.support.table1_problems import CAR, CASES, problem, road


def plan_at(given: Problem, d: Any = 0.0, v: float | None = None, end: float | None = None) -> Plan:
    """Plan at lateral offsets d(s), at constant speed."""
    s = np.linspace(given.start, given.goal if end is None else end, 400)
    xy = given.road.path.to_cartesian(s, d(s) if callable(d) else np.full(len(s), d))
    speed = given.v_x if v is None else v
    return Plan(status=Status.OK, t=(s - s[0]) / speed, xy=xy, v_x=np.full(len(s), speed))


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "blocked"])
def test_every_solvable_problem_has_proof(kind: Any) -> None:
    for seed in range(1, 21):
        sampled = sample_problem(kind, seed)
        assert sampled.problem.solvable
        assert sampled.proof is not None
        found = verify_plan(sampled.problem, sampled.proof, Tolerances(distance=0.01, a_y=0.0))
        assert found.passed, (seed, found.violations)
        assert found.a_y < 0.95 * sampled.problem.a_y_max


@pytest.mark.parametrize(
    "seed", [seed if seed < 4 else pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 21)]
)
def test_blocked_problems_have_no_quintic_solution(seed: int) -> None:
    """Quintic shifts to any offset at the largest lateral acceleration from the start all fail."""
    sampled = sample_problem("blocked", seed)
    assert sampled.proof is None
    assert not sampled.problem.solvable
    given = sampled.problem
    for offset in np.linspace(-0.9, 4.4, 28).tolist():
        length = given.v_x * math.sqrt(5.7735 * max(abs(offset), 0.1) / given.a_y_max)

        def shift(s: Any, offset: float = offset, length: float = length, goal: float = given.goal) -> Any:
            out = np.clip(s / length, 0.0, 1.0)
            back = np.clip((goal - s) / length, 0.0, 1.0)
            tau = np.minimum(out, back)
            return offset * tau**3 * (10.0 - 15.0 * tau + 6.0 * tau**2)

        assert verify_plan(given, plan_at(given, shift)).clearance < given.clearance - 0.05


def test_equal_seeds_give_equal_problems() -> None:
    one, again, other = (sample_problem("moving", seed).problem for seed in (3, 3, 4))
    assert one.others == again.others
    assert (one.v_x, one.goal) == (again.v_x, again.goal)
    assert one.others != other.others
    with pytest.raises(InputError, match=r"^kind must be one of"):
        sample_problem("other", 1)  # type: ignore[arg-type]


def test_parked_cars_are_solvable() -> None:
    given = parked(4, 400.0)
    assert len(given.others) == 4
    assert RelaxedBand().plan(given).status is Status.OK


@pytest.mark.parametrize("d", [-0.4, 0.0, 2.0])
def test_clearance_alongside_is_difference_of_offsets(d: float) -> None:
    given = problem([(60.0, 3.5 if d < 1.0 else -0.7, 0.0)])
    found = verify_plan(given, plan_at(given, d))
    wide = abs((3.5 if d < 1.0 else -0.7) - d) - 1.8
    assert found.clearance == pytest.approx(wide, abs=1e-6)
    assert found.edge == pytest.approx(min(5.25 - d, d + 1.75) - 0.9, abs=1e-6)


@pytest.mark.parametrize("radius", [150.0, -150.0])
def test_lateral_acceleration_on_curve(radius: float) -> None:
    given = problem([], on=road(radius), v_x=20.0)
    found = verify_plan(given, plan_at(given))
    assert found.a_y == pytest.approx(400.0 / 150.0, rel=5e-3)
    assert found.a_y_reversals == 0
    assert found.length == pytest.approx(120.0, rel=1e-3)


def test_jerk_and_reversals_of_sine() -> None:
    t = np.linspace(0.0, 4.0, 4001)
    a_y = 3.0 * np.sin(0.5 * np.pi * t)
    assert max_jerk(t, a_y) == pytest.approx(3.0 * 0.5 * np.pi, rel=5e-3)
    assert count_reversals(a_y) == 1
    assert count_reversals(0.1 * a_y) == 0


def test_each_violation_is_named() -> None:
    given = CASES["stationary"]
    straight = verify_plan(given, plan_at(given))
    assert any("clearance -" in violation for violation in straight.violations)
    empty = problem([])
    assert verify_plan(empty, plan_at(empty)).passed
    cases = {
        "over the edge": plan_at(empty, -1.2), "start": plan_at(empty, 0.3), "speed": plan_at(empty, v=25.0),
        "before the goal": plan_at(empty, end=90.0),
        "a_y": plan_at(empty, lambda s: 1.0 - np.cos(2.0 * np.pi * s / 40.0)),
    }  # fmt: skip
    for name, plan in cases.items():
        found = verify_plan(empty, plan)
        assert any(name in violation for violation in found.violations), (name, found.violations)


def test_malformed_trajectories_are_violations() -> None:
    given, plan = problem([]), plan_at(problem([]))
    broken = plan.xy.copy()
    broken[7] = math.nan
    for wrong in (
        Plan(status=Status.OK), replace(plan, t=plan.t[::-1]), replace(plan, t=plan.t + 1.0),
        replace(plan, xy=broken), replace(plan, t=100.0 * plan.t), replace(plan, t=0.0 * plan.t),
    ):  # fmt: skip
        assert verify_plan(given, wrong).violations == ("no trajectory",)


@pytest.mark.parametrize("name", CASES)
def test_verification_agrees_with_independent_measurement(name: str) -> None:
    given = CASES[name]
    plan = MotionPrimitives().plan(given)
    gap, edge = independent.measured_distances(given, plan)
    found = verify_plan(given, plan)
    assert found.passed
    assert found.clearance == pytest.approx(gap, abs=0.01)
    assert found.edge == pytest.approx(edge, abs=0.01)


def test_straight_plan_is_driven_straight() -> None:
    given = problem([(60.0, 3.5, 0.0)])
    driven = drive_plan(given, plan_at(given))
    assert driven.finished
    assert driven.tracking < 1e-6
    assert driven.a_y < 1e-6
    assert driven.clearance == pytest.approx(1.7, abs=1e-6)
    assert driven.xy[-1, 0] == pytest.approx(120.0, abs=0.5)


def test_plan_through_car_ends_in_collision() -> None:
    given = CASES["stationary"]
    assert drive_plan(given, Straight().plan(given)).clearance < -1.0


def test_drive_starts_on_route_for_any_plan() -> None:
    given = problem([])
    driven = drive_plan(given, plan_at(given, 0.8))
    np.testing.assert_allclose(driven.xy[0], (0.0, 0.0), atol=1e-9)
    assert driven.tracking == pytest.approx(0.8, abs=0.01)


def test_verification_uses_vehicle_of_problem() -> None:
    """A wider car has less clearance on the same plan."""
    given = CASES["stationary"]
    plan = RelaxedBand().plan(given)
    wider = replace(given, vehicle=replace(CAR, width=2.2))
    assert verify_plan(wider, plan).clearance == pytest.approx(
        verify_plan(given, plan).clearance - 0.2, abs=0.02
    )
