"""Lanes along a path."""

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path as FilePath
from typing import Any, Self

import numpy as np

from cca_core._checks import Array, check_real, shown
from cca_core.errors import InputError
from cca_core.path.clean import clean_route
from cca_core.path.fit import fit_path
from cca_core.path.local_frame import LocalFrame
from cca_core.path.path import Path
from cca_core.path.waypoints import Waypoints, read_waypoints


@dataclass(frozen=True, slots=True, kw_only=True)
class Lane:
    """One lane of a road.

    Parameters
    ----------
    d : float
        Lateral offset of its center line [m], left of the route positive.
    width : float
        Width [m].
    direction : int
        Direction of travel [-]: 1 along the route, -1 against it.

    Raises
    ------
    InputError
        If a value is not finite, the width is not positive, or the direction is neither 1 nor -1.
    """

    d: float
    width: float = 3.5
    direction: int = 1

    def __post_init__(self) -> None:
        check_real("d", self.d)
        check_real("width", self.width, gt=0.0)
        if self.direction not in (1, -1):
            raise InputError(f"direction must be 1 or -1, was {shown(self.direction)}")

    @property
    def right(self) -> float:
        """Lateral offset of the right lane boundary [m]."""
        return self.d - 0.5 * self.width

    @property
    def left(self) -> float:
        """Lateral offset of the left lane boundary [m]."""
        return self.d + 0.5 * self.width


class Road:
    """A route with its lanes and road edges.

    Parameters
    ----------
    path : Path
        The route: the center line of the ego lane.
    lanes : sequence of Lane, optional
        All lanes; one lane must contain d = 0. The default is the ego lane alone, 3.5 m wide.
    speed_limit : float
        Legal speed [m/s].
    stop_lines : sequence of float
        Stations at which the ego stops to yield to crossing traffic [m].

    Raises
    ------
    InputError
        If `path` is not a `Path`, no lane contains the route, or the speed limit is not positive.
    """

    def __init__(
        self,
        path: Path,
        lanes: Sequence[Lane] | None = None,
        speed_limit: float = 36.0,
        stop_lines: Sequence[float] = (),
    ) -> None:
        if not isinstance(path, Path):
            raise InputError(f"path must be a Path, was {type(path).__name__}")
        self.path = path
        given: object = (Lane(d=0.0),) if lanes is None else lanes
        lanes = tuple(given) if isinstance(given, Iterable) else ()
        if not lanes or not all(isinstance(lane, Lane) for lane in lanes):
            raise InputError(f"lanes must be a sequence of Lane, was {given!r}")
        self.lanes = tuple(sorted(lanes, key=lambda lane: lane.d))
        self.speed_limit = check_real("speed_limit", speed_limit, gt=0.0)
        self.stop_lines = tuple(check_real("stop_lines", line) for line in stop_lines)
        ego_lane = self.lane_at(0.0)
        if ego_lane is None or ego_lane.direction != 1:
            raise InputError("lanes must contain the route (d = 0) in a lane of direction 1")
        self.ego_lane = ego_lane
        self.frame: LocalFrame | None = None

    @classmethod
    def from_file(
        cls,
        file: str | FilePath,
        lanes: Sequence[Lane] | None = None,
        speed_limit: float = 36.0,
        stop_lines: Sequence[float] = (),
        *,
        part: int | None = None,
        max_gap: float = 100.0,
        origin: tuple[float, float] | None = None,
        skip_invalid: bool = True,
        **fit: Any,
    ) -> Self:
        """Make a road along the route in a file.

        Parameters
        ----------
        file : str or pathlib.Path
            GPX, KML, GeoJSON, NMEA or table, as for `read_waypoints`.
        lanes : sequence of Lane, optional
            As for `Road`.
        speed_limit : float
            As for `Road` [m/s].
        stop_lines : sequence of float
            As for `Road` [m].
        part : int, optional
            Index of the only part (track, segment, line) of the file that is used [-]; by default all of them,
            in file order.
        max_gap : float
            Largest distance between two parts that are joined [m].
        origin : tuple of float, optional
            Origin of the local frame, as for `Waypoints.to_local`.
        skip_invalid : bool
            As for `read_waypoints`.
        **fit : Any
            Further arguments of `fit_path`, such as ``tolerance``.

        Returns
        -------
        road : Road
            The cleaned and fitted route. Its ``frame`` is the local frame of a file with latitude and
            longitude.

        Raises
        ------
        InputError
            If the file is refused by `read_waypoints`, its parts are too far apart, or an argument is out of
            range.
        InfeasibleError
            If no path fits the waypoints within the limits given to `fit_path`.

        Warns
        -----
        UserWarning
            If parts were joined.
        """
        points = read_waypoints(file, skip_invalid=skip_invalid)
        xy = points.to_local(origin)
        rows = _rows_of(points, xy, part, check_real("max_gap", max_gap, gt=0.0), FilePath(file).name)
        route = clean_route(xy[rows])
        if len(route.parts) > 1:
            raise InputError(
                f"file {FilePath(file).name!r} must have no gap within a part, had {len(route.report.gaps)}, after "
                f"the points {(rows.start + route.report.gaps[:5]).tolist()} of the part"
            )
        road = cls(fit_path(route.parts[0], **fit), lanes, speed_limit, stop_lines)
        if not len(points.xy):
            lat0, lon0 = (points.lat[0], points.lon[0]) if origin is None else origin
            road.frame = LocalFrame(lat0, lon0)
        return road

    def __repr__(self) -> str:
        return f"Road({self.path!r}, {len(self.lanes)} lanes, {self.speed_limit:g} m/s)"

    def _repr_svg_(self) -> str:
        svg: str = import_module("cca_core.plot.svg").to_svg(self)
        return svg

    @property
    def right_edge(self) -> float:
        """Lateral offset of the right road edge [m]."""
        return min(lane.right for lane in self.lanes)

    @property
    def left_edge(self) -> float:
        """Lateral offset of the left road edge [m]."""
        return max(lane.left for lane in self.lanes)

    def lane_at(self, d: float) -> Lane | None:
        """Lane at a lateral offset.

        Parameters
        ----------
        d : float
            Lateral offset [m], left positive.

        Returns
        -------
        lane : Lane or None
            The lane that contains `d`; None off the road.
        """
        return next((lane for lane in self.lanes if lane.right <= d <= lane.left), None)


def _rows_of(points: Waypoints, xy: Array, part: int | None, max_gap: float, name: str) -> slice:
    """Return the rows of one part, or of all if they can be joined."""
    starts = [*points.parts.tolist(), len(xy)]
    n = len(starts) - 1
    if part is not None:
        if part not in range(n):
            raise InputError(f"part must be 0 to {n - 1} for file {name!r}, was {shown(part)}")
        if starts[part + 1] - starts[part] < 2:
            raise InputError(f"part {part} of file {name!r} must have at least two points, had 1")
        return slice(starts[part], starts[part + 1])
    inner = np.array(starts[1:-1], dtype=np.intp)
    gaps = np.hypot(*(xy[inner] - xy[inner - 1]).T)
    if gaps.max(initial=0.0) > max_gap:
        far = int(np.argmax(gaps > max_gap))
        raise InputError(
            f"file {name!r} has {n} parts; those before and after point {inner[far]} must be at most {max_gap:g} m "
            f"apart, were {gaps[far]:.0f} m; give part=, or a larger max_gap="
        )
    if n > 1:
        text = f"file {name!r} has {n} parts, which were joined over gaps of up to {gaps.max():.0f} m"
        warnings.warn(text, stacklevel=3)
    return slice(0, len(xy))
