"""The ego's own messages, heard back under an unknown id: a body on the ego's place with its motion."""

import math

from cca_core.geometry import wrap_angle
from cca_core.vehicle import RemoteVehicle, VehicleState

__all__ = ["EgoLikeness"]

_NEAR = 10.0  # farther away the sender is another vehicle, or has lost its position [m]
_MIN_SPEED = 2.0  # a queue at standstill proves nothing [m/s]
_CERTAIN, _MAX_COUNT = 10, 20  # messages on the ego's place that prove it; messages in the mean offset
_ACROSS = 1.3  # of the mean offset from the ego; another body would overlap it [m]
_ACROSS_CERTAIN, _ACROSS_NOW = 3.0, 3.3  # three standard deviations of a receiver's error; now, a lane [m]


class EgoLikeness:
    """Evidence that a sender is the ego: another body cannot be where the ego is."""

    __slots__ = ("_across", "_along", "_count", "_needed", "_t", "is_certain")

    def __init__(self) -> None:
        self.is_certain = False  # whether it was on the ego's place for a second
        self._t = -math.inf  # of the last message compared [s]
        self._count = 0  # messages with the ego's motion, less after one with another
        self._along = self._across = 0.0  # mean offset from the ego [m]: noise of single messages is none
        self._needed = 2  # messages; more if the sender was heard elsewhere

    def compare(self, t: float, ego: VehicleState, vehicle: RemoteVehicle) -> bool:
        """Return whether a sender with its last message at `t` seems to be the ego."""
        x, y = vehicle.x - ego.x, vehicle.y - ego.y
        if abs(x) + abs(y) > _NEAR:
            self.is_certain, self._count, self._needed = False, 0, _CERTAIN
            return False
        if t != self._t:
            self._t = t
            self._add(ego, vehicle, x, y)
        # along: antenna, center of the body and time stamps differ
        limit = _ACROSS_CERTAIN if self.is_certain else _ACROSS
        now = abs(y * math.cos(ego.psi) - x * math.sin(ego.psi))
        fits = (
            now <= _ACROSS_NOW
            and abs(self._across) <= limit
            and abs(self._along) <= limit + 0.7 + 0.05 * ego.v_x
        )  # [m, s]
        own = fits and self._count >= self._needed
        self.is_certain = own and (self.is_certain or self._count >= _CERTAIN)
        return own

    def _add(self, ego: VehicleState, vehicle: RemoteVehicle, x: float, y: float) -> None:
        """Add a message at an offset from the ego [m]."""
        if abs(wrap_angle(vehicle.psi - ego.psi)) > 0.2 or abs(vehicle.v_x - ego.v_x) > 1.0:
            self._count //= 2
            return
        if ego.v_x > _MIN_SPEED:
            self._count = min(self._count + 1, _MAX_COUNT)
        if self._count:
            cos, sin = math.cos(ego.psi), math.sin(ego.psi)
            self._along += (x * cos + y * sin - self._along) / self._count
            self._across += (y * cos - x * sin - self._across) / self._count
