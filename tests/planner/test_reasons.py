"""Reasons: they name vehicles that are there and agree with the sign of the acceleration."""

from typing import Any

import pytest

from cca_core import Planner
from tests.support.crowds import CROWDS, drive

SLOWS = ("braking slowing stopping following yielding passing returning").split()


@pytest.mark.parametrize("name", ["queue", "crossing", "oncoming", "weaving"])
def test_reason_agrees_with_acceleration_and_vehicles(name: str) -> None:
    def checked(planner: Planner, t: float, state: Any, remotes: Any) -> Any:
        command = planner.step(t, state, remotes)
        decision = command.decision
        assert decision.lead_id is None or decision.lead_id in {remote.id for remote in remotes}
        activity = decision.activity
        if command.a_x < -0.5:
            assert activity.split()[0] in SLOWS, f"{command.a_x:.1f} m/s^2: {decision.reason}"
        if command.a_x > 0.1:
            assert not activity.startswith(("braking", "stopping: route", "releasing")), decision.reason
        return command

    drive(CROWDS[name](), 200, checked)
