"""Occupancy: where other vehicles are over time, nominally and in the worst case."""

import math
from dataclasses import dataclass, replace

import numpy as np

from cca_core._checks import Array, Index
from cca_core.frenet import CROSSING_SINE, FrenetVehicle
from cca_core.kernel.memory import Lent
from cca_core.kernel.scene import Scene
from cca_core.path import Lane, Road
from cca_core.planner.records import Observation
from cca_core.planner.scene import TIMES, Scenes
from cca_core.planner.settings import EvasionSettings
from cca_core.predict import predict_ctra, reachable_interval
from cca_core.vehicle import STANDSTILL_SPEED

N_STOPS = 6
"""Crossing vehicles that the ego can yield to at once."""

_BEHIND, _AHEAD = 200.0, 700.0  # part of the route around the ego in which vehicles are relevant [m]
_NO_ACCELERATION = 0.5  # a smaller reported acceleration is noise [m/s^2]
_HARD_BRAKING = 4.0  # least deceleration of a vehicle that reports hard braking [m/s^2]
_MAX_VEHICLES = 600
_GONE = 1e6  # station of a vehicle that is nominally not there [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Traffic:
    """The other vehicles of a decision, in the order of the scene; assumed ones have no record."""

    vehicles: tuple[FrenetVehicle, ...]
    ids: tuple[str, ...]
    crosses: Array  # bool
    s: Array  # nominal stations (m, steps), absolute
    v: Array
    d: Array
    half_l: Array  # (m,)
    half_w: Array
    low: Array  # worst case (m, steps), absolute
    high: Array

    def index(self, vehicle_id: str) -> int:
        """Return the row of a vehicle, -1 if it is not there."""
        return self.ids.index(vehicle_id) if vehicle_id in self.ids else -1


def relevant_vehicles(observation: Observation, settings: EvasionSettings) -> list[FrenetVehicle]:
    """Return the vehicles near the ego's part of the route."""
    near = []
    for n in observation.vehicles:
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
) -> tuple[Lent[Scene], Traffic]:
    """Predict the vehicles and put them into a scene."""
    vehicles = relevant_vehicles(observation, settings)[:_MAX_VEHICLES]
    phantoms = _assumed_vehicles(observation, road, settings)
    n_real, m = len(vehicles), len(vehicles) + len(phantoms)
    scene = scenes.for_vehicles(m)
    rows = scene.arrays
    steps = len(TIMES)
    s, v, d = np.full((m, steps), _GONE), np.zeros((m, steps)), np.zeros((m, steps))
    right, left = np.zeros((2, m, steps))
    reach = np.full((2, 2, m, steps), _GONE)  # of vehicles that are not overtaken, and that are
    half_l, half_w = np.ones(m), np.ones(m)
    crosses, stands, adjacent, assumed = np.zeros((4, m), dtype=np.intp)
    lane = road.ego_lane
    for j, n in enumerate(vehicles):
        nominal = n.nominal() if n.is_stale else n
        half_l[j], half_w[j] = nominal.half_length, nominal.half_width
        crosses[j] = is_crossing(n)
        if crosses[j]:
            _predict_crossing(rows, j, n, settings)
            half_l[j], half_w[j] = (
                0.5 * n.remote.length + 2.0 * nominal.remote.sigma_along,
                0.5 * n.remote.width + 2.0 * nominal.remote.sigma_across,
            )
            s[j], v[j], d[j] = n.s, abs(n.remote.v_x), n.d
            continue
        distance, speed = _travel(nominal, settings, road.speed_limit)
        sign = math.copysign(1.0, n.v_s)
        s[j], v[j] = n.s + sign * distance, sign * speed
        d[j] = n.d + _lateral_motion(n, road, settings)
        for side, a in ((0, settings.assumed_acceleration), (1, settings.assumed_acceleration_passed)):
            reported = _without_acceleration(n) if side else n
            lowest, highest = _reach(reported, settings, road.speed_limit, a)
            if side and sign > 0.0:  # a reported acceleration is believed for a while
                highest = np.maximum(highest, distance)
            reach[side, 0, j], reach[side, 1, j] = lowest + n.rear, highest + n.front
        across = d[j] - d[j, 0]
        right[j] = n.d - n.half_width + np.minimum(across, 0.0)
        left[j] = n.d + n.half_width + np.maximum(across, 0.0)
        adjacent[j] = (n.d + n.half_width > lane.left + settings.lane_entry_tolerance) + 2 * (
            n.d - n.half_width < lane.right - settings.lane_entry_tolerance
        )
    for j, (station, velocity, other) in enumerate(phantoms, start=n_real):
        reach[:, :, j] = station + velocity * TIMES
        right[j], left[j] = other.d - 0.9, other.d + 0.9
        adjacent[j], assumed[j] = 1 if other.d > 0.0 else 2, 1
    passing_distance = np.array(
        [_distance_to_pass(j, vehicles, road, settings) if j < n_real else 0.0 for j in range(m)]
    )
    follow = _in_order(s, d, v, half_l, half_w, crosses)
    v_follow = np.gradient(follow, TIMES, axis=1) if m else v
    oncoming = v[:, 0] < 0.0
    s[oncoming], v[oncoming, 1:] = follow[oncoming], v_follow[oncoming, 1:]  # they keep their order
    stands[:] = np.abs(v_follow[:, -1]) < STANDSTILL_SPEED
    for name, values in (
        ("s_o", s - base), ("v_o", v), ("d_o", d), ("s_follow", follow - base), ("v_follow", v_follow),
        ("half_l", half_l), ("half_w", half_w), ("low", reach[0, 0] - base), ("high", reach[0, 1] - base),
        ("low_passed", reach[1, 0] - base), ("high_passed", reach[1, 1] - base),
        ("right", right), ("left", left),
        ("crosses", crosses), ("passing_distance", passing_distance),
        ("stands", stands), ("adjacent", adjacent),
        ("assumed", assumed),
    ):  # fmt: skip
        if m:
            rows[name][:m] = values
    traffic = Traffic(
        vehicles=tuple(vehicles), ids=tuple(n.id for n in vehicles), crosses=crosses.astype(bool), s=s, v=v,
        d=d, half_l=half_l, half_w=half_w, low=reach[0, 0], high=reach[0, 1],
    )  # fmt: skip
    return scene, traffic


