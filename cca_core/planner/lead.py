"""Lead vehicle: the vehicle ahead, or a downstream one, that limits the ego's speed."""

import itertools
import math
from collections.abc import Collection, Sequence
from dataclasses import replace

from cca_core.decide import LeadVehicle
from cca_core.follow import SpeedSettings, follow_acceleration, required_deceleration
from cca_core.planner.frenet import FrenetEgo, FrenetVehicle
from cca_core.vehicle import STALE_AGE, VehicleParams

__all__ = ["BLOCKING_GAP", "find_lead", "make_lead", "oncoming_assumed_in_lane", "vehicles_to_follow"]

BLOCKING_GAP = 0.3
"""Lateral gap to the route below which a vehicle blocks it [m]."""

_STANDS = 1.0  # slower than this a vehicle stands; messages err by 0.2 [m/s]
_LANE_ENTRY_HORIZON = 2.0  # for which it is taken to go on across the route as it heads [s]
_CREEP_STOP_TIME = 0.5  # time in which a creeping car comes to rest [s]
_BRAKES = -2.0  # acceleration below which a hidden vehicle is braked for [m/s^2]
_BRAKE_NOW_DECELERATION = (
    1.0  # needed deceleration from which on a hidden braking vehicle is braked for [m/s^2]
)
_FOLLOW_SPEED_DIFFERENCE = (
    2.0  # slower than the ego by less than this, a vehicle is not passed but followed [m/s]
)
_FALLS_BACK = 2.0  # how much slower the ego gets than one that may be in its lane [m/s]
_HORIZON, _DELAY, _SPARE = 5.0, 0.3, 5.0  # of a stop behind a hidden vehicle [s], [s], [m]


def find_lead(
    blocking: Sequence[FrenetVehicle], s: float, v_x: float, vehicle: VehicleParams, speed: SpeedSettings,
    stopping_for: Collection[str] = (),
) -> LeadVehicle | None:  # fmt: skip
    """Find the vehicle on the route that demands most of the ego.

    Parameters
    ----------
    blocking : sequence of Neighbor
        Vehicles in the way, nearest first.
    s : float
        Path coordinate of the ego's center of gravity [m].
    v_x : float
        Its speed [m/s].
    vehicle : VehicleParams
        The ego.
    speed : SpeedSettings
        Gaps and limits.
    stopping_for : collection of str
        Standing vehicles behind which the ego is stopping already.

    Returns
    -------
    leader : Leader or None
        The next one in front, or one hidden before it that stands or brakes: everybody between must stop
        behind that one too, so their lengths and standstill gaps are taken off its distance.
    """
    front = s + vehicle.front
    demanding: LeadVehicle | None = None
    between, follow = 0.0, math.inf
    for n in (b for b in blocking if b.s > s):
        gap = n.s - n.half_length - front - between
        hidden = between > 0.0
        alarming = n.v_s < _STANDS or n.remote.a_x < _BRAKES or "hard_braking" in n.remote.events
        if not hidden or alarming:
            kind = "downstream" if hidden else "direct"
            v = 0.0 if abs(n.v_lower) < _STANDS else n.v_lower
            leader = make_lead(n.remote.id, gap, v, n.remote.a_x, v_x, speed, kind)
            body = n.half_width - 2.0 * n.remote.sigma_across
            if abs(n.d) - body > 0.5 * vehicle.width + BLOCKING_GAP:
                leader = _soften_for_uncertain_lead(leader, v_x, speed)
            if hidden and v > 0.0 and leader.required_deceleration > _BRAKE_NOW_DECELERATION:
                # those between will brake too, so that following is too late
                leader = replace(
                    leader,
                    follow_acceleration=min(leader.follow_acceleration, -leader.required_deceleration),
                )
            if hidden and v > 0.0 and "hard_braking" in n.remote.events:
                leader = _relay_hard_braking(leader, blocking, n, front, s, v_x, speed)
            follow = min(follow, leader.follow_acceleration)
            stands = v == 0.0 and (hidden or n.remote.id in stopping_for)
            if stands:
                leader = _with_comfort_stop(leader, v_x)
            if demanding is None or leader.required_deceleration > demanding.required_deceleration:
                demanding = leader
        between += 2.0 * n.half_length + speed.standstill_gap
    if demanding is None or demanding.follow_acceleration == follow:
        return demanding
    return replace(demanding, follow_acceleration=follow)


