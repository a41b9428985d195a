"""Window of a maneuver: where it must begin and end so that the ego is out of the path in time."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array
from cca_core.band import Side
from cca_core.decide import Rejection, RejectionKind
from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.geometry import QUINTIC_PEAK
from cca_core.path import Lane, Road
from cca_core.planner.settings import EvasionSettings

HORIZON = 600.0
"""Longest maneuver [m]."""

_START_OFFSET = 2.0  # a window begins this far behind the ego, which may stop between nodes [m]
_DISTANCES = np.arange(-_START_OFFSET, HORIZON, 1.0)  # at which the ego is compared with vehicles [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Window:
    """Where a maneuver lies, and what it takes."""

    start: float  # stations of the center of gravity at both ends [m]
    end: float
    first: float  # distance until the ego must be out of the path [m]
    last: float  # and until it has passed [m]
    t_last: float  # time until then [s]
    required: float  # distance that a maneuver in comfort takes [m]
    v_return: float  # speed of the return [m/s]
    lead_distances: tuple[float, ...]  # before each blocking vehicle, for `relax_band` [m]
    leaves_lane: bool  # whether the clearance asked forces the body out of the ego lane


def plan_window(
    ego: FrenetEgo,
    road: Road,
    lane: Lane | None,
    blocking: Sequence[FrenetVehicle],
    side: Side,
    settings: EvasionSettings,
    current: tuple[float, float] | None,
    *,
    start_now: bool,
) -> Window | Rejection:
    """Return the window of a new or current maneuver, or why there is none."""
    t = ego.arrival_times(ego.s_cg + _DISTANCES)
    lead_distances, intervals = zip(
        *(_alongside_interval(ego, b, settings, t, b is blocking[0]) for b in blocking), strict=True
    )
    first, last = intervals[0]
    if current is None and not first + 1.0 < last < HORIZON:  # nor a vehicle that is as good as passed
        kind = RejectionKind.TOO_LONG
        return Rejection(kind=kind, side=side, vehicle_id=blocking[0].id, limit=HORIZON)
    half_width = 0.5 * ego.vehicle.width
    offset = blocking[0].half_width + half_width + settings.clearance
    offset += blocking[0].d if side == "left" else -blocking[0].d
    leaves_lane = offset > (road.ego_lane.left if side == "left" else -road.ego_lane.right) - half_width
    if lane is None and leaves_lane:
        return Rejection(kind=RejectionKind.NO_LANE, side=side)
    duration = _offset_time(ego, road, offset, min(last, HORIZON), settings)
    v_out, v_return = _speed_after(ego, first), _speed_after(ego, last)
    # decided one period early: the start does not depend on when decisions fall
    early = v_out * settings.decision.period
    required = v_out * (duration + settings.preparation_time) + early
    return_length = v_return * duration
    if current is None:
        delay = 0.0 if start_now else max(first - required + early, 0.0)
        start, end = ego.s_cg - _START_OFFSET + delay, ego.s_cg + last + return_length
        if not start_now:
            start += v_out * settings.preparation_time
    else:
        start, end = current
    for begin, stop in intervals:  # without space to return before the next vehicle the ego stays out
        later = ego.s_cg + stop + return_length
        if (
            begin < stop < HORIZON
            and ego.s_cg + begin - return_length < end
            and later > end + settings.replan.window_hysteresis
        ):
            end = later
    if end > road.path.end:
        kind, length = RejectionKind.ROUTE_ENDS, road.path.end - ego.s_cg
        return Rejection(kind=kind, side=side, value=end - ego.s_cg, limit=length)
    return Window(
        start=start, end=end, first=first, last=last, t_last=float(np.interp(last, _DISTANCES, t)),
        required=required, v_return=v_return, lead_distances=lead_distances, leaves_lane=leaves_lane,
    )  # fmt: skip


def assumed_interval(
    other: FrenetVehicle, t: Array, settings: EvasionSettings, overtaken: bool
) -> tuple[Array, Array]:
    """Return the stations that a vehicle may cover under the assumptions of the settings."""
    acceleration = settings.assumed_acceleration_passed if overtaken else settings.assumed_acceleration
    return other.occupied_interval(t, braking=settings.assumed_braking, acceleration=acceleration)


def is_following_ego(other: FrenetVehicle, ego: FrenetEgo, lane: Lane) -> bool:
    """Return whether a vehicle is behind the ego in a lane, so that it must keep the gap."""
    return other.front < ego.rear and lane.right < other.d < lane.left and other.v_s >= 0.0


def _offset_time(
    ego: FrenetEgo, road: Road, offset: float, length: float, settings: EvasionSettings
) -> float:
    """Duration of a lateral offset in comfort [s]; curves take up a part of the lateral acceleration."""
    curvature = np.abs(road.path.curvature(np.linspace(ego.s_cg, ego.s_cg + length, 20))).max()
    comfort = settings.lateral_acceleration
    remaining = comfort - max(ego.v_x, ego.v_target) ** 2 * float(curvature)
    return math.sqrt(QUINTIC_PEAK * max(offset, 0.5) / max(remaining, 0.5 * comfort))


def _alongside_interval(
    ego: FrenetEgo, other: FrenetVehicle, settings: EvasionSettings, t: Array, overtaken: bool
) -> tuple[float, tuple[float, float]]:
    """Distance before the vehicle at which the ego must be out of its path, and from where to where [m]."""
    rear, front = assumed_interval(other, t, settings, overtaken)
    center = ego.s + _DISTANCES
    reach = 0.5 * ego.vehicle.length + settings.clearance
    overlap = np.stack((front - center + reach, center + reach - rear))

    def interval(lead_distance: float) -> tuple[float, float]:
        depth = np.minimum(overlap[0], overlap[1] + lead_distance)
        alongside = np.flatnonzero(depth >= 0.0)
        if not len(alongside):
            return math.inf, math.inf
        i, k, x = int(alongside[0]), int(alongside[-1]), _DISTANCES
        # interpolated: ends on whole meters would jump with the last digit of a message
        first = x[i] - depth[i] / (depth[i] - depth[i - 1]) if i else x[i]
        last = x[k] + depth[k] / (depth[k] - depth[k + 1]) if k < len(x) - 1 else math.inf
        return float(first), float(last)

    closing_speed = max(_speed_after(ego, interval(0.0)[0]) - other.v_s, 0.0)
    lead_distance = settings.min_ttc * closing_speed
    return lead_distance, interval(lead_distance)


def _speed_after(ego: FrenetEgo, distance: float) -> float:
    """Speed of the ego after a distance [m/s], at least 1."""
    reached = math.sqrt(ego.v_x**2 + 2.0 * ego.speed.a_max * min(max(distance, 0.0), HORIZON))
    return max(min(reached, max(ego.v_target, ego.v_x)), 1.0)
