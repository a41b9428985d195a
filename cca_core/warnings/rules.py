"""V2V applications that look ahead: a leader that brakes or stands, hard braking, a hidden standing car."""

import math

from cca_core.warnings.alert import (
    PARALLEL_ANGLE,
    Alert,
    AlertSettings,
    Application,
    EgoView,
    Level,
    Sighting,
    alert,
    blocks_ego,
    is_ahead,
    level_for,
)

__all__ = [
    "blind_spot",
    "do_not_pass",
    "emergency_brake_light",
    "forward_collision",
    "intersection",
    "left_turn",
    "stationary_ahead",
]  # fmt: skip


def forward_collision(ego: EgoView, other: Sighting, settings: AlertSettings) -> Alert | None:
    """Warn of a leader that brakes, stands or is slower (FCW).

    Parameters
    ----------
    ego : EgoView
        The ego.
    other : Sighting
        The other vehicle.
    settings : AlertSettings
        Thresholds.

    Returns
    -------
    alert : Alert or None
        The warning, None if there is no reason for one.
    """
    stands = abs(other.remote.v_x) < settings.standstill_speed
    if not (is_ahead(ego, other) and blocks_ego(ego, other)) or (
        abs(other.angle) > PARALLEL_ANGLE and not stands
    ):
        return None
    if stands:
        does, threshold = "stands", settings.fcw_stopped
    elif other.remote.a_x <= -settings.braking:
        does, threshold = "brakes", settings.fcw_decelerating
    else:
        does, threshold = "is slower", settings.fcw_slower
    time = _contact(ego, other, settings)
    if time > threshold:
        return None
    reason = f"{other.remote.id} {does} {max(other.gap, 0.0):.0f} m ahead: {time:.1f} s to collision"
    return alert(Application.FCW, level_for(_needed(ego, other, settings), settings), other, time, reason)


def emergency_brake_light(ego: EgoView, other: Sighting, settings: AlertSettings) -> Alert | None:
    """Tell of hard braking ahead, in sight or not (EEBL).

    Parameters
    ----------
    ego : EgoView
        The ego.
    other : Sighting
        The other vehicle.
    settings : AlertSettings
        Thresholds.

    Returns
    -------
    alert : Alert or None
        The warning; for a vehicle on the lane beside only to inform.
    """
    hard = "hard_braking" in other.remote.events or -other.remote.a_x > settings.eebl_deceleration
    if not (hard and is_ahead(ego, other)):
        return None
    if other.gap > settings.eebl_range or abs(other.angle) > settings.eebl_heading:
        return None
    if abs(other.lateral_offset) > 1.5 * ego.lane_width:
        return None
    own = abs(other.lateral_offset) <= 0.5 * ego.lane_width
    level = level_for(_needed(ego, other, settings), settings) if own else Level.INFORM
    lane = "on the ego's lane" if own else "on the lane beside"
    reason = f"{other.remote.id} brakes hard {max(other.gap, 0.0):.0f} m ahead, {lane}"
    time = _contact(ego, other, settings) if own else math.inf
    return alert(Application.EEBL, level, other, time, reason)


def stationary_ahead(ego: EgoView, other: Sighting, settings: AlertSettings) -> Alert | None:
    """Warn of a vehicle that stands in the way, be it hidden by another one (curb-side).

    Parameters
    ----------
    ego : EgoView
        The ego.
    other : Sighting
        The other vehicle.
    settings : AlertSettings
        Thresholds.

    Returns
    -------
    alert : Alert or None
        The warning, None if there is no reason for one.
    """
    if abs(other.remote.v_x) >= settings.standstill_speed or not is_ahead(ego, other):
        return None
    if not blocks_ego(ego, other, settings.curbside_clearance) or ego.v <= 0.0:
        return None
    time = max(other.gap, 0.0) / ego.v
    if time > settings.curbside_time:
        return None
    hidden = f", hidden by {other.occluded_by}" if other.occluded_by else ""
    reason = f"{other.remote.id} stands {max(other.gap, 0.0):.0f} m ahead{hidden}: {time:.1f} s to it"
    return alert(
        Application.CURB_SIDE, level_for(_needed(ego, other, settings), settings), other, time, reason
    )


def _contact(ego: EgoView, other: Sighting, settings: AlertSettings) -> float:
    """Time to the contact with a leader [s], the ego at its present speed."""
    gap, b, v = max(other.gap, 0.0), -other.remote.a_x, max(other.v, 0.0)
    closing = ego.v - v
    if b < settings.braking or v == 0.0:
        return gap / closing if closing > 0.0 else math.inf
    time = (math.sqrt(closing * closing + 2.0 * b * gap) - closing) / b
    if time <= v / b:
        return time
    return (gap + 0.5 * v * v / b) / ego.v if ego.v > 0.0 else math.inf


def _needed(ego: EgoView, other: Sighting, settings: AlertSettings) -> float:
    """Deceleration with which the ego stays behind a leader [m/s^2]."""
    gap, b, v = max(other.gap, 1e-3), -other.remote.a_x, max(other.v, 0.0)
    needed = max(ego.v - v, 0.0) ** 2 / (2.0 * gap)
    if b >= settings.braking:
        needed = max(needed, max(ego.v, 0.0) ** 2 / (2.0 * (gap + 0.5 * v * v / b)))
    return needed


