"""Plausibility checks of messages against physics and earlier messages."""

import math
from dataclasses import dataclass, fields

from cca_core._checks import check_bool, check_real
from cca_core._repr import short_repr
from cca_core.geometry import wrap_angle
from cca_core.v2x.motion import Fix

__all__ = [
    "PLAUSIBILITY_CHECKS",
    "POSITION_CHECKS",
    "PlausibilitySettings",
    "implausible_motion",
    "implausible_state",
]

PLAUSIBILITY_CHECKS = (
    "replay", "future", "size", "frozen", "teleport", "displacement", "acceleration", "yaw", "overlap",
)  # fmt: skip
"""Names of the checks; each is a switch of `PlausibilitySettings`."""

POSITION_CHECKS = frozenset({"frozen", "teleport", "displacement", "overlap"})
"""Checks of the position: the reported motion of a rejected message may still be true."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlausibilitySettings:
    """Plausibility checks of messages and their limits.

    Parameters
    ----------
    replay : bool
        Reject a message measured more than `age_limit` ago.
    future : bool
        Reject a message measured more than `clock_error` after its reception.
    size : bool
        Reject a body longer than `max_length`, wider than `max_width`, or smaller than `min_size`.
    frozen : bool
        Reject a constant position of a sender that reports a speed.
    teleport : bool
        Reject a position `teleport_factor` times farther from the prediction than `displacement` allows.
    displacement : bool
        Reject a position farther than `position_tolerance` + `time_tolerance` times speed from the one that
        the reported speeds predict.
    acceleration : bool
        Reject an acceleration, or a change of speed beyond `speed_tolerance`, above `max_acceleration`.
    yaw : bool
        Reject a yaw rate, or a change of heading beyond `heading_tolerance`, with a lateral acceleration
        above `max_acceleration`.
    overlap : bool
        Reject a position within the body of a vehicle with an older track.
    age_limit : float
        Largest age of a measurement [s].
    clock_error : float
        Largest lead of a sender's clock [s].
    max_length, max_width, min_size : float
        Limits of a body [m]; the largest is what a message can report.
    min_overlap_length, min_overlap_width, max_overlap_length, max_overlap_width : float
        Limits of a body in the check `overlap`, whatever the sender reports [m].
    position_tolerance : float
        Error of a position against earlier ones [m].
    time_tolerance : float
        Error of a time stamp [s].
    speed_tolerance : float
        Noise of the speed between two messages [m/s].
    heading_tolerance : float
        Noise of the heading between two messages [rad].
    min_turning_speed : float
        Speed below which the heading is noise [m/s].
    max_acceleration : float
        Acceleration of a road vehicle [m/s^2].
    teleport_factor : float
        Multiple of the tolerance of `displacement` [-].

    Raises
    ------
    InputError
        If a switch is not a bool, or a limit is not a positive number.
    """

    replay: bool = True
    future: bool = True
    size: bool = True
    frozen: bool = True
    teleport: bool = True
    displacement: bool = True
    acceleration: bool = True
    yaw: bool = True
    overlap: bool = True
    age_limit: float = 1.0
    clock_error: float = 0.2
    max_length: float = 40.95
    max_width: float = 10.23
    min_size: float = 0.3
    min_overlap_length: float = 1.5
    min_overlap_width: float = 0.8
    max_overlap_length: float = 26.0
    max_overlap_width: float = 4.0
    position_tolerance: float = 6.0
    time_tolerance: float = 0.35
    speed_tolerance: float = 1.0
    heading_tolerance: float = 0.2
    min_turning_speed: float = 3.0
    max_acceleration: float = 12.0
    teleport_factor: float = 3.0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name in PLAUSIBILITY_CHECKS:
                check_bool(field.name, value)
            else:
                check_real(field.name, value, gt=0.0)


def implausible_state(
    settings: PlausibilitySettings, fix: Fix, length: float, width: float, t_received: float
) -> str:
    """Return the name of the check that one message alone fails; empty if none."""
    age = t_received - fix.t
    if settings.replay and age > settings.age_limit:
        return "replay"
    if settings.future and -age > settings.clock_error:
        return "future"
    if settings.size and not (
        settings.min_size <= length <= settings.max_length
        and settings.min_size <= width <= settings.max_width
    ):
        return "size"
    if settings.acceleration and abs(fix.a) > settings.max_acceleration:
        return "acceleration"
    if settings.yaw and abs(fix.r) * max(abs(fix.v), settings.min_turning_speed) > settings.max_acceleration:
        return "yaw"
    return ""


def implausible_motion(
    settings: PlausibilitySettings,
    last: Fix,
    ref: tuple[float, float],
    reported: tuple[float, float],
    driven: float,
    fix: Fix,
    elapsed: float = 0.0,
) -> tuple[str, tuple[float, float]]:
    """Return the name of the check that a message fails against earlier ones, and the new reference."""
    # ref: position at `last` by all messages; reported: last accepted position as reported; driven: distance
    # from that to `last` by the reported speeds [m]; elapsed: least time between the messages [s], if their
    # positions have one time stamp
    dt = fix.t - last.t
    changed_in = max(dt, elapsed)
    turn = wrap_angle(fix.psi - last.psi)
    mean, s = last.psi + 0.5 * turn, 0.5 * (last.v + fix.v) * dt
    x, y = ref[0] + s * math.cos(mean), ref[1] + s * math.sin(mean)
    speed_change = abs(fix.v - last.v)
    if (
        settings.acceleration
        and speed_change > settings.speed_tolerance + settings.max_acceleration * changed_in
    ):
        return "acceleration", (x, y)
    slowest = max(min(abs(last.v), abs(fix.v)), 0.1)
    if (
        settings.yaw
        and slowest > settings.min_turning_speed
        and abs(turn) > settings.heading_tolerance + settings.max_acceleration / slowest * changed_in
    ):
        return "yaw", (x, y)
    driven += abs(s)
    moved = math.hypot(fix.x - reported[0], fix.y - reported[1])
    if settings.frozen and driven > 0.5 and moved < 0.1 * driven:
        return "frozen", (x, y)
    off_x, off_y = fix.x - x, fix.y - y
    off = math.hypot(off_x, off_y)
    fastest = max(abs(last.v), abs(fix.v))
    tolerance = (
        settings.position_tolerance
        + settings.time_tolerance * fastest
        + 0.25 * settings.max_acceleration * dt * dt
    )
    if settings.teleport and off > settings.teleport_factor * tolerance:
        return "teleport", (x, y)
    if settings.displacement and off > tolerance:
        return "displacement", (x, y)
    # the reference follows reported positions with a time constant of 2 s: a slow drift is found like a jump
    gain = 1.0 - math.exp(-0.5 * dt)
    return "", (x + gain * off_x, y + gain * off_y)
