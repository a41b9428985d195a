"""Rules of the V2V applications, one function each."""

import math

from cca_core.warnings.alert import Alert, AlertSettings, Application, Level, level_for
from cca_core.warnings.view import PARALLEL_ANGLE, VehicleInView, WarningView, blocks_ego, is_ahead


def forward_collision(view: WarningView, other: VehicleInView, settings: AlertSettings) -> Alert | None:
    """Warn of a lead vehicle that brakes, is stationary or is slower (FCW).

    Parameters
    ----------
    view : WarningView
        The ego along its route.
    other : VehicleInView
        The other vehicle.
    settings : AlertSettings
        Thresholds.

    Returns
    -------
    alert : Alert or None
        The alert, None if there is no reason for one.
    """
    stationary = abs(other.vehicle.remote.v_x) < settings.standstill_speed
    parallel = abs(other.vehicle.angle) <= PARALLEL_ANGLE
    if not (is_ahead(view, other) and blocks_ego(view, other) and (parallel or stationary)):
        return None
    if stationary:
        motion, threshold = "stationary", settings.fcw_stopped
    elif other.vehicle.remote.a_x <= -settings.braking:
        motion, threshold = "braking", settings.fcw_decelerating
    else:
        motion, threshold = "slower", settings.fcw_slower
    time = _time_to_collision(view, other, settings)
    if time > threshold:
        return None
    reason = (
        f"{other.vehicle.id} {motion}, {max(other.gap, 0.0):.0f} m ahead: "
        f"collision in {time:.1f} s (limit {threshold:.1f} s)"
    )
    level = level_for(_required_deceleration(view, other, settings), settings)
    return _alert(Application.FCW, level, other, time, reason)


def emergency_brake_light(view: WarningView, other: VehicleInView, settings: AlertSettings) -> Alert | None:
    """Warn of hard braking ahead, visible or occluded; inform of it in the adjacent lane (EEBL).

    Parameters
    ----------
    view : WarningView
        The ego along its route.
    other : VehicleInView
        The other vehicle.
    settings : AlertSettings
        Thresholds.

    Returns
    -------
    alert : Alert or None
        The alert, None if there is no reason for one.
    """
    remote = other.vehicle.remote
    hard = "hard_braking" in remote.events or -remote.a_x > settings.eebl_deceleration
    if not (hard and is_ahead(view, other)):
        return None
    if other.gap > settings.eebl_range or abs(other.vehicle.angle) > settings.eebl_heading:
        return None
    if abs(other.lateral_offset) > 1.5 * view.lane_width:
        return None
    in_lane = abs(other.lateral_offset) <= 0.5 * view.lane_width
    lane = "in the ego lane" if in_lane else "in the adjacent lane"
    reason = f"{other.vehicle.id} brakes hard {max(other.gap, 0.0):.0f} m ahead {lane}"
    if not in_lane:
        return _alert(Application.EEBL, Level.INFORM, other, math.inf, reason)
    level = level_for(_required_deceleration(view, other, settings), settings)
    return _alert(Application.EEBL, level, other, _time_to_collision(view, other, settings), reason)


def stationary_ahead(view: WarningView, other: VehicleInView, settings: AlertSettings) -> Alert | None:
    """Warn of a stationary vehicle that blocks the ego, also if it is occluded (curb-side).

    Parameters
    ----------
    view : WarningView
        The ego along its route.
    other : VehicleInView
        The other vehicle.
    settings : AlertSettings
        Thresholds.

    Returns
    -------
    alert : Alert or None
        The alert, None if there is no reason for one.
    """
    if abs(other.vehicle.remote.v_x) >= settings.standstill_speed or not is_ahead(view, other):
        return None
    if not blocks_ego(view, other, settings.curbside_clearance) or view.ego.v_x <= 0.0:
        return None
    gap = max(other.gap, 0.0)
    time = gap / view.ego.v_x
    if time > settings.curbside_time:
        return None
    occluded = f", occluded by {other.occluded_by}" if other.occluded_by else ""
    reason = (
        f"{other.vehicle.id} stationary, {gap:.0f} m ahead{occluded}: "
        f"reached in {time:.1f} s (limit {settings.curbside_time:.1f} s)"
    )
    level = level_for(_required_deceleration(view, other, settings), settings)
    return _alert(Application.CURB_SIDE, level, other, time, reason)


def blind_spot(view: WarningView, other: VehicleInView, settings: AlertSettings) -> Alert | None:
    """Inform of a vehicle in the blind spot (BSW); warn if the ego intends to move there (LCW).

    Parameters
    ----------
    view : WarningView
        The ego along its route.
    other : VehicleInView
        The other vehicle.
    settings : AlertSettings
        Thresholds.

    Returns
    -------
    alert : Alert or None
        The alert, None if there is no reason for one.
    """
    lateral_gap = abs(other.lateral_offset) - 0.5 * view.ego.vehicle.width - other.vehicle.half_width
    far_side = lateral_gap + 2.0 * other.vehicle.half_width
    within_zone = lateral_gap < settings.bsw_far and far_side > settings.bsw_near
    # the zone reaches from the ego's center to behind its rear
    front = other.gap + 0.5 * view.ego.vehicle.length
    behind = -(other.gap + 2.0 * other.vehicle.half_length) - view.ego.vehicle.length
    behind_center = front <= 0.0 and behind <= settings.bsw_behind
    if not (within_zone and behind_center) or abs(other.vehicle.angle) > PARALLEL_ANGLE:
        return None
    side = "left" if other.lateral_offset > 0.0 else "right"
    reason = f"{other.vehicle.id} in the {side} blind spot"
    if view.intent == side:
        return _alert(Application.LCW, Level.WARN, other, 0.0, f"{reason}, to which the ego moves")
    return _alert(Application.BSW, Level.INFORM, other, 0.0, reason)