def blind_spot(ego: EgoView, other: Sighting, settings: AlertSettings) -> Alert | None:
    """Tell of a vehicle beside or close behind beside (BSW), warn if the ego means to go there (LCW).

    Parameters
    ----------
    ego : EgoView
        The ego.
    other : Sighting
        The other vehicle.
    settings : AlertSettings
        Thresholds.

    Returns
    -------
    alert : Alert or None
        The warning, None if there is no reason for one.
    """
    apart = abs(other.lateral_offset) - ego.half_width - other.half_width
    across = apart < settings.bsw_far and apart + 2.0 * other.half_width > settings.bsw_near
    # from the ego's middle back
    ahead = other.gap + ego.half_length
    behind = -(other.gap + 2.0 * other.half_length) - 2.0 * ego.half_length
    along = ahead <= 0.0 and behind <= settings.bsw_behind
    if not (across and along) or abs(other.angle) > PARALLEL_ANGLE:
        return None
    side = "left" if other.lateral_offset > 0.0 else "right"
    if ego.intent == side:
        reason = f"{other.remote.id} is beside, {side}, where the ego means to go"
        return alert(Application.LCW, Level.WARN, other, 0.0, reason)
    reason = f"{other.remote.id} is beside, {side}"
    return alert(Application.BSW, Level.INFORM, other, 0.0, reason)


def do_not_pass(ego: EgoView, other: Sighting, settings: AlertSettings) -> Alert | None:
    """Warn of oncoming traffic where the ego is, or means to go in order to pass (DNPW).

    Parameters
    ----------
    ego : EgoView
        The ego.
    other : Sighting
        The other vehicle.
    settings : AlertSettings
        Thresholds.

    Returns
    -------
    alert : Alert or None
        The warning, None if there is no reason for one.
    """
    if (
        abs(other.angle) < math.pi - PARALLEL_ANGLE
        or other.v > -settings.standstill_speed
        or not is_ahead(ego, other)
    ):
        return None
    side = "left" if other.lateral_offset > 0.0 else "right"
    lane = 0.5 * ego.lane_width <= abs(other.lateral_offset) <= 1.5 * ego.lane_width
    if not (blocks_ego(ego, other) or (ego.intent == side and lane)):
        return None
    time = max(other.gap, 0.0) / (max(ego.v, 0.0) - other.v)
    if time >= settings.dnpw_time:
        return None
    reason = f"{other.remote.id} comes toward the ego, {other.gap:.0f} m ahead: {time:.1f} s to collision"
    return alert(Application.DNPW, Level.WARN, other, time, reason)


def intersection(ego: EgoView, other: Sighting, settings: AlertSettings) -> Alert | None:
    """Warn of crossing traffic that arrives together with the ego (IMA).

    Parameters
    ----------
    ego : EgoView
        The ego.
    other : Sighting
        The other vehicle.
    settings : AlertSettings
        Thresholds.

    Returns
    -------
    alert : Alert or None
        The warning, None if there is no reason for one.
    """
    c = other.conflict
    if c is None or c.t_ego[0] > settings.ima_time or other.crosses_ego_turn:
        return None
    together = c.t_ego[0] <= c.t_other_nominal[1] and c.t_other_nominal[0] <= c.t_ego[1]
    difference = abs(c.t_ego[0] - c.t_other_nominal[0])
    if not together and difference > settings.ima_difference:
        return None
    reason = (
        f"{other.remote.id} crosses {max(c.distance, 0.0):.0f} m ahead: "
        f"it arrives in {c.t_other_nominal[0]:.1f} s, the ego in {c.t_ego[0]:.1f} s"
    )
    time = max(c.t_ego[0], c.t_other_nominal[0])
    return alert(Application.IMA, _stop_level(ego, c.distance, settings), other, time, reason)


def left_turn(ego: EgoView, other: Sighting, settings: AlertSettings) -> Alert | None:
    """Warn of oncoming traffic that is too close to turn in front of it (LTA).

    Parameters
    ----------
    ego : EgoView
        The ego.
    other : Sighting
        The other vehicle.
    settings : AlertSettings
        Thresholds.

    Returns
    -------
    alert : Alert or None
        The warning, None if there is no reason for one. Where traffic keeps left it is a right turn.
    """
    c = other.conflict
    if c is None or c.t_ego[0] > settings.ima_time or not other.crosses_ego_turn:
        return None
    gap = c.t_other_nominal[0] - c.t_ego[0]
    if gap >= settings.lta_gap or c.t_ego[0] - c.t_other_nominal[1] > settings.ima_difference:
        return None
    reason = (
        f"{other.remote.id} comes toward the turning ego: a gap of {gap:.1f} s, "
        f"{settings.lta_gap:.1f} s are needed"
    )
    time = max(c.t_ego[0], c.t_other_nominal[0])
    return alert(Application.LTA, _stop_level(ego, c.distance, settings), other, time, reason)


def _stop_level(ego: EgoView, distance: float, settings: AlertSettings) -> Level:
    """Level of a conflict: in the area already, braking is not the answer."""
    return level_for(0.5 * ego.v * ego.v / distance, settings) if distance > 0.0 else Level.WARN
