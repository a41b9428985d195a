"""V2V applications that look around: beside the ego, at oncoming traffic, and at junctions."""

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

__all__ = ["blind_spot", "do_not_pass", "intersection", "left_turn"]


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
    apart = abs(other.beside) - ego.half_width - other.half_width
    across = apart < settings.bsw_far and apart + 2.0 * other.half_width > settings.bsw_near
    # from the ego's middle back
    ahead = other.gap + ego.half_length
    behind = -(other.gap + 2.0 * other.half_length) - 2.0 * ego.half_length
    along = ahead <= 0.0 and behind <= settings.bsw_behind
    if not (across and along) or abs(other.angle) > ALIKE:
        return None
    side = "left" if other.beside > 0.0 else "right"
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
    if abs(other.angle) < math.pi - ALIKE or other.v > -settings.standing or not is_ahead(ego, other):
        return None
    side = "left" if other.beside > 0.0 else "right"
    lane = 0.5 * ego.lane_width <= abs(other.beside) <= 1.5 * ego.lane_width
    if not (is_in_the_way(ego, other) or (ego.intent == side and lane)):
        return None
    time = max(other.gap, 0.0) / (max(ego.v, 0.0) - other.v)
    if time >= settings.dnpw_time:
        return None
    reason = f"{other.remote.id} comes towards the ego, {other.gap:.0f} m ahead: {time:.1f} s to collision"
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
    if c is None or c.ego[0] > settings.ima_time or other.turns_across:
        return None
    together = c.ego[0] <= c.expected[1] and c.expected[0] <= c.ego[1]
    difference = abs(c.ego[0] - c.expected[0])
    if not together and difference > settings.ima_difference:
        return None
    reason = (
        f"{other.remote.id} crosses {max(c.distance, 0.0):.0f} m ahead: "
        f"it arrives in {c.expected[0]:.1f} s, the ego in {c.ego[0]:.1f} s"
    )
    time = max(c.ego[0], c.expected[0])
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
    if c is None or c.ego[0] > settings.ima_time or not other.turns_across:
        return None
    gap = c.expected[0] - c.ego[0]
    if gap >= settings.lta_gap or c.ego[0] - c.expected[1] > settings.ima_difference:
        return None
    reason = (
        f"{other.remote.id} comes towards the turning ego: a gap of {gap:.1f} s, "
        f"{settings.lta_gap:.1f} s are needed"
    )
    time = max(c.ego[0], c.expected[0])
    return alert(Application.LTA, _stop_level(ego, c.distance, settings), other, time, reason)


def _stop_level(ego: EgoView, distance: float, settings: AlertSettings) -> Level:
    """Level of a conflict: in the area already, braking is not the answer."""
    return level_for(0.5 * ego.v * ego.v / distance, settings) if distance > 0.0 else Level.WARN
