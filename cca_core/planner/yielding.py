"""Yielding to crossing vehicles: the conflict that decides, and the stop point as a virtual lead."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.decide import Conflict, LeadVehicle, find_conflict
from cca_core.follow import friction_limited
from cca_core.frenet import CROSSING_SINE, FrenetEgo, FrenetVehicle
from cca_core.geometry import box_gap, boxes
from cca_core.path import Path, Road
from cca_core.planner.lead import make_lead
from cca_core.planner.tuning import LeadSettings, YieldSettings
from cca_core.predict import predict_ctra

_STATIONS = 100  # of the ego, at which conflicts are searched
_TIME_STEP = 0.05  # at which predicted bodies are compared [s]
_BEHIND = -20.0  # a vehicle whose station is farther behind the ego does not cross ahead of it [m]


def virtual_lead(conflict: Conflict, ego: FrenetEgo, settings: LeadSettings) -> LeadVehicle:
    """Return a stationary lead vehicle at the stop point of a conflict."""
    # half of the standstill gap may be used up in need, as behind a vehicle
    gap = conflict.s_enter - ego.s_cg + 0.5 * ego.speed.standstill_gap
    return make_lead(conflict.vehicle_id, gap, 0.0, 0.0, ego, settings, "crossing")


def find_yield_conflict(
    ego: FrenetEgo,
    road: Road,
    others: Sequence[FrenetVehicle],
    settings: YieldSettings,
    last: Conflict | None = None,
) -> Conflict | None:
    """Return the nearest conflict before which the ego must stop, at its stop line if there is one."""
    s_ego, horizon = ego.s_cg, settings.horizon
    stations = np.linspace(s_ego, s_ego + max(horizon * max(ego.v_x, ego.v_target), 30.0), _STATIONS)
    times = ego.arrival_times(stations)
    conflicts = []
    for n in others:
        near = abs(n.d) <= settings.range and _BEHIND < n.s - s_ego < settings.range
        if near and not abs(math.sin(n.angle)) < CROSSING_SINE:
            found = find_conflict(road.path, s_ego, stations, times, ego.vehicle, n.remote, horizon=horizon)
            if found is not None:
                yielding = last is not None and last.vehicle_id == found.vehicle_id
                conflicts.append(
                    _conflict_to_yield(ego, road.path, n, found, stations, times, settings, yielding)
                )
    remaining = [c for c in conflicts if c is not None]
    if not remaining:
        return None
    first = min(remaining, key=lambda c: c.s_enter)
    before = first.s_enter - float(stations[1] - stations[0])  # the area begins after this station
    if before > s_ego:
        first = replace(first, s_enter=before)
    stops = [line - ego.vehicle.front for line in road.stop_lines]
    stop = max((s for s in stops if s_ego < s < first.s_enter), default=first.s_enter)
    return replace(first, s_enter=stop, distance=stop - s_ego)


def _conflict_to_yield(
    ego: FrenetEgo,
    path: Path,
    other: FrenetVehicle,
    conflict: Conflict,
    stations: Array,
    times: Array,
    settings: YieldSettings,
    yielding: bool,
) -> Conflict | None:
    """Conflict that the ego must yield to, None if it is clear or if the ego should leave the area."""
    if yielding:
        conflict = replace(conflict, min_pet=conflict.min_pet + settings.hold_pet)
    if conflict.is_clear:
        return None
    delay = 0.0 if yielding else settings.brake_delay
    stop_distance, stop_stations = _full_braking_profile(ego, path, times, delay, settings)
    if stop_distance <= conflict.distance:
        return conflict
    # too late to stop before the worst-case area: compare the predicted gaps of continuing and braking
    continuing = _predicted_min_gap(ego, path, stations, other, times, settings.horizon)
    braking = _predicted_min_gap(ego, path, stop_stations, other, times, settings.horizon)
    if continuing > 0.0 and (
        ego.s_cg + stop_distance > conflict.s_exit or braking < min(continuing, settings.sufficient_gap)
    ):
        return None
    return replace(conflict, s_enter=max(conflict.s_enter, ego.s_cg))


def _full_braking_profile(
    ego: FrenetEgo, path: Path, t: Array, delay: float, settings: YieldSettings
) -> tuple[float, Array]:
    """Return the distance of full braking to standstill [m] and the stations at times [m]."""
    lateral = ego.v_x * ego.v_x * float(path.curvature(ego.s_cg))
    b = max(-friction_limited(-ego.speed.b_max, lateral, ego.vehicle.mu), settings.min_braking)
    braking = np.clip(t - delay, 0.0, ego.v_x / b)
    x = ego.v_x * (np.minimum(t, delay) + braking) - 0.5 * b * braking * braking
    return ego.v_x * delay + ego.v_x**2 / (2.0 * b), ego.s_cg + x


def _predicted_min_gap(
    ego: FrenetEgo, path: Path, s: Array, other: FrenetVehicle, t: Array, horizon: float
) -> float:
    """Least predicted gap between bodies [m] if the ego is at stations at times."""
    moments = np.arange(0.0, horizon, _TIME_STEP)
    center, tangent, _ = path.derivatives(np.interp(moments, t, s))
    psi = np.arctan2(tangent[:, 1], tangent[:, 0])
    body = ego.vehicle.body_at(center[:, 0], center[:, 1], psi)
    predicted = boxes(*predict_ctra(other.remote, moments), other.remote.length, other.remote.width)
    return float(box_gap(body, predicted).min())
