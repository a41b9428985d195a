"""The maneuver that the tests of abort and replanning start from."""

import pytest

from cca_core.planner.maneuver import Maneuver, plan_maneuver
from tests.support.planner_drives import NO_ASSUMPTIONS, TWO_LANE_ROAD, frenet_car, frenet_ego


@pytest.fixture(scope="session")
def maneuver() -> Maneuver:
    """Fully out of the path of a slower vehicle, 25 m behind it."""
    lead = frenet_car(0.0, 0.0, 12.0)
    plan = plan_maneuver(frenet_ego(-60.0), TWO_LANE_ROAD, [lead], [], "left", NO_ASSUMPTIONS, start_now=True)
    assert isinstance(plan, Maneuver)
    assert plan.candidate.rejection is None
    return plan
