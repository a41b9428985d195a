"""Candidate paths: the route, returns to it, and bands around vehicles, from the car's lateral state."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cca_core._checks import Array
from cca_core.band import Band, Side, relax_band
from cca_core.decide import Rejection, RejectionKind
from cca_core.errors import Status
from cca_core.frenet import FrenetVehicle
from cca_core.geometry import QUINTIC_PEAK, Boxes
from cca_core.path import Lane, Path, Road
from cca_core.path.interpolate import spline_through
from cca_core.planner.limits import Limits
from cca_core.planner.occupancy import Traffic
from cca_core.planner.records import LateralPath, Level, PathKind
from cca_core.planner.scene import TIMES
from cca_core.planner.settings import EvasionSettings
from cca_core.predict import occupancy_boxes
from cca_core.vehicle import VehicleParams

BEHIND, AHEAD = 60, 800
"""Part of the route around the ego on which paths are defined [m]."""

_MAX_NODES = 140  # of a band
_MIN_SPEED = 5.0  # below it steering limits the curvature, not the tires [m/s]
_MIN_OFFSET = 0.3  # of which the length of a return is computed at least [m]
_TIGHTEST = 0.1  # largest curvature that a return aims at [1/m]
_VEHICLE_SHARE = 0.5  # of the free space, kept to the vehicle; the rest to the edge [-]
_TIME_TO_CLEAR = 1.0  # in which a body that is beyond an edge comes back inside [s]
_EDGE_MARGIN = 0.15  # kept to an edge for the error of steering, where there is room [m]
_EDGE_TOLERANCE = 0.05  # by which the committed part of a path may be closer to an edge [m]
_JOINED = 4  # nodes of the path before and after a band with which it is interpolated
_MIN_CLEARANCE = 0.2  # of the narrowest path [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LateralState:
    """Where the ego is on its last path, or beside it."""

    base: int
    d: Array  # the last path on today's stations; where the ego is if it has lost it
    offset: float
    slope: float
    bend: float
    is_lost: bool  # the ego is not where its path is

    @property
    def on_route(self) -> bool:
        """Whether the last path is the route here."""
        return abs(self.offset) < 0.02 and abs(self.slope) < 0.003 and not self.is_lost


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Surroundings:
    """What paths are made from."""

    vehicle: VehicleParams
    road: Road
    settings: EvasionSettings
    limits: Limits
    traffic: Traffic
    lateral: LateralState
    s: float
    v: float
    awareness_range: float  # in this cycle [m]
    jerk: float  # of normal driving [m/s^3]
    free_s: Array  # the ego's motion if no vehicle limits it, at `TIMES`
    free_v: Array

    @property
    def offset(self) -> float:
        """Center of gravity to center of the body [m]."""
        return self.vehicle.box_offset


def lateral_state(
    base: int, s: float, d: float, angle: float, bend: float, last: LateralPath | None, tolerance: float
) -> LateralState:
    """Return the lateral state at a station, from the last path if the ego is on it."""
    n = BEHIND + AHEAD
    grid = np.zeros(n) if last is None else last.on(base, n)
    at = s - base
    here, ahead, behind = np.interp((at, at + 1.0, at - 1.0), np.arange(n), grid).tolist()
    slope = 0.5 * (ahead - behind)
    if abs(here - d) <= tolerance and abs(angle - math.atan(slope)) <= 0.15:
        return LateralState(
            base=base, d=grid, offset=here, slope=slope, bend=ahead - 2.0 * here + behind, is_lost=False
        )
    slope = math.tan(min(max(angle, -0.6), 0.6))
    x = np.arange(n) - at
    grid = np.where(x < 0.0, d + np.maximum(x, -10.0) * slope, d)
    return LateralState(base=base, d=grid, offset=d, slope=slope, bend=bend, is_lost=True)


def return_paths(around: Surroundings) -> list[LateralPath]:
    """Return paths back to the route: in comfort, hard, and after holding the offset for a while."""
    state, limits, v = around.lateral, around.limits, max(around.v, 2.0)
    x: Array = state.base + np.arange(float(BEHIND + AHEAD)) - around.s
    paths = []
    for level, a_y in ((Level.COMFORT, limits.a_y), (Level.HARD, limits.a_y_hard)):
        length = _length(abs(state.offset) + abs(state.slope) * v, a_y, v)
        d = _quintic(state.offset, state.slope, state.bend, 0.0, length, x)
        paths.append((level, length, d))
    road, half = around.road, 0.5 * around.vehicle.width + 0.1
    for fraction in (0.3, 0.6, 1.0):
        hold = fraction * around.settings.abort.max_hold_time
        settle = max(1.5 * v, 6.0)
        to = state.offset + 0.4 * state.slope * settle
        to = min(max(to, road.right_edge + half), road.left_edge - half)
        length, at = _length(to, limits.a_y, v), max(hold * v, settle)
        d = _quintic(state.offset, state.slope, state.bend, to, settle, x)
        d = np.where(x > at, to + _quintic(0.0, 0.0, 0.0, -to, length, x - at), d)
        paths.append((Level.COMFORT, at + length, d))
    return [
        LateralPath(
            kind=PathKind.RETURN, base=state.base, d=np.where(x < 0.0, state.d, d), begin=around.s,
            end=around.s + length, level=level,
        )
        for level, length, d in paths
    ]  # fmt: skip


def route_path(base: int) -> LateralPath:
    """Return the route as a path."""
    return LateralPath(kind=PathKind.ROUTE, base=base, d=np.zeros(BEHIND + AHEAD))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Window:
    """Where a maneuver is: alongside vehicles from `first` to `last`, off the route from `start` to `end`."""

    start: int
    end: int
    first: float
    last: float
    required: float
    clearance: float
    margin: float  # kept to the edges, if there is room [m]
    lead_distances: tuple[float, ...]
    intervals: tuple[tuple[Array, Array], ...]


def plan_path(
    around: Surroundings,
    group: Sequence[int],
    side: Side,
    lane: Lane | None,
    level: Level,
    last: LateralPath | None,
) -> LateralPath | Rejection:
    """Return a band around a group of vehicles, inside the ego lane or with an adjacent lane."""
    window = _window(around, group, side, lane, level, last)
    if isinstance(window, Rejection):
        return window
    road, state, path = around.road, around.lateral, around.road.path
    length = window.end - window.start
    spacing = max(1, math.ceil(length / _MAX_NODES))
    n = max(math.ceil(length / spacing), 8)
    begin, start = window.start, np.zeros(3)
    ongoing = last is not None or not state.on_route
    if ongoing:
        begin = max(
            begin,
            math.ceil(around.s + around.settings.replan.committed_time * around.v * (not state.is_lost)),
        )
        n = max(math.ceil((window.end - begin) / spacing), 8)
        at = np.array((begin - spacing, begin, begin + spacing)) - state.base
        start = state.d[np.clip(at, 0, len(state.d) - 1)]
        if state.is_lost:
            start = state.offset + state.slope * np.array((-spacing, 0.0, spacing))
    stations = begin + spacing * np.arange(n + 1.0)
    if stations[-1] > min(path.end, state.base + len(state.d) - 2):
        return Rejection(
            kind=RejectionKind.ROUTE_ENDS, side=side, value=float(stations[-1] - around.s),
            limit=path.end - around.s,
        )  # fmt: skip
    t = np.interp(stations, around.free_s, TIMES)
    v = np.maximum(np.interp(stations, around.free_s, around.free_v), _MIN_SPEED)
    limit = around.limits.a_y_limit if level is Level.COMFORT else around.limits.a_y_max
    obstacles, names = _obstacles(around, group, window, stations, t)
    ego_lane = road.ego_lane
    right = min(ego_lane.right, ego_lane.right if lane is None else lane.right) + window.margin
    left = max(ego_lane.left, ego_lane.left if lane is None else lane.left) - window.margin
    slack = np.where(t < _TIME_TO_CLEAR, _excess(around, right, left), 0.0) if ongoing else 0.0
    half = 0.5 * spacing
    band = relax_band(
        path.position(stations), obstacles, side=side, vehicle=around.vehicle, clearance=window.clearance,
        lead_distance=[
            *(max(lead - half, 0.0) for lead in window.lead_distances),
            *(0.0 for _ in obstacles[len(group) :]),
        ],
        corridor=(right - slack, left + slack), curvature_limit=limit / v**2, start=start,
    )  # fmt: skip
    if band.status is not Status.OK:
        return _reject(band, side, names, window)
    d = _on_grid(band, stations, spacing, state, ongoing=ongoing)
    return LateralPath(
        kind=PathKind.LEFT if side == "left" else PathKind.RIGHT, base=state.base, d=d,
        begin=float(window.start if last is None else last.begin), end=float(stations[-1]), level=level,
        overtaken=frozenset(around.traffic.ids[j] for j in group), clearance=window.clearance, band=band,
    )  # fmt: skip


def _excess(around: Surroundings, right: float, left: float) -> float:
    """Return by how much the ego's body is beyond the edges of a corridor now [m]."""
    state, vehicle = around.lateral, around.vehicle
    half = 0.5 * vehicle.width + 0.5 * vehicle.length * abs(state.slope)
    return max(state.offset + half - left, right - state.offset + half, 0.0) + _EDGE_TOLERANCE


