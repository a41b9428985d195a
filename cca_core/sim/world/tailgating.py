"""Tailgating: fixed time gap of the ego until it knows of a hazard."""

from collections.abc import Iterable
from typing import NamedTuple

from cca_core.decide import Action
from cca_core.follow import jerk_limited
from cca_core.planner.command import Command
from cca_core.sim.scenarios.scenario import FixedTimeGap, Scenario
from cca_core.sim.world.traffic import CYCLE_TIME
from cca_core.vehicle import RemoteVehicle

_HAZARD_ACCELERATION = -1.0  # of another vehicle, from which on it is a hazard [m/s^2]


class LeadMotion(NamedTuple):
    """Motion of the lead along the route."""

    rear: float  # station of its rear end [m]
    v: float  # [m/s]
    a: float  # [m/s^2]


class Tailgating:
    """Fixed time gap to the lead, until the planner or the driver takes over."""

    # They take over when a vehicle that brakes or reports hard braking is known to the planner, or the driver
    # brakes. While the lead brakes and the ego does not know, its speed stays constant. At the handover the
    # acceleration changes no faster than brakes allow.

    def __init__(self, scenario: Scenario, gap: FixedTimeGap) -> None:
        self._time_gap, self._vehicle, self._speed = gap.time_gap, scenario.vehicle, scenario.speed
        self._is_driver = scenario.ego_type == "driver"
        self._a_x = 0.0
        self._handed_over = False
        self.released = False

    def acceleration(
        self, remotes: Iterable[RemoteVehicle], command: Command, s: float, v_x: float, lead: LeadMotion
    ) -> float:
        """Return the acceleration of the ego [m/s^2]."""
        if not self.released:
            self.released = (
                command.decision.action is Action.BRAKE
                if self._is_driver
                else any("hard_braking" in r.events or r.a_x <= _HAZARD_ACCELERATION for r in remotes)
            )
        if self._handed_over:
            return command.a_x
        if self.released:
            self._a_x = jerk_limited(command.a_x, self._a_x, CYCLE_TIME, self._speed, emergency=True)
            self._handed_over = self._a_x == command.a_x
        elif lead.a <= _HAZARD_ACCELERATION:
            self._a_x = 0.0
        else:
            front = s + self._vehicle.front
            error = lead.rear - front - self._time_gap * v_x
            # gently: 0.2 1/s^2 and 0.8 1/s have a damping ratio of 0.9
            self._a_x = min(max(0.2 * error + 0.8 * (lead.v - v_x), -1.0), 1.0)
        return self._a_x