def vehicles_to_follow(
    blockers: Sequence[FrenetVehicle], leader: LeadVehicle, ego: FrenetEgo
) -> list[FrenetVehicle]:
    """Find who need not be passed on the way around a hidden vehicle.

    Parameters
    ----------
    blockers : sequence of Neighbor
        Vehicles in front on the route, nearest first.
    leader : Leader
        What is to be passed.
    ego : Ego
        The ego.

    Returns
    -------
    kept : list of Neighbor
        Those before the hidden vehicle that are about as fast as the ego, which goes on following them.
    """
    if leader.kind != "downstream":
        return []
    between = itertools.takewhile(lambda n: n.remote.id != leader.id, blockers)
    return [n for n in between if n.v_s >= ego.v_x - _FOLLOW_SPEED_DIFFERENCE]


def make_lead(
    name: str, gap: float, v: float, a_x: float, v_x: float, speed: SpeedSettings, kind: str
) -> LeadVehicle:
    """Describe a lead vehicle at a gap by what it demands of the ego."""
    need = required_deceleration(v_x, gap + 0.5 * speed.standstill_gap, v, speed, a_x)
    if v_x < _STANDS:  # following stops a creeping car softly, however small an uncertain gap seems
        need = min(need, v_x / _CREEP_STOP_TIME)
    follow = follow_acceleration(v_x, gap, v, speed, a_x)
    return LeadVehicle(
        id=name, gap=gap, v_x=v, required_deceleration=need, follow_acceleration=follow, kind=kind
    )


def _relay_hard_braking(
    leader: LeadVehicle, blockers: Sequence[FrenetVehicle], hidden: FrenetVehicle, front: float, s: float, v_x: float,
    speed: SpeedSettings,
) -> LeadVehicle:  # fmt: skip
    """Take the next one in front to brake as hard as it can when a hidden one says that it brakes hard."""
    near = next(b for b in blockers if b.s > s)
    if near.v_lower <= 0.0:
        return leader
    gap = near.s - near.half_length - front
    a_x = min(near.remote.a_x, hidden.remote.a_x, -speed.b_max)  # whoever reacts late brakes harder
    brakes = make_lead(near.remote.id, gap, near.v_lower, a_x, v_x, speed, "downstream")
    if brakes.required_deceleration <= leader.required_deceleration:
        return leader
    follow = min(leader.follow_acceleration, -brakes.required_deceleration)
    return replace(brakes, follow_acceleration=follow)


def oncoming_assumed_in_lane(
    neighbors: Sequence[FrenetVehicle], vehicle: VehicleParams, was_on_route: dict[str, bool]
) -> set[str]:
    """Find those that come toward the ego beside its route, wherever they may be since they were heard.

    Parameters
    ----------
    neighbors : sequence of Neighbor
        All vehicles.
    vehicle : VehicleParams
        The ego.
    was_on_route : dict
        Whether each vehicle was on the route, without its bounds, or headed for it within 2 s, when it was
        last known well, by id; kept up to date here.

    Returns
    -------
    beside : set of str
        Ids of those that have not been heard for more than 1 s and were neither on the route nor headed for
        it by then. They are taken to keep to their lanes: a yaw rate that is a little off moves them over,
        and braking would endanger those behind.
    """
    known, beside = dict(was_on_route), set()
    was_on_route.clear()
    for n in neighbors:
        name, fresh = n.remote.id, n.remote.age <= STALE_AGE
        reach = 0.5 * vehicle.width + BLOCKING_GAP + n.half_width - 2.0 * n.remote.sigma_across
        then = n.d + _LANE_ENTRY_HORIZON * n.remote.v_x * math.sin(n.angle)
        on_route = min(n.d, then) < reach and max(n.d, then) > -reach
        was_on_route[name] = on_route if fresh else known.get(name, on_route)
        if not (fresh or was_on_route[name]) and n.v_s < -_STANDS:
            beside.add(name)
    return beside


def _soften_for_uncertain_lead(leader: LeadVehicle, v_x: float, speed: SpeedSettings) -> LeadVehicle:
    """Fall back behind a vehicle that may be in the way; hard braking would endanger those behind."""
    gentle = max(max(leader.v_x - _FALLS_BACK, 0.0) - v_x, -speed.b_comfort)
    return replace(
        leader,
        required_deceleration=min(leader.required_deceleration, speed.b_comfort),
        follow_acceleration=max(leader.follow_acceleration, gentle),
    )


def _with_comfort_stop(leader: LeadVehicle, v_x: float) -> LeadVehicle:
    """Say how hard the ego must brake to stand behind a vehicle when it is a horizon away."""
    v = max(v_x, 2.0 * _SPARE / (_HORIZON - _DELAY))  # where the need is least; slower it asks for no more
    return replace(leader, comfort_stop_deceleration=v * v / (2.0 * ((_HORIZON - _DELAY) * v - _SPARE)))
