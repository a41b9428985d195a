"""Roads along lanes of a net of SUMO, which is read from a file or through a connection."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

import numpy as np

from cca_core._checks import Array
from cca_core.adapters.lane_lines import LaneLine, lanes_along
from cca_core.adapters.local_origin import Origin
from cca_core.errors import InputError
from cca_core.geometry import arc_length
from cca_core.path import Path, Road, fit_path

__all__ = ["LaneLink", "Net", "Step", "find_chain", "read_road", "road_along"]

_SPACING = 8.0  # of points on lanes [m]
_TOLERANCE = 0.05  # of the path [m]
_DETAIL = 0.1  # of lane boundaries [m]


class LaneLink(NamedTuple):
    """A connection to a lane of the next edge, by a lane within the junction if there is one."""

    lane: str
    via: str
    goes_straight: bool


class Step(NamedTuple):
    """A lane of the route, and the lanes within the junction behind it."""

    lane: str
    inner: tuple[str, ...]


class Net(Protocol):
    """What a road needs of a net."""

    def lanes_of(self, edge: str) -> list[str]:
        """Return the lanes of an edge, the right one first."""

    def edge_of(self, lane: str) -> str:
        """Return the edge of a lane."""

    def links(self, lane: str) -> list[LaneLink]:
        """Return the connections of a lane."""

    def shape(self, lane: str) -> Array:
        """Return the corners of a lane's center line [m], shape (n, 2)."""

    def width(self, lane: str) -> float:
        """Return the width of a lane [m]."""

    def speed(self, lane: str) -> float:
        """Return the speed limit of a lane [m/s]."""

    def may_use(self, lane: str, kind: str) -> bool:
        """Return whether a class of vehicles may use a lane."""

    def opposite(self, edge: str) -> str | None:
        """Return the edge between the same junctions in the other direction."""


class LiveNet:
    """The net of a running simulation."""

    def __init__(self, connection: Any, origin: Origin) -> None:
        self._connection, self._origin = connection, origin
        self._back: dict[tuple[str, str], str] | None = None

    def lanes_of(self, edge: str) -> list[str]:
        """Return the lanes of an edge, the right one first."""
        return [f"{edge}_{i}" for i in range(self._connection.edge.getLaneNumber(edge))]

    def edge_of(self, lane: str) -> str:
        """Return the edge of a lane."""
        return str(self._connection.lane.getEdgeID(lane))

    def links(self, lane: str) -> list[LaneLink]:
        """Return the connections of a lane."""
        return [LaneLink(link[0], link[4], link[6] == "s") for link in self._connection.lane.getLinks(lane)]

    def shape(self, lane: str) -> Array:
        """Return the corners of a lane's center line [m]."""
        corners: Array = np.array(self._connection.lane.getShape(lane))[:, :2]
        # a micrometer more or less of a difference would change the number of points on a lane
        return np.round(corners - self._origin, 6) if any(self._origin) else corners

    def width(self, lane: str) -> float:
        """Return the width of a lane [m]."""
        return float(self._connection.lane.getWidth(lane))

    def speed(self, lane: str) -> float:
        """Return the speed limit of a lane [m/s]."""
        return float(self._connection.lane.getMaxSpeed(lane))

    def may_use(self, lane: str, kind: str) -> bool:
        """Return whether a class of vehicles may use a lane."""
        allowed = self._connection.lane.getAllowed(lane)
        return kind in allowed if allowed else kind not in self._connection.lane.getDisallowed(lane)

    def opposite(self, edge: str) -> str | None:
        """Return the edge between the same junctions in the other direction."""
        ends = self._connection.edge
        if self._back is None:
            edges = [e for e in ends.getIDList() if not e.startswith(":")]
            self._back = {(ends.getToJunction(e), ends.getFromJunction(e)): e for e in edges}
        return self._back.get((ends.getFromJunction(edge), ends.getToJunction(edge)))


def read_road(connection: Any, ego_id: str, length: float, front: float, origin: Origin) -> Road:
    """Return the road along the ego's lane and route, of edges that begin within `length`."""
    cars, net = connection.vehicle, LiveNet(connection, origin)
    first, start = cars.getLaneID(ego_id), ""
    edges = list(cars.getRoute(ego_id)[max(cars.getRouteIndex(ego_id), 0) :])
    if not first:
        raise InputError(f"ego_id must be on a lane, was {ego_id!r}")
    if first.startswith(":"):  # within a junction
        start, first = first, net.links(first)[0].lane
        edges = edges[1:]
    chain, steps, driven = find_chain(net, first, edges), list[Step](), 0.0
    for step in chain:
        if driven > length:
            break
        steps.append(step)
        driven += sum(float(arc_length(net.shape(piece))[-1]) for piece in (step.lane, *step.inner))
    road = road_along(net, steps, cars.getVehicleClass(ego_id), start)
    if len(steps) == len(chain) < len(edges):  # the lane leaves the route: the front stops at its end
        end = max(road.path.end - front, 0.5 * (road.path.start + road.path.end))
        path = road.path.cut(road.path.start, end)
        road = Road(path, road.lanes, road.speed_limit, speed_limits=road.speed_limits)
    return road


