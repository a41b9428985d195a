"""Files of SUMO's nets: edges, lanes and connections."""

from collections.abc import Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path as FilePath
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from cca_core._checks import Array, check_real, read_real, shown
from cca_core._files import parse_tree, read_bytes
from cca_core.adapters.local_origin import Move, Origin, move_to_origin
from cca_core.adapters.sumo_net import LaneLink, find_chain, road_along
from cca_core.errors import InputError
from cca_core.path import Road
from cca_core.vehicle import MAX_COORDINATE

__all__ = ["SumoNet", "read_sumo_net"]

_WIDTH = 3.2  # of a lane without one, as in SUMO [m]


class _Lane(NamedTuple):
    """A lane of the file."""

    edge: str
    shape: Array
    width: float
    speed: float
    allowed: frozenset[str]
    disallowed: frozenset[str]


class _Edge(NamedTuple):
    """An edge of the file, with its lanes, the right one first."""

    start: str
    end: str
    lanes: list[str]


class _FileNet:
    """What a road needs of a net, from a file."""

    def __init__(self, root: Element) -> None:
        self.edges: dict[str, _Edge] = {}
        self._lanes: dict[str, _Lane] = {}
        self._links: dict[str, list[LaneLink]] = {}
        for element in root.iterfind("edge"):
            self._add_edge(element)
        for element in root.iterfind("connection"):
            self._add_link(element)
        inner = (item for item in self.edges.items() if not item[0].startswith(":"))
        self._back = {(edge.end, edge.start): id_ for id_, edge in inner}

    def lanes_of(self, edge: str) -> list[str]:
        """Return the lanes of an edge, the right one first."""
        return self.edges[edge].lanes

    def edge_of(self, lane: str) -> str:
        """Return the edge of a lane."""
        return self._lanes[lane].edge

    def links(self, lane: str) -> list[LaneLink]:
        """Return the connections of a lane."""
        return self._links.get(lane, [])

    def shape(self, lane: str) -> Array:
        """Return the corners of a lane's center line."""
        return self._lanes[lane].shape

    def width(self, lane: str) -> float:
        """Return the width of a lane."""
        return self._lanes[lane].width

    def speed(self, lane: str) -> float:
        """Return the speed limit of a lane."""
        return self._lanes[lane].speed

    def may_use(self, lane: str, kind: str) -> bool:
        """Return whether a class of vehicles may use a lane."""
        here = self._lanes[lane]
        if here.allowed:
            return kind in here.allowed or "all" in here.allowed
        return kind not in here.disallowed and "all" not in here.disallowed

    def opposite(self, edge: str) -> str | None:
        """Return the edge between the same junctions in the other direction."""
        here = self.edges[edge]
        return self._back.get((here.start, here.end))

    def _add_edge(self, element: Element) -> None:
        id_ = _text(element, "id")
        if not id_ or id_ in self.edges:
            raise InputError(f"id of edge must be unique and not empty, was {id_!r}")
        lanes = sorted(element.iterfind("lane"), key=lambda e: read_real("index of lane", e.get("index")))
        ids = []
        for lane in lanes:
            name = _text(lane, "id")
            where = f"lane {name!r}"
            if not name or name in self._lanes:
                raise InputError(f"id of lane must be unique and not empty, was {name!r}")
            if lane.get("speed") is None:
                raise InputError(
                    f"speed of {where} must be given [m/s], as netconvert writes it, was missing"
                )
            self._lanes[name] = _Lane(
                id_, _shape(lane.get("shape") or "", where),
                read_real(f"width of {where}", lane.get("width", str(_WIDTH)), ge=0.1, le=100.0),
                read_real(f"speed of {where}", lane.get("speed"), ge=0.01, le=1000.0),
                frozenset(lane.get("allow", "").split()), frozenset(lane.get("disallow", "").split()),
            )  # fmt: skip
            ids.append(name)
        if ids:
            self.edges[id_] = _Edge(_text(element, "from"), _text(element, "to"), ids)

    def _add_link(self, element: Element) -> None:
        """Keep a connection between lanes that are there."""
        ends = [self.edges.get(_text(element, key)) for key in ("from", "to")]
        numbers = [element.get(key) for key in ("fromLane", "toLane")]
        lanes = []
        for edge, text in zip(ends, numbers, strict=True):
            index = read_real("lane of connection", text, ge=0.0, le=1e6)
            if edge is None or not index < len(edge.lanes):
                return
            lanes.append(edge.lanes[int(index)])
        via = _text(element, "via")
        link = LaneLink(lanes[1], via if via in self._lanes else "", _text(element, "dir") == "s")
        self._links.setdefault(lanes[0], []).append(link)


