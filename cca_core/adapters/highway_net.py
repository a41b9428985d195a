"""A road from the lanes of highway-env, along that of the ego."""

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from cca_core._checks import Array, shown
from cca_core.adapters.conversions import flip_axes
from cca_core.errors import InputError
from cca_core.path import Lane, Path, Road, fit_path

_SPACING = 10.0  # of points on lanes [m]
_TOLERANCE = 0.02  # of the path [m]
_BEHIND = 50.0  # where the road begins behind the ego [m]
_OVERRUN = 300.0  # by which the road goes on straight behind the last lane [m]
_LANE_DRIFT = 0.5  # of the lateral offset of a lane that goes along [m]
_SAMPLES = 9  # of a lane next to a part of the route
_SPEED_LIMIT = 36.0  # of lanes without one [m/s]


def world_of(env: Any) -> Any:
    """Return the world within an environment of highway-env."""
    world = getattr(env, "unwrapped", None)
    if not all(hasattr(world, name) for name in ("config", "road", "vehicle")):
        raise InputError(f"env must be an environment of highway-env, was {shown(env)}")
    return world


def read_highway_road(env: Any, *, length: float = 2000.0) -> Road:
    """Road along the ego's lane.

    Parameters
    ----------
    env : gymnasium.Env
        The environment.
    length : float
        Length ahead of the ego [m].

    Returns
    -------
    road : Road
        It follows the ego's lane and those that continue it, and goes on straight for 300 m behind the last
        one. Its lanes are those that go along all of it; one that is driven in both directions is opposing.
        Its speed limits are those of the ego's lanes, 36 m/s where one has none.

    Raises
    ------
    InputError
        If it is no environment of highway-env, or has not been reset.
    InfeasibleError
        If no path fits the lanes.
    """
    world = world_of(env)
    if world.vehicle is None:
        raise InputError(f"env must be reset, was not: {shown(env)}")
    chain = _chain(world.vehicle, world.road.network, length)
    points = np.concatenate([part.points() for part in chain])
    if chain[-1].end >= chain[-1].lane.length:
        step = points[-1] - points[-2]
        count = int(_OVERRUN / math.hypot(*step))
        points = np.concatenate((points, points[-1] + np.outer(np.arange(1, count + 1), step)))
    path = fit_path(points[np.r_[True, np.hypot(*np.diff(points, axis=0).T) > 1e-3]], tolerance=_TOLERANCE)
    graph = world.road.network.graph
    lanes = [Lane(d=0.0, width=min(_width(part.lane) for part in chain))]
    opposing = _measured(path, chain, [graph.get(part.name[1], {}).get(part.name[0], []) for part in chain])
    lanes += [replace(lane, direction=-1) for lane in opposing]
    for lane in _measured(path, chain, [graph[part.name[0]][part.name[1]] for part in chain]):
        if all(abs(lane.d - known.d) > _LANE_DRIFT for known in lanes):
            lanes.append(lane)
    limits = [part.lane.speed_limit or _SPEED_LIMIT for part in chain]
    if len(set(limits)) == 1:
        return Road(path, lanes, speed_limit=limits[0])
    begins = path.project([_position(part.lane, part.begin) for part in chain])[0]
    return Road(path, lanes, speed_limits=np.column_stack((begins, limits)))


class _Part(NamedTuple):
    """A lane of the ego's route, with the stations on it from and to which it counts."""

    name: tuple[str, str, int]
    lane: Any
    begin: float
    end: float

    def points(self) -> Array:
        """Return points of its center line in the axes of the library."""
        stations = np.linspace(self.begin, self.end, max(2, math.ceil((self.end - self.begin) / _SPACING)))
        return np.array([_position(self.lane, s) for s in stations])


def _chain(vehicle: Any, network: Any, length: float) -> list[_Part]:
    """Return the ego's lane and those that continue it."""
    index, route = vehicle.lane_index, list(getattr(vehicle, "route", None) or ())
    s = float(network.get_lane(index).local_coordinates(vehicle.position)[0])
    begin, ahead = s - _BEHIND, s + length
    chain: list[_Part] = []
    while True:
        lane = network.get_lane(index)
        chain.append(_Part(index, lane, begin, min(ahead, float(lane.length))))
        if ahead <= lane.length:
            return chain
        begin, ahead = 0.0, ahead - float(lane.length)
        index = network.next_lane(index, route=route, position=lane.position(lane.length, 0.0))
        turn = network.get_lane(index).heading_at(0.0) - lane.heading_at(lane.length)
        if math.cos(turn) < 0.0 or any(index == part.name for part in chain):  # back, the last one, a circle
            return chain


def _measured(path: Path, chain: list[_Part], roads: list[list[Any]]) -> list[Lane]:
    """Return the lanes of the roads along the path that go along all of it, apart from the ego's."""
    found: list[Lane] = []
    for i, (part, lanes) in enumerate(zip(chain, roads, strict=True)):
        here = [(_offsets(path, part, lane), _width(lane)) for lane in lanes if not lane.forbidden]
        if i == 0:
            found = [Lane(d=float(np.median(d)), width=width) for d, width in here]
        kept = []
        for lane in found:
            widths = [width for d, width in here if np.abs(d - lane.d).max() <= _LANE_DRIFT]
            if widths:
                kept.append(replace(lane, width=min(lane.width, *widths)))
        found = kept
    return [lane for lane in found if abs(lane.d) > _LANE_DRIFT]


def _offsets(path: Path, part: _Part, lane: Any) -> Array:
    """Return lateral offsets of a lane from the path, where it is next to a part of the route."""
    ends = [lane.local_coordinates(part.lane.position(s, 0.0))[0] for s in (part.begin, part.end)]
    points = [_position(lane, s) for s in np.linspace(ends[0], ends[1], _SAMPLES)]
    return path.project(points)[1]


def _position(lane: Any, s: float) -> tuple[float, float]:
    """Return a point of a lane's center line in the axes of the library."""
    x, y = lane.position(float(s), 0.0)
    return flip_axes(float(x), float(y), 0.0)[:2]


def _width(lane: Any) -> float:
    """Return the width of a lane at its beginning."""
    return float(lane.width_at(0.0))
