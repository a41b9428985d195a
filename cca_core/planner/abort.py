"""Abort and early return: leave the adjacent lane ahead of passed vehicles, or behind the lead vehicle."""

from collections.abc import Sequence

import numpy as np

from cca_core.decide import Rejection
from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.path import Lane, Path, Road
from cca_core.planner.maneuver import Maneuver
from cca_core.planner.maneuver_tuning import AbortSettings
from cca_core.planner.return_path import return_length, return_maneuver


def plan_abort(
    ego: FrenetEgo,
    road: Road,
    maneuver: Maneuver,
    others: Sequence[FrenetVehicle],
    rejection: Rejection | None,
    settings: AbortSettings,
) -> Maneuver | None:
    """Return behind the lead vehicle; None beyond the point of no return or ahead of following vehicles."""
    ahead = [n for n in others if not n.body_front <= ego.rear and _in_lane(n, road.ego_lane)]
    if not ahead:
        return None
    lead = min(ahead, key=lambda n: n.s)
    gap, b, delay = lead.rear - ego.front, settings.deceleration, settings.brake_delay
    t = np.linspace(0.0, delay + max(ego.v_x, 0.1) / b, 60)
    braked = np.maximum(t - delay, 0.0)
    gaps = gap + lead.v_s * t - (ego.v_x * t - 0.5 * b * braked * braked)
    closing = np.maximum(ego.v_x - b * braked - lead.v_s, 0.0)
    clear = np.flatnonzero(gaps >= settings.standstill_gap + closing**2 / (2.0 * b))
    if not len(clear):
        return None
    t_return, braking_time = float(t[clear[0]]), float(braked[clear[0]])
    hold_distance = ego.v_x * t_return - 0.5 * b * braking_time**2
    v_return = ego.v_x - b * braking_time
    for n in others:
        gap_behind = ego.rear + hold_distance - (n.front + n.v_s * t_return)
        required = _following_gap(n.v_s, min(v_return, lead.v_s), settings)
        if n.body_front <= ego.rear and n.v_s > 0.0 and gap_behind < required:
            return None
    return return_maneuver(
        ego, road, maneuver, hold_distance, v_return, rejection, settings, keep_moving_out=True
    )


def plan_early_return(
    ego: FrenetEgo,
    road: Road,
    maneuver: Maneuver,
    others: Sequence[FrenetVehicle],
    rejection: Rejection | None,
    settings: AbortSettings,
) -> Maneuver | None:
    """Return ahead of passed vehicles at the speed of now; None if the gap does not open in time."""
    v, d = max(ego.v_x, 1.0), maneuver.offset_at(ego.s_cg)
    t = np.linspace(0.0, settings.max_hold_time, 31)
    t_return, clear = return_length(d, v, settings) / v, np.ones(len(t), dtype=np.bool_)
    for n in others:
        gap_ahead = n.rear + n.v_s * t - (ego.front + v * t)
        lateral = abs(n.d - d) - 0.5 * ego.vehicle.width
        if _in_lane(n, road.ego_lane):
            gap_behind = ego.rear + v * t - (n.front + n.v_s * t)
            passed = gap_behind >= _following_gap(n.v_s, v, settings)
            stopping = settings.standstill_gap + max(v - n.v_s, 0.0) ** 2 / (2.0 * settings.deceleration)
            followable = gap_ahead >= max(stopping, settings.time_gap * v)
            off_path = lateral >= n.body_half_width + settings.lateral_gap
            clear &= followable | (passed if n.s <= ego.s_cg or off_path else False)
        elif n.s > ego.s_cg and lateral < n.half_width:
            clear &= gap_ahead + (n.v_s - v) * t_return >= settings.standstill_gap
    if not clear.any():
        return None
    hold_distance = v * float(t[np.argmax(clear)])
    return return_maneuver(ego, road, maneuver, hold_distance, v, rejection, settings, keep_moving_out=False)


def delay_return(
    ego: FrenetEgo, road: Road, maneuver: Maneuver, others: Sequence[FrenetVehicle], settings: AbortSettings
) -> Maneuver:
    """Delay the return of an aborted maneuver while a vehicle is alongside or close behind, or go ahead."""
    near = _near_in_lane(ego, road, others, settings)
    if not any(n.front > ego.rear - _following_gap(n.v_s, ego.v_x, settings) for n in near):
        return maneuver
    rejection = maneuver.candidate.rejection
    later = plan_abort(ego, road, maneuver, others, rejection, settings)
    if later is None:
        return plan_early_return(ego, road, maneuver, others, rejection, settings) or maneuver
    return later if later.end > maneuver.end else maneuver


def vehicle_alongside(
    ego: FrenetEgo, road: Road, others: Sequence[FrenetVehicle], settings: AbortSettings
) -> bool:
    """Return whether a vehicle in the ego lane is alongside, which the ego lets pass before it returns."""
    return not all(n.body_front <= ego.rear for n in _near_in_lane(ego, road, others, settings))


def return_deceleration(path: Path, s: float, v_x: float, settings: AbortSettings) -> float:
    """Return the deceleration that the curvature of a return path requires [m/s^2]; it may be negative."""
    x = np.arange(1.0, 2.0 + v_x * v_x / (2.0 * settings.deceleration), 1.0)
    squared_speed = settings.lateral_acceleration / np.maximum(np.abs(path.curvature(s + x)), 1e-6)
    return float(np.max((v_x * v_x - squared_speed) / (2.0 * x)))


def _near_in_lane(
    ego: FrenetEgo, road: Road, others: Sequence[FrenetVehicle], settings: AbortSettings
) -> list[FrenetVehicle]:
    """Vehicles in the ego lane that are not ahead of the ego by the standstill gap."""
    end = ego.front + settings.standstill_gap
    return [n for n in others if _in_lane(n, road.ego_lane) and n.rear < end]


def _in_lane(other: FrenetVehicle, lane: Lane) -> bool:
    """Whether the body is in a lane; the uncertainty bound would put a stale vehicle in both lanes."""
    return other.d - other.body_half_width < lane.left and other.d + other.body_half_width > lane.right


def _following_gap(v: float, v_ahead: float, settings: AbortSettings) -> float:
    """Gap in which a following driver slows down to the speed ahead [m]."""
    reaction = v * settings.reaction_time * (v > v_ahead)
    braking = max(v * v - v_ahead * v_ahead, 0.0) / (2.0 * settings.deceleration)
    return settings.standstill_gap + reaction + braking
