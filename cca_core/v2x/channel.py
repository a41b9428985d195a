"""A radio channel in software: bytes are late, lost in bursts, out of order, twice or out of range."""

import math
from dataclasses import dataclass, fields
from typing import NamedTuple, Self

import numpy as np

from cca_core._checks import check_array, check_real
from cca_core.errors import InputError

__all__ = ["Channel", "ChannelSettings", "ReceivedMessage"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelSettings:
    """What a channel does to messages; the default does nothing.

    Parameters
    ----------
    latency : float
        Least time from sending to receiving [s].
    jitter : float
        Mean of what is added to it, exponentially distributed [s].
    loss_probability : float
        Share of messages lost near by [-], below 1.
    mean_burst_length : float
        Mean number of messages lost in a row [-], at least 1; 1 / (1 - `loss`) is loss without memory.
    range : float
        Distance beyond which nothing arrives [m].
    loss_at_range : float
        Share of messages lost besides at that distance [-]; grows with the fourth power of distance.
    reorder_probability : float
        Share of messages that are held back by `reordering`, so that later ones overtake them [-].
    reorder_delay : float
        Time for which they are held back [s].
    duplicate_probability : float
        Share of messages that arrive a second time, up to `reordering` later [-].

    Raises
    ------
    InputError
        If a value is outside its range, or bursts of that mean length cannot make up that loss.
    """

    latency: float = 0.0
    jitter: float = 0.0
    loss_probability: float = 0.0
    mean_burst_length: float = 1.0
    range: float = math.inf
    loss_at_range: float = 0.0
    reorder_probability: float = 0.0
    reorder_delay: float = 0.15
    duplicate_probability: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "range":
                check_real(field.name, value, gt=0.0, allow_inf=True)
            elif field.name == "mean_burst_length":
                check_real(field.name, value, ge=1.0)
            else:
                share = field.name not in ("latency", "jitter", "reorder_delay")
                check_real(field.name, value, ge=0.0, le=1.0 if share else 60.0)
        if self.loss_probability >= 1.0:
            raise InputError("loss_probability must be below 1")
        if self.loss_probability > 0.0 and self.burst_start_probability > 1.0:
            raise InputError(
                f"mean_burst_length must be at least {self.loss_probability / (1.0 - self.loss_probability):.3g} for loss_probability {self.loss_probability:g}, "
                f"was {self.mean_burst_length:g}"
            )

    @property
    def burst_start_probability(self) -> float:
        """Probability that a loss follows on a message that was not lost [-]."""
        return self.loss_probability / (self.mean_burst_length * (1.0 - self.loss_probability))

    @classmethod
    def wyoming(cls) -> Self:
        """Loss as in the first 16 s of a recorded drive of the Wyoming connected-vehicle pilot.

        Returns
        -------
        settings : ChannelSettings
            28 % lost, in bursts of 3 messages in the mean; 20 ms latency and 10 ms jitter, which the record
            does not show, are assumed.
        """
        return cls(latency=0.02, jitter=0.01, loss_probability=0.28, mean_burst_length=3.0)


class ReceivedMessage(NamedTuple):
    """A message that has arrived.

    Parameters
    ----------
    data : bytes
        As sent.
    sender : str
        Who sent it, for evaluation; a receiver does not know.
    t : float
        When it arrived [s].
    """

    data: bytes
    sender: str
    t: float


class _Flying(NamedTuple):
    t: float  # of arrival
    number: int  # ties are resolved by order of sending
    data: bytes
    sender: str
    place: tuple[float, float]
    luck: float


class Channel:
    """Carries messages of many senders to one receiver.

    Parameters
    ----------
    settings : ChannelSettings
        What it does to them.
    rng : numpy.random.Generator
        Source of chance. What happens to a message depends only on the messages sent before it, not on when
        the receiver looks.
    """

    def __init__(self, settings: ChannelSettings, rng: np.random.Generator) -> None:
        self.settings = settings
        self._rng = rng
        self._lossy: dict[str, bool] = {}
        self._flying: list[_Flying] = []
        self._number = 0

    def send(self, t: float, position: tuple[float, float], data: bytes, *, sender: str = "") -> None:
        """Send a message.

        Parameters
        ----------
        t : float
            Now [s].
        position : tuple of float
            Where the sender is [m].
        data : bytes
            The message.
        sender : str
            Who sends; bursts of loss are each sender's own.

        Raises
        ------
        InputError
            If the time or the position is not finite.
        """
        t = check_real("t", t)
        x, y = check_array("position", position, (2,)).tolist()
        settings = self.settings
        fading, luck, held, again, after = self._rng.random(5).tolist()
        jitter = settings.jitter * float(self._rng.standard_exponential())
        before = self._lossy.get(sender)
        if before is None:
            lossy = fading < settings.loss_probability
        else:
            lossy = fading < (
                1.0 - 1.0 / settings.mean_burst_length if before else settings.burst_start_probability
            )
        self._lossy[sender] = lossy
        if lossy:
            return
        arrives = (
            t + settings.latency + jitter + settings.reorder_delay * (held < settings.reorder_probability)
        )
        times = [arrives]
        if again < settings.duplicate_probability:
            times.append(arrives + settings.reorder_delay * after)
        for arrives in times:
            self._flying.append(_Flying(arrives, self._number, data, sender, (x, y), luck))
            self._number += 1

    def receive(self, t: float, position: tuple[float, float]) -> tuple[ReceivedMessage, ...]:
        """Take what has arrived since the last call.

        Parameters
        ----------
        t : float
            Now [s].
        position : tuple of float
            Where the receiver is [m].

        Returns
        -------
        arrivals : tuple of Arrival
            In order of arrival.

        Raises
        ------
        InputError
            If the time or the position is not finite.
        """
        t = check_real("t", t)
        x, y = check_array("position", position, (2,)).tolist()
        due = sorted(f for f in self._flying if f.t <= t + 1e-9)
        self._flying = [f for f in self._flying if f.t > t + 1e-9]
        return tuple(
            ReceivedMessage(f.data, f.sender, f.t)
            for f in due
            if self._reaches(math.dist(f.place, (x, y)), f.luck)
        )

    def _reaches(self, distance: float, luck: float) -> bool:
        settings = self.settings
        if distance > settings.range:
            return False
        return luck >= settings.loss_at_range * (distance / settings.range) ** 4
