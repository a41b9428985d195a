"""Leave a lane beside that is no longer free: in front of those that are passed already, else behind them."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.errors import Status
from cca_core.geometry import quintic_step
from cca_core.path import Lane, Path, Road, splice_path
from cca_core.planner.frenet import FrenetEgo, FrenetVehicle
from cca_core.planner.maneuver import Maneuver
from cca_core.vehicle import VehicleParams

__all__ = ["delay_return", "plan_abort", "plan_early_return", "return_deceleration", "vehicle_alongside"]

_BRAKE = 5.0  # deceleration counted on for falling back [m/s^2]
_LAG = 0.3  # until it is there: half the time in which brakes build up, and their lag [s]
_STANDSTILL_GAP = 2.0  # to the vehicle in front before the ego returns behind it [m]
_REACTION = 1.0  # of drivers behind [s]
_RUN_OUT = 0.6  # in which it stops to drift back too early [s]
_LATERAL = 4.0  # lateral acceleration of the return [m/s^2]
_GIVEN_UP = "given up: "
_QUINTIC = 5.7735  # peak of the second derivative of the quintic step
_HEADWAY = 2.0  # to the next one in front of those passed: behind a nearer one the ego falls back [s]
_LEAST_LENGTH = 15.0  # of a return [m]
_MAX_OVERSHOOT_RATIO = (
    2.5  # as a multiple of how far it would go straight on, the longest return that does not overshoot
)
_MAX_LENGTHENINGS = 5  # times that a return is made longer to be less sharp, at most
_LATERAL_GAP = 0.2  # between bodies where one is passed on a shortcut [m]
_EARLY_RETURN_HORIZON = 3.0  # until a shortcut begins to return, at the latest [s]


def plan_abort(
    ego: FrenetEgo, road: Road, maneuver: Maneuver, others: Sequence[FrenetVehicle], obstruction: str
) -> Maneuver | None:
    """Return to the own lane behind what was to be passed, if that can still be done.

    Parameters
    ----------
    ego : Ego
        The ego, somewhere in the maneuver.
    road : Road
        Route and lanes.
    maneuver : Evasion
        What is given up.
    others : sequence of Neighbor
        All other vehicles.
    obstruction : str
        Why it is given up.

    Returns
    -------
    retreat : Evasion or None
        The way back; None beyond the point of no return: where braking no longer brings the ego behind, or
        into the way of those that come from behind on either lane.
    """
    front = ego.s + ego.vehicle.front
    rear = front - ego.vehicle.length
    ahead = [n for n in others if not _is_behind(n, rear) and _in_lane(n, road.ego_lane)]
    if not ahead:
        return None
    leader = min(ahead, key=lambda n: n.s)
    gap = leader.s - leader.half_length - front
    t = np.linspace(0.0, _LAG + max(ego.v_x, 0.1) / _BRAKE, 60)
    braked = np.maximum(t - _LAG, 0.0)
    opens = gap + leader.v_s * t - (ego.v_x * t - 0.5 * _BRAKE * braked * braked)
    closing = np.maximum(ego.v_x - _BRAKE * braked - leader.v_s, 0.0)
    behind = np.flatnonzero(opens >= _STANDSTILL_GAP + closing**2 / (2.0 * _BRAKE))
    if not len(behind):
        return None
    moment = float(t[behind[0]])
    hold = ego.v_x * moment - 0.5 * _BRAKE * float(braked[behind[0]]) ** 2
    v_return = ego.v_x - _BRAKE * float(braked[behind[0]])
    for n in others:
        left = rear + hold - (n.s + n.half_length + n.v_s * moment)
        if _is_behind(n, rear) and n.v_s > 0.0 and left < _following_gap(n.v_s, min(v_return, leader.v_s)):
            return None
    return _return_maneuver(ego, road, maneuver, hold, v_return, obstruction, keep_moving_out=True)


def plan_early_return(
    ego: FrenetEgo, road: Road, maneuver: Maneuver, others: Sequence[FrenetVehicle], obstruction: str
) -> Maneuver | None:
    """Return to the own lane sooner than was planned, in front of those that are passed by then.

    Parameters
    ----------
    ego : Ego
        The ego, somewhere in the maneuver; it keeps its speed.
    road : Road
        Route and lanes.
    maneuver : Evasion
        What can no longer be driven to its end.
    others : sequence of Neighbor
        All other vehicles.
    obstruction : str
        Why.

    Returns
    -------
    shortcut : Evasion or None
        The way back; None if the own lane does not have the room within 3 s, or somebody is met beside it
        before the ego is back.
    """
    front = ego.s + ego.vehicle.front
    rear, v, d = front - ego.vehicle.length, max(ego.v_x, 1.0), maneuver.offset_at(ego.s)
    t = np.linspace(0.0, _EARLY_RETURN_HORIZON, 31)
    returns, free = _return_length(d, v) / v, np.ones(len(t), dtype=np.bool_)
    for n in others:
        before = n.s - n.half_length + n.v_s * t - (front + v * t)
        apart = abs(n.d - d) - 0.5 * ego.vehicle.width
        if _in_lane(n, road.ego_lane):
            past = rear + v * t - (n.s + n.half_length + n.v_s * t) >= _following_gap(n.v_s, v)
            far = max(_STANDSTILL_GAP + max(v - n.v_s, 0.0) ** 2 / (2.0 * _BRAKE), _HEADWAY * v)
            free &= (before >= far) | (
                past if n.s <= ego.s or apart >= _half_width(n) + _LATERAL_GAP else False
            )
        elif n.s > ego.s and apart < n.half_width:
            free &= before + (n.v_s - v) * returns >= _STANDSTILL_GAP
    if not free.any():
        return None
    hold = v * float(t[np.argmax(free)])
    return _return_maneuver(ego, road, maneuver, hold, v, obstruction, keep_moving_out=False)


def _return_length(d: float, v: float) -> float:
    """Length of a return from a displacement at a speed [m]."""
    return max(v * math.sqrt(_QUINTIC * max(abs(d), 0.5) / _LATERAL), _LEAST_LENGTH)


def _return_maneuver(
    ego: FrenetEgo,
    road: Road,
    maneuver: Maneuver,
    hold_distance: float,
    v_return: float,
    obstruction: str,
    *,
    keep_moving_out: bool,
) -> Maneuver | None:
    """Stay out for `hold` meters, then return at a speed; None where the route ends before."""
    d, first = maneuver.offset_at(ego.s), ego.s + hold_distance
    drift, length = maneuver.offset_at(ego.s + 1.0) - d, _return_length(d, v_return)
    if drift * d < 0.0 and hold_distance == 0.0:
        length = min(length, max(_MAX_OVERSHOOT_RATIO * abs(d / drift), _LEAST_LENGTH))
    for _ in range(_MAX_LENGTHENINGS):
        s, u = _return_profile(ego, maneuver, first, length, keep_moving_out=keep_moving_out)
        bent = np.abs(np.diff(u, n=2))[s[1:-1] >= ego.s].max() / (s[1] - s[0]) ** 2
        sharp = v_return * v_return * float(bent) / _LATERAL
        if sharp <= 1.1:
            break
        length *= math.sqrt(sharp)  # it went out still, or has to turn round
    if s[-1] > road.path.end:
        return None
    band = replace(maneuver.band, status=Status.DEGRADED, message=f"{_GIVEN_UP}{obstruction}")
    reference = splice_path(road.path, s, road.path.to_cartesian(s, u))
    return replace(maneuver, end=float(s[-1]), band=band, displacement=u, reference=reference)


def _return_profile(
    ego: FrenetEgo, maneuver: Maneuver, first: float, length: float, *, keep_moving_out: bool
) -> tuple[Array, Array]:
    """Places and displacements of a maneuver that is held until `first` and then returns in a length."""
    d, before = maneuver.offset_at(ego.s), maneuver.offset_at(ego.s - 1.0)
    drift, hold = maneuver.offset_at(ego.s + 1.0) - d, first - ego.s
    returning = drift * d < 0.0
    s = np.linspace(maneuver.start, first + length, len(maneuver.displacement))
    u, onward = np.interp(s, maneuver.stations, maneuver.displacement), s >= ego.s
    x = np.clip((s - first) / length, 0.0, 1.0)
    if returning and hold == 0.0:  # on from its slope and curvature
        bent = drift - (d - before)
        back = d * (1.0 - quintic_step(x))
        back += drift * length * (x - x**3 * (6.0 - 8.0 * x + 3.0 * x * x))
        back += 0.5 * bent * length**2 * (x * x * (1.0 - x) ** 3)
        u[onward] = back[onward]
    else:
        sign = 1.0 if maneuver.side == "left" else -1.0
        # until it may return it goes out as the swerve did, but not back
        out = np.maximum.accumulate(np.maximum(sign * u[onward], sign * d)) if keep_moving_out else sign * d
        u[onward] = sign * out
        if returning or not keep_moving_out:  # what it drifts dies down
            run_out = max(_RUN_OUT * ego.v_x, 1.0)
            part = np.clip((s[onward] - ego.s) / run_out, 0.0, 1.0)
            u[onward] += drift * run_out * (part - part**3 + 0.5 * part**4)
        u *= 1.0 - quintic_step(x)
    return s, u


def delay_return(ego: FrenetEgo, road: Road, retreat: Maneuver, others: Sequence[FrenetVehicle]) -> Maneuver:
    """Begin the return later where the ego has not fallen back as far as was counted on.

    Parameters
    ----------
    ego : Ego
        The ego, on its way back.
    road : Road
        Route and lanes.
    retreat : Evasion
        As it was planned.
    others : sequence of Neighbor
        All other vehicles.

    Returns
    -------
    retreat : Evasion
        A later one while somebody is beside the ego on the own lane or close behind it, or one in front of
        whoever has fallen behind meanwhile, if there is one; else the same.
    """
    front = ego.s + ego.vehicle.front
    rear = front - ego.vehicle.length
    near = [n for n in others if _in_lane(n, road.ego_lane) and n.s - n.half_length < front + _STANDSTILL_GAP]
    if not any(n.s + n.half_length > rear - _following_gap(n.v_s, ego.v_x) for n in near):
        return retreat
    why = retreat.band.message.removeprefix(_GIVEN_UP)
    later = plan_abort(ego, road, retreat, others, why)
    if later is None:
        return plan_early_return(ego, road, retreat, others, why) or retreat
    return later if later.end > retreat.end else retreat


def vehicle_alongside(vehicle: VehicleParams, road: Road, s: float, others: Sequence[FrenetVehicle]) -> bool:
    """Tell whether somebody is beside the ego on the own lane, whom it lets pass on its way back.

    Parameters
    ----------
    vehicle : VehicleParams
        The ego.
    road : Road
        Route and lanes.
    s : float
        Where the ego is on the route [m].
    others : sequence of Neighbor
        All other vehicles.

    Returns
    -------
    beside : bool
        Whether somebody is; who is behind is not.
    """
    front = s + vehicle.front
    near = [n for n in others if _in_lane(n, road.ego_lane) and n.s - n.half_length < front + _STANDSTILL_GAP]
    return not all(_is_behind(n, front - vehicle.length) for n in near)


def return_deceleration(way: Path, s: float, v_x: float) -> float:
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
        Least constant one with which it asks for no more than 4 m/s^2 to the side anywhere [m/s^2]; negative
        where the car may become faster.
    """
    x = np.arange(1.0, 2.0 + v_x * v_x / (2.0 * _BRAKE), 1.0)
    squared = _LATERAL / np.maximum(np.abs(way.curvature(s + x)), 1e-6)
    return float(np.max((v_x * v_x - squared) / (2.0 * x)))


def _in_lane(other: FrenetVehicle, lane: Lane) -> bool:
    """Whether it is on a lane, as far as is known best: bounds would put one that is unheard on both."""
    return other.d - _half_width(other) < lane.left and other.d + _half_width(other) > lane.right


def _half_width(other: FrenetVehicle) -> float:
    """Half its width without bounds [m]."""
    return other.half_width - 2.0 * other.remote.sigma_across


def _is_behind(other: FrenetVehicle, rear: float) -> bool:
    return other.s + other.half_length - 2.0 * other.remote.sigma_along <= rear


def _following_gap(v: float, v_ahead: float) -> float:
    """Gap in which a driver behind slows down to the speed of the one in front [m]."""
    return (
        _STANDSTILL_GAP + v * _REACTION * (v > v_ahead) + max(v * v - v_ahead * v_ahead, 0.0) / (2.0 * _BRAKE)
    )
