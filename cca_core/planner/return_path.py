"""Path of a return: hold the lateral offset for a distance, then go back to the route."""

import math
from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.decide import Rejection
from cca_core.errors import Status
from cca_core.frenet import FrenetEgo
from cca_core.geometry import QUINTIC_PEAK, quintic_step
from cca_core.path import Road, splice_path
from cca_core.planner.maneuver import Maneuver
from cca_core.planner.maneuver_tuning import AbortSettings


def return_length(d: float, v: float, settings: AbortSettings) -> float:
    """Return the length of a return from a lateral offset at a speed [m]."""
    duration = math.sqrt(QUINTIC_PEAK * max(abs(d), 0.5) / settings.lateral_acceleration)
    return max(v * duration, settings.min_length)


def return_maneuver(
    ego: FrenetEgo,
    road: Road,
    maneuver: Maneuver,
    hold_distance: float,
    v_return: float,
    rejection: Rejection | None,
    settings: AbortSettings,
    *,
    keep_moving_out: bool,
) -> Maneuver | None:
    """Hold the offset of a maneuver for a distance, then return at a speed; None if the route ends before."""
    s_ego = ego.s_cg
    d, s_return = maneuver.offset_at(s_ego), s_ego + hold_distance
    slope, length = maneuver.offset_at(s_ego + 1.0) - d, return_length(d, v_return, settings)
    if slope * d < 0.0 and hold_distance == 0.0:
        length = min(length, max(settings.max_overshoot_ratio * abs(d / slope), settings.min_length))
    for _ in range(5):  # it moved out still, or has to turn round: lengthen it until it is smooth enough
        s, u = _return_profile(
            s_ego, ego.v_x, maneuver, s_return, length, settings, keep_moving_out=keep_moving_out
        )
        curvature = np.abs(np.diff(u, n=2))[s[1:-1] >= s_ego].max() / (s[1] - s[0]) ** 2
        ratio = v_return * v_return * float(curvature) / settings.lateral_acceleration
        if ratio <= 1.1:
            break
        length *= math.sqrt(ratio)
    if s[-1] > road.path.end:
        return None
    return replace(
        maneuver, end=float(s[-1]), displacement=u,
        band=replace(maneuver.band, status=Status.DEGRADED, message=f"aborted: {rejection}"),
        candidate=replace(maneuver.candidate, rejection=rejection),
        reference=splice_path(road.path, s, road.path.to_cartesian(s, u)),
    )  # fmt: skip


def _return_profile(
    s_ego: float,
    v_x: float,
    maneuver: Maneuver,
    s_return: float,
    length: float,
    settings: AbortSettings,
    *,
    keep_moving_out: bool,
) -> tuple[Array, Array]:
    """Stations and displacements of a maneuver that is held until `s_return` and then returns."""
    d, before = maneuver.offset_at(s_ego), maneuver.offset_at(s_ego - 1.0)
    slope, hold_distance = maneuver.offset_at(s_ego + 1.0) - d, s_return - s_ego
    returning = slope * d < 0.0
    s = np.linspace(maneuver.start, s_return + length, len(maneuver.displacement))
    u, ahead = np.interp(s, maneuver.stations, maneuver.displacement), s >= s_ego
    x = np.clip((s - s_return) / length, 0.0, 1.0)
    if returning and hold_distance == 0.0:  # from the slope and curvature of now
        second_difference = slope - (d - before)
        back = d * (1.0 - quintic_step(x))
        back += slope * length * (x - x**3 * (6.0 - 8.0 * x + 3.0 * x * x))
        back += 0.5 * second_difference * length**2 * (x * x * (1.0 - x) ** 3)
        u[ahead] = back[ahead]
        return s, u
    sign = 1.0 if maneuver.side == "left" else -1.0
    # until it may return it moves out as planned, but not back
    out = np.maximum.accumulate(np.maximum(sign * u[ahead], sign * d)) if keep_moving_out else sign * d
    u[ahead] = sign * out
    if returning or not keep_moving_out:  # the lateral motion of now settles
        settling = max(settings.settling_time * v_x, 1.0)
        y = np.clip((s[ahead] - s_ego) / settling, 0.0, 1.0)
        u[ahead] += slope * settling * (y - y**3 + 0.5 * y**4)
    u *= 1.0 - quintic_step(x)
    return s, u
