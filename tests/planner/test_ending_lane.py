"""A lane change for good out of a lane that ends: it is complete before the end, however late it is asked."""

import pytest

from cca_core import Lane, Planner, Road, VehicleState
from cca_core.path import fit_path
from cca_core.sim import SingleTrackPlant
from tests.support.planner_drives import CAR
from tests.support.sweeps import sweep

END = 300.0


@pytest.mark.parametrize("side", [1.0, -1.0], ids=["right", "left"])
@pytest.mark.parametrize(
    ("distance", "v"), sweep((22.0, 9.6), (80.0, 25.0), (15.0, 5.0), (40.0, 20.0), (30.0, 2.0), quick=2)
)
def test_late_request_leaves_lane_before_its_end(distance: float, v: float, side: float) -> None:
    ending = sorted((-1.75 * side, -5.25 * side))
    road = Road(
        fit_path([[0.0, 0.0], [1000.0, 0.0]]),
        [Lane(d=0.0), Lane.from_boundaries([(0.0, *ending), (END, *ending)])],
        speed_limit=25.0,
    )
    plant = SingleTrackPlant(CAR, VehicleState(x=20.0, y=0.0, psi=0.0, v_x=v))
    planner = Planner(CAR, road, cruise_speed=v)
    planner.request_lane(-3.5 * side)
    asked, half, a_y = False, 0.5 * CAR.width, 0.0
    for k in range(10_000):
        state = plant.state
        if state.x > END + 20.0:
            break
        if not asked and planner.lane != 0.0 and state.x > END - distance:
            planner.request_lane(0.0)
            asked = True
        command = planner.step(0.02 * k, state, [])
        a_y = max(a_y, abs(state.v_x * state.r))
        if state.x + CAR.front > END:
            assert -side * state.y < 1.75 - half
        plant.step(command.delta, command.a_x, 0.02)
    assert plant.state.x > END + 20.0
    assert a_y < 3.0