def _travel(n: FrenetVehicle, settings: EvasionSettings, limit: float) -> tuple[Array, Array]:
    """Nominal distance and speed along the route, without sign; reports are believed for a bounded time."""
    v, a = abs(n.v_s), n.speed_rate
    if "hard_braking" in n.remote.events:
        a = min(a, -_HARD_BRAKING)
    if abs(a) < _NO_ACCELERATION or (
        settings.assumed_braking == settings.assumed_acceleration == 0.0 and a > 0.0
    ):
        return v * TIMES, np.full(len(TIMES), v)
    certificate = settings.certificate
    if a < 0.0:
        until = min(certificate.braking_time, v / -a)
    else:
        until = min(certificate.acceleration_time, max(limit - v, 0.0) / a)
    changing = np.minimum(TIMES, until)
    speed = v + a * changing
    return v * changing + 0.5 * a * changing**2 + speed * (TIMES - changing), np.maximum(speed, 0.0)


def _lateral_motion(n: FrenetVehicle, road: Road, settings: EvasionSettings) -> Array:
    """Nominal lateral motion: a vehicle that moves sideways does so up to the middle of the next lane."""
    v_d, certificate = n.remote.v_x * math.sin(n.angle), settings.certificate
    turned = abs(math.sin(n.angle)) >= certificate.side_angle and abs(n.remote.v_x) > STANDSTILL_SPEED
    if abs(v_d) < certificate.side_speed and not turned:
        return np.zeros(len(TIMES))
    side = math.copysign(1.0, v_d)
    ahead = [(lane.d - n.d) * side for lane in road.lanes if (lane.d - n.d) * side > 0.2]
    distance = min(ahead) if ahead else 1.5 * abs(v_d)
    return side * np.minimum(abs(v_d) * TIMES, distance)


def _reach(
    n: FrenetVehicle, settings: EvasionSettings, limit: float, acceleration: float
) -> tuple[Array, Array]:
    """Worst-case displacements along the route, least and largest."""
    braking = settings.assumed_braking
    v, a_s = n.v_s, n.speed_rate
    if settings.keeps_motion:
        distance, _ = _travel(n, settings, limit)
        low = high = math.copysign(1.0, v) * distance
        return low, high
    low, high = reachable_interval(
        v,
        TIMES,
        braking=max(braking, -a_s),
        acceleration=max(acceleration, a_s),
        age=n.remote.age,
        a_reported=a_s,
    )
    farthest = max(limit, abs(v) + 0.5) * np.diff(TIMES)
    high = high[0] + np.concatenate(([0.0], np.cumsum(np.minimum(np.diff(high), farthest))))
    low = low[0] + np.concatenate(([0.0], np.cumsum(np.maximum(np.diff(low), -farthest))))
    if abs(v) < STANDSTILL_SPEED:  # what stands does not reverse
        if math.cos(n.angle) > 0.0:
            low = np.maximum(low, low[0])
        else:
            high = np.minimum(high, high[0])
    return low, high


