"""Motion of a sender by one message, its dead reckoning, and the bounds of the error."""

import math
from dataclasses import dataclass, fields
from typing import NamedTuple

from cca_core._checks import check_real, formula
from cca_core._repr import short_repr
from cca_core.geometry import wrap_angle
from cca_core.vehicle import STALE_AGE, STANDSTILL_SPEED

__all__ = ["Fix", "PositionErrorModel", "dead_reckon", "position_bounds", "predicted_displacement"]


class Fix(NamedTuple):
    """Motion of a sender at one time, in the local frame at the center of its body.

    Parameters
    ----------
    t : float
        Time of measurement [s].
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


@dataclass(frozen=True, slots=True, kw_only=True)
class PositionErrorModel:
    """Errors of dead-reckoned positions that are not exceeded in 95 % of cases.

    The first five values are the largest errors of the first half of recorded drives, rounded up. Beyond an
    age of 1 s there is no record: a vehicle that is not received may brake, accelerate and leave its lane.

    Parameters
    ----------
    time_error_rate : float
        Growth of the error of time stamps with age [s/s].
    max_time_error : float
        Its end [s]; it moves the position along the heading in proportion to speed.
    along : float
        Error along the heading at standstill [m].
    across : float
        Error across the heading at age 0 [m].
    across_rate : float
        Its growth with age [m/s].
    assumed_acceleration : float
        Unreported acceleration or braking after 1 s [m/s^2].
    assumed_lateral_acceleration : float
        Unreported lateral acceleration after 1 s [m/s^2].

    Raises
    ------
    InputError
        If a value is negative or not finite.
    """

    time_error_rate: float = 2.3
    max_time_error: float = 0.31
    along: float = 0.1
    across: float = 0.035
    across_rate: float = 0.32
    assumed_acceleration: float = 8.0
    assumed_lateral_acceleration: float = 1.0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for field in fields(self):
            check_real(field.name, getattr(self, field.name), ge=0.0)


_RECORDED = PositionErrorModel()


@formula
def dead_reckon(fix: Fix, t: float) -> Fix:
    """Dead-reckon to a later time.

    Parameters
    ----------
    fix : Fix
        Last motion of the sender.
    t : float
        Time asked [s]; one before the fix returns the fix.

    Returns
    -------
    fix : Fix
        Constant turn rate and acceleration (CTRA) for 1 s as in `predict_ctra`, then straight on at the speed
        reached. A braking vehicle stops.
    """
    _, x, y, psi, v, a, r = fix
    age = max(t - fix.t, 0.0)
    turning = min(age, STALE_AGE)
    stops = a * v < 0.0 or (v == 0.0 and a < 0.0)
    if stops:
        turning = min(turning, -v / a)
    s = (v + 0.5 * a * turning) * turning
    half = 0.5 * r / v * s if abs(v) >= STANDSTILL_SPEED else 0.0
    chord = s * math.sin(half) / half if half else s
    x, y, psi = x + chord * math.cos(psi + half), y + chord * math.sin(psi + half), psi + 2.0 * half
    after = v + a * turning
    if stops and after * v <= 1e-9:
        return Fix(t, x, y, psi, 0.0)
    if age > STALE_AGE:
        straight = after * (age - STALE_AGE)
        return Fix(t, x + straight * math.cos(psi), y + straight * math.sin(psi), psi, after)
    return Fix(t, x, y, psi, after, a, r)


def predicted_displacement(last: Fix, fix: Fix) -> tuple[float, float, float]:
    """Return position and distance [m] after `last` by the mean of two reported speeds and headings."""
    mean = last.psi + 0.5 * wrap_angle(fix.psi - last.psi)
    s = 0.5 * (last.v + fix.v) * (fix.t - last.t)
    return last.x + s * math.cos(mean), last.y + s * math.sin(mean), abs(s)


@formula
def position_bounds(
    v: float,
    age: float,
    driven: float = math.inf,
    *,
    time_error: float = 0.0,
    model: PositionErrorModel = _RECORDED,
) -> tuple[float, float]:
    """Uncertainty bounds of a dead-reckoned position: errors that are not exceeded in 95 % of cases.

    Parameters
    ----------
    v : float
        Speed reported with the position [m/s].
    age : float
        Time since the position was measured [s], not negative.
    driven : float
        Distance driven since by the speeds reported later [m]; infinite if there was no message.
    time_error : float
        Known error of the time of measurement [s], such as that of a clock, not negative.
    model : PositionErrorModel
        Errors of positions and time stamps.

    Returns
    -------
    along, across : float
        Half extents along and across the heading [m]; the standard deviation is half of each.

    Notes
    -----
    Up to 1 s the bounds are those of recorded messages. Their largest error is that of the time stamps, in
    proportion to speed. Beyond 1 s the vehicle may have braked or accelerated to at most twice its speed, and
    left its lane. If its speed is still reported, it may be at its last position or twice as far.

    Examples
    --------
    >>> [round(b, 2) for b in position_bounds(20.0, 0.1) + position_bounds(20.0, 1.0)]
    [4.7, 0.07, 6.3, 0.35]
    """
    speed = abs(v)
    time_error = max(min(model.time_error_rate * age, model.max_time_error), time_error)
    along, across = model.along + speed * time_error, model.across + model.across_rate * age
    late = age - STALE_AGE
    if late > 0.0:
        limit = min(max(speed, STANDSTILL_SPEED) * late, driven + STANDSTILL_SPEED * late)
        along += min(0.5 * model.assumed_acceleration * late * late, limit)
        across += min(0.5 * model.assumed_lateral_acceleration * late * late, limit)
    return along, across
