"""V2V applications that look ahead: a leader that brakes or stands, hard braking, a hidden standing car."""

import math

from cca_core.decide.alert import (
    ALIKE,
    Alert,
    AlertSettings,
    Application,
    EgoView,
    Level,
    Sighting,
    alert,
    is_ahead,
    is_in_the_way,
    level_for,
)

__all__ = ["brake_light", "forward_collision", "stationary_ahead"]


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
    stands = abs(other.remote.v_x) < settings.standing
    if not (is_ahead(ego, other) and is_in_the_way(ego, other)) or (abs(other.angle) > ALIKE and not stands):
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


def brake_light(ego: EgoView, other: Sighting, settings: AlertSettings) -> Alert | None:
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
    if abs(other.beside) > 1.5 * ego.lane_width:
        return None
    own = abs(other.beside) <= 0.5 * ego.lane_width
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
    if abs(other.remote.v_x) >= settings.standing or not is_ahead(ego, other):
        return None
    if not is_in_the_way(ego, other, settings.curbside_clearance) or ego.v <= 0.0:
        return None
    time = max(other.gap, 0.0) / ego.v
    if time > settings.curbside_time:
        return None
    hidden = f", hidden by {other.hidden_by}" if other.hidden_by else ""
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