def _predict_crossing(rows: dict[str, Array], j: int, n: FrenetVehicle, settings: EvasionSettings) -> None:
    """Nominal and worst-case motion of a vehicle in the plane."""
    remote = n.remote
    reported_remote = replace(remote, a_x=0.0) if remote.a_x * remote.v_x > -_NO_ACCELERATION else remote
    x, y, psi = predict_ctra(reported_remote, TIMES)
    for name, values in (("x_o", x), ("y_o", y), ("psi_o", psi)):
        rows[name][j] = values
    crossing, pet = settings.crossing, settings.crossing.min_pet
    v, sign = abs(remote.v_x), math.copysign(1.0, remote.v_x)
    free = settings.assumed_braking == settings.assumed_acceleration == 0.0
    bounds = {
        "braking": 0.0 if free else crossing.assumed_braking,
        "acceleration": 0.0 if free else crossing.assumed_acceleration, "age": remote.age,
    }  # fmt: skip
    low, _ = reachable_interval(v, np.maximum(TIMES - pet, 0.0), **bounds)
    _, high = reachable_interval(v, TIMES + pet, **bounds)
    middle = 0.5 * (low + high)
    kappa = remote.r / remote.v_x if abs(remote.v_x) > STANDSTILL_SPEED else 0.0
    turn = np.clip(kappa * middle * sign, -0.5 * math.pi, 0.5 * math.pi)
    half = 0.5 * turn
    chord = sign * middle * np.sinc(half / math.pi)
    rows["x_w"][j] = remote.x + chord * np.cos(remote.psi + half)
    rows["y_w"][j] = remote.y + chord * np.sin(remote.psi + half)
    rows["psi_w"][j] = remote.psi + turn
    reach = 0.5 * (high - low)
    rows["half_l_w"][j] = 0.5 * remote.length + 2.0 * remote.sigma_along + reach
    rows["half_w_w"][j] = (
        0.5 * remote.width + 2.0 * remote.sigma_across + np.minimum(0.25 * abs(kappa) * reach * reach, reach)
    )


def _assumed_vehicles(
    observation: Observation, road: Road, settings: EvasionSettings
) -> list[tuple[float, float, Lane]]:
    """Vehicles assumed at the end of the awareness range: station, speed and lane of each."""
    known = min(observation.awareness_range, settings.awareness_range)
    if not 0.0 < known < math.inf:
        return []
    return [
        (observation.s + known, -road.speed_limit, lane) if lane.direction < 0
        else (observation.s - known, road.speed_limit, lane)
        for lane in road.lanes if lane is not road.ego_lane
    ]  # fmt: skip


def _without_acceleration(n: FrenetVehicle) -> FrenetVehicle:
    """Return a vehicle as if it kept its speed, unless it brakes."""
    return replace(n, remote=replace(n.remote, a_x=0.0)) if n.speed_rate > 0.0 else n


def _distance_to_pass(j: int, vehicles: list[FrenetVehicle], road: Road, settings: EvasionSettings) -> float:
    """Distance kept behind a single stationary vehicle beside which a lane is free, to pass it later [m]."""
    n, lane = vehicles[j], road.ego_lane
    if abs(n.v_s) > STANDSTILL_SPEED or is_crossing(n) or not _is_in(n, lane):
        return 0.0
    near = [o for o in vehicles if o is not n and o.rear < n.front + settings.lead.queue_gap]
    if any(o.rear > n.front and abs(o.d - n.d) < 1.5 for o in near):
        return 0.0  # a queue drives on
    alongside = [o for o in near if o.front > n.rear and abs(o.v_s) <= STANDSTILL_SPEED]
    can_pass = any(not any(_is_in(o, other) for o in alongside) for other in road.lanes if other is not lane)
    return settings.lead.passing_distance if can_pass else 0.0


def _is_in(n: FrenetVehicle, lane: Lane) -> bool:
    """Return whether a body is at least in part in a lane."""
    return n.d - n.half_width <= lane.left and n.d + n.half_width >= lane.right


def _in_order(s: Array, d: Array, v: Array, half_l: Array, half_w: Array, crosses: Index) -> Array:
    """Stations where vehicles of one lane and direction stay behind each other, a meter apart."""
    follow = s.copy()
    for sign in (1.0, -1.0):
        rows = [
            j
            for j in np.argsort(-sign * s[:, 0])
            if not crosses[j] and sign * v[j, 0] > -STANDSTILL_SPEED and s[j, 0] < 0.5 * _GONE
        ]
        for i, j in enumerate(rows):
            for k in rows[:i]:
                space = half_l[j] + half_l[k]
                apart = np.abs(d[j] - d[k]) >= half_w[j] + half_w[k] - 0.2
                if sign * (s[k, 0] - s[j, 0]) > space and not apart[0]:
                    behind = np.where(apart, np.inf, sign * follow[k] - space - 1.0)
                    moved = np.maximum(np.minimum(sign * follow[j], behind), sign * s[j, 0])
                    follow[j] = sign * np.maximum.accumulate(moved)
    return follow
