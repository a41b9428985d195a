"""What one message says of a sender's motion, where that takes it, and how well this is known."""

import math
from typing import NamedTuple

__all__ = ["STALE_AFTER", "Fix", "move_on", "position_bounds"]

STALE_AFTER = 1.0
"""Age from which on a track is stale [s]."""

_CREEPING = 0.5  # slower than this the direction of motion is not known [m/s]

# Bounds that hold in 95 % of cases on the recorded drives; docs/v2x.md says how they were found
_TIMING_RATE = 1.3  # growth of the error of time stamps with age [s/s]
_TIMING = 0.31  # its end [s]
_DRIFT = 0.005  # its growth from there on [s/s]
_ALONG = 0.1  # at standstill [m]
_ACROSS = 0.06  # new [m]
_ACROSS_RATE = 0.22  # growth with age [m/s]
# beyond the record
_BRAKING = 8.0  # what a vehicle may do that is not heard any more [m/s^2]
_SWERVING = 1.0


class Fix(NamedTuple):
    """Motion of a sender at one time, in the local frame at the centre of its body.

    Parameters
    ----------
    t : float
        When it was measured [s].
    x, y : float
        Position [m].
    psi : float
        Heading [rad], counter-clockwise from +x.
    v : float
        Forward speed [m/s], negative in reverse.
    a : float
        Forward acceleration [m/s^2].
    r : float
        Yaw rate [rad/s], left positive.
    """

    t: float
    x: float
    y: float
    psi: float
    v: float
    a: float = 0.0
    r: float = 0.0


def move_on(fix: Fix, t: float) -> Fix:
    """Dead-reckon to a later time.

    Parameters
    ----------
    fix : Fix
        Where the sender was.
    t : float
        Time asked [s]; one before the fix gives the fix.

    Returns
    -------
    fix : Fix
        Where it is: constant turn rate and acceleration for 1 s as in `predict_free`, then straight on at
        the speed reached. A braking vehicle stops.
    """
    _, x, y, psi, v, a, r = fix
    age = max(t - fix.t, 0.0)
    turning = min(age, STALE_AFTER)
    if a * v < 0.0:
        turning = min(turning, -v / a)
    s = (v + 0.5 * a * turning) * turning
    half = 0.5 * r / v * s if abs(v) >= _CREEPING else 0.0
    chord = s * math.sin(half) / half if half else s
    x, y, psi = x + chord * math.cos(psi + half), y + chord * math.sin(psi + half), psi + 2.0 * half
    after = v + a * turning
    if a * v < 0.0 and after * v <= 1e-9:
        return Fix(t, x, y, psi, 0.0)
    if age > STALE_AFTER:
        straight = after * (age - STALE_AFTER)
        return Fix(t, x + straight * math.cos(psi), y + straight * math.sin(psi), psi, after)
    return Fix(t, x, y, psi, after, a, r)


def position_bounds(v: float, age: float) -> tuple[float, float]:
    """Errors of a dead-reckoned position that are not exceeded in 95 % of cases.

    Parameters
    ----------
    v : float
        Speed reported [m/s].
    age : float
        Time since the position was measured [s], not negative.

    Returns
    -------
    along, across : float
        Half extents along and across the heading [m]; the standard deviation is taken to be half of each.

    Notes
    -----
    Up to 1 s the bounds are those of recorded messages, whose largest error is that of their time stamps and
    so goes with speed. Beyond, the vehicle may have braked or sped up at 8 m/s^2 to at most twice its speed,
    and swerved at 1 m/s^2.

    Examples
    --------
    >>> [round(b, 2) for b in position_bounds(20.0, 0.1) + position_bounds(20.0, 1.0)]
    [2.7, 0.08, 6.4, 0.28]
    """
    speed = abs(v)
    timing = min(_TIMING_RATE * age, _TIMING + _DRIFT * age)
    along, across = _ALONG + speed * timing, _ACROSS + _ACROSS_RATE * age
    late = age - STALE_AFTER
    if late > 0.0:
        along += min(0.5 * _BRAKING * late * late, max(speed, _CREEPING) * late)
        across += min(0.5 * _SWERVING * late * late, max(speed, _CREEPING) * late)
    return along, across
