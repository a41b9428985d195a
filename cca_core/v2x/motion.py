"""What one message says of a sender's motion, where that takes it, and how well this is known."""

import math
from typing import NamedTuple

from cca_core.geometry import wrap_angle

__all__ = ["STALE_AFTER", "Fix", "dead_reckon", "position_bounds", "predicted_displacement"]

STALE_AFTER = 1.0
"""Age from which on a track is stale [s]."""

_CREEPING = 0.5  # slower than this the direction of motion is not known [m/s]

# Bounds of 95 %: the largest errors of the first half of the recorded drives, rounded up; see docs/v2x.md
_TIMING_RATE = 2.3  # growth of the error of time stamps with age [s/s]
_TIMING = 0.31  # its end [s]
_ALONG = 0.1  # at standstill [m]
_ACROSS = 0.035  # new [m]
_ACROSS_RATE = 0.32  # growth with age [m/s]
# beyond the record
_BRAKING = 8.0  # what a vehicle may do that is not heard any more [m/s^2]
_SWERVING = 1.0


class Fix(NamedTuple):
    """Motion of a sender at one time, in the local frame at the center of its body.

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


def dead_reckon(fix: Fix, t: float) -> Fix:
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
        Where it is: constant turn rate and acceleration for 1 s as in `predict_ctra`, then straight on at
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


def predicted_displacement(last: Fix, fix: Fix) -> tuple[float, float, float]:
    """Place to which the motion told by two messages leads from the place of the first.

    Parameters
    ----------
    last, fix : Fix
        The two, in order of time; the place of the second is not looked at.

    Returns
    -------
    x, y : float
        Place [m], at the mean of speeds and headings.
    driven : float
        Way from the one to the other [m], not negative.
    """
    mean = last.psi + 0.5 * wrap_angle(fix.psi - last.psi)
    s = 0.5 * (last.v + fix.v) * (fix.t - last.t)
    return last.x + s * math.cos(mean), last.y + s * math.sin(mean), abs(s)


def position_bounds(v: float, age: float, driven: float = math.inf) -> tuple[float, float]:
    """Errors of a dead-reckoned position that are not exceeded in 95 % of cases.

    Parameters
    ----------
    v : float
        Speed reported with the position [m/s].
    age : float
        Time since the position was measured [s], not negative.
    driven : float
        Distance driven since by the speeds reported later [m]; infinite if nothing was heard.

    Returns
    -------
    along, across : float
        Half extents along and across the heading [m]; the standard deviation is taken to be half of each.

    Notes
    -----
    Up to 1 s the bounds are those of recorded messages, whose largest error is that of their time stamps and
    so goes with speed. Beyond, the vehicle may have braked or sped up at 8 m/s^2 to at most twice its speed,
    and swerved at 1 m/s^2. Where its speed is still heard, it may stand where it was or be twice as far.

    Examples
    --------
    >>> [round(b, 2) for b in position_bounds(20.0, 0.1) + position_bounds(20.0, 1.0)]
    [4.7, 0.07, 6.3, 0.35]
    """
    speed = abs(v)
    timing = min(_TIMING_RATE * age, _TIMING)
    along, across = _ALONG + speed * timing, _ACROSS + _ACROSS_RATE * age
    late = age - STALE_AFTER
    if late > 0.0:
        most = min(max(speed, _CREEPING) * late, driven + _CREEPING * late)
        along += min(0.5 * _BRAKING * late * late, most)
        across += min(0.5 * _SWERVING * late * late, most)
    return along, across
