"""Maneuvers that an oracle knows to be safe in the worst case, and whether the planner refuses them."""

import math
from dataclasses import replace

import numpy as np

from cca_core import RemoteVehicle
from cca_core._checks import Array
from cca_core.planner import EvasionSettings
from tests.support.guarantee import (
    CAR,
    CYCLE,
    SPEED_LIMIT,
    START,
    Case,
    Sender,
    decide,
    hear,
    name_of,
    road_of,
    state_at,
)

BRAKING, ACCELERATION = 8.0, 3.0  # declared bounds [m/s^2]
REACTION = 0.4  # of the ego [s]
EGO_BRAKING = 7.0  # [m/s^2]
DURATION = 16.0  # of a maneuver at most [s]


def is_refused(case: Case, settings: EvasionSettings) -> bool | None:
    """Return whether a maneuver is refused that an oracle knows to be safe; None if it knows of none."""
    case = replace(case, driven=0.0, d=0.0, angle=0.0)
    lead = replace(case, senders=case.senders[:1])
    if decide(lead, settings).command.band is None:
        return None
    ride = _passing(lead, settings)
    if ride is None:
        return None
    remotes = hear(case)
    others = [(s, remotes[name_of(i)]) for i, s in enumerate(case.senders) if i and name_of(i) in remotes]
    if not all(_is_clear(case, sender, remote, *ride) for sender, remote in others):
        return None
    return decide(case, settings).command.band is None


def _passing(case: Case, settings: EvasionSettings) -> tuple[Array, Array, Array, Array] | None:
    """Times, stations, offsets and speeds of an ego that passes the lead alone; None if it does not."""
    decided = decide(case, settings)
    road, planner, sender = road_of(case.road), decided.planner, case.senders[0]
    if name_of(0) not in decided.remotes:
        return None
    seen = decided.remotes[name_of(0)]
    path, s, v = road.path, START, case.v
    rows, left = [(0.0, s, 0.0, v)], False
    a = decided.command.a_x
    for k in range(1, round(DURATION / CYCLE)):
        then = max(v + a * CYCLE, 0.0)
        s, v = s + 0.5 * (v + then) * CYCLE, then
        driven = planner.maneuver
        d, d_next = (0.0, 0.0) if driven is None else (driven.offset_at(s), driven.offset_at(s + 1.0))
        at = sender.s + sender.v * (sender.age + k * CYCLE)
        x, y = path.to_cartesian(at, sender.d)
        report = replace(
            seen, x=float(x), y=float(y), psi=float(path.heading(at)), v_x=abs(sender.v), a_x=0.0, r=0.0,
            age=0.0, sigma_along=0.0, sigma_across=0.0,
        )  # fmt: skip
        kappa = float(path.curvature_at(s))
        a = planner.step(
            k * CYCLE, state_at(road, s, d, math.atan((d_next - d) / (1.0 - d * kappa)), v), [report]
        ).a_x
        rows.append((k * CYCLE, s, d, v))
        left = left or abs(d) > 1.0
        if left and abs(d) < 0.05:
            ride = np.array(rows).T
            return (ride[0], ride[1], ride[2], ride[3]) if s > at else None
    return None


def _is_clear(
    case: Case, sender: Sender, remote: RemoteVehicle, t: Array, s: Array, d: Array, v: Array
) -> bool:
    """Whether a vehicle cannot be where the ego is, nor so close ahead at the end that it cannot stop."""
    road, half = road_of(case.road), 0.5 * sender.length + 2.0 * remote.sigma_along
    at, offset = (float(x) for x in road.path.project((remote.x, remote.y), sender.s))
    if sender.v >= 0.0 and at + half < START - 0.5 * CAR.length and abs(offset) < 1.2:
        return True  # it keeps its distance in the ego lane
    since, u = t + sender.age, abs(sender.v)
    slows = np.minimum(since, u / BRAKING)
    gains = np.minimum(since, max(SPEED_LIMIT - u, 0.0) / ACCELERATION)
    shortest = u * slows - 0.5 * BRAKING * slows**2
    longest = u * since + 0.5 * ACCELERATION * gains**2 + ACCELERATION * gains * (since - gains)
    begin = sender.s
    low, high = (
        (begin + shortest, begin + longest) if sender.v >= 0.0 else (begin - longest, begin - shortest)
    )
    aside = np.abs(d - offset) - 0.5 * (CAR.width + sender.width) - 2.0 * remote.sigma_across
    aside -= 0.5 * CAR.length * np.abs(np.gradient(d, s + 1e-6 * t))
    center = s + CAR.box_offset
    along = np.maximum(low - half - center, center - high - half) - 0.5 * CAR.length
    if bool(((aside < 0.1) & (along < 0.1)).any()):
        return False
    if abs(offset) < 2.0 and at > START:  # ahead in the ego lane: it stops, and so does the ego
        rest = begin + math.copysign(0.5 * u * u / BRAKING, sender.v) - half
        stops = s[-1] + 0.5 * CAR.length + v[-1] * REACTION + 0.5 * v[-1] ** 2 / EGO_BRAKING
        return sender.v >= 0.0 and rest > stops
    return True
