"""Paths from the car's lateral state: the route, returns to it, and the reference of a path."""

import math
from dataclasses import dataclass, replace

import numpy as np

from cca_core._checks import Array
from cca_core.geometry import QUINTIC_PEAK
from cca_core.path import Lane, Path, Road
from cca_core.path.interpolate import spline_through
from cca_core.planner.limits import Limits
from cca_core.planner.occupancy import Traffic
from cca_core.planner.records import LaneWish, LateralPath, Level, PathKind
from cca_core.planner.scene import FREE_ROW
from cca_core.planner.settings import EvasionSettings
from cca_core.planner.stretch import AHEAD, BEHIND
from cca_core.vehicle import VehicleParams

_MIN_OFFSET = 0.3  # of which the length of a return is computed at least [m]
_TIGHTEST = 0.1  # largest curvature that a return aims at [1/m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LateralState:
    """Where the ego is on its last path, or next to it."""

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
    lane: Lane  # the ego lane, as narrow as it is on this part of the route
    settings: EvasionSettings
    limits: Limits
    traffic: Traffic
    lateral: LateralState
    s: float
    v: float
    awareness_range: float  # in this cycle [m]
    jerk: float  # of normal driving [m/s^3]
    jerk_emergency: float
    free_s: Array  # the ego's motion if no vehicle limits it, at `TIMES`
    free_v: Array
    free_row: int = FREE_ROW  # of that motion in the scene
    a_y: float = math.inf  # lateral acceleration up to which it speeds up on a maneuver [m/s^2]
    wish: LaneWish | None = None

    @property
    def offset(self) -> float:
        """Center of gravity to center of the body [m]."""
        return self.vehicle.box_offset

    @property
    def creeps(self) -> bool:
        """Whether the ego is so slow that it may pull out as sharply as it can steer."""
        return self.v < self.settings.last_resort.walking_pace


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
    in_curve = abs(around.road.path.curvature_at(around.s)) * v * v
    paths = []
    for level, a_y in ((Level.COMFORT, limits.a_y), (Level.HARD, limits.a_y_hard)):
        rest = max(a_y - in_curve, 0.5 * a_y)
        d, length = blend(state.offset, state.slope, state.bend, rest, v, x)
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


def change_paths(around: Surroundings, wish: LaneWish | None) -> list[LateralPath]:
    """Return paths into another lane, gentle and as sharp as comfort allows; without one, a gentle way back.

    They begin once the path can change, so that steering does not jump, or where the ego is if it has lost
    its path. They are complete before the route ends, where the wanted lane may go on.
    """
    state, v, to = around.lateral, max(around.v, 2.0), 0.0 if wish is None else wish.d
    begin, found = around.s, []
    start = state.offset - to, state.slope, state.bend
    if not state.is_lost:
        begin = math.ceil(around.s + around.settings.replan.committed_time * v)
        k = begin - state.base
        behind, here, ahead = state.d[k - 1 : k + 2].tolist()
        start = here - to, 0.5 * (ahead - behind), ahead - 2.0 * here + behind
    x: Array = state.base + np.arange(float(len(state.d))) - begin
    kind = PathKind.RETURN if wish is None else PathKind(wish.side)
    left = around.road.path.end - begin
    a_ys = around.settings.change.gentle_fraction * around.limits.a_y, around.limits.a_y
    for a_y in a_ys if wish is not None else a_ys[:1]:
        rest, length = blend(*start, a_y, v, x, max_length=left)
        d = np.where(x < 0.0, state.d, to + rest)
        path = LateralPath(
            kind=kind, base=state.base, d=d, begin=around.s, end=begin + length, rest=to, is_smooth=True
        )
        found.append(path if wish is None else replace(path, to_lane=wish.lane, change=wish.side))
    return found


def route_path(base: int) -> LateralPath:
    """Return the route as a path."""
    return LateralPath(kind=PathKind.ROUTE, base=base, d=np.zeros(BEHIND + AHEAD))


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


def blend(
    offset: float, slope: float, bend: float, a_y: float, v: float, x: Array, min_length: float = 0.0,
    max_length: float = math.inf,
) -> tuple[Array, float]:  # fmt: skip
    """Return a way back to the route from a lateral state at `x` 0, and its length [m]."""
    to_go = abs(offset) + abs(slope) * v
    length = max(min(_length(to_go, a_y, v), max_length), _length(to_go, a_y, 0.0), min_length)
    return _quintic(offset, slope, bend, 0.0, length, x), length


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
