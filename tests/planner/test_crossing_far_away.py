"""A vehicle that crosses long after the ego is no reason to brake, with a lead ahead or without one."""

import math

import pytest

from tests.support.planner_drives import ClosedLoop, CrossingVehicle, ScriptedVehicle, make_planner
from tests.support.sweeps import sweep


@pytest.mark.parametrize(
    ("gap", "ahead", "distance", "v"),
    sweep(
        (45.0, 50.0, 110.0, 15.0), (60.0, 90.0, 170.0, 15.0), (45.0, 70.0, 140.0, 17.0),
        (45.0, 90.0, 110.0, 12.0), (60.0, 70.0, 110.0, 15.0), (45.0, 120.0, 140.0, 12.0),
        (60.0, 50.0, 140.0, 15.0), (400.0, 70.0, 140.0, 17.0), (400.0, 50.0, 110.0, 15.0),
        quick=3,
    ),
)  # fmt: skip
@pytest.mark.parametrize("side", [1.0, -1.0], ids=["left", "right"])
def test_early_pass_needs_no_braking(
    gap: float, ahead: float, distance: float, v: float, side: float
) -> None:
    """If the lead braked fully, the ego could stop behind the crossing, but not with full braking itself."""
    lead = ScriptedVehicle("R", gap, 0.0, 19.0)
    cross = CrossingVehicle("X", ahead, side * distance, v, psi=-side * 0.5 * math.pi)
    run = ClosedLoop(make_planner(None, cruise=21.0), [lead, cross], 8.0, v=20.5)
    assert run.collided_with is None
    assert min(run.a_x) > -1.0
    assert run.x[-1] > 160.0
