"""Motion primitives: limits, clearance, the route as optimum, symmetry, infeasible roads."""

import math
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, Status
from cca_core.baselines.methods.primitives import MotionPrimitives
from cca_core.baselines.problems.problem import Problem
from tests.support.table1_problems import BLOCKED, CASES, SLALOM, measured_distances, problem, road

METHOD = MotionPrimitives()


@pytest.mark.parametrize("radius", [math.inf, 200.0, -200.0])
def test_plan_on_empty_road_follows_route(radius: float) -> None:
    given = problem([], on=road(radius))
    plan = METHOD.plan(given)
    assert plan.status is Status.OK
    assert np.abs(given.road.path.project(plan.xy)[1]).max() < 0.01
    assert plan.t[-1] == pytest.approx(given.duration)


@pytest.mark.parametrize("given", [*CASES.values(), SLALOM], ids=[*CASES, "slalom"])
def test_plan_keeps_limits_and_clearance(given: Problem) -> None:
    plan = METHOD.plan(given)
    assert plan.status is Status.OK
    gap, edge = measured_distances(given, plan)
    assert gap >= given.clearance - 2e-3
    assert edge >= -2e-3


def test_jerk_is_below_limit() -> None:
    plan = METHOD.plan(CASES["stationary"])
    t = np.linspace(0.0, plan.t[-1], 4001)
    d = np.interp(t, plan.t, plan.xy[:, 1])
    jerk = np.diff(np.interp(plan.t, t, d), 3) / (plan.t[1] - plan.t[0]) ** 3
    assert 5.0 < np.abs(jerk).max() <= 1.02 * METHOD.jerk_max


def test_small_jerk_limit_lengthens_shifts() -> None:
    gentle = MotionPrimitives(jerk_max=5.0).plan(problem([(80.0, 0.0, 0.0)], goal=160.0))
    step = gentle.t[1]
    assert np.abs(np.diff(gentle.xy[:, 1], 3)).max() / step**3 <= 5.1


def mirrored(radius: float, lanes: tuple[float, ...], cars: list[Any], side: float) -> Problem:
    on = road(side * radius, tuple(sorted(side * d for d in lanes)))
    return problem([(s, side * d, v) for s, d, v in cars], on=on, v_x=18.0, goal=150.0)


@pytest.mark.parametrize("radius", [math.inf, 250.0])
def test_mirrored_problem_gives_mirrored_plan(radius: float) -> None:
    cars = [(50.0, -0.3, 0.0), (105.0, 2.5, 0.0)]
    plans = [METHOD.plan(mirrored(radius, (-3.5, 0.0, 3.5), cars, side)) for side in (1.0, -1.0)]
    assert plans[0].status is plans[1].status is Status.OK
    assert np.abs(plans[0].xy[:, 1]).max() > 1.0
    np.testing.assert_allclose(plans[0].xy * [1.0, -1.0], plans[1].xy, atol=1e-3)


@pytest.mark.parametrize(
    "given",
    [BLOCKED, problem([(15.0, 0.0, 0.0)]), problem([(50.0, 0.0, 0.0)], on=road(lanes=(0.0,)))],
    ids=["blocked", "too close", "one lane"],
)
def test_infeasible_problem_has_status_and_message(given: Problem) -> None:
    plan = METHOD.plan(given)
    assert plan.status is Status.INFEASIBLE
    assert plan.message
    assert len(plan.t) == len(plan.xy) == len(plan.v_x) == 0


def test_adjacent_lane_is_used_if_it_clears_in_time() -> None:
    parked = (60.0, 0.0, 0.0)
    plans = [METHOD.plan(problem([parked, (s, 3.5, -20.0)], goal=150.0)) for s in (60.0, 120.0)]
    assert [plan.status for plan in plans] == [Status.OK, Status.INFEASIBLE]


def test_curve_beyond_curvature_limit_is_infeasible() -> None:
    assert METHOD.plan(problem([], on=road(80.0))).status is Status.INFEASIBLE


def test_finer_lattice_costs_no_more() -> None:
    """The fine lattice contains the offsets of the coarse one."""
    only_offset = {"weight_a_y": 0.0, "weight_jerk": 0.0}
    given = CASES["stationary"]
    off = [
        np.sum(MotionPrimitives(spacing=spacing, **only_offset).plan(given).xy[:, 1] ** 2)
        for spacing in (0.5, 0.25, 0.125)
    ]
    assert off[0] >= off[1] >= off[2]


@pytest.mark.parametrize(
    ("name", "value"),
    [("step", 0.0), ("spacing", 0.0), ("jerk_max", -1.0), ("weight_a_y", -1.0), ("weight_jerk", math.nan),
     ("weight_offset", math.inf), ("cell_width", 0.0), ("heading_step", -1.0), ("length_factors", (0.5,)),
     ("max_attempts", 0)],
)  # fmt: skip
def test_error_names_setting(name: str, value: Any) -> None:
    with pytest.raises(InputError, match=f"^{name} must"):
        MotionPrimitives(**{name: value})


def test_error_without_any_weight() -> None:
    with pytest.raises(InputError, match="greater than 0"):
        MotionPrimitives(weight_a_y=0.0, weight_jerk=0.0, weight_offset=0.0)
