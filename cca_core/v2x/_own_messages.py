"""The ego's own messages, heard back under an unknown id: a body on the ego's place with its motion."""

import math
from collections import deque

from cca_core.geometry import wrap_angle
from cca_core.v2x.motion import Fix
from cca_core.vehicle import RemoteVehicle, VehicleState

__all__ = ["EgoLikeness", "EgoMotion"]

_NEAR = 10.0  # farther away the sender is another vehicle, or has lost its position [m]
_MIN_SPEED = 2.0  # a queue at standstill proves nothing [m/s]
_CERTAIN, _MAX_COUNT = 10, 20  # messages on the ego's place that prove it; messages in the mean offset
_ACROSS = 1.3  # of the mean offset from the ego; another body would overlap it [m]
_ACROSS_CERTAIN, _ACROSS_NOW = 3.0, 3.3  # three standard deviations of a receiver's error; now, a lane [m]
_ACROSS_MOVING = 2.5  # of a sender that changes its speed as the ego does: less than a lane [m]
_SWING = 0.1  # change of speed that shows whether another has it too [m/s]
_PART = 0.25  # of the ego's changes of speed by which those of its messages may differ, root mean square
_TURNED = 0.05  # heading of the ego and of its messages may differ by this [rad]
_NEWER = 0.05  # a message may be newer than the last state [s]
_DIFFERS = 0.3  # by this speed a sender does not move as the ego does [m/s]


class EgoMotion:
    """Speed and heading of the ego during the last seconds."""

    def __init__(self) -> None:
        self._states: deque[tuple[float, float, float]] = deque(maxlen=200)

    def add(self, t: float, ego: VehicleState) -> None:
        """Add the state at a time [s]; begin anew if time runs backward."""
        if self._states and t < self._states[-1][0]:
            self._states.clear()
        self._states.append((t, ego.v_x, ego.psi))

    def at(self, t: float) -> tuple[float, float] | None:
        """Return speed [m/s] and heading [rad] at a time [s], None if it is unknown."""
        later = None
        for state in reversed(self._states):
            if state[0] > t:
                later = state
                continue
            if later is None:  # the message is newer than the last state
                return state[1:] if t - state[0] <= _NEWER else None
            part = (t - state[0]) / (later[0] - state[0])
            return state[1] + part * (later[1] - state[1]), later[2]
        return None


class EgoLikeness:
    """Evidence that a sender is the ego.

    Another body cannot be where the ego is. The error of a receiver may drift, and shift the messages
    to the side for seconds. They still change their speed when the ego does, by as much.
    """

    __slots__ = ("_across", "_along", "_count", "_needed", "_shares_motion", "_speeds", "_t", "is_certain")

    def __init__(self) -> None:
        self.is_certain = False  # whether it was on the ego's place for a second
        self._shares_motion = False  # whether it changed its speed as the ego did
        self._speeds: deque[tuple[float, float]] = deque(maxlen=_MAX_COUNT)  # of the ego, difference [m/s]
        self._t = -math.inf  # of the last message compared [s]
        self._count = 0  # messages with the ego's motion, less after one with another
        self._along = self._across = 0.0  # mean offset from the ego [m]: noise of single messages is none
        self._needed = 2  # messages; more if the sender was heard elsewhere

    def compare(self, fix: Fix, ego: VehicleState, vehicle: RemoteVehicle, motion: EgoMotion) -> bool:
        """Return whether the sender of a last message, now at `vehicle`, seems to be the ego."""
        x, y = vehicle.x - ego.x, vehicle.y - ego.y
        if abs(x) + abs(y) > _NEAR:
            self.is_certain, self._count, self._needed = False, 0, _CERTAIN
            self._shares_motion = False
            self._speeds.clear()
            return False
        if fix.t != self._t:
            self._t = fix.t
            self._add(ego, vehicle, x, y)
            self._compare_motion(fix, motion)
        limit = _ACROSS_CERTAIN if self.is_certain else _ACROSS_MOVING if self._shares_motion else _ACROSS
        # along: antenna, center of the body and time stamps differ
        now = abs(y * math.cos(ego.psi) - x * math.sin(ego.psi))
        fits = (
            now <= _ACROSS_NOW
            and abs(self._across) <= limit
            and abs(self._along) <= limit + 0.7 + 0.05 * ego.v_x
        )  # [m, s]
        own = fits and self._count >= self._needed
        is_near = self._count >= _CERTAIN and abs(self._across) <= _ACROSS
        self.is_certain = own and (self.is_certain or is_near)
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

    def _compare_motion(self, fix: Fix, motion: EgoMotion) -> None:
        """Compare speed and heading of a message with those of the ego when it was made."""
        state = motion.at(fix.t)
        if state is None:
            return
        speed, difference = state[0], fix.v - state[0]
        if abs(difference) > _DIFFERS or abs(wrap_angle(fix.psi - state[1])) > _TURNED:
            self._shares_motion = False
            self._speeds.clear()
            return
        self._speeds.append((speed, difference))
        mean = sum(v for v, _ in self._speeds) / len(self._speeds)
        changes = sum((v - mean) ** 2 for v, _ in self._speeds)
        differences = sum(d * d for _, d in self._speeds)
        swing = max(v for v, _ in self._speeds) - min(v for v, _ in self._speeds)
        if swing >= _SWING and differences <= _PART * _PART * changes:
            self._shares_motion = True
