"""What the ego knows of others, from bytes and by sight; a run and its replay share it."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

from cca_core.sim.radio import Receiver
from cca_core.sim.scenario import Scenario
from cca_core.sim.sensor import Sensor
from cca_core.vehicle import RemoteVehicle, VehicleState

__all__ = ["Perception"]

_PRECISE = 0.1  # deviation up to which a sender's own word on its place is taken [m]


class Perception:
    """Receiver and sensor of the ego.

    With V2V it knows what it hears. Who does not send, and whose message is older than what the sensor tells,
    is known by the sensor while in sight; the events that were heard of stay. Of who knows its own place
    less well than the sensor does the place is the sensor's. Without V2V it knows what it sees.

    Parameters
    ----------
    scenario : Scenario
        Road users, and who drives.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._hears = scenario.v2v
        self._sight_alone = not all(user.connected and self._hears for user in scenario.users)
        self._receiver, self._sensor = Receiver(scenario), Sensor(scenario)

    @property
    def looks(self) -> bool:
        """Whether somebody is known by sight alone, so that every cycle counts."""
        return self._sight_alone

    def known_range(self, t: float) -> float:
        """Tell up to which distance silence means that nobody is there.

        Parameters
        ----------
        t : float
            Now [s].

        Returns
        -------
        known_range : float
            0 while there are too many senders, else infinity: then the planner's own settings count [m].
        """
        return 0.0 if self._hears and self._receiver.tracker.is_saturated(t) else math.inf

    def look(self, rows: Sequence[Sequence[float]], ego: VehicleState) -> list[bool]:
        """Tell who is in sight.

        Parameters
        ----------
        rows : sequence of sequence of float
            x, y [m], psi [rad], ... of each road user.
        ego : VehicleState
            The ego now.

        Returns
        -------
        seen : list of bool
            One for each road user.
        """
        return self._sensor.look(rows, ego)

    def remotes(
        self,
        t: float,
        rows: Sequence[Sequence[float]],
        seen: Sequence[bool],
        messages: Iterable[bytes],
        ego: VehicleState,
    ) -> list[RemoteVehicle]:
        """Tell what the ego knows now.

        Parameters
        ----------
        t : float
            Now [s].
        rows : sequence of sequence of float
            x, y [m], psi [rad], speed [m/s], acceleration [m/s^2], yaw rate [rad/s] of each road user.
        seen : sequence of bool
            Who is in sight.
        messages : iterable of bytes
            What has arrived.
        ego : VehicleState
            The ego now.

        Returns
        -------
        remotes : list of RemoteVehicle
            For the planner; the source is ``"sensor"`` where nothing has been heard.
        """
        heard = {v.id: v for v in self._receiver.take(t, messages, ego)} if self._hears else {}
        recent = {name for name, v in heard.items() if v.age <= self._sensor.delay}
        precise = {name for name in recent if heard[name].sigma_across <= _PRECISE}
        for v in self._sensor.report(t, rows, seen, leaving_out=precise):
            if v.id in recent:
                heard[v.id] = replace(heard[v.id], x=v.x, y=v.y, sigma_along=0.0, sigma_across=0.0)
            elif v.id in heard:
                heard[v.id] = replace(v, events=heard[v.id].events, source="v2v")
            else:
                heard[v.id] = v
        return list(heard.values())
