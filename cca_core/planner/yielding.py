"""Yielding to crossing vehicles: the conflict that the ego must wait for, and where it stops."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.decide import Conflict, Leader, crossing
from cca_core.follow import SpeedSettings, friction_limited
from cca_core.geometry import box_gap, boxes
from cca_core.path import Path, Road
from cca_core.planner.frenet import Ego, Neighbor
from cca_core.planner.lead import make_leader
from cca_core.predict import predict_free

__all__ = ["conflict_ahead", "leader_at"]

_HOLD = 1.0  # further time that must lie between bodies until the ego goes on that waits already [s]
_SIGHT = 150.0  # within which crossing vehicles are looked at [m]
_CROSSING = 0.35  # sine of the angle to the route above which a vehicle may cross it
_LOOK, _STATIONS = 8.0, 100  # [s], [-]
_STEP = 0.05  # at which bodies that could meet are looked at [s]
_CLEAR = 0.5  # distance between them that is enough [m]
_LEAST_BRAKES = 1.0  # counted on where cornering takes all of the grip [m/s^2]
_BRAKE_DELAY = 0.3  # until the brakes act [s]


def leader_at(conflict: Conflict, s: float, v_x: float, speed: SpeedSettings) -> Leader:
    """Stand in for a conflict: something that stands where the ego must stop.

    Parameters
    ----------
    conflict : Conflict
        The conflict to wait for.
    s, v_x : float
        Path coordinate [m] and speed [m/s] of the ego.
    speed : SpeedSettings
        Gaps and limits.

    Returns
    -------
    leader : Leader
        At the edge of the conflict area.
    """
    gap = conflict.s_in - s + 0.5 * speed.standstill_gap  # of which a real one may be used up in need
    return make_leader(conflict.remote, gap, 0.0, 0.0, v_x, speed, "crossing")


def conflict_ahead(
    ego: Ego, road: Road, others: Sequence[Neighbor], last: Conflict | None = None
) -> Conflict | None:
    """Find the nearest place at which the ego must wait for a crossing vehicle.

    Parameters
    ----------
    ego : Ego
        The ego and how it intends to drive.
    road : Road
        Its route; where a stop line lies before the conflict, the ego waits there.
    others : sequence of Neighbor
        Vehicles around.
    last : Conflict, optional
        What the ego waits for already; it goes on only when there is a little more time than it needs.

    Returns
    -------
    conflict : Conflict or None
        None if nobody has to be waited for. Where it is too late to stay out of the area in which somebody
        may be, the ego brakes all the same if that keeps it 0.5 m clear of where that one is expected, or
        farther than going on does, or if going on is expected to end in a contact; else it clears the area.
    """
    stations = np.linspace(ego.s, ego.s + max(_LOOK * max(ego.v_x, ego.v_target), 30.0), _STATIONS)
    times = ego.times(stations)
    waits = []
    for n in others:
        if abs(math.sin(n.angle)) < _CROSSING or abs(n.d) > _SIGHT or not -20.0 < n.s - ego.s < _SIGHT:
            continue
        conflict = crossing(road.path, ego.s, stations, times, ego.vehicle, n.remote, horizon=_LOOK)
        if conflict is None:
            continue
        brakes = last is not None and last.remote == conflict.remote
        if brakes:
            conflict = replace(conflict, margin=conflict.margin + _HOLD)
        if conflict.free:
            continue
        needed, places = _braked(ego, road.path, times, 0.0 if brakes else _BRAKE_DELAY)
        if needed > conflict.distance:  # too late to stay out of where it may be: think of where it will be
            goes_on = _apart(ego, road.path, stations, n, times)
            stops = _apart(ego, road.path, places, n, times)
            if goes_on > 0.0 and (ego.s + needed > conflict.s_out or stops < min(goes_on, _CLEAR)):
                continue
            conflict = replace(conflict, s_in=max(conflict.s_in, ego.s))
        waits.append(conflict)
    if not waits:
        return None
    first = min(waits, key=lambda c: c.s_in)
    before = first.s_in - float(stations[1] - stations[0])  # it begins somewhere after that one
    if before > ego.s:
        first = replace(first, s_in=before)
    front = ego.vehicle.box_offset + 0.5 * ego.vehicle.length
    lines = [line - front for line in road.stop_lines if ego.s < line - front < first.s_in]
    at = max(lines, default=first.s_in)
    return replace(first, s_in=at, distance=at - ego.s)


def _braked(ego: Ego, path: Path, t: Array, delay: float) -> tuple[float, Array]:
    """Distance in which the ego stops if it brakes fully [m], and its places at times [m]."""
    lateral = ego.v_x * ego.v_x * float(path.curvature(ego.s))
    brakes = max(-friction_limited(-ego.speed.b_max, lateral, ego.vehicle.mu), _LEAST_BRAKES)
    braking = np.clip(t - delay, 0.0, ego.v_x / brakes)
    x = ego.v_x * (np.minimum(t, delay) + braking) - 0.5 * brakes * braking * braking
    return ego.v_x * delay + ego.v_x**2 / (2.0 * brakes), ego.s + x


def _apart(ego: Ego, path: Path, s: Array, other: Neighbor, t: Array) -> float:
    """Least distance between the bodies [m] if the ego is at places at times and the other goes on."""
    moments = np.arange(0.0, _LOOK, _STEP)
    center, tangent, _ = path.derivatives(np.interp(moments, t, s))
    psi = np.arctan2(tangent[:, 1], tangent[:, 0])
    x, y = center.T + ego.vehicle.box_offset * np.array((np.cos(psi), np.sin(psi)))
    body = boxes(x, y, psi, ego.vehicle.length, ego.vehicle.width)
    met = boxes(*predict_free(other.remote, moments), other.remote.length, other.remote.width)
    return float(box_gap(body, met).min())
