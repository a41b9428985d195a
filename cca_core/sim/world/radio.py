"""Radio: message bytes of all vehicles through lossy channels."""

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

_MIN_INTERVAL = 0.075  # no other message can be due for this time after one [s]: their interval, less a cycle


class Receiver:
    """Receiver of the ego: bytes in, vehicles with the ids of road users out."""

    def __init__(self, scenario: Scenario) -> None:
        self._names = {sender_id(i): user.id for i, user in enumerate(scenario.road_users)}
        self.tracker = Tracker(LocalFrame(*scenario.origin), TrackerSettings(max_reported_accuracy=1.5))

    def take(self, t: float, messages: Iterable[bytes], ego: VehicleState) -> list[RemoteVehicle]:
        """Process messages and return all tracked vehicles."""
        for data in messages:
            self.tracker.update(data, t)
        return list(self.tracker.vehicles(t, ego, self._names))


class Radio:
    """Every vehicle sends its state as bytes ten times per second, the ego too."""

    # Each road user is a sender of its own, or, with one modem, all are one: a burst of loss then affects the
    # messages of all in the order of sending. A road user that reacts to messages has a channel of its own
    # from its lead. The ego's messages go through one channel to all others.

    def __init__(self, scenario: Scenario, rng: np.random.Generator, *, utc_at_start: float = 0.0) -> None:
        frame, settings = LocalFrame(*scenario.origin), scenario.sender
        channel = scenario.channel or ChannelSettings(latency=scenario.latency)
        self._utc_at_start = utc_at_start  # of the time marks in messages [s]
        self._vehicle, self._one_modem = scenario.vehicle, scenario.shared_modem
        self._senders = [
            Sender(sender_id(i), frame, settings, rng) if user.connected else None
            for i, user in enumerate(scenario.road_users)
        ]
        self._channel = Channel(channel, rng)
        back, *others = rng.spawn(1 + len(scenario.road_users))
        self._ego_sender = Sender("ffffffff", frame, settings, back)
        self._ego_channel = Channel(channel, back)
        self._listeners = [
            (user.id, act.lead_id, Channel(channel, own))
            for user, own in zip(scenario.road_users, others, strict=True)
            for act in user.actions
            if isinstance(act, ReactToLeadAction) and math.isfinite(act.warning_delay)
        ]
        # earliest next message of each, the ego last
        self._next_due = [-math.inf] * (1 + len(scenario.road_users))
        # "sent" and "delivered" to the ego, "ego_sent" and "ego_delivered"
        self.counts: Counter[str] = Counter(sent=0, delivered=0, ego_sent=0, ego_delivered=0)

    @property
    def is_needed(self) -> bool:
        """Whether any road user listens."""
        return bool(self._listeners)

    def exchange(self, t: float, traffic: Traffic, ego: VehicleState, *, ego_sends: bool) -> list[bytes]:
        """Let all vehicles send; return the bytes that have arrived at the ego."""
        for i, (sender, agent) in enumerate(zip(self._senders, traffic.agents, strict=True)):
            if sender is None or t < self._next_due[i]:
                continue
            user, (x, y, psi, r) = agent.user, agent.pose
            data = sender.poll(
                self._utc_at_start + t, bsm_of(user.id, (x, y, psi, agent.v, agent.a, r), user, user.events)
            )
            if data is None:
                continue
            self._next_due[i] = t + _MIN_INTERVAL
            self.counts["sent"] += 1
            self._channel.send(t, (x, y), data, sender="others" if self._one_modem else sender.id)
            for _, lead_id, channel in self._listeners:
                if lead_id == user.id:
                    channel.send(t, (x, y), data, sender=lead_id)
        for name, _, channel in self._listeners:
            listener = traffic.by_id[name]
            if not listener.warning_received:
                for arrival in channel.receive(t, listener.pose[:2]):
                    if "hard_braking" in decode_bsm(arrival.data).events:
                        listener.deliver_warning(t)
        if ego_sends and t >= self._next_due[-1]:
            self._send_ego(t, traffic, ego)
        arrivals = [arrival.data for arrival in self._channel.receive(t, (ego.x, ego.y))]
        self.counts["delivered"] += len(arrivals)
        return arrivals

    def _send_ego(self, t: float, traffic: Traffic, ego: VehicleState) -> None:
        """Send the ego's state."""
        car = self._vehicle
        center = car.center_at(ego.x, ego.y, ego.psi)
        motion = (*center, ego.psi, max(ego.v_x, 0.0), ego.a_x, ego.r)
        data = self._ego_sender.poll(self._utc_at_start + t, bsm_of("ego", motion, car, frozenset()))
        if data is None:
            return
        self._next_due[-1] = t + _MIN_INTERVAL
        self.counts["ego_sent"] += 1
        self._ego_channel.send(t, center, data)
        if traffic.agents:
            self.counts["ego_delivered"] += len(self._ego_channel.receive(t, traffic.agents[0].pose[:2]))


def sender_id(i: int) -> str:
    """Return the temporary identity of a road user by its index."""
    if i < 0:
        raise InputError(f"i must be at least 0, was {i}")
    return f"{i + 1:08x}"


def bsm_of(
    name: str, motion: Sequence[float], body: RoadUser | VehicleParams, events: frozenset[str]
) -> RemoteVehicle:
    """Return the vehicle that a message reports: motion, body, and hard braking."""
    x, y, psi, v, a, r = motion
    return RemoteVehicle(
        id=name, x=x, y=y, psi=psi, v_x=v, a_x=a, r=r, length=body.length, width=body.width,
        events=events | {"hard_braking"} if a <= -0.4 * GRAVITY else events,  # SAE J2735: more than 0.4 g
    )  # fmt: skip
