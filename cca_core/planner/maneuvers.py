"""Maneuvers: bands around a group of vehicles, inside the ego lane or with an adjacent lane."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cca_core._checks import Array
from cca_core.band import Band, BandStiffness, Side, relax_band
from cca_core.decide import Rejection, RejectionKind
from cca_core.errors import Status
from cca_core.geometry import QUINTIC_PEAK, Boxes
from cca_core.path import Lane
from cca_core.planner.paths import LateralState, Surroundings
from cca_core.planner.records import LateralPath, Level, PathKind
from cca_core.planner.scene import TIMES, obstacles_of, span_of
from cca_core.planner.stretch import AHEAD, narrowed

_MAX_NODES = 140  # of a band
_MIN_SPEED = 5.0  # below it steering limits the curvature, not the tires [m/s]
_VEHICLE_SHARE = 0.5  # of the free space, kept to the vehicle; the rest to the edge [-]
_TIME_TO_CLEAR = 1.0  # in which a body that is beyond an edge comes back inside [s]
_EDGE_MARGIN = 0.15  # kept to an edge for the error of steering, where there is room [m]
_EDGE_TOLERANCE = 0.05  # by which the committed part of a path may be closer to an edge [m]
_JOINED = 4  # nodes of the path before and after a band with which it is interpolated


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Window:
    """Where a maneuver is off the route, and from how far before each vehicle it is fully displaced."""

    start: int
    end: int
    lane: Lane | None  # the adjacent lane as narrow as it is there
    clearance: float
    margin: float  # kept to the edges, if there is room [m]
    lead_distances: tuple[float, ...]


def plan_path(
    around: Surroundings, group: Sequence[int], side: Side, lane: Lane | None, level: Level,
    last: LateralPath | None,
) -> LateralPath | Rejection:  # fmt: skip
    """Return a band around a group of vehicles; at walking pace a tight one if there is no other."""
    window = _window(around, group, side, lane, level, last)
    if isinstance(window, Rejection):
        return window
    found = _bend_path(around, group, side, level, last, window)
    narrowest = around.settings.last_resort.clearance
    if level is Level.NARROW and isinstance(found, Rejection) and window.clearance > narrowest:
        return _bend_path(around, group, side, level, last, replace(window, clearance=narrowest))
    if level is Level.COMFORT and isinstance(found, Rejection) and around.creeps:
        clearance = min(around.settings.replan.min_clearance, window.clearance)
        window = replace(window, clearance=clearance, lead_distances=(0.0,) * len(group))
        stiffness = BandStiffness(k_e=around.settings.last_resort.pull_out_stiffness)
        tight = _bend_path(around, group, side, level, last, window, stiffness)
        return found if isinstance(tight, Rejection) else tight
    return found


def _bend_path(
    around: Surroundings, group: Sequence[int], side: Side, level: Level, last: LateralPath | None,
    window: _Window, stiffness: BandStiffness | None = None,
) -> LateralPath | Rejection:  # fmt: skip
    """Return the band in a window."""
    state, path, ongoing = around.lateral, around.road.path, last is not None or not around.lateral.on_route
    vehicle = around.vehicle
    spacing = max(1, math.ceil((window.end - window.start) / _MAX_NODES))
    stations, start = _nodes(around, window, spacing, ongoing=ongoing)
    if stations[-1] > path.end:
        return Rejection(
            kind=RejectionKind.ROUTE_ENDS, side=side, value=float(stations[-1] - around.s),
            limit=path.end - around.s,
        )  # fmt: skip
    if stations[-1] > state.base + len(state.d) - 2:
        return Rejection(
            kind=RejectionKind.TOO_LONG,
            side=side,
            vehicle_id=around.traffic.ids[group[0]],
            limit=float(AHEAD),
        )
    t = np.interp(stations, around.free_s, TIMES)
    v = np.maximum(np.interp(stations, around.free_s, around.free_v), _MIN_SPEED)
    limit = around.limits.a_y_limit if level is Level.COMFORT else around.limits.a_y_max
    curvature_limit = limit / v**2
    if stiffness is not None:  # it will be driven as slowly as it is sharp
        sharpest = math.tan(vehicle.delta_max) / vehicle.wheelbase
        curvature_limit = np.full(len(v), around.settings.last_resort.pull_out_steering * sharpest)
    obstacles, names = _obstacles(around, group, stations, t)
    lanes = (around.lane, window.lane or around.lane)
    right = min(each.right for each in lanes) + window.margin
    left = max(each.left for each in lanes) - window.margin
    slack = np.where(t < _TIME_TO_CLEAR, _excess(around, right, left), 0.0) if ongoing else 0.0
    leads = np.zeros(len(obstacles))
    leads[: len(group)] = np.maximum(np.array(window.lead_distances) - 0.5 * spacing, 0.0)
    band = relax_band(
        path.position(stations), obstacles, side=side, vehicle=around.vehicle, clearance=window.clearance,
        lead_distance=leads, curvature_limit=curvature_limit, start=start,
        corridor=(right - slack, left + slack), stiffness=stiffness,
    )  # fmt: skip
    if band.status is not Status.OK:
        return _reject(band, side, names, window)
    return LateralPath(
        kind=PathKind.LEFT if side == "left" else PathKind.RIGHT, base=state.base,
        d=_on_grid(band, stations, spacing, around.lateral, ongoing=ongoing), level=level, band=band,
        begin=float(window.start if last is None else last.begin), end=float(stations[-1]),
        overtaken=frozenset(around.traffic.ids[j] for j in group), clearance=window.clearance, a_y=around.a_y,
    )  # fmt: skip


def _nodes(around: Surroundings, window: _Window, spacing: int, *, ongoing: bool) -> tuple[Array, Array]:
    """Return stations of a band, and the offsets at which it begins: a node before the first one, and two."""
    state, begin, start = around.lateral, window.start, np.zeros(3)
    if ongoing:
        committed = around.settings.replan.committed_time * around.v * (not state.is_lost)
        begin = max(begin, math.ceil(around.s + committed))
        at = np.array((begin - spacing, begin, begin + spacing)) - state.base
        start = state.d[np.clip(at, 0, len(state.d) - 1)]
        if state.is_lost:
            start = state.offset + state.slope * np.array((-spacing, 0.0, spacing))
    n = max(math.ceil((window.end - begin) / spacing), 8)
    return begin + spacing * np.arange(n + 1.0), start


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


def _window(
    around: Surroundings, group: Sequence[int], side: Side, lane: Lane | None, level: Level,
    last: LateralPath | None,
) -> _Window | Rejection:  # fmt: skip
    """Return where a maneuver must begin and end."""
    settings, traffic, base = around.settings, around.traffic, around.lateral.base
    narrow = level is Level.NARROW
    first_id, sign = traffic.ids[group[0]], 1.0 if side == "left" else -1.0
    lanes = (around.lane, around.lane if lane is None else lane)
    edge = max(sign * (each.left if side == "left" else each.right) for each in lanes)
    outermost = max(float((sign * traffic.d[j] + traffic.half_w[j]).max()) for j in group)
    space = edge - outermost - around.vehicle.width
    clearance = settings.clearance
    if narrow:
        narrowest = settings.last_resort.clearance
        clearance = min(clearance, max(_VEHICLE_SHARE * space, narrowest))
    if space < clearance - 0.05:
        if lane is None:
            return Rejection(kind=RejectionKind.NO_LANE, side=side)
        gap = float(traffic.s[group[0], 0] - around.s)
        return Rejection(kind=RejectionKind.NO_SPACE, side=side, vehicle_id=first_id, distance=gap)
    ttc = settings.last_resort.min_ttc if narrow else settings.min_ttc
    spans = [span_of(traffic.scene.workspace, around.free_row, j, clearance, ttc) for j in group]
    first, stop = base + min(s[0] for s in spans), base + max(s[1] for s in spans)
    if not math.isfinite(stop):
        return Rejection(kind=RejectionKind.TOO_LONG, side=side, vehicle_id=first_id, limit=float(AHEAD))
    offset = outermost + 0.5 * around.vehicle.width + clearance
    start, end = _ends(around, first, stop, offset, level)
    if last is not None:
        start = math.floor(last.begin)
        end = math.ceil(last.end) if end < last.end + 2.0 else end
    if lane is not None and lane.boundaries:
        local = narrowed(lane, start, end)
        if local is None and (lane.start > start or lane.end >= end):
            return Rejection(kind=RejectionKind.NO_LANE, side=side)
        if local is None:
            return Rejection(
                kind=RejectionKind.LANE_ENDS, side=side, value=end - around.s, limit=lane.end - around.s
            )
        return _window(around, group, side, local, level, last)
    return _Window(
        start=start, end=end, lane=lane, clearance=clearance, lead_distances=tuple(s[2] for s in spans),
        margin=0.0 if narrow else min(_EDGE_MARGIN, 0.5 * max(space - clearance, 0.0)),
    )  # fmt: skip


def _ends(around: Surroundings, first: float, stop: float, offset: float, level: Level) -> tuple[int, int]:
    """Return where a new maneuver begins and ends that is alongside vehicles from `first` to `stop`."""
    limits, preparation = around.limits, around.settings.preparation_time
    a_y = limits.a_y if level is Level.COMFORT else limits.a_y_hard
    v_out, v_back = np.maximum(np.interp((first, stop), around.free_s, around.free_v), 1.0).tolist()
    curve = max(map(abs, map(around.road.path.curvature_at, np.linspace(around.s, stop, 12).tolist())))
    rest = max(a_y - curve * max(v_out, v_back) ** 2, 0.5 * a_y)
    duration = math.sqrt(QUINTIC_PEAK * max(offset, 0.5) / rest)
    required = v_out * (duration + preparation)
    delay = max(first - required - around.s, 0.0) if around.lateral.on_route else 0.0
    speed = around.v if delay == 0.0 else v_out
    return math.ceil(around.s + delay + speed * preparation), math.ceil(stop + v_back * duration)


def _obstacles(
    around: Surroundings, group: Sequence[int], stations: Array, t: Array
) -> tuple[list[Boxes], list[str]]:
    """Return boxes of the group in its worst case and of the others near the band nominally."""
    traffic, n, base = around.traffic, len(stations), around.lateral.base
    rows, boxes = np.zeros(len(traffic.ids), dtype=np.int32), np.empty((len(traffic.ids) * n, 5))
    rows[: len(group)] = group
    count = obstacles_of(
        traffic.scene.workspace, around.road.path.curve, float(base), n, stations, t,
        around.s - base + around.vehicle.rear, len(group), len(rows), rows, boxes,
    )  # fmt: skip
    each = boxes[: count * n].reshape(count, n, 5)
    return [Boxes(*box.T) for box in each], [traffic.ids[j] for j in rows[:count].tolist()]


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
