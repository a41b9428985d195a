"""Yielding to crossing vehicles: the conflict that the ego must wait for, and where it stops."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.decide import Conflict, LeadVehicle, find_conflict
from cca_core.follow import SpeedSettings, friction_limited
from cca_core.geometry import box_gap, boxes
from cca_core.path import Path, Road
from cca_core.planner.frenet import FrenetEgo, FrenetVehicle
from cca_core.planner.lead import make_lead
from cca_core.predict import predict_ctra

__all__ = ["find_yield_conflict", "virtual_lead"]

_HOLD = 1.0  # further time that must lie between bodies until the ego goes on that waits already [s]
_CROSSING_RANGE = 150.0  # within which crossing vehicles are looked at [m]
_CROSSING = 0.35  # sine of the angle to the route above which a vehicle may cross it
_LOOK, _STATIONS = 8.0, 100  # [s], [-]
_STEP = 0.05  # at which bodies that could meet are looked at [s]
_SUFFICIENT_GAP = 0.5  # distance between them that is enough [m]
_LEAST_BRAKES = 1.0  # counted on where cornering takes all of the grip [m/s^2]
_BRAKE_DELAY = 0.3  # until the brakes act [s]


def virtual_lead(conflict: Conflict, s: float, v_x: float, speed: SpeedSettings) -> LeadVehicle:
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
    gap = conflict.s_enter - s + 0.5 * speed.standstill_gap  # of which a real one may be used up in need
    return make_lead(conflict.vehicle_id, gap, 0.0, 0.0, v_x, speed, "crossing")


def find_yield_conflict(
    ego: FrenetEgo, road: Road, others: Sequence[FrenetVehicle], last: Conflict | None = None
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
    times = ego.arrival_times(stations)
    waits = []
    for n in others:
        if (
            abs(math.sin(n.angle)) < _CROSSING
            or abs(n.d) > _CROSSING_RANGE
            or not -20.0 < n.s - ego.s < _CROSSING_RANGE
        ):
            continue
        conflict = find_conflict(road.path, ego.s, stations, times, ego.vehicle, n.remote, horizon=_LOOK)
        if conflict is None:
            continue
        brakes = last is not None and last.vehicle_id == conflict.vehicle_id
        if brakes:
            conflict = replace(conflict, min_pet=conflict.min_pet + _HOLD)
        if conflict.is_clear:
            continue
        needed, places = _full_braking_profile(ego, road.path, times, 0.0 if brakes else _BRAKE_DELAY)
        if needed > conflict.distance:  # too late to stay out of where it may be: think of where it will be
            goes_on = _predicted_min_gap(ego, road.path, stations, n, times)
            stops = _predicted_min_gap(ego, road.path, places, n, times)
            if goes_on > 0.0 and (ego.s + needed > conflict.s_exit or stops < min(goes_on, _SUFFICIENT_GAP)):
                continue
            conflict = replace(conflict, s_enter=max(conflict.s_enter, ego.s))
        waits.append(conflict)
    if not waits:
        return None
    first = min(waits, key=lambda c: c.s_enter)
    before = first.s_enter - float(stations[1] - stations[0])  # it begins somewhere after that one
    if before > ego.s:
        first = replace(first, s_enter=before)
    front = ego.vehicle.front
    lines = [line - front for line in road.stop_lines if ego.s < line - front < first.s_enter]
    at = max(lines, default=first.s_enter)
    return replace(first, s_enter=at, distance=at - ego.s)


def _full_braking_profile(ego: FrenetEgo, path: Path, t: Array, delay: float) -> tuple[float, Array]:
    """Distance in which the ego stops if it brakes fully [m], and its places at times [m]."""
    lateral = ego.v_x * ego.v_x * float(path.curvature(ego.s))
    brakes = max(-friction_limited(-ego.speed.b_max, lateral, ego.vehicle.mu), _LEAST_BRAKES)
    braking = np.clip(t - delay, 0.0, ego.v_x / brakes)
    x = ego.v_x * (np.minimum(t, delay) + braking) - 0.5 * brakes * braking * braking
    return ego.v_x * delay + ego.v_x**2 / (2.0 * brakes), ego.s + x


def _predicted_min_gap(ego: FrenetEgo, path: Path, s: Array, other: FrenetVehicle, t: Array) -> float:
    """Least distance between the bodies [m] if the ego is at places at times and the other goes on."""
    moments = np.arange(0.0, _LOOK, _STEP)
    center, tangent, _ = path.derivatives(np.interp(moments, t, s))
    psi = np.arctan2(tangent[:, 1], tangent[:, 0])
    body = ego.vehicle.body_at(center[:, 0], center[:, 1], psi)
    met = boxes(*predict_ctra(other.remote, moments), other.remote.length, other.remote.width)
    return float(box_gap(body, met).min())
