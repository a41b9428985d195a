"""Association: whether two messages can come from one body."""

import math

from cca_core.geometry import wrap_angle
from cca_core.v2x._tracks import Track
from cca_core.v2x.motion import Fix
from cca_core.v2x.plausibility import PlausibilitySettings
from cca_core.vehicle import STALE_AGE

__all__ = ["explains", "may_be_same_body", "position_at"]

_MIN_SEPARATION = 1.8  # across, of two bodies next to each other [m]
_MAX_CHANGE_GAP = 15.0  # message gap after which a new id may be that of a stale track [s]
_MAX_OFFSET = 30.0  # of a new id from the prediction [m]
_MAX_UNEXPLAINED_TURN = 2.0  # that the reported yaw rates do not show; a U-turn shows [rad]


def position_at(fix: Fix, t: float) -> tuple[float, float]:
    """Position at a time before or after a fix, at constant speed [m]."""
    s = fix.v * (t - fix.t)
    return fix.x + s * math.cos(fix.psi), fix.y + s * math.sin(fix.psi)


def may_be_same_body(track: Track, message: Track, limits: PlausibilitySettings) -> bool:
    """Return whether a message may come from the body of a track: two bodies would not fit there."""
    dt, v = message.fix.t - track.fix.t, max(abs(track.fix.v), abs(message.fix.v))
    unknown = 0.25 * limits.max_acceleration * dt * dt
    tolerance = limits.time_tolerance * v + unknown
    x, y = position_at(track.fix, message.fix.t)
    off_x, off_y = message.fix.x - x, message.fix.y - y
    if math.hypot(off_x, off_y) > limits.position_tolerance + tolerance:
        return False
    if track.motion.psi is None or message.motion.psi is None:
        return True
    cos, sin = math.cos(track.fix.psi), math.sin(track.fix.psi)
    along, across = abs(off_x * cos + off_y * sin), abs(off_y * cos - off_x * sin)
    length, width = 0.5 * (track.length + message.length), 0.5 * (track.width + message.width)
    return along <= length + tolerance and across <= max(width, _MIN_SEPARATION) + unknown


def explains(message: Track, silent: Track, limits: PlausibilitySettings) -> bool:
    """Return whether a new sender can be the vehicle of a silent track under another id."""
    old, new = silent.fix, message.fix
    gap = new.t - old.t
    if gap > _MAX_CHANGE_GAP or not silent.has_size_of(message):
        return False
    turn, reported = wrap_angle(new.psi - old.psi), 0.5 * (old.r + new.r) * gap
    turn += math.tau * round((reported - turn) / math.tau)
    # an arc with the mean speed and the change of heading leads from one to the other; a road that bends
    # on a part of the way leads off the arc, by as much as the yaw rates differ from the mean
    unexplained = abs(old.r * gap - turn), abs(new.r * gap - turn)
    if min(unexplained) > _MAX_UNEXPLAINED_TURN:
        return False
    driven, half = 0.5 * (old.v + new.v) * gap, 0.5 * turn
    chord, mean = driven * (math.sin(half) / half if half else 1.0), old.psi + half
    off_x, off_y = new.x - old.x - chord * math.cos(mean), new.y - old.y - chord * math.sin(mean)
    along = abs(off_x * math.cos(mean) + off_y * math.sin(mean))
    across = abs(off_y * math.cos(mean) - off_x * math.sin(mean))
    part = 0.25 if old.r or new.r else 0.5  # without yaw rates the turn may be anywhere on the way
    bend = min(part * abs(driven) * max(unexplained), _MAX_OFFSET)
    if gap <= STALE_AGE:  # the predicted body and the new one would overlap
        length, width = 0.5 * (silent.length + message.length), 0.5 * (silent.width + message.width)
        return along <= length and across <= width + bend
    # mean speeds err by a quarter of an acceleration of 4 m/s^2; the lane is kept
    limit = 3.0 + limits.time_tolerance * max(abs(old.v), abs(new.v)) + gap * gap
    return along <= min(limit, _MAX_OFFSET) and across <= 2.0 + 0.1 * gap + bend
