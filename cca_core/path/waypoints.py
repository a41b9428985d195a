"""Waypoints from GPX and CSV files."""

import csv
from dataclasses import dataclass
from pathlib import Path as FilePath
from xml.etree import ElementTree

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError

_COLUMNS = {
    "latitude": ("latitude", "lat", "latitude_deg"),
    "longitude": ("longitude", "lon", "long", "lng", "longitude_deg"),
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Waypoints:
    """Geodetic waypoints as read from a file.

    Parameters
    ----------
    lat, lon : ndarray, shape (n,)
        Geodetic latitude and longitude [deg], in driving order, no two neighbors equal.
    duplicates : int
        Number of dropped rows that repeat the row before [-].
    """

    lat: Array
    lon: Array
    duplicates: int


def read_waypoints(file: str | FilePath) -> Waypoints:
    """Read a route from a GPX track or a CSV table.

    Parameters
    ----------
    file : str or pathlib.Path
        File with the ending ``.gpx`` (track points, else route points, else waypoints) or ``.csv`` (with a
        header that names a latitude and a longitude column, in degrees).

    Returns
    -------
    waypoints : Waypoints
        The points in file order; neighbors that are equal are merged and counted.

    Raises
    ------
    InputError
        If the file cannot be read, is broken, has fewer than two points, or a value is out of range.
    """
    try:
        file = FilePath(file)
    except TypeError:
        raise InputError(f"file must be a path, was {file!r}") from None
    readers = {".gpx": _read_gpx, ".csv": _read_csv}
    if file.suffix.lower() not in readers:
        raise InputError(f"file must end in .gpx or .csv, was {file.name!r}")
    try:
        pairs = readers[file.suffix.lower()](file)
    except OSError as error:
        raise InputError(f"file {str(file)!r} cannot be read: {error.strerror}") from None
    except InputError:
        raise
    except (ElementTree.ParseError, LookupError, ValueError, csv.Error) as error:
        raise InputError(f"file {file.name!r} is broken: {error}") from None
    if len(pairs) < 2:
        raise InputError(f"file {file.name!r} must have at least two points, had {len(pairs)}")
    table = np.array(pairs)
    for column, name, limit in ((0, "latitude", 90.0), (1, "longitude", 180.0)):
        bad = ~(np.abs(table[:, column]) <= limit)
        if bad.any():
            row = int(np.argmax(bad))
            hint = (
                "; are latitude and longitude mixed up?" if limit < abs(table[row, column]) <= 180.0 else ""
            )
            raise InputError(
                f"{name} must be within +-{limit:g} deg, was {table[row, column]:g} "
                f"in point {row} of {file.name!r}{hint}"
            )
    keep = np.concatenate(([True], (np.diff(table, axis=0) != 0.0).any(axis=1)))
    if keep.sum() < 2:
        raise InputError(f"file {file.name!r} must have at least two different points")
    table = table[keep]
    table.setflags(write=False)
    return Waypoints(lat=table[:, 0], lon=table[:, 1], duplicates=int((~keep).sum()))


def _read_gpx(file: FilePath) -> list[tuple[float, float]]:
    root = ElementTree.parse(file).getroot()
    for tag in ("trkpt", "rtept", "wpt"):
        points = [e for e in root.iter() if e.tag.rpartition("}")[2] == tag]
        if points:
            return [
                _pair(e.get("lat"), e.get("lon"), f"point {i} of {file.name!r}") for i, e in enumerate(points)
            ]
    return []


def _read_csv(file: FilePath) -> list[tuple[float, float]]:
    with file.open(newline="", encoding="utf-8-sig") as stream:
        rows = csv.reader(stream)
        header = [cell.strip().lower() for cell in next(rows, [])]
        lat, lon = (
            next((i for i, cell in enumerate(header) if cell in names), None) for names in _COLUMNS.values()
        )
        if lat is None or lon is None:
            raise InputError(
                f"file {file.name!r} must have a header with a latitude and a longitude column "
                f"({'; '.join(', '.join(names) for names in _COLUMNS.values())}) and commas between columns, "
                f"had {','.join(header)[:80]!r}"
            )
        pairs = []
        for row in rows:
            if not row:
                continue
            where = f"line {rows.line_num} of {file.name!r}"
            if len(row) <= max(lat, lon):
                raise InputError(f"{where} has too few columns")
            pairs.append(_pair(row[lat], row[lon], where))
        return pairs


def _pair(lat: str | None, lon: str | None, where: str) -> tuple[float, float]:
    try:
        return float(lat or ""), float(lon or "")
    except ValueError:
        raise InputError(
            f"latitude and longitude must be numbers, were {lat!r}, {lon!r} in {where}"
        ) from None