def _on_grid(band: Band, stations: Array, spacing: int, state: LateralState, *, ongoing: bool) -> Array:
    """Return a band at stations a meter apart, with the path that it leaves and the route behind it."""
    from scipy.interpolate import CubicSpline  # slow to import

    grid = state.base + np.arange(float(len(state.d)))
    d = state.d.copy() if ongoing else np.zeros(len(grid))
    inside = (grid >= stations[0]) & (grid <= stations[-1])
    d[grid > stations[-1]] = 0.0
    if spacing == 1:
        d[inside] = band.displacement
        return d
    # nodes of both neighbors: the spline of the band alone swings at its ends
    beyond = spacing * np.arange(1.0, _JOINED + 1.0)
    before = stations[0] - beyond[::-1]
    nodes = np.concatenate((before, stations, stations[-1] + beyond))
    left = d[np.clip(before - state.base, 0, len(d) - 1).astype(int)]
    values = np.concatenate((left, band.displacement, np.zeros(_JOINED)))
    d[inside] = CubicSpline(nodes, values)(grid[inside])
    # the curvature of a band begins at once; a mean over 2 m, which moves it by a millimeter, ramps it up
    i = np.flatnonzero(inside)
    d[i] = 0.25 * (d[i - 1] + 2.0 * d[i] + d[i + 1])
    return d


