"""Lead vehicle: the vehicle directly ahead, or a downstream one, that limits the ego's speed."""

import itertools
import math
from collections.abc import Collection, Sequence
from dataclasses import replace

from cca_core.decide import LeadVehicle
from cca_core.follow import follow_acceleration, required_deceleration
from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.planner.tuning import LeadSettings
from cca_core.vehicle import VehicleParams


def find_lead(
    blocking: Sequence[FrenetVehicle],
    ego: FrenetEgo,
    settings: LeadSettings,
    stopping_for: Collection[str] = (),
) -> LeadVehicle | None:
    """Return the vehicle that demands most of the ego: the one directly ahead, or a downstream one."""
    speed, demanding = ego.speed, None
    offset, follow = 0.0, math.inf
    for n in (b for b in blocking if b.s > ego.s_cg):
        # the vehicles in between stop behind a downstream one too: their lengths and gaps are subtracted
        downstream = offset > 0.0
        braking = n.remote.a_x < -settings.downstream_braking or "hard_braking" in n.remote.events
        if not downstream or braking or n.v_s < settings.creep_speed:
            lead = _demand(n, n.rear - ego.front - offset, downstream, blocking, ego, settings)
            follow = min(follow, lead.follow_acceleration)
            if lead.v_x == 0.0 and (downstream or n.id in stopping_for):
                lead = _with_comfort_stop(lead, ego.v_x, settings)
            if demanding is None or lead.required_deceleration > demanding.required_deceleration:
                demanding = lead
        offset += 2.0 * n.half_length + speed.standstill_gap
    if demanding is None or demanding.follow_acceleration == follow:
        return demanding
    return replace(demanding, follow_acceleration=follow)


def vehicles_to_follow(
    blocking: Sequence[FrenetVehicle], lead: LeadVehicle, ego: FrenetEgo, settings: LeadSettings
) -> list[FrenetVehicle]:
    """Return the vehicles before a downstream lead that the ego follows while it passes that one."""
    if lead.kind != "downstream":
        return []
    between = itertools.takewhile(lambda n: n.id != lead.id, blocking)
    return [n for n in between if n.v_s >= ego.v_x - settings.follow_speed_difference]


def make_lead(
    vehicle_id: str, gap: float, v: float, a_x: float, ego: FrenetEgo, settings: LeadSettings, kind: str
) -> LeadVehicle:
    """Return a lead vehicle at a gap with what it demands of the ego."""
    need = required_deceleration(ego.v_x, gap + 0.5 * ego.speed.standstill_gap, v, ego.speed, a_x)
    if ego.v_x < settings.creep_speed:  # following stops a creeping ego, however small an uncertain gap
        need = min(need, ego.v_x / settings.creep_stop_time)
    follow = follow_acceleration(ego.v_x, gap, v, ego.speed, a_x)
    return LeadVehicle(
        id=vehicle_id, gap=gap, v_x=v, required_deceleration=need, follow_acceleration=follow, kind=kind
    )


def oncoming_assumed_in_lane(
    vehicles: Sequence[FrenetVehicle],
    ego: VehicleParams,
    was_on_route: dict[str, bool],
    settings: LeadSettings,
) -> set[str]:
    """Return the stale oncoming vehicles last known outside the route, assumed to keep their lane."""
    # `was_on_route` keeps by id whether a vehicle was on the route or headed for it at its last fresh
    # message.
    known, assumed = dict(was_on_route), set()
    was_on_route.clear()
    beyond = 0.5 * ego.width + settings.blocking_gap
    for n in vehicles:
        name, is_stale, reach = n.id, n.is_stale, beyond + n.body_half_width
        later = n.d + settings.lane_entry_horizon * n.remote.v_x * math.sin(n.angle)
        on_route = min(n.d, later) < reach and max(n.d, later) > -reach
        was_on_route[name] = on_route = known.get(name, on_route) if is_stale else on_route
        # a small error of the yaw rate moves a stale vehicle over; braking would endanger following vehicles
        if is_stale and not on_route and n.v_s < -settings.creep_speed:
            assumed.add(name)
    return assumed


def _demand(
    n: FrenetVehicle,
    gap: float,
    downstream: bool,
    blocking: Sequence[FrenetVehicle],
    ego: FrenetEgo,
    settings: LeadSettings,
) -> LeadVehicle:
    """Return the vehicle as lead vehicle at a gap."""
    v = 0.0 if abs(n.v_lower) < settings.creep_speed else n.v_lower
    lead = make_lead(n.id, gap, v, n.remote.a_x, ego, settings, "downstream" if downstream else "direct")
    if abs(n.d) - n.body_half_width > 0.5 * ego.vehicle.width + settings.blocking_gap:
        lead = _soften_for_uncertain_lead(lead, ego, settings)
    if not (downstream and v > 0.0):
        return lead
    if lead.required_deceleration > settings.brake_now_deceleration:
        # the vehicles in between will brake too: following is too late
        follow = min(lead.follow_acceleration, -lead.required_deceleration)
        lead = replace(lead, follow_acceleration=follow)
    if "hard_braking" in n.remote.events:
        lead = _relay_hard_braking(lead, blocking, n, ego, settings)
    return lead


def _relay_hard_braking(
    lead: LeadVehicle,
    blocking: Sequence[FrenetVehicle],
    downstream: FrenetVehicle,
    ego: FrenetEgo,
    settings: LeadSettings,
) -> LeadVehicle:
    """Assume that the vehicle directly ahead brakes fully if a downstream one reports hard braking."""
    direct = next(b for b in blocking if b.s > ego.s_cg)
    if direct.v_lower <= 0.0:
        return lead
    # a driver that reacts late brakes harder
    a_x = min(direct.remote.a_x, downstream.remote.a_x, -ego.speed.b_max)
    braking = make_lead(direct.id, direct.rear - ego.front, direct.v_lower, a_x, ego, settings, "downstream")
    if braking.required_deceleration <= lead.required_deceleration:
        return lead
    follow = min(lead.follow_acceleration, -braking.required_deceleration)
    return replace(braking, follow_acceleration=follow)


def _soften_for_uncertain_lead(lead: LeadVehicle, ego: FrenetEgo, settings: LeadSettings) -> LeadVehicle:
    """Fall back from a vehicle that only its uncertainty bound puts on the route, without hard braking."""
    gentle = max(max(lead.v_x - settings.fall_back_speed, 0.0) - ego.v_x, -ego.speed.b_comfort)
    return replace(
        lead, required_deceleration=min(lead.required_deceleration, ego.speed.b_comfort),
        follow_acceleration=max(lead.follow_acceleration, gentle),
    )  # fmt: skip


def _with_comfort_stop(lead: LeadVehicle, v_x: float, settings: LeadSettings) -> LeadVehicle:
    """Add the deceleration of a stop behind a vehicle that is the stop horizon away."""
    time = settings.stop_horizon - settings.stop_delay
    v = max(v_x, 2.0 * settings.stop_margin / time)  # at which the need is least; slower it is not more
    deceleration = v * v / (2.0 * (time * v - settings.stop_margin))
    return replace(lead, comfort_stop_deceleration=deceleration)
