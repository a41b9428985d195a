"""Occupancy: where other vehicles are over time, nominally and in the worst case."""

import math
from dataclasses import dataclass
from itertools import pairwise

from cca_core._checks import Array, Mask
from cca_core.frenet import CROSSING_SINE, FrenetVehicle
from cca_core.kernel.memory import Lent
from cca_core.kernel.scene import Scene
from cca_core.path import Lane, Road
from cca_core.planner.records import Observation
from cca_core.planner.scene import Scenes, locate, set_numbers
from cca_core.planner.settings import EvasionSettings
from cca_core.planner.stretch import highest_speed, road_numbers
from cca_core.vehicle import STANDSTILL_SPEED

N_STOPS = 6
"""Crossing vehicles that the ego can yield to at once."""

_BEHIND, _AHEAD = 200.0, 700.0  # part of the route around the ego in which vehicles are relevant [m]
_HARD_BRAKING = 4.0  # least deceleration of a vehicle that reports hard braking [m/s^2]
_MAX_VEHICLES = 600
_NEXT = 0.5  # distance of lanes that are next to each other [m]
_NARROW, _SLOW = 1.2, 10.0  # width [m] and speed [m/s] of pedestrians and cyclists
_MAX_DRIFT = 5.0  # of an offset that is dead-reckoned; more is another branch of the route [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Traffic:
    """The other vehicles of a decision in the order of the scene, with their nominal motion."""

    scene: Lent[Scene]
    vehicles: tuple[FrenetVehicle, ...]
    ids: tuple[str, ...]
    crosses: Mask
    s: Array  # stations (m, steps), absolute
    v: Array
    d: Array
    half_l: Array  # (m,)
    half_w: Array

    def index(self, vehicle_id: str) -> int:
        """Return the row of a vehicle, -1 if it is not there."""
        return self.ids.index(vehicle_id) if vehicle_id in self.ids else -1


def relevant_vehicles(observation: Observation, settings: EvasionSettings) -> list[FrenetVehicle]:
    """Return the vehicles near the ego's part of the route."""
    near = []
    for n in (vehicle.since_measurement() for vehicle in observation.vehicles):
        if is_crossing(n):
            if abs(n.d) <= settings.crossing.range and abs(n.s - observation.s) < settings.crossing.range:
                near.append(n)
        elif n.front > observation.s - _BEHIND and n.rear < observation.s + _AHEAD:
            near.append(n)
    return near


def is_crossing(n: FrenetVehicle) -> bool:
    """Return whether a vehicle moves across the route."""
    return abs(math.sin(n.angle)) > CROSSING_SINE and abs(n.remote.v_x) > STANDSTILL_SPEED


def predict_vehicles(
    scenes: Scenes, observation: Observation, road: Road, settings: EvasionSettings, base: int
) -> Traffic:
    """Predict the vehicles and put them into a scene."""
    vehicles = relevant_vehicles(observation, settings)[:_MAX_VEHICLES]
    seen = [_columns(n, observation, road, settings, base) for n in vehicles]
    n = len(seen)
    seen += _assumed_vehicles(observation, road, settings, base)
    scene = scenes.for_vehicles(len(seen))
    rows = scene.arrays
    if seen:
        rows["seen"][: len(seen)] = seen
    set_numbers(scene, **road_numbers(road, observation.s))
    locate(scene.workspace, n)
    ids, crosses = tuple([n.id for n in vehicles]), rows["crosses"][:n] != 0
    return Traffic(
        scene=scene, vehicles=tuple(vehicles), ids=ids, crosses=crosses, s=rows["s_o"][:n] + base,
        v=rows["v_o"][:n], d=rows["d_o"][:n], half_l=rows["half_l"][:n], half_w=rows["half_w"][:n],
    )  # fmt: skip


def reported_rate(n: FrenetVehicle) -> float:
    """Return the change of speed that a vehicle reports, by its acceleration or an event [m/s^2]."""
    return min(n.speed_rate, -_HARD_BRAKING) if "hard_braking" in n.remote.events else n.speed_rate


def _columns(
    n: FrenetVehicle, observation: Observation, road: Road, settings: EvasionSettings, base: int
) -> tuple[float, ...]:
    """Return what the kernel sees of a vehicle, in the order of its columns."""
    remote, rate = n.remote, n.speed_rate
    crosses = is_crossing(n)
    nominal = n.nominal() if n.is_stale else n
    half_l, half_w = _half_body(nominal) if crosses else (nominal.half_length, nominal.half_width)
    d, side_speed, side_range, leaves = _lateral_motion(n, observation, road, settings)
    if not (leaves or crosses):
        inward, excess = _excess(n, half_w, road)
        d, half_w = d - 0.5 * inward * excess, half_w - 0.5 * excess
    aside = 0.0 if leaves or crosses else _distance_home(n, road)
    if aside:  # it may return before or after they meet
        d, half_w = d + 0.5 * aside, half_w + 0.5 * abs(aside)
        side_speed, side_range = math.copysign(settings.certificate.return_speed, aside), abs(aside)
    return (
        n.s - base, n.d, n.v_s, n.half_length, n.half_width, half_l, half_w,
        rate, reported_rate(n), remote.age, math.cos(n.angle), side_speed, side_range, crosses,
        remote.x, remote.y, remote.psi, remote.v_x, remote.a_x, remote.r, *_half_body(n),
        0.125 * remote.length**2, n.added_width,
        0.5 * remote.width - 2.0 * remote.sigma_across,  # a corner in a lane does not make it drive there
        d, leaves,
    )  # fmt: skip


