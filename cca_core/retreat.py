"""Give up a swerve whose lane beside is no longer free: fall back and return behind the vehicle in front."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cca_core.errors import Status
from cca_core.evasion import Evasion
from cca_core.path import Lane, Path, Road, detour_path
from cca_core.scene import Ego, Neighbour

__all__ = ["plan_retreat", "put_off", "slow_enough"]

_BRAKE = 5.0  # deceleration counted on for falling back [m/s^2]
_LAG = 0.3  # until it is there: half the time in which brakes build up, and their lag [s]
_ROOM = 2.0  # to the vehicle in front before the ego returns behind it [m]
_REACTION = 1.0  # of drivers behind [s]
_RUN_OUT = 0.6  # in which it stops to drift back too early [s]
_LATERAL = 4.0  # lateral acceleration of the return [m/s^2]
_GIVEN_UP = "given up: "
_QUINTIC = 5.7735  # peak of the second derivative of the quintic step


def plan_retreat(
    ego: Ego, road: Road, maneuver: Evasion, others: Sequence[Neighbour], obstruction: str
) -> Evasion | None:
    """Return to the own lane behind what was to be passed, if that can still be done.

    Parameters
    ----------
    ego : Ego
        The ego, somewhere in the manoeuvre.
    road : Road
        Route and lanes.
    maneuver : Evasion
        What is given up.
    others : sequence of Neighbour
        All other vehicles.
    obstruction : str
        Why it is given up.

    Returns
    -------
    retreat : Evasion or None
        The way back; None beyond the point of no return: where braking no longer brings the ego behind, or
        into the way of those that come from behind on either lane.
    """
    d = maneuver.offset_at(ego.s)
    front = ego.s + ego.vehicle.box_offset + 0.5 * ego.vehicle.length
    rear = front - ego.vehicle.length
    own = road.own_lane
    ahead = [n for n in others if n.s + n.half_length > rear and _on(n, own)]
    if not ahead:
        return None
    leader = min(ahead, key=lambda n: n.s)
    gap = leader.s - leader.half_length - front
    t = np.linspace(0.0, _LAG + max(ego.v_x, 0.1) / _BRAKE, 60)
    braked = np.maximum(t - _LAG, 0.0)
    opens = gap + leader.v_s * t - (ego.v_x * t - 0.5 * _BRAKE * braked * braked)
    closing = np.maximum(ego.v_x - _BRAKE * braked - leader.v_s, 0.0)
    behind = np.flatnonzero(opens >= _ROOM + closing**2 / (2.0 * _BRAKE))
    if not len(behind):
        return None
    moment = float(t[behind[0]])
    hold = ego.v_x * moment - 0.5 * _BRAKE * float(braked[behind[0]]) ** 2
    v_then = ego.v_x - _BRAKE * float(braked[behind[0]])
    for n in others:
        left = rear + hold - (n.s + n.half_length + n.v_s * moment)
        from_behind = n.s + n.half_length <= rear and n.v_s > 0.0
        if from_behind and left < _following(n.v_s, min(v_then, leader.v_s)):
            return None
    length = max(v_then * math.sqrt(_QUINTIC * max(abs(d), 0.5) / _LATERAL), 15.0)
    first, last = ego.s + hold, ego.s + hold + length
    if last > road.path.end:
        return None
    s = np.linspace(maneuver.start, last, len(maneuver.displacement))
    u = np.array([maneuver.offset_at(x) for x in s.tolist()])
    # until it may return it goes out as the swerve did, but not back: what it drifts dies down
    sign, onward = (1.0 if maneuver.side == "left" else -1.0), s >= ego.s
    u[onward] = sign * np.maximum.accumulate(np.maximum(sign * u[onward], sign * d))
    drift, run_out = maneuver.offset_at(ego.s + 1.0) - d, max(_RUN_OUT * ego.v_x, 1.0)
    if sign * drift < 0.0:
        part = np.clip((s - ego.s) / run_out, 0.0, 1.0)
        u += drift * run_out * (part - part**3 + 0.5 * part**4)
    share = np.clip((s - first) / length, 0.0, 1.0)
    u *= 1.0 - share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    band = replace(maneuver.band, status=Status.FALLBACK, message=f"{_GIVEN_UP}{obstruction}")
    reference = detour_path(road.path, s, road.path.to_cartesian(s, u))
    return replace(maneuver, end=last, band=band, displacement=u, reference=reference)


def put_off(ego: Ego, road: Road, retreat: Evasion, others: Sequence[Neighbour]) -> Evasion:
    """Begin the return later where the ego has not fallen back as far as was counted on.

    Parameters
    ----------
    ego : Ego
        The ego, on its way back.
    road : Road
        Route and lanes.
    retreat : Evasion
        As it was planned.
    others : sequence of Neighbour
        All other vehicles.

    Returns
    -------
    retreat : Evasion
        A later one while somebody is beside the ego on the own lane, if there is one; else the same.
    """
    front = ego.s + ego.vehicle.box_offset + 0.5 * ego.vehicle.length
    rear = front - ego.vehicle.length
    for n in others:
        if _on(n, road.own_lane) and rear < n.s + n.half_length and n.s - n.half_length < front + _ROOM:
            why = retreat.band.message.removeprefix(_GIVEN_UP)
            later = plan_retreat(ego, road, retreat, others, why)
            return later if later is not None and later.end > retreat.end else retreat
    return retreat


def slow_enough(way: Path, s: float, v_x: float) -> float:
    """Find what a car must brake with to be slow enough for the way back.

    The way is bent for the speed that the ego has once it has fallen back, not for the one that it has now.

    Parameters
    ----------
    way : Path
        What is steered along.
    s : float
        Where the ego is on it [m].
    v_x : float
        Its speed [m/s].

    Returns
    -------
    deceleration : float
        Least constant one with which it asks for no more than 4 m/s^2 to the side anywhere [m/s^2].
    """
    x = np.arange(1.0, 2.0 + v_x * v_x / (2.0 * _BRAKE), 1.0)
    squared = _LATERAL / np.maximum(np.abs(way.curvature(s + x)), 1e-6)
    return max(float(np.max((v_x * v_x - squared) / (2.0 * x))), 0.0)


def _on(other: Neighbour, lane: Lane) -> bool:
    return other.d - other.half_width < lane.left and other.d + other.half_width > lane.right


def _following(v: float, v_ahead: float) -> float:
    """Gap in which a driver behind slows down to the speed of the one in front [m]."""
    return _ROOM + v * _REACTION * (v > v_ahead) + max(v * v - v_ahead * v_ahead, 0.0) / (2.0 * _BRAKE)
