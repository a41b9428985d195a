"""Random trees: limits, clearance, seeds, termination."""

import math
from importlib.util import find_spec

import numpy as np
import pytest

from cca_core import InputError, MissingExtraError, Status
from cca_core.baselines.methods.rrt import Rrt, Variant
from cca_core.baselines.problems.problem import Problem
from tests.support.table1_problems import BLOCKED, CASES, SLALOM, measured_distances, problem, road

pytestmark = pytest.mark.requires("ompl")
VARIANTS: tuple[Variant, ...] = ("rrt", "rrt_star")


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("radius", [math.inf, 200.0])
def test_tree_reaches_goal_on_empty_road(variant: Variant, radius: float) -> None:
    given = problem([], on=road(radius), v_x=15.0)
    plan = Rrt(variant=variant).plan(given)
    assert plan.status is Status.OK
    measured_distances(given, plan)
    assert plan.t[-1] == pytest.approx(given.duration)


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("given", CASES.values(), ids=CASES)
def test_plan_keeps_limits_and_clearance(variant: Variant, given: Problem) -> None:
    plan = Rrt(variant=variant, time_limit=10.0).plan(given)
    assert plan.status is Status.OK
    gap, edge = measured_distances(given, plan)
    assert gap >= given.clearance - 5e-3
    assert edge >= -5e-3


def test_plan_passes_slalom() -> None:
    plan = Rrt(variant="rrt", time_limit=10.0).plan(SLALOM)
    assert plan.status is Status.OK
    assert measured_distances(SLALOM, plan)[0] >= SLALOM.clearance - 5e-3


@pytest.mark.parametrize("variant", VARIANTS)
def test_equal_seeds_give_equal_plans(variant: Variant) -> None:
    given = CASES["stationary"]
    first, again, other = (Rrt(variant=variant, seed=s, time_limit=10.0).plan(given) for s in (3, 3, 4))
    assert first.status is again.status is other.status is Status.OK
    np.testing.assert_array_equal(first.xy, again.xy)
    assert first.xy.shape != other.xy.shape or not np.array_equal(first.xy, other.xy)


def test_refinement_shortens_plan() -> None:
    given = CASES["stationary"]

    def length(refine: int) -> float:
        found = [Rrt(seed=s, refine=refine, time_limit=20.0).plan(given).xy for s in range(1, 6)]
        return sum(float(np.hypot(*np.diff(xy, axis=0).T).sum()) for xy in found)

    assert length(300) < length(0)


@pytest.mark.parametrize("variant", VARIANTS)
def test_blocked_road_is_infeasible(variant: Variant) -> None:
    plan = Rrt(variant=variant).plan(BLOCKED)
    assert plan.status is Status.INFEASIBLE
    assert "ahead" in plan.message
    assert len(plan.t) == len(plan.xy) == len(plan.v_x) == 0


@pytest.mark.parametrize("variant", VARIANTS)
def test_search_ends_by_time_and_by_samples(variant: Variant) -> None:
    hopeless = problem([(15.0, 0.0, 0.0)])
    plan = Rrt(variant=variant, time_limit=0.3, iterations=10**9).plan(hopeless)
    assert plan.status is Status.NOT_CONVERGED
    few = Rrt(variant=variant, time_limit=60.0, iterations=50).plan(hopeless)
    assert few.status is Status.NOT_CONVERGED
    assert "50 samples" in few.message


@pytest.mark.parametrize(
    ("name", "value"),
    [("variant", "prm"), ("seed", -1), ("seed", 1.5), ("iterations", 0), ("refine", -1), ("time_limit", 0.0),
     ("reach", math.nan), ("rewire_factor", 0.0), ("goal_bias", 1.5), ("max_heading", 2.0),
     ("heading_spread", 0.0), ("cell_width", 0.0), ("heading_step", 0.0)],
)  # fmt: skip
def test_error_names_setting(name: str, value: object) -> None:
    with pytest.raises(InputError, match=f"^{name} must"):
        Rrt(**{name: value})  # type: ignore[arg-type]


def test_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "cca_core._optional.find_spec", lambda name: None if name == "ompl" else find_spec(name)
    )
    with pytest.raises(MissingExtraError, match=r"pip install .*cca-planner\[rrt\]"):
        Rrt()
