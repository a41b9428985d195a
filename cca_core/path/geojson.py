"""Lines of GeoJSON files."""

from typing import Any

from cca_core._files import parse_json
from cca_core.errors import InputError
from cca_core.path.fixes import Fixes, Text

_LINES = {"Point": 0, "MultiPoint": 1, "LineString": 1, "MultiLineString": 2}
"""Geometry to the depth of lists around its positions."""


def read_geojson(data: bytes, name: str) -> Fixes:
    """Return the lines of a GeoJSON file, else its points."""
    lines, points = Fixes(), Fixes()
    waiting = [(parse_json(data, f"file {name!r}"), None)]
    while waiting:
        value, times = waiting.pop()
        if not isinstance(value, dict):
            raise InputError(f"file {name!r} must hold GeoJSON objects, had a {type(value).__name__}")
        inner = value.get("features", value.get("geometries"))
        if isinstance(inner, list):
            waiting += [(item, times) for item in reversed(inner)]
        elif value.get("geometry") is not None:
            properties = value.get("properties")
            times = properties.get("coordTimes") if isinstance(properties, dict) else None
            waiting.append((value["geometry"], times))
        elif isinstance(kind := value.get("type"), str) and kind in _LINES:
            _add(lines if "Line" in kind else points, value.get("coordinates"), _LINES[kind], times)
    return lines if lines.rows else points


def _add(fixes: Fixes, coordinates: Any, depth: int, times: Any) -> None:
    """Add the positions in `depth` lists around them, in order."""
    nested = coordinates if isinstance(coordinates, list) else [None]
    if depth == 2:
        several = times if isinstance(times, list) and len(times) == len(nested) else [None] * len(nested)
        for line, its_times in zip(nested, several, strict=True):
            _add(fixes, line, 1, its_times)
        return
    if depth == 0:
        nested = [nested]
    elif fixes.rows or depth == 1:
        fixes.begin_part()
    moments = times if isinstance(times, list) and len(times) == len(nested) else [None] * len(nested)
    for position, t in zip(nested, moments, strict=True):
        values = [_text(item) for item in position[:3]] if isinstance(position, list) else []
        lon, lat, z = (*values, None, None, None)[:3]
        fixes.add(lat, lon, z, _text(t))


def _text(value: Any) -> Text:
    """Return a number or text of JSON; None for anything else."""
    if isinstance(value, (str, float)):
        return value
    is_small = isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**1023
    return float(value) if is_small else None
