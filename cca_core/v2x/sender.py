"""Sender of ten messages per second, with the errors of real devices."""

import math
from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from cca_core._checks import check_real
from cca_core._repr import short_repr
from cca_core.path.local_frame import LocalFrame
from cca_core.v2x._projection import unprojector
from cca_core.v2x.bsm import Bsm, PositionalAccuracy, encode_bsm
from cca_core.vehicle import MAX_COORDINATE, RemoteVehicle

__all__ = ["Sender", "SenderSettings"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SenderSettings:
    """Interval and errors of a sender.

    Parameters
    ----------
    interval : float
        Mean time between messages [s].
    interval_spread : float
        Largest deviation from it [s]; intervals are distributed uniformly.
    position_noise : float
        Standard deviation of the position in each of x and y [m]; messages report it.
    noise_time_constant : float
        Correlation time of the noise [s]; 0 is white noise.
    freeze_probability : float
        Probability that a message begins to repeat the last position [-].
    mean_freeze_length : float
        Mean number of repetitions [-], at least 1.

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

    __repr__ = short_repr

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
            Intervals of 95 to 105 ms; 3 % of the messages repeat a position.
        """
        return cls(interval_spread=0.005, freeze_probability=0.03)


class Sender:
    """Sender of the motion of a vehicle as messages.

    Parameters
    ----------
    id : str
        Temporary identity: 8 hexadecimal digits in lower case.
    frame : LocalFrame
        Frame of the vehicle's position.
    settings : SenderSettings
        Interval and errors.
    rng : numpy.random.Generator
        Source of randomness; the first message is sent at a random time within the first interval.
    """

    def __init__(
        self, id: str, frame: LocalFrame, settings: SenderSettings, rng: np.random.Generator
    ) -> None:
        self.id, self.settings = id, settings
        self._frame, self._rng, self._unproject = frame, rng, unprojector(frame)
        self._due: float | None = None
        self._count = int(rng.integers(128))
        self._phase = float(rng.random()) * settings.interval
        self._last: tuple[float, float, float] | None = None  # time, latitude, longitude
        self._noise = 0.0, 0.0
        error = min(settings.position_noise, 12.7) or None  # [m], the largest code
        self._accuracy = PositionalAccuracy(semi_major=error, semi_minor=error)
        self._is_frozen = False

    def poll(self, t: float, vehicle: RemoteVehicle, *, transmission: str | None = "forward") -> bytes | None:
        """Return a message if one is due.

        Parameters
        ----------
        t : float
            Now, with minutes at multiples of 60 [s]; grows from call to call.
        vehicle : RemoteVehicle
            Position, motion, size and events now.
        transmission : str or None
            Reported gear while the vehicle moves forward; ``"reverse"`` is automatic.

        Returns
        -------
        data : bytes or None
            A message; None if none is due.

        Raises
        ------
        InputError
            If `t` or a value of the vehicle cannot be encoded.
        """
        t = check_real("t", t)
        if self._due is None:
            self._due = t + self._phase
        if t < self._due - 1e-9:
            return None
        settings = self.settings
        spread, begins, ends_by = self._rng.random(3).tolist()
        shock = self._rng.standard_normal(2).tolist()
        while self._due <= t + 1e-9:
            self._due += settings.interval + settings.interval_spread * (2.0 * spread - 1.0)
        last = self._last
        lat, lon = self._position(t, vehicle, shock)
        ends = ends_by < 1.0 / settings.mean_freeze_length
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

    def _position(self, t: float, vehicle: RemoteVehicle, shock: list[float]) -> tuple[float, float]:
        """Return the latitude and longitude that the sender measures [deg]."""
        settings = self.settings
        correlation = 0.0
        if self._last is not None and settings.noise_time_constant > 0.0:
            correlation = math.exp(-(t - self._last[0]) / settings.noise_time_constant)
        size = math.sqrt(1.0 - correlation * correlation) * settings.position_noise
        east, north = (correlation * last + size * new for last, new in zip(self._noise, shock, strict=True))
        self._noise = east, north
        x, y = vehicle.x + east, vehicle.y + north
        if not (abs(x) <= MAX_COORDINATE and abs(y) <= MAX_COORDINATE):
            self._frame.to_geodetic((x, y))  # raises, and says why
        return self._unproject(x, y)
