"""Motion that a message reports; speed, heading and gear that it does not report come from two positions."""

import math
from collections import deque
from typing import NamedTuple

from cca_core.v2x.bsm import Bsm
from cca_core.vehicle import STANDSTILL_SPEED

__all__ = ["MAX_UNREPORTED_REVERSING", "PositionHistory", "ReportedMotion", "reported_motion"]

MAX_UNREPORTED_REVERSING = 12.0
"""Speed up to which a sender without gear may be reversing [m/s]."""

_MAX_SPAN, _MIN_SPAN = 1.05, 0.05  # between two positions [s]
_MIN_DISTANCE = 0.5  # between two positions that show a heading [m]
_MIN_REVERSED = 0.7  # distance backwards that shows a reversing vehicle [m]
_POSITION_NOISE = 0.2  # between two positions [m]


class ReportedMotion(NamedTuple):
    """Heading (None if unknown) and signed speed, with a standard deviation that finding them adds [m]."""

    psi: float | None
    v: float
    sigma: float = 0.0
    gear_known: bool = True


class PositionHistory:
    """Positions of a sender in the last second."""

    __slots__ = ("_fixes",)

    def __init__(self) -> None:
        self._fixes: deque[tuple[float, float, float]] = deque(maxlen=12)

    @property
    def t(self) -> float:
        """Time of the last position [s]."""
        return self._fixes[-1][0] if self._fixes else -math.inf

    def displacement(self, t: float, x: float, y: float) -> tuple[float, float, float]:
        """Return time and displacement from the oldest position, and add a position; 0 if there is none."""
        fixes = self._fixes
        while fixes and not 0.0 <= t - fixes[0][0] <= _MAX_SPAN:
            fixes.popleft()
        first = fixes[0] if fixes else (t, x, y)
        if not fixes or t > fixes[-1][0]:
            fixes.append((t, x, y))
        dt = t - first[0]
        return (dt, x - first[1], y - first[2]) if dt >= _MIN_SPAN else (0.0, 0.0, 0.0)


def reported_motion(
    bsm: Bsm, last: tuple[float | None, float] | None, displacement: tuple[float, float, float]
) -> ReportedMotion | None:
    """Return the motion of a message; None if neither it nor two positions show it."""
    # last: heading (None if unknown) and speed of the track; displacement: time [s], x and y [m]
    speed, psi, gear = bsm.speed, bsm.psi, bsm.transmission
    dt, dx, dy = displacement
    moved = math.hypot(dx, dy)
    if speed is not None and psi is not None:
        backwards = gear == "reverse"
        if not backwards and gear != "forward":
            along = dx * math.cos(psi) + dy * math.sin(psi)
            clear = max(_MIN_REVERSED, 0.3 * speed * dt)
            if moved > 2.0 * speed * dt + 3.0:  # [m], the positions are not of one body
                along = 0.0
            backwards = along < -clear or (along < clear and last is not None and last[1] < 0.0)
        return ReportedMotion(psi, -speed if backwards else speed, 0.0, gear in ("forward", "reverse"))
    sigma = 0.3 * _POSITION_NOISE / dt if dt else 0.0
    sign = -1.0 if gear == "reverse" else 1.0
    if psi is None:
        if speed is None:
            if not dt:
                return None
            speed = moved / dt if moved >= _MIN_DISTANCE else 0.0
        if moved >= _MIN_DISTANCE and speed > STANDSTILL_SPEED:
            return ReportedMotion(math.atan2(sign * dy, sign * dx), sign * speed, sigma)
        known = None if last is None else last[0]
        if known is None and speed > STANDSTILL_SPEED:
            return None
        return ReportedMotion(known, sign * speed)
    if not dt:
        return None
    v = (dx * math.cos(psi) + dy * math.sin(psi)) / dt
    return ReportedMotion(psi, max(v, 0.0) if gear == "forward" else v, sigma)
