"""What on the route asks for a lower speed: its end, a curve, a speed limit, or the cruise speed."""

import math
from typing import NamedTuple

import numpy as np

from cca_core._checks import Array
from cca_core.planner.setup import Setup

__all__ = ["RouteLimit", "limit_ahead"]

_NEAR = 3.0  # distance of a limit that holds here [m]
_MARGIN = 30.0  # beyond the way in which a deceleration of 1 m/s^2 stops the ego [m]
_MIN_DECELERATION = 0.05  # deceleration that slows down [m/s^2]
_CURVE = 0.5  # part of the lateral acceleration in curves, from which on a curve limits the speed [-]
_HERE = 0.9  # the same, from which on the ego is in that curve [-]
_POSTED = 0.85  # part of the speed of a sign, of which the ego drives more [-]


class RouteLimit(NamedTuple):
    """A lower speed, and why."""

    v: float
    why: str


def limit_ahead(setup: Setup, profile: tuple[Array, Array], s: float, v: float) -> RouteLimit | None:
    """Return what slows the ego most, by the squared speeds along its route; None if nothing does."""
    stations, squared = profile
    left = setup.road.path.end - s
    part = slice(*np.searchsorted(stations, (s, s + 0.5 * v * v + _MARGIN)))
    at, limits = stations[part], squared[part]
    if left < 1.0 or not len(at):
        return RouteLimit(0.0, f"the route ends in {max(left, 0.0):.0f} m")
    need = (v * v - limits) / (2.0 * np.maximum(at - s, max(0.5 * v, 1.0)))
    if need.max() < _MIN_DECELERATION:
        return None
    i = int(np.flatnonzero(need > 0.9 * need.max())[-1])  # before a slower part all needs are the same
    rises = np.flatnonzero(np.diff(limits[i:]) >= 0.0)  # an ego that is too fast has most need on the way
    i = i + int(rises[0]) if len(rises) else len(limits) - 1
    if limits[i] <= 0.01:
        return RouteLimit(0.0, f"the route ends in {left:.0f} m")
    target, name = math.sqrt(limits[i]), _name(setup, float(at[i]), math.sqrt(limits[i]))
    if name == "cruise speed":
        return RouteLimit(target, name)
    distance = _distance(setup, name, s, float(at[i]), target)
    return RouteLimit(target, f"{name} {'here' if distance < _NEAR else f'in {distance:.0f} m'}")


def _name(setup: Setup, s: float, v: float) -> str:
    """Return what limits the speed at a station."""
    road = setup.road
    if abs(float(road.path.curvature_at(s))) * v * v > _CURVE * setup.limits.curve:
        return "curve"
    posted = _sign(setup, s, v)[1]
    return "speed limit" if v > _POSTED * posted else "cruise speed"


def _sign(setup: Setup, s: float, v: float) -> tuple[float, float]:
    """Return station and speed of the sign that limits the speed at a station."""
    road = setup.road
    if road.speed_limits is None:
        return road.path.start, road.speed_limit
    at, limits = road.speed_limits.T
    begin = s + v / setup.speed.approach_rate  # from that time before a sign on the ego is slower
    k = max(int(np.searchsorted(at, begin)) - 1, 0)
    return float(at[k]), float(limits[k])


def _distance(setup: Setup, name: str, s: float, reached: float, v: float) -> float:
    """Return the distance to where a limit begins; an ego that is too fast reaches its speed later."""
    if name == "curve":
        holds = abs(float(setup.road.path.curvature_at(s))) * v * v > _HERE * setup.limits.curve
        return 0.0 if holds else reached - s
    return _sign(setup, reached, v)[0] - s