def reference_of(lateral: LateralPath, road: Road, s: float) -> Path:
    """Return the path that is steered along: the route, deformed where the lateral path leaves it."""
    path = road.path
    begin = math.ceil(max(min(lateral.begin, s) - 20.0, lateral.base, path.start - 20.0))
    end = math.floor(min(lateral.end + 60.0, lateral.base + len(lateral.d) - 1))
    stations = np.arange(float(begin), float(max(end, begin + 40)))
    nodes = path.to_cartesian(stations, lateral.on(begin, len(stations)))
    _, tangent, _ = path.derivatives(stations[[0, -1]])
    first, last = ((x / math.hypot(x, y), y / math.hypot(x, y)) for x, y in tangent.tolist())
    if abs(float(lateral.on(begin, 2)[0])) > 1e-3:
        return spline_through(nodes, float(begin), None, last)
    return spline_through(nodes, float(begin), first, last)


def _window(
    around: Surroundings,
    group: Sequence[int],
    side: Side,
    lane: Lane | None,
    level: Level,
    last: LateralPath | None,
) -> _Window | Rejection:
    """Return where a maneuver must begin and end."""
    settings, limits, traffic, state = around.settings, around.limits, around.traffic, around.lateral
    narrow = level is Level.NARROW
    vehicles = [traffic.vehicles[j] for j in group]
    name, sign = vehicles[0].id, 1.0 if side == "left" else -1.0
    half = 0.5 * around.vehicle.width
    ego_lane = around.road.ego_lane
    edge = sign * (ego_lane.left if side == "left" else ego_lane.right)
    if lane is not None:
        edge = max(edge, sign * (lane.left if side == "left" else lane.right))
    outermost = max(float((sign * traffic.d[j] + traffic.half_w[j]).max()) for j in group)
    space = edge - outermost - 2.0 * half
    clearance = settings.clearance
    if narrow:
        clearance = min(
            clearance, max(_VEHICLE_SHARE * space, min(settings.last_resort.clearance, _MIN_CLEARANCE))
        )
    if space < clearance - 0.05:
        if lane is None:
            return Rejection(kind=RejectionKind.NO_LANE, side=side)
        gap = float(traffic.s[group[0], 0] - around.s)
        return Rejection(kind=RejectionKind.NO_SPACE, side=side, vehicle_id=name, distance=gap)
    ttc = settings.last_resort.min_ttc if narrow else settings.min_ttc
    spans = [_alongside(around, n, clearance, ttc) for n in vehicles]
    first, stop = min(s.first for s in spans), max(s.last for s in spans)
    if not math.isfinite(stop):
        return Rejection(kind=RejectionKind.TOO_LONG, side=side, vehicle_id=name, limit=float(AHEAD))
    offset = outermost + half + clearance
    a_y = limits.a_y if level is Level.COMFORT else limits.a_y_hard
    v_out = max(float(np.interp(first, around.free_s, around.free_v)), 1.0)
    v_back = max(float(np.interp(stop, around.free_s, around.free_v)), 1.0)
    curve = float(np.abs(around.road.path.curvature(np.linspace(around.s, stop, 12))).max())
    rest = max(a_y - curve * max(v_out, v_back) ** 2, 0.5 * a_y)
    duration = math.sqrt(QUINTIC_PEAK * max(offset, 0.5) / rest)
    required = v_out * (duration + settings.preparation_time)
    delay = max(first - required - around.s, 0.0) if state.on_route else 0.0
    speed = around.v if delay == 0.0 else v_out
    start = math.ceil(around.s + delay + speed * settings.preparation_time)
    end = math.ceil(stop + v_back * duration)
    if last is not None:
        start = math.floor(last.begin)
        end = math.ceil(last.end) if end < last.end + 2.0 else end
    return _Window(
        start=start, end=end, first=first, last=stop, required=required, clearance=clearance,
        margin=0.0 if narrow else min(_EDGE_MARGIN, 0.5 * max(space - clearance, 0.0)),
        lead_distances=tuple(s.lead for s in spans), intervals=tuple((s.rear, s.front) for s in spans),
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Span:
    """When the ego is alongside a vehicle: stations, and the vehicle's interval over time."""

    first: float
    last: float
    lead: float
    rear: Array
    front: Array


def _alongside(around: Surroundings, n: FrenetVehicle, clearance: float, ttc: float) -> _Span:
    """Return where the ego is alongside a vehicle whatever that does within its limits."""
    settings = around.settings
    steady = replace(n, remote=replace(n.remote, a_x=0.0)) if n.speed_rate > 0.0 else n
    rear, front = steady.occupied_interval(
        TIMES, braking=settings.assumed_braking, acceleration=settings.assumed_acceleration_passed
    )
    j = around.traffic.index(n.id)
    if n.v_s >= 0.0:  # what it reports is believed for a while
        front = np.maximum(front, around.traffic.s[j] + around.traffic.half_l[j])
    center = around.free_s + around.offset
    reach = 0.5 * around.vehicle.length + clearance
    ahead, behind = front - center + reach, center + reach - rear

    def ends(lead: float) -> tuple[float, float]:
        depth = np.minimum(ahead, behind + lead)
        alongside = np.flatnonzero(depth >= 0.0)
        if not len(alongside):
            return math.inf, math.inf
        i, k, s = int(alongside[0]), int(alongside[-1]), around.free_s
        first = s[i] - (s[i] - s[i - 1]) * depth[i] / (depth[i] - depth[i - 1]) if i else s[0]
        if k == len(depth) - 1:
            return float(first), math.inf
        return float(first), float(s[k] + (s[k + 1] - s[k]) * depth[k] / (depth[k] - depth[k + 1]))

    at = ends(0.0)[0]
    closing = max(float(np.interp(at, around.free_s, around.free_v)) - n.v_s, 0.0) if at < math.inf else 0.0
    lead = ttc * closing
    first, last = ends(lead)
    return _Span(first=first, last=last, lead=lead, rear=rear, front=front)


def _obstacles(
    around: Surroundings, group: Sequence[int], window: _Window, stations: Array, t: Array
) -> tuple[list[Boxes], list[str]]:
    """Return boxes of the group in its worst case and of the others near the band nominally."""
    traffic, path = around.traffic, around.road.path
    boxes, names = [], []
    for j, (rear, front) in zip(group, window.intervals, strict=True):
        d = np.interp(t, TIMES, traffic.d[j])
        boxes.append(
            occupancy_boxes(
                path, stations, np.interp(t, TIMES, rear), np.interp(t, TIMES, front), d, traffic.half_w[j]
            )
        )
        names.append(traffic.ids[j])
    lane, rear_of_ego = around.road.ego_lane, around.s + around.vehicle.rear
    for j, n in enumerate(traffic.vehicles):
        if j in group or traffic.crosses[j] or n.front < rear_of_ego or _beyond(n, lane):
            continue  # eq 11 decides about the adjacent lane
        s = np.interp(t, TIMES, traffic.s[j])
        if np.abs(s - stations).min() > traffic.half_l[j] + around.vehicle.length + 2.0:
            continue
        d = np.interp(t, TIMES, traffic.d[j])
        boxes.append(
            occupancy_boxes(
                path, stations, s - traffic.half_l[j], s + traffic.half_l[j], d, traffic.half_w[j]
            )
        )
        names.append(n.id)
    return boxes, names


def _beyond(n: FrenetVehicle, lane: Lane) -> bool:
    return n.d - n.half_width > lane.left or n.d + n.half_width < lane.right


def _reject(band: Band, side: Side, names: Sequence[str], window: _Window) -> Rejection:
    """Rejection of a band that is not OK, from the constraint that decides."""
    kinds, active = RejectionKind, band.active_obstacle
    if band.active_constraint == "curvature":
        limit = float(np.min(band.problem.curvature_limit))
        return Rejection(kind=kinds.CURVATURE, side=side, value=band.curvature, limit=limit)
    if band.active_constraint in ("left edge", "right edge"):
        return Rejection(kind=kinds.ROAD_EDGE, side=side, value=max(-band.edge_clearance, 0.0))
    return Rejection(
        kind=kinds.CLEARANCE, side=side, vehicle_id="" if active is None else names[active],
        value=band.clearance, limit=window.clearance,
    )  # fmt: skip


def _length(offset: float, a_y: float, v: float) -> float:
    """Length of a lateral offset at a lateral acceleration [m]."""
    offset = max(abs(offset), _MIN_OFFSET)
    return max(v * math.sqrt(QUINTIC_PEAK * offset / a_y), math.sqrt(QUINTIC_PEAK * offset / _TIGHTEST))


def _quintic(d: float, slope: float, bend: float, to: float, length: float, x: Array) -> Array:
    """Lateral offset from a state to another offset, straight there."""
    z = np.clip(x / length, 0.0, 1.0)
    a, b, e = slope * length, bend * length * length, to - d
    c3, c4, c5 = 10 * e - 6 * a - 1.5 * b, -15 * e + 8 * a + 1.5 * b, 6 * e - 3 * a - 0.5 * b
    shape: Array = d + z * (a + z * (0.5 * b + z * (c3 + z * (c4 + z * c5))))
    return shape
