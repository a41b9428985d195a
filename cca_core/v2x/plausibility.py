"""Whether a message can be true, given what its sender and the others said before."""

import math
from dataclasses import dataclass, fields

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.geometry import wrap_angle
from cca_core.v2x.motion import Fix

__all__ = ["PLAUSIBILITY_CHECKS", "PlausibilitySettings", "implausible_motion", "implausible_state"]

PLAUSIBILITY_CHECKS = (
    "replay", "future", "size", "frozen", "teleport", "displacement", "acceleration", "yaw", "overlap",
)  # fmt: skip
"""Names of the checks; each is a switch of `PlausibilitySettings`."""

_SPEED_NOISE = 1.0  # between two messages [m/s]
_TURN_NOISE = 0.2  # [rad]
_TURNING = 3.0  # slower than this the heading is noise [m/s]
_TELEPORT = 3.0  # times the room of `displacement`


@dataclass(frozen=True, slots=True, kw_only=True)
class PlausibilitySettings:
    """Which checks are made, and their limits.

    Parameters
    ----------
    replay : bool
        Drop what was measured longer than `age_limit` ago.
    future : bool
        Drop what claims to be measured more than `clock_error` from now.
    size : bool
        Drop a body longer than `longest`, wider than `widest`, or shorter or narrower than `min_size`.
    frozen : bool
        Drop a position that stands still while its sender reports to move.
    teleport : bool
        Drop a position more than three times as far from where the reported speeds lead as `displacement`
        allows.
    displacement : bool
        Drop a position farther than `room` + `timing` times speed from where the reported speeds lead.
    acceleration : bool
        Drop an acceleration, or a change of speed, beyond `strongest`.
    yaw : bool
        Drop a yaw rate, or a change of heading, that needs more than `strongest` sideways.
    overlap : bool
        Drop a position within the body of a vehicle that was heard of before it.
    age_limit : float
        Oldest measurement [s].
    clock_error : float
        Largest lead of a sender's clock [s].
    max_length, max_width, min_size : float
        Limits of a body [m].
    position_tolerance : float
        Error of a position against the last ones [m].
    time_tolerance : float
        Error of a time stamp [s].
    max_acceleration : float
        Acceleration of a road vehicle [m/s^2].

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
    max_length: float = 26.0
    max_width: float = 4.0
    min_size: float = 0.3
    position_tolerance: float = 6.0
    time_tolerance: float = 0.35
    max_acceleration: float = 12.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name not in PLAUSIBILITY_CHECKS:
                check_real(field.name, value, gt=0.0)
            elif not isinstance(value, bool):
                raise InputError(f"{field.name} must be True or False, was {value!r}")


def implausible_state(
    settings: PlausibilitySettings, fix: Fix, length: float, width: float, t_received: float
) -> str:
    """Look at one message alone.

    Parameters
    ----------
    settings : PlausibilitySettings
        Checks and limits.
    fix : Fix
        What it says.
    length, width : float
        Size that it claims [m].
    t_received : float
        When it was received [s].

    Returns
    -------
    check : str
        Name of the check that it fails; empty if none.
    """
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
    if settings.yaw and abs(fix.r) * max(abs(fix.v), _TURNING) > settings.max_acceleration:
        return "yaw"
    return ""


def implausible_motion(
    settings: PlausibilitySettings,
    last: Fix,
    ref: tuple[float, float],
    said: tuple[float, float],
    driven: float,
    fix: Fix,
) -> tuple[str, tuple[float, float]]:
    """Compare a message with what its sender said before.

    Parameters
    ----------
    settings : PlausibilitySettings
        Checks and limits.
    last : Fix
        Where it was and how it moved at its last message.
    ref : tuple of float
        Where its sender was then by all messages before [m].
    said : tuple of float
        The last place that was believed, as told [m].
    driven : float
        Distance driven between that and the last message by the reported speeds [m].
    fix : Fix
        What the new one says, measured later.

    Returns
    -------
    check : str
        Name of the check that it fails; empty if none. Those of its motion come before those of its place.
    ref : tuple of float
        Where its sender is now by all messages [m]: dead-reckoned by the reported speeds and drawn to the
        reported positions with a time constant of 2 s, so that a slow drift is found as well as a jump.
    """
    dt = fix.t - last.t
    turn = wrap_angle(fix.psi - last.psi)
    mean, s = last.psi + 0.5 * turn, 0.5 * (last.v + fix.v) * dt
    x, y = ref[0] + s * math.cos(mean), ref[1] + s * math.sin(mean)
    if settings.acceleration and abs(fix.v - last.v) > _SPEED_NOISE + settings.max_acceleration * dt:
        return "acceleration", (x, y)
    slowest = max(min(abs(last.v), abs(fix.v)), 0.1)
    if (
        settings.yaw
        and slowest > _TURNING
        and abs(turn) > _TURN_NOISE + settings.max_acceleration / slowest * dt
    ):
        return "yaw", (x, y)
    driven += abs(s)
    moved = math.hypot(fix.x - said[0], fix.y - said[1])
    if settings.frozen and driven > 0.5 and moved < 0.1 * driven:
        return "frozen", (x, y)
    off_x, off_y = fix.x - x, fix.y - y
    off = math.hypot(off_x, off_y)
    fastest = max(abs(last.v), abs(fix.v))
    room = (
        settings.position_tolerance
        + settings.time_tolerance * fastest
        + 0.25 * settings.max_acceleration * dt * dt
    )
    if settings.teleport and off > _TELEPORT * room:
        return "teleport", (x, y)
    if settings.displacement and off > room:
        return "displacement", (x, y)
    gain = 1.0 - math.exp(-0.5 * dt)
    return "", (x + gain * off_x, y + gain * off_y)
