"""Waypoints from files."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path as FilePath

import numpy as np

from cca_core._checks import Array, Index, check_bool
from cca_core._files import read_bytes
from cca_core.errors import InputError
from cca_core.path.fixes import Fixes
from cca_core.path.geojson import read_geojson
from cca_core.path.local_frame import LocalFrame
from cca_core.path.nmea import read_nmea
from cca_core.path.table import read_table
from cca_core.path.track_xml import read_gpx, read_kml
from cca_core.vehicle import MAX_COORDINATE

_MAX_METERS = 2e7  # from the origin of a projection
_MAX_ELEVATION = 1e5  # [m]


def _read_text(data: bytes, name: str) -> Fixes:
    return read_nmea(data, name) if data.lstrip()[:1] in (b"$", b"!") else read_table(data, name)


_READERS: dict[str, Callable[[bytes, str], Fixes]] = {
    ".gpx": read_gpx, ".kml": read_kml, ".geojson": read_geojson, ".json": read_geojson,
    ".nmea": read_nmea, ".csv": read_table, ".tsv": read_table, ".txt": _read_text, ".log": _read_text,
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Waypoints:
    """Waypoints as read from a file, in driving order, no two neighbors equal.

    Parameters
    ----------
    lat, lon : ndarray, shape (n,)
        Geodetic latitude and longitude [deg]; empty if the file has x and y.
    duplicates : int
        Number of dropped rows that repeat the row before [-].
    skipped : int
        Number of rows without a position [-].
    parts : ndarray of int, shape (p,)
        Row at which each part begins: track, segment, line. The first is 0.
    z, t : ndarray, shape (n,)
        Elevation [m] and time [s]; NaN where the file has none. Dates count from 1970 in UTC.
    xy : ndarray, shape (n, 2)
        Positions [m] of a file with x and y; else empty.
    """

    lat: Array
    lon: Array
    duplicates: int
    skipped: int = 0
    parts: Index = field(default_factory=lambda: np.zeros(1, dtype=np.intp))
    z: Array = field(default_factory=lambda: np.empty(0))
    t: Array = field(default_factory=lambda: np.empty(0))
    xy: Array = field(default_factory=lambda: np.empty((0, 2)))

    def __repr__(self) -> str:
        n = max(len(self.lat), len(self.xy))
        counts = f"{len(self.parts)} parts, {self.duplicates} duplicates and {self.skipped} skipped rows"
        return f"Waypoints({n} points, {counts})"

    def to_local(self, origin: tuple[float, float] | None = None) -> Array:
        """Project the waypoints into a plane.

        Parameters
        ----------
        origin : tuple of float, optional
            Latitude and longitude [deg] of the origin, by default the first waypoint. For a file with x and
            y their values [m] there, by default 0.

        Returns
        -------
        xy : ndarray, shape (n, 2)
            East and north [m], or x and y [m].

        Raises
        ------
        InputError
            If the origin is invalid, or a point is more than 1000 km from it.
        """
        if not len(self.xy):
            lat0, lon0 = (self.lat[0], self.lon[0]) if origin is None else _pair(origin)
            return LocalFrame(lat0, lon0).to_local(self.lat, self.lon)
        xy: Array = self.xy - np.array((0.0, 0.0) if origin is None else _pair(origin), dtype=np.float64)
        if not np.abs(xy).max() <= MAX_COORDINATE:
            raise InputError(
                f"x and y must be within {MAX_COORDINATE / 1e3:g} km of origin, "
                f"were up to {np.abs(xy).max():g} m; give origin=({self.xy[0, 0]:g}, {self.xy[0, 1]:g})"
            )
        return xy


def read_waypoints(file: str | FilePath, *, skip_invalid: bool = True) -> Waypoints:
    """Read a route from a file of at most 50 MB.

    Parameters
    ----------
    file : str or pathlib.Path
        The ending of its name gives the format:

        - ``.gpx``: track points, else route points, else waypoints.
        - ``.csv``, ``.tsv``, ``.txt``: a table with a header and commas, semicolons or tabs. It names
          latitude and longitude in degrees (``lat``, ``latitude``, ``lat_deg``, ``field.latitude``), or
          ``x`` and ``y`` in meters.
        - ``.geojson``, ``.json``: lines, else points.
        - ``.kml``: lines and tracks, else points.
        - ``.nmea``, ``.log``, ``.txt``: sentences RMC and GGA.

    skip_invalid : bool
        Whether rows without a position are skipped and counted, instead of an error: empty cells, no number,
        no fix of the receiver, or latitude and longitude 0 far from the other rows.

    Returns
    -------
    waypoints : Waypoints
        The points in file order, with their parts, elevations and times. Neighbors that are equal are merged
        and counted.

    Raises
    ------
    InputError
        If the file cannot be read, is too large, too deep or broken, has a document type declaration or fewer
        than two points, or a value is out of range.
    """
    check_bool("skip_invalid", skip_invalid)
    data = read_bytes(file)
    file = FilePath(file)
    reader = _READERS.get(file.suffix.lower())
    if reader is None:
        raise InputError(f"file must end in {', '.join(_READERS)}, was {file.name!r}")
    fixes = reader(data, file.name)
    rows, starts, skipped = fixes.numbers(file.name, skip_invalid=skip_invalid)
    if len(rows) < 2:
        without = f"; {skipped} without a position were skipped" if skipped else ""
        raise InputError(f"file {file.name!r} must have at least two points, had {len(rows)}{without}")
    table = np.array(rows)
    _check_range(table, file.name, in_meters=fixes.in_meters)
    keep = np.concatenate(([True], (np.diff(table[:, :2], axis=0) != 0.0).any(axis=1)))
    if keep.sum() < 2:
        raise InputError(f"file {file.name!r} must have at least two different points")
    before = np.concatenate(([0], np.cumsum(keep)))  # kept rows before each row
    parts = np.unique(before[[0, *starts]])
    parts = parts[parts < before[-1]].astype(np.intp)
    table = table[keep]
    table[~(np.abs(table[:, 2]) <= _MAX_ELEVATION), 2] = np.nan
    for array in (table, parts):
        array.setflags(write=False)
    first, second, z, t = table.T
    nothing = table[:0, 0]
    return Waypoints(
        lat=nothing if fixes.in_meters else first, lon=nothing if fixes.in_meters else second,
        xy=table[:, :2] if fixes.in_meters else table[:0, :2], z=z, t=t, parts=parts,
        duplicates=int((~keep).sum()), skipped=skipped,
    )  # fmt: skip


def _pair(origin: object) -> tuple[float, float]:
    if not isinstance(origin, (tuple, list)) or len(origin) != 2:
        raise InputError("origin must be a pair of numbers")
    return origin[0], origin[1]


def _check_range(table: Array, name: str, *, in_meters: bool) -> None:
    """Raise if a position is out of range."""
    names = ("x", "y") if in_meters else ("latitude", "longitude")
    for column, limit in enumerate((_MAX_METERS, _MAX_METERS) if in_meters else (90.0, 180.0)):
        bad = ~(np.abs(table[:, column]) <= limit)
        if bad.any():
            row = int(np.argmax(bad))
            value, unit = float(table[row, column]), "m" if in_meters else "deg"
            hint = "; are latitude and longitude mixed up?" if limit < abs(value) <= 180.0 else ""
            raise InputError(
                f"{names[column]} must be within +-{limit:g} {unit}, was {value:g} in point {row} of "
                f"{name!r}{hint}"
            )
    if in_meters and np.ptp(table[:, :2], axis=0).max() < 1.0:
        raise InputError(f"x and y of {name!r} must extend over 1 m or more; are they degrees?")
