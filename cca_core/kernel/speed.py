"""Speeds along a path, and times of arrival."""

import math
from typing import Annotated

from cca_core.kernel.constants import STANDSTILL_SPEED
from cca_core.kernel.curve import Curve, curvature_at
from cca_core.kernel.types import Int, Real, Reals

__all__ = ["arrival_times", "interpolated", "profile_acceleration", "squared_speed_limits"]

Row = Annotated[Reals, "n"]

STRAIGHT = 1e-9  # smaller curvatures limit no speed [1/m]
LOOKAHEAD = 2.0  # least distance to the point that decides on the acceleration [m]


def ramp_time(v: Real, a: Real, distance: Real) -> Real:
    """Time for a distance at a constant acceleration that is not zero [s]."""
    return (math.sqrt(max(v * v + 2.0 * a * distance, 0.0)) - v) / a


def arrival_times(
    n: Int, v_x: Real, v_target: Real, distance: Row, a_max: Real, b_comfort: Real, t: Row
) -> None:
    """Compute when points ahead are reached if the target speed is approached freely."""
    v = max(v_x, STANDSTILL_SPEED)
    target = max(v_target, STANDSTILL_SPEED)
    a = a_max if target > v else -b_comfort
    ramp = (target * target - v * v) / (2.0 * a)
    t_ramp = ramp_time(v, a, ramp)
    unknown = ramp if math.isnan(ramp) else 0.0  # what is no number stays none
    for i in range(n):
        if distance[i] >= ramp:
            t[i] = t_ramp + (distance[i] - ramp) / target
        elif distance[i] > 0.0:
            t[i] = ramp_time(v, a, distance[i]) + unknown
        else:
            t[i] = distance[i] / v + unknown


def squared_speed_limits(
    curve: Curve, n: Int, cruise: Real, a_y: Real, b_comfort: Real, s: Row, squared: Row
) -> None:
    """Squares of the highest speeds at stations, with standstill at the last one."""
    squared[n - 1] = 0.0
    for i in range(n - 2, -1, -1):
        bend = max(abs(curvature_at(curve, s[i])), STRAIGHT)
        here = min(cruise * cruise, a_y / bend)
        squared[i] = min(here, squared[i + 1] + 2.0 * b_comfort * (s[i + 1] - s[i]))


def interpolated(n: Int, at: Row, value: Row, s: Real) -> Real:
    """Value at a station, linear between the given ones and constant beyond."""
    if math.isnan(s):
        return s
    low = 0
    high = n
    for _ in range(32):
        if low >= high:
            break
        middle = (low + high) // 2
        if at[middle] <= s:
            low = middle + 1
        else:
            high = middle
    if low == 0:
        return value[0]
    if low == n:
        return value[n - 1]
    fraction = (s - at[low - 1]) / (at[low] - at[low - 1])
    return value[low - 1] + fraction * (value[low] - value[low - 1])


def profile_acceleration(
    n: Int, at: Row, squared: Row, s: Real, v_x: Real, a_max: Real, b_comfort: Real, b_max: Real
) -> Real:
    """Acceleration along a speed profile, with its slope as feedforward."""
    horizon = LOOKAHEAD + max(v_x, 0.0)
    here = max(interpolated(n, at, squared, s), 0.0)
    there = interpolated(n, at, squared, s + horizon)
    ahead = (there - v_x * v_x) / (2.0 * horizon)
    cruise = min(max(math.sqrt(here) - v_x, -b_comfort), a_max)
    return min(cruise, max(ahead, -b_max))
