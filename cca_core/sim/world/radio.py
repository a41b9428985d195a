"""What is sent and heard: message bytes from everybody through lossy channels."""

import math
from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np

from cca_core.errors import InputError
from cca_core.path import LocalFrame
from cca_core.sim.scenarios.road_user import ReactToLeadAction, RoadUser
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.sim.world.traffic import Traffic
from cca_core.v2x import Channel, ChannelSettings, Sender, Tracker, TrackerSettings, decode_bsm
from cca_core.vehicle import GRAVITY, RemoteVehicle, VehicleParams, VehicleState

__all__ = ["Radio", "Receiver"]

_HARD = 0.4 * GRAVITY  # deceleration from which on hard braking is announced [m/s^2]
_BRAKING = frozenset({"hard_braking"})
_ACCURACY = 1.5  # up to which it is believed how well a sender knows its place [m]
_EGO = "ffffffff"
_SILENT = 0.075  # after a message no other can be due for this time [s]: their interval, less a cycle


class Receiver:
    """The ego's receiver: bytes in, vehicles under the names of the road users out.

    Parameters
    ----------
    scenario : Scenario
        Road users.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._names = {sender_id(i): user.id for i, user in enumerate(scenario.road_users)}
        self.tracker = Tracker(LocalFrame(*scenario.origin), TrackerSettings(max_reported_accuracy=_ACCURACY))

    def take(self, t: float, messages: Iterable[bytes], ego: VehicleState) -> list[RemoteVehicle]:
        """Take messages in and tell where all senders are.

        Parameters
        ----------
        t : float
            Now [s].
        messages : iterable of bytes
            What has arrived.
        ego : VehicleState
            The receiver.

        Returns
        -------
        remotes : list of RemoteVehicle
            All that are tracked; senders that are no road users keep their own ids.
        """
        for data in messages:
            self.tracker.update(data, t)
        return list(self.tracker.vehicles(t, ego, self._names))


class Radio:
    """Everybody sends its state as bytes ten times a second, the ego too.

    Each road user is its own sender to the channel, or, with one modem, all are one: then a burst of loss
    goes through the messages of all in the order of sending. A road user that is warned by messages has a
    channel of its own from its leader. What the ego sends goes through a channel to all others.

    Parameters
    ----------
    scenario : Scenario
        Road users and channel.
    rng : numpy.random.Generator
        Source of chance: phases of the senders, losses and delays of the channels.

    Attributes
    ----------
    counts : Counter
        Messages ``"sent"`` and ``"delivered"`` to the ego, ``"ego_sent"`` and ``"ego_delivered"``.
    """

    def __init__(self, scenario: Scenario, rng: np.random.Generator) -> None:
        frame, settings = LocalFrame(*scenario.origin), scenario.sender
        channel = scenario.channel or ChannelSettings(latency=scenario.latency)
        self._vehicle, self._one_modem = scenario.vehicle, scenario.shared_modem
        self._senders = [
            Sender(sender_id(i), frame, settings, rng) if user.connected else None
            for i, user in enumerate(scenario.road_users)
        ]
        self._channel = Channel(channel, rng)
        back, *others = rng.spawn(1 + len(scenario.road_users))
        self._own, self._back = Sender(_EGO, frame, settings, back), Channel(channel, back)
        self._ears = [
            (user.id, act.lead_id, Channel(channel, own))
            for user, own in zip(scenario.road_users, others, strict=True)
            for act in user.actions
            if isinstance(act, ReactToLeadAction) and math.isfinite(act.warning_delay)
        ]
        self._asleep = [-math.inf] * (
            1 + len(scenario.road_users)
        )  # until when each sends nothing, the ego last
        self.counts: Counter[str] = Counter(sent=0, delivered=0, ego_sent=0, ego_delivered=0)

    @property
    def is_needed(self) -> bool:
        """Whether any road user listens."""
        return bool(self._ears)

    def exchange(self, t: float, traffic: Traffic, ego: VehicleState, *, ego_sends: bool) -> list[bytes]:
        """Let all send, and give what has arrived at the ego.

        Parameters
        ----------
        t : float
            Now [s].
        traffic : Traffic
            The road users; those that listen are warned.
        ego : VehicleState
            The ego now.
        ego_sends : bool
            Whether it has a modem.

        Returns
        -------
        messages : list of bytes
            In order of arrival.
        """
        for i, (sender, mover) in enumerate(zip(self._senders, traffic.movers, strict=True)):
            if sender is None or t < self._asleep[i]:
                continue
            user, (x, y, psi, r) = mover.user, mover.pose
            data = sender.poll(t, _bsm_of(user.id, (x, y, psi, mover.v, mover.a, r), user, user.events))
            if data is None:
                continue
            self._asleep[i] = t + _SILENT
            self.counts["sent"] += 1
            self._channel.send(t, (x, y), data, sender="others" if self._one_modem else sender.id)
            for _, leader, ear in self._ears:
                if leader == user.id:
                    ear.send(t, (x, y), data, sender=leader)
        for name, _, ear in self._ears:
            listener = traffic.by_id[name]
            if not listener.warning_received:
                for arrival in ear.receive(t, listener.pose[:2]):
                    if "hard_braking" in decode_bsm(arrival.data).events:
                        listener.deliver_warning(t)
        if ego_sends and t >= self._asleep[-1]:
            self._send_own(t, traffic, ego)
        arrivals = [arrival.data for arrival in self._channel.receive(t, (ego.x, ego.y))]
        self.counts["delivered"] += len(arrivals)
        return arrivals

    def _send_own(self, t: float, traffic: Traffic, ego: VehicleState) -> None:
        car = self._vehicle
        center = car.center_at(ego.x, ego.y, ego.psi)
        motion = (*center, ego.psi, max(ego.v_x, 0.0), ego.a_x, ego.r)
        data = self._own.poll(t, _bsm_of("ego", motion, car, frozenset()))
        if data is None:
            return
        self._asleep[-1] = t + _SILENT
        self.counts["ego_sent"] += 1
        self._back.send(t, center, data)
        if traffic.movers:
            self.counts["ego_delivered"] += len(self._back.receive(t, traffic.movers[0].pose[:2]))


def sender_id(i: int) -> str:
    """Identity in messages of a road user by its place in the scenario.

    Parameters
    ----------
    i : int
        Its index [-].

    Returns
    -------
    id : str
        8 hexadecimal digits.

    Raises
    ------
    InputError
        If `i` is negative.
    """
    if i < 0:
        raise InputError(f"i must be at least 0, was {i}")
    return f"{i + 1:08x}"


def _bsm_of(
    name: str, motion: Sequence[float], body: RoadUser | VehicleParams, events: frozenset[str]
) -> RemoteVehicle:
    """Put in words what a vehicle says of itself: motion, body, and whether it brakes hard."""
    x, y, psi, v, a, r = motion
    return RemoteVehicle(
        id=name, x=x, y=y, psi=psi, v_x=v, a_x=a, r=r, length=body.length, width=body.width,
        events=events | _BRAKING if a <= -_HARD else events,
    )  # fmt: skip
