"""Lanes along a path."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path as FilePath
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_real, check_reals, shown
from cca_core.errors import InputError
from cca_core.path.local_frame import LocalFrame
from cca_core.path.path import Path
from cca_core.path.road_file import read_route

_SIGMA_ELEVATION = 3.0  # of heights of satellite receivers [m]


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
    elevation : array_like, shape (n, 2), optional
        Stations and heights of the route in the local frame [m], stations increasing, heights linear between
        them. A height that is NaN is unknown, as are those before the first and behind the last station. By
        default the route is level, at height 0.
    sigma_elevation : float
        Standard deviation of these heights [m].

    Raises
    ------
    InputError
        If `path` is not a `Path`, no lane contains the route, the speed limit is not positive, or the
        stations of `elevation` do not increase.
    """

    def __init__(
        self,
        path: Path,
        lanes: Sequence[Lane] | None = None,
        speed_limit: float = 36.0,
        stop_lines: Sequence[float] = (),
        elevation: ArrayLike | None = None,
        sigma_elevation: float = 0.0,
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
        self.stop_lines = check_reals("stop_lines", stop_lines)
        self.elevation = None if elevation is None else _check_elevation(elevation)
        self.sigma_elevation = check_real("sigma_elevation", sigma_elevation, ge=0.0)
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
            Index of the only part (track, segment, line) of the file that is used [-]; by default all of
            them, in file order.
        max_gap : float
            Largest distance between two parts that are joined [m].
        origin : tuple of float, optional
            Origin of the local frame, as for `Waypoints.to_local`; by default the first waypoint of the file,
            or of the part if that is more than 1000 km away.
        skip_invalid : bool
            As for `read_waypoints`.
        **fit : Any
            Further arguments of `fit_path`, such as ``tolerance``.

        Returns
        -------
        road : Road
            The cleaned and fitted route. Its ``frame`` is the local frame of a file with latitude and
            longitude. Its ``elevation`` are the heights of the file above the first one, if there are any.

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
        max_gap = check_real("max_gap", max_gap, gt=0.0)
        path, heights, frame = read_route(file, part, max_gap, origin, skip_invalid, fit)
        road = cls(path, lanes, speed_limit, stop_lines, heights, _SIGMA_ELEVATION)
        road.frame = frame
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

    def height_range(self, start: float, end: float) -> tuple[float, float]:
        """Lowest and highest height of a part of the route.

        Parameters
        ----------
        start, end : float
            Stations [m].

        Returns
        -------
        low, high : float
            Heights in the local frame [m]; NaN if one is unknown.
        """
        if self.elevation is None:
            return 0.0, 0.0
        s, z = self.elevation.T
        within = z[(s > start) & (s < end)]
        heights = np.append(within, np.interp((start, end), s, z, left=math.nan, right=math.nan))
        return float(heights.min()), float(heights.max())

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

        Raises
        ------
        InputError
            If `d` is no real number.
        """
        d = check_real("d", d, allow_inf=True)
        return next((lane for lane in self.lanes if lane.right <= d <= lane.left), None)


def _check_elevation(elevation: ArrayLike) -> Array:
    """Return stations and heights as a read-only table; unknown heights are NaN."""
    words = "elevation must be finite, increasing stations and heights of shape (n, 2)"
    try:
        table = np.array(elevation, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{words}, was {type(elevation).__name__}") from None
    if table.ndim != 2 or table.shape[1] != 2 or not len(table):
        raise InputError(f"{words}, had shape {table.shape}")
    s, z = table.T
    if not (np.isfinite(s).all() and (np.diff(s) > 0.0).all() and not np.isinf(z).any()):
        raise InputError(f"{words}, was not")
    table.setflags(write=False)
    return table
