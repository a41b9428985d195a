"""Tracks and lines of GPX and KML files."""

from cca_core._files import XmlTarget, parse_xml
from cca_core.path.fixes import Fixes

_GPX_PARTS = {"trk": "trkpt", "trkseg": "trkpt", "rte": "rtept"}
_GPX_VALUES = "ele", "time"
_KML_VALUES = "coordinates", "when", "coord"


def read_gpx(data: bytes, name: str) -> Fixes:
    """Return the track points of a GPX file, else its route points, else its waypoints."""
    gpx = _Gpx()
    parse_xml(data, gpx, name)
    return next((fixes for fixes in gpx.found.values() if fixes.rows), Fixes())


def read_kml(data: bytes, name: str) -> Fixes:
    """Return the lines and tracks of a KML file, else its single points."""
    kml = _Kml()
    parse_xml(data, kml, name)
    return kml.lines if kml.lines.rows else kml.points


class _TextTarget(XmlTarget):
    """Keeps the text of some elements."""

    def __init__(self) -> None:
        super().__init__()
        self._text: list[str] | None = None

    def data(self, text: str, /) -> None:
        if self._text is not None:
            self._text.append(text)

    def _taken(self) -> str:
        text, self._text = "".join(self._text or ()), None
        return text


class _Gpx(_TextTarget):
    """Points by kind, with elevation and time."""

    def __init__(self) -> None:
        super().__init__()
        self.found = {kind: Fixes() for kind in ("trkpt", "rtept", "wpt")}
        self._point: dict[str, str] | None = None
        self._point_depth = 0
        self._values: dict[str, str] = {}

    def start(self, tag: str, attributes: dict[str, str], /) -> None:
        super().start(tag, attributes)
        name = tag.rpartition(":")[2]
        if name in _GPX_PARTS:
            self.found[_GPX_PARTS[name]].begin_part()
        elif name in self.found:
            self._point, self._point_depth, self._values = attributes, self.depth, {}
        elif name in _GPX_VALUES and self._point is not None and self.depth == self._point_depth + 1:
            self._text = []

    def end(self, tag: str, /) -> None:
        name = tag.rpartition(":")[2]
        if self._point is not None:
            if self.depth == self._point_depth:
                point, self._point = self._point, None
                values = self._values
                self.found[name].add(
                    point.get("lat"), point.get("lon"), values.get("ele"), values.get("time")
                )
            elif name in _GPX_VALUES and self._text is not None:
                self._values[name] = self._taken()
        super().end(tag)


class _Kml(_TextTarget):
    """Lines, tracks and single points."""

    def __init__(self) -> None:
        super().__init__()
        self.lines, self.points = Fixes(), Fixes()
        self._owner = ""
        self._times: list[str] = []
        self._positions: list[list[str]] = []

    def start(self, tag: str, attributes: dict[str, str], /) -> None:
        super().start(tag, attributes)
        name = tag.rpartition(":")[2]
        if name in ("LineString", "Track", "Point", "LinearRing"):
            self._owner, self._times, self._positions = name, [], []
        elif name in _KML_VALUES and self._owner:
            self._text = []

    def end(self, tag: str, /) -> None:
        name = tag.rpartition(":")[2]
        if name in _KML_VALUES and self._text is not None:
            text = self._taken()
            if name == "when":
                self._times.append(text)
            elif name == "coord":
                self._positions.append(text.split())
            else:
                self._positions += [position.split(",") for position in text.split()]
        elif name == self._owner:
            self._keep(self.points if name == "Point" else self.lines)
            self._owner = ""
        super().end(tag)

    def _keep(self, fixes: Fixes) -> None:
        """Keep the places of a line; those of an outline are no route."""
        if self._owner == "LinearRing":
            return
        if self._owner != "Point":
            fixes.begin_part()
        times = self._times if len(self._times) == len(self._positions) else [""] * len(self._positions)
        for position, t in zip(self._positions, times, strict=True):
            lon, lat, z = (*position, "", "", "")[:3]
            fixes.add(lat, lon, z, t)
