"""What the ego knows of the vehicles of another world by their messages alone."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from cca_core.path import LocalFrame
from cca_core.v2x import Channel, Sender, SenderSettings, Tracker
from cca_core.vehicle import GRAVITY, RemoteVehicle, VehicleState

_MAX_YAW_RATE = 5.7  # of a message [rad/s]
_MAX_ACCELERATION = 20.0  # [m/s^2]


class RadioLink:
    """Messages of other vehicles, as bytes through a channel into a tracker.

    Parameters
    ----------
    frame : LocalFrame
        Frame of the positions.
    channel : Channel
        From the senders to the ego.
    rng : numpy.random.Generator
        Randomness of the senders.
    sender : SenderSettings, optional
        Interval and errors of the senders.
    tracker : Tracker, optional
        Receiver of the ego; the default is made for `frame`.

    Attributes
    ----------
    tracker : Tracker
        Receiver of the ego.

    Examples
    --------
    >>> from cca_core.v2x import ChannelSettings
    >>> frame, rng = LocalFrame(48.0, 11.0), np.random.default_rng(1)
    >>> link = RadioLink(frame, Channel(ChannelSettings(), rng), rng)
    >>> car = RemoteVehicle(id="car", x=50.0, y=0.0, psi=0.0, v_x=10.0)
    >>> ego = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=10.0)
    >>> for k in range(100):
    ...     known = link.exchange(0.02 * k, [replace(car, x=50.0 + 0.2 * k)], ego)
    >>> known[0].id, round(known[0].x)
    ('car', 70)
    """

    def __init__(
        self,
        frame: LocalFrame,
        channel: Channel,
        rng: np.random.Generator,
        *,
        sender: SenderSettings | None = None,
        tracker: Tracker | None = None,
    ) -> None:
        self.tracker = tracker or Tracker(frame)
        self._frame, self._channel, self._rng = frame, channel, rng
        self._settings = sender or SenderSettings()
        self._senders: dict[str, Sender] = {}
        self._names: dict[str, str] = {}  # ids of the world by ids of the senders

    def exchange(
        self, t: float, vehicles: Iterable[RemoteVehicle], ego: VehicleState
    ) -> tuple[RemoteVehicle, ...]:
        """Let all vehicles send, and return what the ego knows.

        Parameters
        ----------
        t : float
            Now [s]; grows from call to call.
        vehicles : iterable of RemoteVehicle
            True motion of the vehicles now. The event ``"hard_braking"`` is added from 0.4 g on.
        ego : VehicleState
            The ego now.

        Returns
        -------
        known : tuple of RemoteVehicle
            All tracks, with the ids of the world.

        Raises
        ------
        InputError
            If a value of a vehicle cannot be encoded.
        """
        for given in vehicles:
            vehicle = replace(  # what a message cannot say of motion that jumps is cut off
                given, r=min(max(given.r, -_MAX_YAW_RATE), _MAX_YAW_RATE),
                a_x=min(max(given.a_x, -_MAX_ACCELERATION), _MAX_ACCELERATION),
            )  # fmt: skip
            if vehicle.a_x <= -0.4 * GRAVITY:  # SAE J2735
                vehicle = replace(vehicle, events=vehicle.events | {"hard_braking"})
            data = self._sender(vehicle.id).poll(t, vehicle)
            if data is not None:
                self._channel.send(t, (vehicle.x, vehicle.y), data, sender=vehicle.id)
        for arrival in self._channel.receive(t, (ego.x, ego.y)):
            self.tracker.update(arrival.data, t)
        return self.tracker.vehicles(t, ego, self._names)

    def _sender(self, name: str) -> Sender:
        """Return the sender of a vehicle."""
        if name not in self._senders:
            id = f"{len(self._senders) + 0x1000:08x}"
            self._senders[name] = Sender(id, self._frame, self._settings, self._rng)
            self._names[id] = name
        return self._senders[name]
