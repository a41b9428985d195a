"""Elastic bands as planning methods: limits, clearance, refusal."""

import math
from functools import partial
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, Status
from cca_core.baselines import OneShotBand, Problem, RelaxedBand, sample_problem, verify_plan
from tests.support.table1_problems import BLOCKED, CASES, SLALOM, measured_distances

BANDS = pytest.mark.parametrize(
    "method",
    [RelaxedBand(), pytest.param(RelaxedBand(smooth=True), marks=pytest.mark.requires("piqp"))],
    ids=["relaxed", "QP"],
)


@BANDS
@pytest.mark.parametrize("problem", [*CASES.values(), SLALOM], ids=[*CASES, "slalom"])
def test_band_keeps_limits_and_clearance(method: Any, problem: Problem) -> None:
    plan = method.plan(problem)
    assert plan.status is Status.OK
    gap, edge = measured_distances(problem, plan)
    assert gap >= problem.clearance - 5e-3
    assert edge >= -5e-3
    assert verify_plan(problem, plan).passed


@BANDS
def test_band_refuses_blocked_road(method: Any) -> None:
    plan = method.plan(BLOCKED)
    assert plan.status is Status.INFEASIBLE
    assert plan.message
    assert not len(plan.t)


def test_eq_9_as_printed_displaces_and_never_refuses() -> None:
    plans = [OneShotBand().plan(sample_problem("one car", seed).problem) for seed in range(1, 6)]
    assert all(plan.status is Status.OK for plan in plans)
    assert max(np.abs(plan.xy[:, 1]).max() for plan in plans) > 1.0
    assert OneShotBand().plan(BLOCKED).status is Status.OK


@pytest.mark.parametrize(
    ("make", "name"),
    [(partial(OneShotBand, spacing=0.0), "spacing"), (partial(OneShotBand, ratio=-1.0), "ratio"),
     (partial(RelaxedBand, spacing=math.nan), "spacing"), (partial(RelaxedBand, spacing=-1.0), "spacing")],
)  # fmt: skip
def test_error_names_setting(make: Any, name: str) -> None:
    with pytest.raises(InputError, match=f"^{name} must"):
        make()
