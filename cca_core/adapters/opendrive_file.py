"""Files of OpenDRIVE: roads with reference line, lanes, links and speed limits."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path as FilePath
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element

from cca_core._checks import read_real
from cca_core._files import parse_tree, read_bytes
from cca_core.adapters.local_origin import Move, Origin, move_to_origin
from cca_core.adapters.reference_line import Cubic, Geometry, PlanView
from cca_core.errors import InputError

__all__ = ["DRIVABLE", "Connection", "FileLane", "FileRoad", "Link", "read_roads"]

DRIVABLE = frozenset(
    ("driving", "entry", "exit", "onRamp", "offRamp", "connectingRamp", "slipLane", "bidirectional")
)
"""Types of lanes that cars drive on."""

_SPEED_UNITS = {"": 1.0, "m/s": 1.0, "km/h": 1.0 / 3.6, "mph": 0.44704}
_MAX_LENGTH = 1e6  # of a road [m]
_MAX_NUMBER = 1e9


class Link(NamedTuple):
    """Where a road goes on: in a road, at its start or end, or in a junction."""

    kind: str
    id: str
    at_start: bool


class Connection(NamedTuple):
    """A connection in a junction: into which road, at its start or end, and lanes from and to."""

    incoming: str
    road: str
    at_start: bool
    lanes: dict[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class FileLane:
    """A lane of one section; its records are over s of the road."""

    id: int
    kind: str
    widths: tuple[Cubic, ...]
    limits: tuple[tuple[float, float], ...]  # stations and speeds; infinite without a limit
    predecessors: tuple[int, ...]
    successors: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FileRoad:
    """A road of the file."""

    id: str
    length: float
    is_left_hand: bool
    view: PlanView
    offsets: tuple[Cubic, ...]
    heights: tuple[Cubic, ...]
    limits: tuple[tuple[float, float], ...]
    sections: tuple[tuple[float, dict[int, FileLane]], ...]  # start, and lanes by id
    predecessor: Link | None
    successor: Link | None

    def section_end(self, i: int) -> float:
        """Return the station at which a section ends."""
        return self.sections[i + 1][0] if i + 1 < len(self.sections) else self.length

    def section_at(self, s: float) -> int:
        """Return the section at a station."""
        return max(sum(start <= s for start, _ in self.sections) - 1, 0)

    def is_forward(self, lane_id: int) -> bool:
        """Whether traffic in a lane goes in the direction of s."""
        return (lane_id < 0) != self.is_left_hand


def read_roads(
    file: str | FilePath, origin: Origin | None
) -> tuple[dict[str, FileRoad], dict[str, list[Connection]], Origin]:
    """Return the roads of a file by id, the connections of its junctions by id, and the origin."""
    root = parse_tree(read_bytes(file), FilePath(file).name)
    if root.tag != "OpenDRIVE":
        raise InputError(f"root element must be OpenDRIVE, was {root.tag[:40]!r}")
    origin = move_to_origin(partial(_visit, root), origin)
    roads = {}
    for element in root.iterfind("road"):
        road = _road(element)
        if road.id in roads:
            raise InputError(f"id of road must be unique, {road.id!r} is not")
        roads[road.id] = road
    if not roads:
        raise InputError("OpenDRIVE must hold a road, held none")
    return roads, {_text(e, "id"): list(_connections(e)) for e in root.iterfind("junction")}, origin


def _visit(root: Element, move: Move) -> None:
    """Move the positions of all reference lines."""
    for element in root.iterfind("road/planView/geometry"):
        x, y = element.get("x"), element.get("y")
        if x is not None and y is not None:
            for key, text in zip("xy", move(x, y), strict=True):
                element.set(key, text)


def _text(element: Element | None, key: str) -> str:
    return "" if element is None else (element.get(key) or "").strip()[:200]


def _number(element: Element, key: str, where: str, default: float | None = None) -> float:
    text = element.get(key)
    if text is None and default is not None:
        return default
    return read_real(f"{key} of {element.tag[:40]} of {where}", text, ge=-_MAX_NUMBER, le=_MAX_NUMBER)


def _cubics(
    parent: Element | None, tag: str, where: str, key: str = "s", start: float = 0.0
) -> tuple[Cubic, ...]:
    if parent is None:
        return ()
    found = [
        Cubic(start + _number(e, key, where), *(_number(e, name, where, 0.0) for name in "abcd"))
        for e in parent.iterfind(tag)
    ]
    return tuple(sorted(found))


def _road(element: Element) -> FileRoad:
    id_ = _text(element, "id")
    where = f"road {id_!r}"
    length = read_real(f"length of {where}", element.get("length"), ge=0.0, le=_MAX_LENGTH)
    view, lanes, link = element.find("planView"), element.find("lanes"), element.find("link")
    geometries = [] if view is None else list(_geometries(view, where))
    if not geometries:
        raise InputError(f"{where} must have a planView with a geometry, had none")
    types = element.findall("type")
    limits = [(_number(e, "s", where, 0.0), _speed(e.find("speed"), where)) for e in types]
    sections = () if lanes is None else tuple(sorted(_sections(lanes, where), key=lambda section: section[0]))
    if not sections:
        raise InputError(f"{where} must have a laneSection, had none")
    links = (None if link is None else _link(link.find(tag)) for tag in ("predecessor", "successor"))
    predecessor, successor = links
    return FileRoad(
        id=id_, length=length, is_left_hand=_text(element, "rule") == "LHT", view=PlanView(geometries),
        offsets=_cubics(lanes, "laneOffset", where), limits=tuple(sorted(limits)), sections=sections,
        heights=_cubics(element.find("elevationProfile"), "elevation", where),
        predecessor=predecessor, successor=successor,
    )  # fmt: skip


def _geometries(view: Element, where: str) -> Iterator[Geometry]:
    for e in view.iterfind("geometry"):
        s, x, y, heading, length = (_number(e, key, where) for key in ("s", "x", "y", "hdg", "length"))
        if not length > 0.0:  # writers leave some of no length
            continue
        kinds = [child for child in e if child.tag in ("line", "arc", "spiral", "poly3", "paramPoly3")]
        if len(kinds) != 1:
            raise InputError(f"geometry of {where} must be a line, arc, spiral, poly3 or paramPoly3, was not")
        plain = Geometry(s=s, x=x, y=y, heading=heading, length=length)
        yield replace(plain, **_shape(kinds[0], length, where))


def _shape(kind: Element, length: float, where: str) -> dict[str, Any]:
    """Return the fields of a geometry that depend on its kind."""
    if kind.tag == "arc":
        return {"curvature": (_number(kind, "curvature", where),) * 2}
    if kind.tag == "spiral":
        return {"curvature": (_number(kind, "curvStart", where), _number(kind, "curvEnd", where))}
    if kind.tag == "poly3":
        return {"u": (0.0, 1.0, 0.0, 0.0), "v": tuple(_number(kind, key, where) for key in "abcd")}
    if kind.tag == "paramPoly3":
        u, v = (tuple(_number(kind, f"{letter}{axis}", where) for letter in "abcd") for axis in "UV")
        return {"u": u, "v": v, "p_end": length if kind.get("pRange") == "arcLength" else 1.0}
    return {}


def _speed(element: Element | None, where: str) -> float:
    """Return a speed limit [m/s]; infinite if there is none."""
    text = _text(element, "max")
    if element is None or text in ("", "no limit", "undefined"):
        return math.inf
    unit = _text(element, "unit")
    if unit not in _SPEED_UNITS:
        raise InputError(f"unit of speed of {where} must be m/s, km/h or mph, was {unit!r}")
    value = read_real(f"max of speed of {where}", text, ge=-_MAX_NUMBER, le=_MAX_NUMBER)
    return value * _SPEED_UNITS[unit] if value > 0.0 else math.inf


def _sections(lanes: Element, where: str) -> Iterator[tuple[float, dict[int, FileLane]]]:
    for section in lanes.iterfind("laneSection"):
        start = _number(section, "s", where)
        found = {}
        for side in ("left", "right"):
            for element in section.iterfind(f"{side}/lane"):
                lane = _lane(element, start, where)
                found[lane.id] = lane
        yield start, found


def _lane(element: Element, start: float, where: str) -> FileLane:
    id_ = int(_number(element, "id", where))
    if element.find("width") is None and element.find("border") is not None:
        raise InputError(f"lane {id_} of {where} must have width records, had borders only")
    link = element.find("link")
    before, after = (
        () if link is None else tuple(int(_number(e, "id", where)) for e in link.iterfind(tag))
        for tag in ("predecessor", "successor")
    )
    limits = [(start + _number(e, "sOffset", where), _speed(e, where)) for e in element.iterfind("speed")]
    return FileLane(
        id=id_, kind=_text(element, "type"), widths=_cubics(element, "width", where, "sOffset", start),
        limits=tuple(sorted(limits)), predecessors=before, successors=after,
    )  # fmt: skip


def _link(element: Element | None) -> Link | None:
    if element is None:
        return None
    contact = _text(element, "contactPoint")
    return Link(_text(element, "elementType"), _text(element, "elementId"), contact != "end")


def _connections(junction: Element) -> Iterator[Connection]:
    where = f"junction {_text(junction, 'id')!r}"
    for e in junction.iterfind("connection"):
        lanes = {int(_number(k, "from", where)): int(_number(k, "to", where)) for k in e.iterfind("laneLink")}
        road = _text(e, "connectingRoad") or _text(e, "linkedRoad")
        yield Connection(_text(e, "incomingRoad"), road, _text(e, "contactPoint") != "end", lanes)
