"""A vehicle that sends messages ten times a second, with the faults of real senders."""

import math
from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from cca_core._checks import check_real
from cca_core.path.local_frame import LocalFrame
from cca_core.v2x.bsm import Bsm, PositionalAccuracy, encode_bsm
from cca_core.vehicle import RemoteVehicle

__all__ = ["Sender", "SenderSettings"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SenderSettings:
    """How often a sender sends, and how well it knows its place.

    Parameters
    ----------
    interval : float
        Mean time between messages [s].
    interval_spread : float
        Largest difference from it [s]; intervals are distributed evenly.
    position_noise : float
        Standard deviation of the position in each of x and y [m]; its messages tell it.
    noise_time_constant : float
        Time over which the noise forgets itself [s]; 0 is noise without memory.
    freeze_probability : float
        Probability that a message begins to repeat the last position [-].
    mean_freeze_length : float
        Mean number of messages that repeat it [-], at least 1.

    Raises
    ------
    InputError
        If a value is outside its range.
    """

    interval: float = 0.1
    interval_spread: float = 0.0
    position_noise: float = 0.0
    noise_time_constant: float = 0.0
    freeze_probability: float = 0.0
    mean_freeze_length: float = 1.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "interval":
                check_real(field.name, value, gt=0.0)
            elif field.name == "interval_spread":
                check_real(field.name, value, ge=0.0, le=0.5 * self.interval)
            elif field.name == "mean_freeze_length":
                check_real(field.name, value, ge=1.0)
            else:
                check_real(field.name, value, ge=0.0, le=1.0 if field.name == "freeze_probability" else 1e3)

    @classmethod
    def wyoming(cls) -> Self:
        """Sender of the Wyoming connected-vehicle pilot.

        Returns
        -------
        settings : SenderSettings
            Intervals of 95 to 105 ms; 3 % of its messages repeat a position.
        """
        return cls(interval_spread=0.005, freeze_probability=0.03)


class Sender:
    """Turns the motion of a vehicle into messages.

    Parameters
    ----------
    id : str
        Temporary identity: 8 hexadecimal digits in lower case.
    frame : LocalFrame
        Plane in which the vehicle moves.
    settings : SenderSettings
        Interval and faults.
    rng : numpy.random.Generator
        Source of chance; the first message is sent at a random time within the first interval.
    """

    def __init__(
        self, id: str, frame: LocalFrame, settings: SenderSettings, rng: np.random.Generator
    ) -> None:
        self.id, self.settings = id, settings
        self._frame, self._rng = frame, rng
        self._due: float | None = None
        self._count = int(rng.integers(128))
        self._phase = float(rng.random()) * settings.interval
        self._last: tuple[float, float, float] | None = None  # time, latitude, longitude
        self._noise = np.zeros(2)
        error = min(settings.position_noise, 12.7) or None  # [m], the largest that can be told
        self._accuracy = PositionalAccuracy(semi_major=error, semi_minor=error)
        self._is_frozen = False

    def poll(self, t: float, vehicle: RemoteVehicle, *, transmission: str | None = "forward") -> bytes | None:
        """Send if it is time to.

        Parameters
        ----------
        t : float
            Now, with minutes at multiples of 60 [s]; grows from call to call.
        vehicle : RemoteVehicle
            Place, motion, size and events now.
        transmission : str or None
            What the message says of it while the vehicle moves forward; ``"reverse"`` is set by itself.

        Returns
        -------
        data : bytes or None
            A message, or None between two.

        Raises
        ------
        InputError
            If `t` or a value of the vehicle cannot be sent.
        """
        t = check_real("t", t)
        if self._due is None:
            self._due = t + self._phase
        if t < self._due - 1e-9:
            return None
        settings = self.settings
        spread, begins, stays = self._rng.random(3).tolist()
        shock = self._rng.standard_normal(2)
        while self._due <= t + 1e-9:
            self._due += settings.interval + settings.interval_spread * (2.0 * spread - 1.0)
        last = self._last
        lat, lon = self._place(t, vehicle, shock)
        ends = stays < 1.0 / settings.mean_freeze_length
        self._is_frozen = not ends if self._is_frozen else begins < settings.freeze_probability
        if self._is_frozen and last is not None:
            lat, lon = last[1:]
        self._last = t, lat, lon
        self._count = (self._count + 1) % 128
        return encode_bsm(
            Bsm(
                msg_count=self._count, id=self.id, sec_mark=round((t % 60.0) * 1000.0) % 60000 / 1000.0,
                latitude_deg=lat, longitude_deg=lon, speed=abs(vehicle.v_x), psi=vehicle.psi, a_x=vehicle.a_x,
                r=vehicle.r, transmission="reverse" if vehicle.v_x < 0.0 else transmission,
                width=vehicle.width, length=vehicle.length, events=vehicle.events,
                accuracy=self._accuracy,
            )
        )  # fmt: skip

    def _place(self, t: float, vehicle: RemoteVehicle, shock: np.ndarray) -> tuple[float, float]:
        """Latitude and longitude as the sender knows them [deg]."""
        settings = self.settings
        kept = 0.0
        if self._last is not None and settings.noise_time_constant > 0.0:
            kept = math.exp(-(t - self._last[0]) / settings.noise_time_constant)
        self._noise = kept * self._noise + math.sqrt(1.0 - kept * kept) * settings.position_noise * shock
        lat, lon = self._frame.to_geodetic((vehicle.x + self._noise[0], vehicle.y + self._noise[1]))
        return float(lat), float(lon)