class SumoNet:
    """A net of SUMO.

    Parameters
    ----------
    root : xml.etree.ElementTree.Element
        What the file holds; `read_sumo_net` reads it.
    origin : tuple of float
        Position in the file that is x = y = 0 in `root` [m].

    Attributes
    ----------
    edge_ids : tuple of str
        Ids of the edges, without those within junctions.
    origin : tuple of float
        As given.
    """

    def __init__(self, root: Element, origin: Origin = (0.0, 0.0)) -> None:
        self._net, self.origin = _FileNet(root), origin
        self.edge_ids = tuple(id_ for id_ in self._net.edges if not id_.startswith(":"))

    def __repr__(self) -> str:
        return f"SumoNet({len(self.edge_ids)} edges)"

    def road_along(
        self, edge_ids: Sequence[str], lane: int | None = None, *, vehicle_class: str = "passenger"
    ) -> Road:
        """Make the road along edges.

        Parameters
        ----------
        edge_ids : sequence of str
            Ids of the edges in driving order, without those within junctions.
        lane : int, optional
            Index of the lane on the first edge, 0 for the right one [-]. By default it is the right one of
            those that lead along all edges.
        vehicle_class : str
            SUMO's class of the ego: lanes that it may not use are no lanes.

        Returns
        -------
        road : Road
            The lane from the beginning of the first edge to the end of the last one, through the junctions,
            fitted within 5 cm, with the other lanes of the edges, those of the opposite edges, and the speed
            limits of the edges.

        Raises
        ------
        InputError
            If there is no such edge or lane, or the lane does not lead along all edges without a lane change.
        InfeasibleError
            If no path fits the lanes.
        """
        if isinstance(edge_ids, str) or not edge_ids:
            raise InputError(f"edge_ids must be a sequence of ids, was {shown(edge_ids)}")
        for id_ in edge_ids:
            if id_ not in self._net.edges:
                raise InputError(f"edge_ids must be edges of the net, one was {shown(id_)}")
        lanes = self._net.lanes_of(edge_ids[0])
        if lane is not None:
            index = check_real("lane", lane, ge=0.0, le=len(lanes) - 1.0)
            lanes = lanes[int(index) : int(index) + 1]
        usable = [own for own in lanes if self._net.may_use(own, vehicle_class)]
        if not usable:
            which = f"edge {edge_ids[0]!r}" if lane is None else f"lane {lanes[0]!r}"
            raise InputError(f"vehicle_class must be allowed on {which}, was {vehicle_class!r}")
        self._check_order(edge_ids)
        best = max((find_chain(self._net, own, edge_ids) for own in usable), key=len)
        if len(best) < len(edge_ids):
            whole = [
                str(i)
                for i, own in enumerate(self._net.lanes_of(edge_ids[0]))
                if len(find_chain(self._net, own, edge_ids)) == len(edge_ids)
            ]
            raise InputError(
                f"edge_ids must be reachable without a lane change, was not behind "
                f"{edge_ids[len(best) - 1]!r}; lanes that lead along: {', '.join(whole) or 'none'}"
            )
        return road_along(self._net, best, vehicle_class)

    def _check_order(self, edge_ids: Sequence[str]) -> None:
        """Raise unless each edge follows the one before, from any of its lanes."""
        for before, after in pairwise(edge_ids):
            links = (link for lane in self._net.lanes_of(before) for link in self._net.links(lane))
            there = sorted({self._net.edge_of(link.lane) for link in links})
            if after not in there:
                names = ", ".join(map(repr, there)) or "no edge"
                raise InputError(
                    f"edge_ids must follow each other, {before!r} leads to {names}, not {after!r}"
                )


def read_sumo_net(file: str | FilePath, *, origin: Origin | None = None) -> SumoNet:
    """Read a net of SUMO.

    Parameters
    ----------
    file : str or pathlib.Path
        File that ends in ``.net.xml``, at most 50 MB, without a document type declaration.
    origin : tuple of float, optional
        Position in the net that becomes x = y = 0 [m], such as that of another map. By default it is 0.
        A net whose middle is more than 900 km from there gets an origin near its middle, at whole kilometers.

    Returns
    -------
    net : SumoNet
        Its edges, along which `SumoNet.road_along` makes a `Road`, and the `origin`. A position in
        coordinates of the net belongs to x and y less those of the origin.

    Raises
    ------
    InputError
        If the file cannot be read or is not such a net.

    Notes
    -----
    SUMO itself is not needed. Read are edges, lanes with shape, width, speed and permissions, the lanes
    within junctions, and connections. Not read are heights, traffic lights, rules of priority, and netOffset
    and projection: coordinates of the net are those that SUMO reports.

    References
    ----------
    .. [1] Eclipse SUMO, *SUMO Road Networks*, https://sumo.dlr.de/docs/Networks/SUMO_Road_Networks.html.
    """
    root = parse_tree(read_bytes(file), FilePath(file).name)
    if root.tag != "net":
        raise InputError(f"root element must be net, was {root.tag[:40]!r}")
    net = SumoNet(root, move_to_origin(partial(_visit, root), origin))
    if not net.edge_ids:
        raise InputError("net must hold an edge with a lane, held none")
    return net


def _visit(root: Element, move: Move) -> None:
    """Move the corners of all lanes."""
    for element in root.iterfind("edge/lane"):
        corners = []
        for corner in (element.get("shape") or "").split():
            x, *rest = corner.split(",")
            corners.append(",".join((*move(x, rest[0]), *rest[1:])) if rest else x)
        if corners:
            element.set("shape", " ".join(corners))


def _text(element: Element, key: str) -> str:
    return (element.get(key) or "").strip()[:500]


def _shape(text: str, where: str) -> Array:
    """Return the corners of a shape; heights are left out."""
    rows = []
    for corner in text.split():
        x, y = (*corner.split(","), "", "")[:2]
        rows.append([
            read_real(f"shape of {where}", value, ge=-MAX_COORDINATE, le=MAX_COORDINATE) for value in (x, y)
        ])  # fmt: skip
    points = np.array(rows).reshape(-1, 2)
    distinct = np.append(True, np.hypot(*np.diff(points, axis=0).T) > 1e-3)[: len(points)]
    if np.count_nonzero(distinct) < 2:
        raise InputError(f"shape of {where} must have two different points, was {text[:60]!r}")
    corners: Array = points[distinct]
    return corners