def find_chain(net: Net, lane: str, edges: Sequence[str]) -> list[Step]:
    """Return the lanes along edges as far as they lead without a lane change, straight on if they can."""
    # from the last edge on: how many edges the route can be followed, and by which connection
    reach: dict[str, tuple[int, bool, LaneLink | None]] = {}
    for i in range(len(edges) - 1, -1, -1):
        for own in net.lanes_of(edges[i]):
            options = [
                (1 + reach[link.lane][0], link.goes_straight, link)
                for link in (net.links(own) if i + 1 < len(edges) else [])
                if net.edge_of(link.lane) == edges[i + 1]
            ]
            reach[own] = max(options, key=lambda option: option[:2], default=(0, False, None))
    steps: list[Step] = []
    for _ in range(max(len(edges), 1)):
        link = reach[lane][2] if lane in reach else None
        steps.append(Step(lane, () if link is None else _inner_lanes(net, link)))
        if link is None:
            break
        lane = link.lane
    return steps


def road_along(net: Net, steps: Sequence[Step], kind: str, start: str = "") -> Road:
    """Return the road along lanes; `start` is a lane within a junction before them."""
    points = [net.shape(start)] if start else []
    for step in steps:
        points += [_resampled(_distinct(net.shape(step.lane))), *map(net.shape, step.inner)]
    path = fit_path(_distinct(np.concatenate(points)), tolerance=_TOLERANCE)
    parts = [[_line(net, (start,), is_ego=True)]] if start else []
    for i, step in enumerate(steps):
        parts.append(list(_edge_lines(net, step.lane, kind)))
        if step.inner:
            after = steps[i + 1].lane if i + 1 < len(steps) else ""
            parts.append(list(_junction_lines(net, step, after, kind)))
    limits = _limits(net, path, steps)
    changes = np.append(True, np.diff(limits[:, 1]) != 0.0)
    limits = limits[changes]
    return Road(
        path, lanes_along(path, parts, _DETAIL), float(limits[0, 1]),
        speed_limits=limits if len(limits) > 1 else None,
    )  # fmt: skip


def _limits(net: Net, path: Path, steps: Sequence[Step]) -> Array:
    """Return stations and speed limits: that of a lane holds until the next edge begins."""
    rows, s = [(path.start, net.speed(steps[0].lane))], path.start
    for before, step in pairwise(steps):
        s += sum(float(arc_length(net.shape(lane))[-1]) for lane in (before.lane, *before.inner))
        s = float(path.project(net.shape(step.lane)[0], s)[0])
        rows.append((max(s, rows[-1][0] + 1e-3), net.speed(step.lane)))
    return np.array(rows)


def _inner_lanes(net: Net, link: LaneLink) -> tuple[str, ...]:
    """Return the lanes of a connection within its junction."""
    found: list[str] = []
    via = link.via
    while via and via not in found:
        found.append(via)
        via = next((more.via for more in net.links(via)), "")
    return tuple(found)


def _edge_lines(net: Net, lane: str, kind: str) -> Iterator[LaneLine]:
    """Yield the lanes of an edge that a class of vehicles may use, and those of the opposite edge."""
    edge = net.edge_of(lane)
    for own in net.lanes_of(edge):
        if own == lane or net.may_use(own, kind):
            yield _line(net, (own,), is_ego=own == lane)
    opposite = net.opposite(edge)
    for other in [] if opposite is None else net.lanes_of(opposite):
        if net.may_use(other, kind):
            yield _line(net, (other,), -1)


def _junction_lines(net: Net, step: Step, after: str, kind: str) -> Iterator[LaneLine]:
    """Yield the lanes within a junction between two edges, in both directions."""
    yield _line(net, step.inner, is_ego=True)
    edge, onward = net.edge_of(step.lane), net.edge_of(after) if after else ""
    there, back = (net.opposite(onward) if onward else None), net.opposite(edge)
    for first, last, direction in ((edge, onward, 1), (there, back, -1)):
        for lane in net.lanes_of(first) if first and last else []:
            for link in net.links(lane):
                inner = _inner_lanes(net, link)
                leads_there = inner and net.edge_of(link.lane) == last and net.may_use(link.lane, kind)
                if lane != step.lane and leads_there and net.may_use(lane, kind):
                    yield _line(net, inner, direction)


def _line(net: Net, lanes: Sequence[str], direction: int = 1, *, is_ego: bool = False) -> LaneLine:
    """Return lanes one behind the other as one, in the direction of the route."""
    center = _distinct(np.concatenate([net.shape(lane) for lane in lanes]))
    along = np.gradient(center, axis=0)
    normal = np.column_stack((-along[:, 1], along[:, 0])) / np.hypot(*along.T)[:, None]
    half = 0.5 * min(map(net.width, lanes))
    right, left = center - half * normal, center + half * normal
    if direction < 0:
        right, left = left[::-1], right[::-1]
    spacing = 1.0 if lanes[0].startswith(":") else _SPACING
    return LaneLine(_resampled(right, spacing), _resampled(left, spacing), direction, is_ego)


def _distinct(points: Array) -> Array:
    """Return points without those that lie on the one before."""
    return np.asarray(points[np.r_[True, np.hypot(*np.diff(points, axis=0).T) > 1e-3]])


def _resampled(points: Array, spacing: float = _SPACING) -> Array:
    """Return points of a polyline at even distances."""
    s = arc_length(points)
    even = np.linspace(0.0, s[-1], max(2, int(s[-1] / spacing)))
    return np.column_stack((np.interp(even, s, points[:, 0]), np.interp(even, s, points[:, 1])))
