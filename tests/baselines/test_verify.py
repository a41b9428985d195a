"""The judge: closed forms, an independent one, and the proofs of all problems."""

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


def along(task: Problem, d: Any = 0.0, v: float | None = None, end: float | None = None) -> Plan:
    """A plan at lateral coordinates d(s), at constant speed."""
    s = np.linspace(task.start, task.goal if end is None else end, 400)
    xy = task.road.path.to_cartesian(s, d(s) if callable(d) else np.full(len(s), d))
    speed = task.v_x if v is None else v
    return Plan(status=Status.OK, t=(s - s[0]) / speed, xy=xy, v_x=np.full(len(s), speed))


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "blocked"])
def test_every_solvable_problem_has_a_proof(kind: Any) -> None:
    for seed in range(1, 21):
        drawn = sample_problem(kind, seed)
        assert drawn.problem.solvable
        assert drawn.proof is not None
        verdict = verify_plan(drawn.problem, drawn.proof, Tolerances(distance=0.01, a_y=0.0))
        assert verdict.passed, (seed, verdict.violations)
        assert verdict.a_y < 0.95 * drawn.problem.a_y_max


def test_blocked_problems_have_no_quintic_solution() -> None:
    """Quintic shifts to any offset at full lateral acceleration, begun at once, all fail."""
    for seed in range(1, 21):
        drawn = sample_problem("blocked", seed)
        assert drawn.proof is None
        assert not drawn.problem.solvable
        task = drawn.problem
        for offset in np.linspace(-0.9, 4.4, 28).tolist():
            length = task.v_x * math.sqrt(5.7735 * max(abs(offset), 0.1) / task.a_y_max)

            def shift(s: Any, offset: float = offset, length: float = length, goal: float = task.goal) -> Any:
                out = np.clip(s / length, 0.0, 1.0)
                back = np.clip((goal - s) / length, 0.0, 1.0)
                tau = np.minimum(out, back)
                return offset * tau**3 * (10.0 - 15.0 * tau + 6.0 * tau**2)

            assert verify_plan(task, along(task, shift)).clearance < task.clearance - 0.05


def test_equal_seeds_equal_problems() -> None:
    one, again, other = (sample_problem("moving", seed).problem for seed in (3, 3, 4))
    assert one.others == again.others
    assert (one.v_x, one.goal) == (again.v_x, again.goal)
    assert one.others != other.others
    with pytest.raises(InputError, match=r"^kind must be one of"):
        sample_problem("other", 1)  # type: ignore[arg-type]


def test_parked_cars_leave_a_way() -> None:
    task = parked(4, 400.0)
    assert len(task.others) == 4
    assert RelaxedBand().plan(task).status is Status.OK


@pytest.mark.parametrize("d", [-0.4, 0.0, 2.0])
def test_clearance_beside_a_car_is_the_difference_of_offsets(d: float) -> None:
    task = problem([(60.0, 3.5 if d < 1.0 else -0.7, 0.0)])
    verdict = verify_plan(task, along(task, d))
    wide = abs((3.5 if d < 1.0 else -0.7) - d) - 1.8
    assert verdict.clearance == pytest.approx(wide, abs=1e-6)
    assert verdict.edge == pytest.approx(min(5.25 - d, d + 1.75) - 0.9, abs=1e-6)


@pytest.mark.parametrize("radius", [150.0, -150.0])
def test_lateral_acceleration_in_a_bend(radius: float) -> None:
    task = problem([], on=road(radius), v_x=20.0)
    verdict = verify_plan(task, along(task))
    assert verdict.a_y == pytest.approx(400.0 / 150.0, rel=5e-3)
    assert verdict.a_y_reversals == 0
    assert verdict.length == pytest.approx(120.0, rel=1e-3)


def test_jerk_and_swings_of_a_sine() -> None:
    t = np.linspace(0.0, 4.0, 4001)
    a_y = 3.0 * np.sin(0.5 * np.pi * t)
    assert max_jerk(t, a_y) == pytest.approx(3.0 * 0.5 * np.pi, rel=5e-3)
    assert count_reversals(a_y) == 1
    assert count_reversals(0.1 * a_y) == 0


def test_each_fault_is_named() -> None:
    task = CASES["stationary"]
    straight = verify_plan(task, along(task))
    assert any("clearance -" in fault for fault in straight.violations)
    empty = problem([])
    assert verify_plan(empty, along(empty)).passed
    cases = {
        "over the edge": along(empty, -1.2), "start": along(empty, 0.3), "speed": along(empty, v=25.0),
        "before the goal": along(empty, end=90.0),
        "a_y": along(empty, lambda s: 1.0 - np.cos(2.0 * np.pi * s / 40.0)),
    }  # fmt: skip
    for name, plan in cases.items():
        verdict = verify_plan(empty, plan)
        assert any(name in fault for fault in verdict.violations), (name, verdict.violations)


def test_malformed_trajectories_are_violations() -> None:
    task, plan = problem([]), along(problem([]))
    broken = plan.xy.copy()
    broken[7] = math.nan
    for wrong in (
        Plan(status=Status.OK), replace(plan, t=plan.t[::-1]), replace(plan, t=plan.t + 1.0),
        replace(plan, xy=broken), replace(plan, t=100.0 * plan.t), replace(plan, t=0.0 * plan.t),
    ):  # fmt: skip
        assert verify_plan(task, wrong).violations == ("no trajectory",)


@pytest.mark.parametrize("name", CASES)
def test_agrees_with_an_independent_judge(name: str) -> None:
    task = CASES[name]
    plan = MotionPrimitives().plan(task)
    gap, edge = independent.measured_distances(task, plan)
    verdict = verify_plan(task, plan)
    assert verdict.passed
    assert verdict.clearance == pytest.approx(gap, abs=0.01)
    assert verdict.edge == pytest.approx(edge, abs=0.01)


def test_a_straight_plan_is_driven_straight() -> None:
    task = problem([(60.0, 3.5, 0.0)])
    driven = drive_plan(task, along(task))
    assert driven.finished
    assert driven.tracking < 1e-6
    assert driven.a_y < 1e-6
    assert driven.clearance == pytest.approx(1.7, abs=1e-6)
    assert driven.xy[-1, 0] == pytest.approx(120.0, abs=0.5)


def test_a_plan_through_a_car_ends_in_contact() -> None:
    task = CASES["stationary"]
    assert drive_plan(task, Straight().plan(task)).clearance < -1.0


def test_a_drive_begins_on_the_route_whatever_the_plan_says() -> None:
    task = problem([])
    driven = drive_plan(task, along(task, 0.8))
    np.testing.assert_allclose(driven.xy[0], (0.0, 0.0), atol=1e-9)
    assert driven.tracking == pytest.approx(0.8, abs=0.01)


def test_the_car_is_that_of_the_problem() -> None:
    """In a wider car the same plan leaves less room."""
    task = CASES["stationary"]
    plan = RelaxedBand().plan(task)
    wider = replace(task, vehicle=replace(CAR, width=2.2))
    assert verify_plan(wider, plan).clearance == pytest.approx(
        verify_plan(task, plan).clearance - 0.2, abs=0.02
    )
