"""A road from a net of SUMO, along the ego's route."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.geometry import arc_length
from cca_core.path import Lane, Path, Road, fit_path

_SPACING = 8.0  # of points on lanes [m]
_TOLERANCE = 0.05  # of the path [m]
_LANE_DRIFT = 0.5  # of the lateral offset of a lane that goes along [m]
_ENDS = 3  # points at each end of a lane that may be bent by a junction


class _Link(NamedTuple):
    """A connection to a lane of the next edge, by a lane within the junction if there is one."""

    lane: str
    via: str
    goes_straight: bool


def read_road(connection: Any, ego_id: str, length: float) -> Road:
    """Return the road along the ego's lane and route, of edges that begin within `length`."""
    cars, lanes = connection.vehicle, connection.lane
    first, pieces = cars.getLaneID(ego_id), []
    edges = list(cars.getRoute(ego_id)[max(cars.getRouteIndex(ego_id), 0) :])
    if not first:
        raise InputError(f"ego_id must be on a lane, was {ego_id!r}")
    if first.startswith(":"):  # within a junction
        pieces, first = [first], _links(connection, first)[0].lane
        edges = edges[1:]
    chain = _chain(connection, first, edges)
    driven = 0.0
    for i, (lane, inner) in enumerate(chain):
        if driven > length:
            chain = chain[:i]
            break
        pieces += [lane, *inner]
        driven += sum(lanes.getLength(piece) for piece in (lane, *inner))
    main = [lane for lane, _ in chain]
    path = fit_path(_joined(connection, pieces), tolerance=_TOLERANCE)
    road_lanes = [Lane(d=0.0, width=min(map(lanes.getWidth, main)))]
    for along, direction in _lanes_along(connection, main, cars.getVehicleClass(ego_id)):
        lane_along = _measured(connection, path, along, direction)
        if lane_along is not None:
            road_lanes.append(lane_along)
    return Road(path, road_lanes, speed_limit=min(map(lanes.getMaxSpeed, main)))


def _links(connection: Any, lane: str) -> list[_Link]:
    """Return the connections of a lane."""
    return [_Link(link[0], link[4], link[6] == "s") for link in connection.lane.getLinks(lane)]


def _inner_lanes(connection: Any, link: _Link) -> list[str]:
    """Return the lanes of a connection within its junction."""
    found, via = [], link.via
    while via and via not in found:
        found.append(via)
        via = next((more.via for more in _links(connection, via)), "")
    return found


def _chain(connection: Any, lane: str, edges: Sequence[str]) -> list[tuple[str, list[str]]]:
    """Return the lanes along the edges, each with those within the junction behind it."""
    # from the last edge on: how many edges the route can be followed, and by which connection
    reach: dict[str, tuple[int, bool, _Link | None]] = {}
    for i in range(len(edges) - 1, -1, -1):
        for own in _lanes_of(connection, edges[i]):
            ahead = _links(connection, own) if i + 1 < len(edges) else []
            options = [
                (1 + reach[link.lane][0], link.goes_straight, link)
                for link in ahead
                if connection.lane.getEdgeID(link.lane) == edges[i + 1]
            ]
            reach[own] = max(options, key=lambda option: option[:2], default=(0, False, None))
    chain: list[tuple[str, list[str]]] = []
    link: _Link | None = _Link(lane, "", goes_straight=True)
    while link is not None:
        lane = link.lane
        link = reach[lane][2] if lane in reach else None
        chain.append((lane, [] if link is None else _inner_lanes(connection, link)))
    return chain


def _lanes_along(connection: Any, main: list[str], kind: str) -> Iterator[tuple[list[str], int]]:
    """Yield the other lanes of all edges, with their direction: each as long as the road."""
    edges = [connection.lane.getEdgeID(lane) for lane in main]
    all_lanes = [_lanes_of(connection, edge) for edge in edges]
    own = [lanes.index(lane) for lanes, lane in zip(all_lanes, main, strict=True)]
    for offset in range(-own[0], len(all_lanes[0]) - own[0]):
        along = [
            lanes[i + offset] for lanes, i in zip(all_lanes, own, strict=True) if 0 <= i + offset < len(lanes)
        ]
        goes_on = all(
            after in {link.lane for link in _links(connection, before)} for before, after in pairwise(along)
        )
        if offset and len(along) == len(main) and goes_on and _may_use(connection, along, kind):
            yield along, 1
    opposite = _opposing_lanes(connection, edges)
    for i in range(min(map(len, opposite))):
        along = [lanes[i] for lanes in opposite]
        if _may_use(connection, along, kind):
            yield along, -1


def _lanes_of(connection: Any, edge: str) -> list[str]:
    """Return the lanes of an edge, the right one first."""
    return [f"{edge}_{i}" for i in range(connection.edge.getLaneNumber(edge))]


def _opposing_lanes(connection: Any, edges: list[str]) -> list[list[str]]:
    """Return the lanes of the edges between the same junctions in the other direction, nearest first."""
    ends, back = connection.edge, {}
    for edge in ends.getIDList():
        if not edge.startswith(":"):
            back[ends.getToJunction(edge), ends.getFromJunction(edge)] = edge
    found = [back.get((ends.getFromJunction(edge), ends.getToJunction(edge))) for edge in edges]
    return [[] if edge is None else _lanes_of(connection, edge)[::-1] for edge in found]


def _may_use(connection: Any, lanes: list[str], kind: str) -> bool:
    """Whether a class of vehicles may use all lanes."""
    for lane in lanes:
        allowed = connection.lane.getAllowed(lane)
        if kind not in allowed if allowed else kind in connection.lane.getDisallowed(lane):
            return False
    return True


def _measured(connection: Any, path: Path, lanes: list[str], direction: int) -> Lane | None:
    """Return lanes as one lane along the path; None if they do not keep their distance from it."""
    offsets = []
    for lane in lanes:
        points = _resampled(_shape(connection, lane))
        inner = points[_ENDS:-_ENDS] if len(points) > 2 * _ENDS else points
        offsets.append(path.project(inner)[1])
    all_offsets = np.concatenate(offsets)
    d = float(np.median(all_offsets))
    if np.abs(all_offsets - d).max() > _LANE_DRIFT:
        return None
    return Lane(d=d, width=min(map(connection.lane.getWidth, lanes)), direction=direction)


def _joined(connection: Any, lanes: list[str]) -> Array:
    """Return points along lanes; within junctions their corners, which lie on the curve, as chords do not."""
    parts = []
    for lane in lanes:
        shape = _shape(connection, lane)
        parts.append(shape if lane.startswith(":") else _resampled(shape))
    return _without_repetitions(np.concatenate(parts))


def _shape(connection: Any, lane: str) -> Array:
    """Return the corners of a lane's center line."""
    return _without_repetitions(np.array(connection.lane.getShape(lane))[:, :2])


def _without_repetitions(points: Array) -> Array:
    """Return points without those that lie on the one before."""
    distances = np.hypot(*np.diff(points, axis=0).T)
    return np.asarray(points[np.r_[True, distances > 1e-3]])


def _resampled(points: Array) -> Array:
    """Return points of a polyline at even distances."""
    s = arc_length(points)
    even = np.linspace(0.0, s[-1], max(2, int(s[-1] / _SPACING)))
    return np.column_stack((np.interp(even, s, points[:, 0]), np.interp(even, s, points[:, 1])))