def do_not_pass(view: WarningView, other: VehicleInView, settings: AlertSettings) -> Alert | None:
    """Warn of oncoming traffic in the lane where the ego is or intends to pass (DNPW).

    Parameters
    ----------
    view : WarningView
        The ego along its route.
    other : VehicleInView
        The other vehicle.
    settings : AlertSettings
        Thresholds.

    Returns
    -------
    alert : Alert or None
        The alert, None if there is no reason for one.
    """
    oncoming = abs(other.vehicle.angle) >= math.pi - PARALLEL_ANGLE
    if not (oncoming and other.vehicle.v_s <= -settings.standstill_speed and is_ahead(view, other)):
        return None
    side = "left" if other.lateral_offset > 0.0 else "right"
    adjacent = 0.5 * view.lane_width <= abs(other.lateral_offset) <= 1.5 * view.lane_width
    if not (blocks_ego(view, other) or (view.intent == side and adjacent)):
        return None
    time = max(other.gap, 0.0) / (max(view.ego.v_x, 0.0) - other.vehicle.v_s)
    if time >= settings.dnpw_time:
        return None
    reason = (
        f"{other.vehicle.id} oncoming, {other.gap:.0f} m ahead: "
        f"collision in {time:.1f} s (limit {settings.dnpw_time:.1f} s)"
    )
    return _alert(Application.DNPW, Level.WARN, other, time, reason)


def intersection(view: WarningView, other: VehicleInView, settings: AlertSettings) -> Alert | None:
    """Warn of crossing traffic that arrives together with the ego (IMA).

    Parameters
    ----------
    view : WarningView
        The ego along its route.
    other : VehicleInView
        The other vehicle.
    settings : AlertSettings
        Thresholds.

    Returns
    -------
    alert : Alert or None
        The alert, None if there is no reason for one.
    """
    c = other.conflict
    if c is None or c.t_ego[0] > settings.ima_time or other.crosses_ego_turn:
        return None
    together = c.t_ego[0] <= c.t_other_nominal[1] and c.t_other_nominal[0] <= c.t_ego[1]
    difference = abs(c.t_ego[0] - c.t_other_nominal[0])
    if not together and difference > settings.ima_difference:
        return None
    reason = (
        f"{other.vehicle.id} crosses {max(c.distance, 0.0):.0f} m ahead: "
        f"it enters in {c.t_other_nominal[0]:.1f} s, ego in {c.t_ego[0]:.1f} s"
    )
    time = max(c.t_ego[0], c.t_other_nominal[0])
    return _alert(Application.IMA, _stop_level(view, c.distance, settings), other, time, reason)


def left_turn(view: WarningView, other: VehicleInView, settings: AlertSettings) -> Alert | None:
    """Warn of oncoming traffic that is too close for a turn across its lane (LTA).

    Parameters
    ----------
    view : WarningView
        The ego along its route.
    other : VehicleInView
        The other vehicle.
    settings : AlertSettings
        Thresholds.

    Returns
    -------
    alert : Alert or None
        The alert, None if there is no reason for one.

    Notes
    -----
    In left-hand traffic it is a right turn.
    """
    c = other.conflict
    if c is None or c.t_ego[0] > settings.ima_time or not other.crosses_ego_turn:
        return None
    gap = c.t_other_nominal[0] - c.t_ego[0]
    if gap >= settings.lta_gap or c.t_ego[0] - c.t_other_nominal[1] > settings.ima_difference:
        return None
    reason = (
        f"{other.vehicle.id} oncoming to the turning ego: "
        f"time gap {gap:.1f} s (limit {settings.lta_gap:.1f} s)"
    )
    time = max(c.t_ego[0], c.t_other_nominal[0])
    return _alert(Application.LTA, _stop_level(view, c.distance, settings), other, time, reason)


def _time_to_collision(view: WarningView, other: VehicleInView, settings: AlertSettings) -> float:
    """Time to collision with a lead vehicle [s] at the present speed of the ego."""
    gap, b, v = max(other.gap, 0.0), -other.vehicle.remote.a_x, max(other.vehicle.v_s, 0.0)
    closing = view.ego.v_x - v
    if b < settings.braking or v == 0.0:
        return gap / closing if closing > 0.0 else math.inf
    time = (math.sqrt(closing * closing + 2.0 * b * gap) - closing) / b
    if time <= v / b:
        return time
    return (gap + 0.5 * v * v / b) / view.ego.v_x if view.ego.v_x > 0.0 else math.inf


def _required_deceleration(view: WarningView, other: VehicleInView, settings: AlertSettings) -> float:
    """Deceleration with which the ego stays behind a lead vehicle [m/s^2]."""
    gap, b, v = max(other.gap, 1e-3), -other.vehicle.remote.a_x, max(other.vehicle.v_s, 0.0)
    required = max(view.ego.v_x - v, 0.0) ** 2 / (2.0 * gap)
    if b >= settings.braking:
        required = max(required, max(view.ego.v_x, 0.0) ** 2 / (2.0 * (gap + 0.5 * v * v / b)))
    return required


def _stop_level(view: WarningView, distance: float, settings: AlertSettings) -> Level:
    """Level of a conflict area at a distance; inside it braking is not the answer."""
    return level_for(0.5 * view.ego.v_x * view.ego.v_x / distance, settings) if distance > 0.0 else Level.WARN


def _alert(application: Application, level: Level, other: VehicleInView, time: float, reason: str) -> Alert:
    """Make an alert because of a vehicle."""
    return Alert(
        application=application,
        level=level,
        vehicle_id=other.vehicle.id,
        time_to_conflict=time,
        reason=reason,
    )
