"""Change of the route under way: what is driven stays where it is in the plane."""

import math
from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.path import Path, Road
from cca_core.planner.inputs import first_station
from cca_core.planner.limits import Limits
from cca_core.planner.paths import blend, reference_of
from cca_core.planner.records import DrivenPlan, LateralPath, PathKind
from cca_core.planner.stretch import AHEAD, BEHIND
from cca_core.vehicle import VehicleState

__all__ = ["carry_plan", "is_same_road", "station_on"]

_BEHIND = 30.0  # part of the driven path that is carried over [m]
_MIN_AHEAD, _TIME_AHEAD = 5.0, 1.0  # part ahead of the ego that is carried over [m], [s]
_MARGIN = 5.0  # beyond both, for its slope at the ends [m]
_MIN_TIME = 2.5  # of the way to the new route [s]
_ON_ROUTE, _ALONG = 0.02, 0.003  # offset [m] and slope [-] below which a path is the route
_THERE = 2e-3  # offset [m] and slope [-] below which a maneuver ends on the new route
_MAX_SLOPE = 0.6  # of a path to its route; beyond it the routes have parted [-]
_NEAR = 2.0  # by which another part of the new route must be nearer than that of the same station [m]


def is_same_road(road: Road, other: Road) -> bool:
    """Return whether two roads are equal in all that the planner uses."""
    mine, theirs = ({k: v for k, v in vars(each).items() if k != "frame"} for each in (road, other))
    return mine.keys() == theirs.keys() and all(_is_same(value, theirs[k]) for k, value in mine.items())


def _is_same(value: object, other: object) -> bool:
    """Return whether two attributes of roads are equal."""
    if isinstance(value, Path) and isinstance(other, Path):
        return value is other or (
            np.array_equal(value.breaks, other.breaks)
            and np.array_equal(value.coefficients, other.coefficients)
        )
    if isinstance(value, np.ndarray) and isinstance(other, np.ndarray):
        return np.array_equal(value, other, equal_nan=True)
    return type(value) is type(other) and bool(value == other)


def station_on(path: Path, state: VehicleState, s: float) -> float:
    """Return the ego's station on a new route: near the one on the old route if that is as near as any."""
    first = first_station(path, state)
    distance = abs(path.foot_point(state.x, state.y, first)[1])
    here, d, heading, _ = path.foot_point(state.x, state.y, s)
    is_along = math.cos(state.psi - heading) > 0.0
    return here if is_along and abs(d) <= distance + _NEAR else first


def carry_plan(
    plan: DrivenPlan, old: Road, new: Road, s: float, s_new: float, v: float, limits: Limits,
    goes_on: bool = True,
) -> DrivenPlan:  # fmt: skip
    """Return a plan in coordinates of another route; its certificate ends.

    The path stays in the plane: a maneuver to its end, others for the time that steering looks ahead. From
    there it leads to the new route in comfort. With `goes_on` unset, maneuvers end as well.
    """
    plan = replace(plan, assumptions=None)
    if _is_same(old.path, new.path):
        return plan
    path = _carried(plan.path, old.path, new.path, s, s_new, v, limits, goes_on)
    reference = new.path if path.kind is PathKind.ROUTE else reference_of(path, new, s_new)
    if path.kind is not PathKind.ROUTE:
        path = replace(path, reference=reference)
    return replace(plan, path=path, reference=reference, s=plan.s + (s_new - s))


def _carried(
    path: LateralPath, old: Path, new: Path, s: float, s_new: float, v: float, limits: Limits, goes_on: bool
) -> LateralPath:
    """Return a lateral path on a new route."""
    ahead = s + max(_MIN_AHEAD, _TIME_AHEAD * v)
    goes_on = goes_on and path.kind.is_evasive and s < path.end
    end = max(path.end, ahead) if goes_on else ahead
    base = math.floor(s_new) - BEHIND
    grid = base + np.arange(float(BEHIND + AHEAD))
    stations, at, d = _project(path, old, new, s - _BEHIND, end + _MARGIN, s, s_new)
    values = _on_grid(grid, at, d)
    slopes = np.gradient(values)
    near = (grid >= s_new - _MARGIN) & (grid <= at[-1] - _MARGIN)
    if not goes_on and (np.abs(values[near]) < _ON_ROUTE).all() and (np.abs(slopes[near]) < _ALONG).all():
        return LateralPath(kind=PathKind.ROUTE, base=base, d=np.zeros(len(grid)))
    if goes_on and stations[-1] >= path.end:
        shift = float(np.interp(path.begin, stations, at)) - max(path.begin, float(stations[0]))
        path = replace(path, begin=path.begin + shift)
        if path.to_lane is not None:  # the new route is in that lane
            path = replace(path, kind=PathKind.RETURN, to_lane=None, rest=0.0)
    else:
        end = ahead
        path = LateralPath(kind=PathKind.RETURN, base=base, d=values, begin=s_new)
    k = min(math.floor(np.interp(end, stations, at)) - base, len(grid) - 3)
    bend = float(values[k + 1] - 2.0 * values[k] + values[k - 1])
    v, x = max(v, 2.0), grid[k:] - grid[k]
    values[k:], length = blend(
        float(values[k]), float(slopes[k]), bend, limits.a_y, v, x, min_length=_MIN_TIME * v
    )
    if max(abs(float(values[k])), abs(float(slopes[k]))) < _THERE:
        length = 0.0
    return replace(path, base=base, d=values, end=float(grid[k]) + length, is_last=False)


def _project(
    path: LateralPath, old: Path, new: Path, start: float, end: float, s: float, s_new: float
) -> tuple[Array, Array, Array]:
    """Return stations of a path, and its stations and offsets on a new route as far as both run together."""
    stations = s + np.arange(math.floor(start - s), math.ceil(end - s) + 1.0)
    nodes = old.to_cartesian(stations, np.interp(stations, path.stations, path.d, left=0.0, right=path.rest))
    at, d = new.project(nodes, s_new + (stations - s))
    middle, steps = int(np.argmin(np.abs(stations - s))), np.diff(at)
    parted = (steps <= 0.2) | (np.abs(np.diff(d)) > _MAX_SLOPE * steps)
    before, after = np.flatnonzero(parted[:middle]), np.flatnonzero(parted[middle:])
    first = int(before[-1]) + 1 if len(before) else 0
    last = middle + int(after[0]) if len(after) else len(at) - 1
    part = slice(first, last + 1)
    return stations[part], at[part], d[part]


def _on_grid(grid: Array, at: Array, d: Array) -> Array:
    """Return offsets at whole stations; those of the ends beyond them."""
    from scipy.interpolate import CubicSpline  # slow to import

    if len(at) < 4:
        return np.interp(grid, at, d)
    return np.asarray(CubicSpline(at, d)(np.clip(grid, at[0], at[-1])))
