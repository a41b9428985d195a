"""The ego's state is lost while it passes a car: it follows the safe stop of its last plan."""

import numpy as np
import pytest

from cca_core import Status
from cca_core.sim import SingleTrackPlant
from tests.support.planner_drives import CAR, CYCLE, ScriptedVehicle, ego_state, make_planner


@pytest.mark.parametrize("moment", [0.6, 1.5, 2.4, 3.2])
def test_lost_state_in_pass_follows_safe_stop(moment: float) -> None:
    """`moment`: lateral offset [m] at which it is lost for good."""
    planner, plant = make_planner(), SingleTrackPlant(CAR, ego_state())
    slow, k, path, t_lost, offsets = ScriptedVehicle("R", 60.0, 0.0, 10.0), 0, None, 0.0, []
    stop = planner.step(0.0, plant.state, [slow.record()]).safe_stop
    while plant.state.v_x > 0.0 and k < 1500:
        t, k = CYCLE * k, k + 1
        is_lost = path is not None
        command = planner.step(t, None if is_lost else plant.state, [slow.record()])  # type: ignore[arg-type]
        if path is not None:
            assert stop is not None
            assert command.status is Status.INVALID_INPUT
            assert command.a_x == pytest.approx(np.interp(t + CYCLE - t_lost, stop.t, stop.a_x), abs=0.5)
            offsets.append(float(path.project((plant.state.x, plant.state.y))[1]))
            gap = abs(slow.x - plant.state.x) - 4.5, abs(slow.d - plant.state.y) - 1.8
            assert max(gap) > 0.1
        elif plant.state.y > moment:
            stop, t_lost = command.safe_stop, t
            assert stop is not None
            path = stop.path()
        plant.step(command.delta, command.a_x, CYCLE)
        slow.move(t)
    assert plant.state.v_x == 0.0
    assert max(map(abs, offsets)) < 0.5
