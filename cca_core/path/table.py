"""Positions of tables with a header (CSV)."""

import csv
import io
import re
from itertools import islice
from typing import Any

from cca_core.errors import InputError
from cca_core.path.fixes import Fixes, to_number

_NAMES = {
    "lat": ("latitude", "lat"),
    "lon": ("longitude", "lon", "long", "lng"),
    "x": ("x", "east", "easting"),
    "y": ("y", "north", "northing"),
    "z": ("elevation", "ele", "elev", "altitude", "alt", "height", "z"),
    "t": ("time", "timestamp", "t", "datetime", "utc", "date"),
    "status": ("status",),
}
_AROUND = {"gps", "gnss", "wgs84", "deg", "degree", "degrees", "dd", "m", "meter", "meters", "metres", "s",
           "sec", "position", "pos", "utm", "local"}  # fmt: skip
_OTHER = {"orientation", "velocity", "acceleration", "linear", "angular", "twist", "covariance", "std",
          "error", "accuracy", "magnetic", "rad", "radians"}  # fmt: skip
_HEADER_ROWS = 20  # in which the header is sought
_MAX_COLUMNS = 1000


def read_table(data: bytes, name: str) -> Fixes:
    """Return the positions of a table: latitude and longitude, or x and y in meters."""
    text = _decoded(data)
    for delimiter in ",;\t":
        rows = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
        try:
            for header in islice(rows, _HEADER_ROWS):
                columns = _columns(header[:_MAX_COLUMNS])
                if {"lat", "lon"} <= columns.keys() or {"x", "y"} <= columns.keys():
                    return _read_rows(rows, columns, decimal_comma=delimiter != ",")
        except csv.Error as error:
            raise InputError(f"file {name!r} is broken in line {rows.line_num}: {error}") from None
    first = text[:200].strip().partition("\n")[0]
    raise InputError(
        f"file {name!r} must have a header with a latitude and a longitude column "
        f"(such as lat, lon), or with x and y in meters, had {first[:80]!r}"
    )


def _decoded(data: bytes) -> str:
    """Return the text of UTF-8, UTF-16 with its mark, or one byte for each character."""
    for encoding in ("utf-16",) if data[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig",):
        try:
            return data.decode(encoding)
        except UnicodeDecodeError:
            pass
    return data.decode("latin-1")


def _columns(header: list[str]) -> dict[str, int]:
    """Return the column of each quantity that the header names."""
    found: dict[str, int] = {}
    words = [_words(cell) for cell in header]
    for quantity, names in _NAMES.items():
        exact = [i for name in names for i, cell in enumerate(words) if cell == [name]]
        around = [
            i for i, cell in enumerate(words) if len(hits := set(cell) - _AROUND) == 1 and hits <= set(names)
        ]
        if exact or around:
            found[quantity] = (exact or around)[0]
    return found


def _words(cell: str) -> list[str]:
    """Return the words of a column's name, without what stands before the last point or slash."""
    cell = cell[:80].strip().lower()
    if _OTHER & set(re.findall(r"[a-z]+", cell)):
        return []
    units = re.sub(r"[\[({].*", " ", cell)  # lat [deg]
    last = re.split(r"[./:]", units.strip(" ./:"))[-1]
    return re.findall(r"[a-z0-9]+", last)


def _read_rows(rows: Any, columns: dict[str, int], *, decimal_comma: bool) -> Fixes:
    in_meters = not {"lat", "lon"} <= columns.keys()
    fixes = Fixes("line", in_meters=in_meters)
    first, second, z, t = (
        columns.get(q, -1) for q in (("x", "y") if in_meters else ("lat", "lon")) + ("z", "t")
    )
    status = columns.get("status", -1)

    def cell(row: list[str], column: int) -> str | None:
        if not 0 <= column < len(row):
            return None
        return row[column].replace(",", ".") if decimal_comma else row[column]

    for row in rows:
        if not row:
            continue
        has_fix = not to_number(cell(row, status)) < 0.0  # of ROS: -1 without a fix
        pair = (cell(row, first), cell(row, second)) if has_fix else (None, None)
        fixes.add(*pair, cell(row, z), cell(row, t), rows.line_num)
    return fixes