def _half_body(n: FrenetVehicle) -> tuple[float, float]:
    """Return half length and half width of a body with its uncertainty bound [m]."""
    remote = n.remote
    return 0.5 * remote.length + 2.0 * remote.sigma_along, 0.5 * remote.width + 2.0 * remote.sigma_across


def _lateral_motion(
    n: FrenetVehicle, observation: Observation, road: Road, settings: EvasionSettings
) -> tuple[float, float, float, bool]:
    """Return nominal offset, lateral speed and range, and whether it is expected to move so far.

    A vehicle with lateral speed may move up to the middle of another lane. It is expected to do so once it
    has left the middle of its own, and to follow the road since it was measured.
    """
    certificate, known = settings.certificate, observation.memory.known.get(n.id)
    d, angle, before = n.d, n.angle, n.angle
    if known is not None and abs(known.d - n.d) < _MAX_DRIFT:
        d, angle, before = known.d, known.angle, known.before  # as measured, not as dead-reckoned since
    v_d = n.remote.v_x * math.sin(angle)
    turned = abs(math.sin(angle)) >= certificate.side_angle and abs(n.remote.v_x) > STANDSTILL_SPEED
    if abs(v_d) < certificate.side_speed and not turned:
        return d, 0.0, 0.0, False
    side = math.copysign(1.0, v_d)
    lanes = _lanes_at(road, n.s)
    # the center of the body may be so far from that of what it covers, which is compared
    ahead = [x + n.added_width for lane in lanes if (x := (lane.d - n.d) * side) > 0.2 + n.added_width]
    reach = min(ahead) if ahead else 1.5 * abs(v_d)
    beyond = [(d - lane.d) * side for lane in lanes if abs(d - lane.d) <= 0.5 * lane.width]
    # the error of one heading is no lateral motion
    steady = min(math.copysign(1.0, n.remote.v_x) * side * math.sin(each) for each in (angle, before))
    moves = turned or steady > certificate.heading_error
    keeps = not moves or (not turned and bool(beyond) and min(beyond) < certificate.side_offset)
    return (d if keeps else n.d), v_d, reach, not keeps


def _excess(n: FrenetVehicle, half_w: float, road: Road) -> tuple[float, float]:
    """Return the side of the ego lane, left positive, and how far a bound exceeds the other lane [m].

    A vehicle that drives along another lane keeps to it, as far as its reported body does.
    """
    lane = next((lane for lane in _lanes_at(road, n.s) if lane.right <= n.d <= lane.left), road.ego_lane)
    inward = math.copysign(1.0, road.ego_lane.d - lane.d)
    if lane is road.ego_lane or abs(n.v_s) <= STANDSTILL_SPEED or lane.direction * n.v_s < 0.0:
        return inward, 0.0
    d, boundary = inward * n.d, inward * (lane.left if inward > 0.0 else lane.right)
    return inward, max(d + half_w - max(boundary, d + n.body_half_width), 0.0)


def _distance_home(n: FrenetVehicle, road: Road) -> float:
    """Return how far left an oncoming vehicle in the middle of a wrong lane has to its own [m]; else 0.

    Pedestrians and cyclists do not overtake, and no vehicle returns across a median.
    """
    lanes = sorted(_lanes_at(road, n.s), key=lambda lane: lane.d)
    here = next((lane for lane in lanes if abs(n.d - lane.d) <= n.half_width), None)
    home = min((x for x in lanes if x.direction < 0), key=lambda x: abs(x.d - n.d), default=None)
    if n.v_s > -STANDSTILL_SPEED or here is None or here.direction < 0 or home is None:
        return 0.0
    low, high = sorted((here.d, home.d))
    between = [lane for lane in lanes if low <= lane.d <= high]
    is_divided = any(b.right - a.left > _NEXT for a, b in pairwise(between))
    walks_or_cycles = n.remote.width < _NARROW and abs(n.v_s) < _SLOW
    return 0.0 if is_divided or walks_or_cycles else home.d - n.d


def _lanes_at(road: Road, s: float) -> list[Lane]:
    return [lane for lane in road.lanes if lane.start <= s <= lane.end]


def _assumed_vehicles(
    observation: Observation, road: Road, settings: EvasionSettings, base: int
) -> list[tuple[float, ...]]:
    """Return columns of the vehicles assumed at the end of the awareness range, one in each other lane."""
    known = min(observation.awareness_range, settings.awareness_range)
    if not 0.0 < known < math.inf:
        return []
    at, size = observation.s - base, (0.0, 0.0, 1.0, 1.0)
    fastest = highest_speed(road, observation.s, known)
    return [
        (at - lane.direction * known, lane.d, lane.direction * fastest, *size, *[0.0] * 20)
        for lane in road.lanes if lane is not road.ego_lane
        and lane.start < observation.s + known and lane.end > observation.s - known
    ]  # fmt: skip
