"""Tailgating: the gap that the ego keeps until it knows of a hazard."""

from collections.abc import Iterable

from cca_core.decide import Action
from cca_core.follow import jerk_limited
from cca_core.planner.command import Command
from cca_core.sim.scenarios.scenario import FixedTimeGap, Scenario
from cca_core.sim.world.traffic import CYCLE_TIME, TrafficAgent
from cca_core.vehicle import RemoteVehicle

__all__ = ["Tailgating"]

_BRAKES = -1.0  # acceleration that tells of a hazard [m/s^2]
_STIFF, _DAMPED, _GENTLE = 0.2, 0.8, 1.0  # [1/s^2], [1/s], [m/s^2]


class Tailgating:
    """Holds the time gap to a vehicle, then hands over to the planner or the driver.

    The gap is held until a vehicle that brakes, or announces hard braking, is known to the planner, or the
    driver brakes. While the leader brakes and the ego does not know it yet, it keeps its speed. At the
    handover the acceleration changes no faster than brakes do.

    Parameters
    ----------
    scenario : Scenario
        With a pinned gap.
    pinned : FixedTimeGap
        That gap.
    """

    def __init__(self, scenario: Scenario, pinned: FixedTimeGap) -> None:
        self._pinned, self._vehicle, self._speed = pinned, scenario.vehicle, scenario.speed
        self._by_sight = scenario.ego_type == "driver"
        self._a_x = 0.0
        self._handed_over = False
        self.released = False

    def acceleration(
        self, remotes: Iterable[RemoteVehicle], command: Command, s: float, v_x: float, leader: TrafficAgent
    ) -> float:
        """Acceleration to drive with.

        Parameters
        ----------
        remotes : iterable of RemoteVehicle
            What the ego knows.
        command : Command
            What the planner or the driver wants.
        s, v_x : float
            Path coordinate of the ego's center of gravity [m] and its speed [m/s].
        leader : Mover
            The vehicle in front.

        Returns
        -------
        a_x : float
            Acceleration [m/s^2].
        """
        if not self.released:
            self.released = (
                command.decision.action is Action.BRAKE
                if self._by_sight
                else any("hard_braking" in r.events or r.a_x <= _BRAKES for r in remotes)
            )
        if self._handed_over:
            return command.a_x
        if self.released:
            self._a_x = jerk_limited(command.a_x, self._a_x, CYCLE_TIME, self._speed, emergency=True)
            self._handed_over = self._a_x == command.a_x
        elif leader.a <= _BRAKES:
            self._a_x = 0.0
        else:
            front = s + self._vehicle.front
            error = leader.s - 0.5 * leader.user.length - front - self._pinned.time_gap * v_x
            self._a_x = min(max(_STIFF * error + _DAMPED * (leader.v - v_x), -_GENTLE), _GENTLE)
        return self._a_x
