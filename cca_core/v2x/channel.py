"""A radio channel in software: bytes are late, lost in bursts, out of order, twice or out of range."""

import math
from dataclasses import dataclass, fields
from typing import NamedTuple, Self

import numpy as np

from cca_core._checks import check_array, check_real
from cca_core.errors import InputError

__all__ = ["Arrival", "Channel", "ChannelSettings"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelSettings:
    """What a channel does to messages; the default does nothing.

    Parameters
    ----------
    latency : float
        Least time from sending to receiving [s].
    jitter : float
        Mean of what is added to it, exponentially distributed [s].
    loss : float
        Share of messages lost near by [-], below 1.
    burst : float
        Mean number of messages lost in a row [-], at least 1; 1 / (1 - `loss`) is loss without memory.
    range : float
        Distance beyond which nothing arrives [m].
    edge_loss : float
        Share of messages lost besides at that distance [-]; grows with the fourth power of distance.
    reordered : float
        Share of messages that are held back by `reordering`, so that later ones overtake them [-].
    reordering : float
        Time for which they are held back [s].
    duplicated : float
        Share of messages that arrive a second time, up to `reordering` later [-].

    Raises
    ------
    InputError
        If a value is outside its range, or bursts of that mean length cannot make up that loss.
    """

    latency: float = 0.0
    jitter: float = 0.0
    loss: float = 0.0
    burst: float = 1.0
    range: float = math.inf
    edge_loss: float = 0.0
    reordered: float = 0.0
    reordering: float = 0.15
    duplicated: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "range":
                check_real(field.name, value, above=0.0, infinite=True)
            elif field.name == "burst":
                check_real(field.name, value, least=1.0)
            else:
                share = field.name not in ("latency", "jitter", "reordering")
                check_real(field.name, value, least=0.0, most=1.0 if share else 60.0)
        if self.loss >= 1.0:
            raise InputError("loss must be below 1")
        if self.loss > 0.0 and self.entering > 1.0:
            raise InputError(
                f"burst must be at least {self.loss / (1.0 - self.loss):.3g} for loss {self.loss:g}, "
                f"was {self.burst:g}"
            )

    @property
    def entering(self) -> float:
        """Probability that a loss follows on a message that was not lost [-]."""
        return self.loss / (self.burst * (1.0 - self.loss))

    @classmethod
    def wyoming(cls) -> Self:
        """Loss as in the first 16 s of a recorded drive of the Wyoming connected-vehicle pilot.

        Returns
        -------
        settings : ChannelSettings
            28 % lost, in bursts of 3 messages in the mean; 20 ms latency and 10 ms jitter, which the record
            does not show, are assumed.
        """
        return cls(latency=0.02, jitter=0.01, loss=0.28, burst=3.0)


class Arrival(NamedTuple):
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
            lossy = fading < settings.loss
        else:
            lossy = fading < (1.0 - 1.0 / settings.burst if before else settings.entering)
        self._lossy[sender] = lossy
        if lossy:
            return
        arrives = t + settings.latency + jitter + settings.reordering * (held < settings.reordered)
        times = [arrives]
        if again < settings.duplicated:
            times.append(arrives + settings.reordering * after)
        for arrives in times:
            self._flying.append(_Flying(arrives, self._number, data, sender, (x, y), luck))
            self._number += 1

    def receive(self, t: float, position: tuple[float, float]) -> tuple[Arrival, ...]:
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
            Arrival(f.data, f.sender, f.t) for f in due if self._reaches(math.dist(f.place, (x, y)), f.luck)
        )

    def _reaches(self, distance: float, luck: float) -> bool:
        settings = self.settings
        if distance > settings.range:
            return False
        return luck >= settings.edge_loss * (distance / settings.range) ** 4
