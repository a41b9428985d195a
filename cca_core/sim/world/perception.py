"""What the ego knows of others, from bytes and by sight; a run and its replay share it."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from cca_core.sim.scenarios.scenario import Scenario
from cca_core.sim.world.radio import Receiver
from cca_core.sim.world.sensor import Sensor
from cca_core.vehicle import RemoteVehicle, VehicleState

__all__ = ["Perception"]

_PRECISE = 0.1  # deviation up to which a sender's own word on its place is taken [m]
_CREDIBLE = 3.0  # deviations beyond which an error is not one of a receiver, and is not counted on
_LASTING = 30.0  # time in which the error of a receiver's position forgets itself [s]


@dataclass(frozen=True, slots=True)
class _SenderBias:
    """What a sender was wrong by when it was last in sight.

    Parameters
    ----------
    t : float
        When that was [s].
    x, y : float
        From where it said to be to where it was [m].
    along, across : float
        Deviations that it was held capable of [m].
    """

    t: float
    x: float
    y: float
    along: float
    across: float

    def correct(self, heard: RemoteVehicle, t: float) -> RemoteVehicle:
        """Correct what the sender says now by what is left of the error, and grow what is not known."""
        left = math.exp((self.t - t) / _LASTING)
        return replace(
            heard, x=heard.x + left * self.x, y=heard.y + left * self.y,
            sigma_along=_remaining_sigma(heard.sigma_along, left * self.along),
            sigma_across=_remaining_sigma(heard.sigma_across, left * self.across),
        )  # fmt: skip


class Perception:
    """Receiver and sensor of the ego.

    With V2V it knows what it hears. Who does not send, and whose message is older than what the sensor tells,
    is known by the sensor while in sight; the events that were heard of stay. Of who knows its own place
    less well than the sensor does the place is the sensor's; out of sight it is what messages say, corrected
    by what they were last wrong by. Without V2V it knows what it sees.

    Parameters
    ----------
    scenario : Scenario
        Road users, and who drives.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._hears = scenario.v2v
        self._sight_alone = not all(user.connected and self._hears for user in scenario.road_users)
        self._receiver, self._sensor = Receiver(scenario), Sensor(scenario)
        self._errors: dict[str, _SenderBias] = {}

    @property
    def needs_every_cycle(self) -> bool:
        """Whether somebody is known by sight alone, so that every cycle counts."""
        return self._sight_alone

    def awareness_range(self, t: float) -> float:
        """Tell up to which distance silence means that nobody is there.

        Parameters
        ----------
        t : float
            Now [s].

        Returns
        -------
        awareness_range : float
            0 while there are too many senders, else infinity: then the planner's own settings count [m].
        """
        return 0.0 if self._hears and self._receiver.tracker.is_saturated(t) else math.inf

    def visible(self, rows: Sequence[Sequence[float]], ego: VehicleState) -> list[bool]:
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
        return self._sensor.visible(rows, ego)

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
        in_sight = {v.id: v for v in self._sensor.detections(t, rows, seen)}
        self._errors = {name: error for name, error in self._errors.items() if name in heard}
        for name, told in heard.items():
            v = in_sight.pop(name, None)
            recent, precise = told.age <= self._sensor.delay, told.sigma_across <= _PRECISE
            if v is not None and not recent:
                heard[name] = replace(v, events=told.events, source="v2v")
            elif v is not None and not precise:
                off = v.x - told.x, v.y - told.y
                if math.hypot(*off) <= _CREDIBLE * math.hypot(told.sigma_along, told.sigma_across):
                    self._errors[name] = _SenderBias(t, *off, told.sigma_along, told.sigma_across)
                else:
                    self._errors.pop(name, None)
                heard[name] = replace(told, x=v.x, y=v.y, sigma_along=0.0, sigma_across=0.0)
            elif not precise and name in self._errors:
                heard[name] = self._errors[name].correct(told, t)
        return [*heard.values(), *in_sight.values()]


def _remaining_sigma(sigma: float, known: float) -> float:
    """Deviation that is left of one [m] when a part of it is known."""
    return math.sqrt(max(sigma * sigma - known * known, 0.0))
