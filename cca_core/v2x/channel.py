"""Simulated radio channel: latency, burst loss, reordering, duplicates and range."""

import math
from dataclasses import dataclass, fields
from typing import NamedTuple, Self

import numpy as np

from cca_core._checks import check_array, check_real
from cca_core._repr import short_repr
from cca_core.errors import InputError

__all__ = ["Channel", "ChannelSettings", "ReceivedMessage"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelSettings:
    """Impairments of a channel; the default is a perfect one.

    Parameters
    ----------
    latency : float
        Least transport delay [s].
    jitter : float
        Mean of an additional delay, exponentially distributed [s].
    loss_probability : float
        Probability of loss at distance 0 [-], below 1.
    mean_burst_length : float
        Mean number of messages lost in succession [-], at least 1; 1 / (1 - `loss_probability`) is loss
        without memory.
    range : float
        Distance beyond which no message arrives [m].
    loss_at_range : float
        Additional probability of loss at `range` [-]; it grows with the fourth power of distance.
    reorder_probability : float
        Probability that a message is delayed by `reorder_delay` and overtaken by later ones [-].
    reorder_delay : float
        Delay of reordered messages, largest delay of duplicates [s].
    duplicate_probability : float
        Probability that a message arrives twice, the second time up to `reorder_delay` later [-].

    Raises
    ------
    InputError
        If a value is outside its range, or bursts of that mean length cannot have that loss probability.
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

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "range":
                check_real(field.name, value, gt=0.0, allow_inf=True)
            elif field.name == "mean_burst_length":
                check_real(field.name, value, ge=1.0)
            else:
                is_time = field.name in ("latency", "jitter", "reorder_delay")
                check_real(field.name, value, ge=0.0, le=60.0 if is_time else 1.0)
        if self.loss_probability >= 1.0:
            raise InputError("loss_probability must be below 1")
        if self.loss_probability > 0.0 and self.burst_start_probability > 1.0:
            shortest = self.loss_probability / (1.0 - self.loss_probability)
            raise InputError(
                f"mean_burst_length must be at least {shortest:.3g} for loss_probability "
                f"{self.loss_probability:g}, was {self.mean_burst_length:g}"
            )

    @property
    def burst_start_probability(self) -> float:
        """Probability that a burst of loss begins after a received message [-]."""
        return self.loss_probability / (self.mean_burst_length * (1.0 - self.loss_probability))

    @classmethod
    def wyoming(cls) -> Self:
        """Loss as in the first 16 s of a recorded drive of the Wyoming connected-vehicle pilot.

        Returns
        -------
        settings : ChannelSettings
            28 % loss in bursts of 3 messages on average. The record shows no latency: 20 ms and 10 ms jitter
            are assumed.
        """
        return cls(latency=0.02, jitter=0.01, loss_probability=0.28, mean_burst_length=3.0)


class ReceivedMessage(NamedTuple):
    """A received message.

    Parameters
    ----------
    data : bytes
        Bytes as sent.
    sender : str
        Sender, for evaluation only: a receiver does not have it.
    t : float
        Time of arrival [s].
    """

    data: bytes
    sender: str
    t: float


class _InFlight(NamedTuple):
    """A message that has not been received."""

    t: float  # of arrival
    number: int  # ties are resolved by order of sending
    data: bytes
    sender: str
    position: tuple[float, float]
    luck: float  # drawn once, compared with the loss by distance


class Channel:
    """Channel of many senders to one receiver.

    Parameters
    ----------
    settings : ChannelSettings
        Impairments.
    rng : numpy.random.Generator
        Source of randomness. The fate of a message depends only on the messages sent before it, not on the
        times of `receive`.
    """

    def __init__(self, settings: ChannelSettings, rng: np.random.Generator) -> None:
        self.settings = settings
        self._rng = rng
        self._lossy: dict[str, bool] = {}
        self._in_flight: list[_InFlight] = []
        self._number = 0

    def send(self, t: float, position: tuple[float, float], data: bytes, *, sender: str = "") -> None:
        """Send a message.

        Parameters
        ----------
        t : float
            Now [s].
        position : tuple of float
            Position of the sender [m].
        data : bytes
            The message.
        sender : str
            Sender; every sender has its own bursts of loss.

        Raises
        ------
        InputError
            If the time or the position is not finite.
        """
        t = check_real("t", t)
        x, y = _checked(position)
        settings = self.settings
        fading, luck, late, again, after = self._rng.random(5).tolist()
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
            t + settings.latency + jitter + settings.reorder_delay * (late < settings.reorder_probability)
        )
        times = [arrives]
        if again < settings.duplicate_probability:
            times.append(arrives + settings.reorder_delay * after)
        for arrives in times:
            self._in_flight.append(_InFlight(arrives, self._number, data, sender, (x, y), luck))
            self._number += 1

    def receive(self, t: float, position: tuple[float, float]) -> tuple[ReceivedMessage, ...]:
        """Return the messages that have arrived since the last call.

        Parameters
        ----------
        t : float
            Now [s].
        position : tuple of float
            Position of the receiver [m].

        Returns
        -------
        messages : tuple of ReceivedMessage
            In order of arrival.

        Raises
        ------
        InputError
            If the time or the position is not finite.
        """
        t = check_real("t", t)
        x, y = _checked(position)
        due = [f for f in self._in_flight if f.t <= t + 1e-9]
        if not due:
            return ()
        self._in_flight = [f for f in self._in_flight if f.t > t + 1e-9]
        return tuple(
            ReceivedMessage(f.data, f.sender, f.t)
            for f in sorted(due)
            if self._reaches(math.dist(f.position, (x, y)), f.luck)
        )

    def _reaches(self, distance: float, luck: float) -> bool:
        """Return whether a message arrives over a distance [m]."""
        settings = self.settings
        if distance > settings.range:
            return False
        return luck >= settings.loss_at_range * (distance / settings.range) ** 4


def _checked(position: tuple[float, float]) -> tuple[float, float]:
    """Return a position if it is finite."""
    try:
        x, y = position
        if type(x) is type(y) is float and math.isfinite(x) and math.isfinite(y):  # without arrays
            return x, y
    except (TypeError, ValueError):
        pass
    x, y = check_array("position", position, (2,)).tolist()
    return x, y
