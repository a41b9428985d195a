"""Lanes along a path."""

import math
from collections.abc import Iterable, Sequence
from importlib import import_module
from pathlib import Path as FilePath
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_array, check_real, check_reals
from cca_core.errors import InputError
from cca_core.path.lane import Lane
from cca_core.path.local_frame import LocalFrame
from cca_core.path.path import Path
from cca_core.path.road_file import read_route

_SIGMA_ELEVATION = 3.0  # of heights of satellite receivers [m]


class Road:
    """A route with its lanes and road edges.

    Parameters
    ----------
    path : Path
        The route: the center line of the ego lane.
    lanes : sequence of Lane, optional
        All lanes; one lane must contain d = 0. The default is the ego lane alone, 3.5 m wide.
    speed_limit : float
        Legal speed [m/s]; without effect if `speed_limits` is given.
    stop_lines : sequence of float
        Stations at which the ego stops to yield to crossing traffic [m].
    elevation : array_like, shape (n, 2), optional
        Stations and heights of the route in the local frame [m], stations increasing, heights linear between
        them. A height that is NaN is unknown, as are those before the first and behind the last station. By
        default the route is level, at height 0.
    sigma_elevation : float
        Standard deviation of these heights [m].
    speed_limits : array_like, shape (n, 2), optional
        Stations [m], increasing, from each of which on a legal speed [m/s] holds; the first one holds before
        its station too. `speed_limit` is then the highest of them.

    Raises
    ------
    InputError
        If `path` is not a `Path`, a speed limit is not positive, or the stations of `elevation` or
        `speed_limits` do not increase. If no lane of direction 1 contains the route all along it.
    """

    def __init__(
        self,
        path: Path,
        lanes: Sequence[Lane] | None = None,
        speed_limit: float = 36.0,
        stop_lines: Sequence[float] = (),
        elevation: ArrayLike | None = None,
        sigma_elevation: float = 0.0,
        speed_limits: ArrayLike | None = None,
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
        self.speed_limits = None if speed_limits is None else _check_limits(speed_limits)
        if self.speed_limits is not None:
            self.speed_limit = float(self.speed_limits[:, 1].max())
        self.ego_lane = self._find_ego_lane()
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
        """Lateral offset of the right road edge [m]; the outermost one if it varies."""
        return min(lane.outer_bounds[0] for lane in self.lanes)

    @property
    def left_edge(self) -> float:
        """Lateral offset of the left road edge [m]; the outermost one if it varies."""
        return max(lane.outer_bounds[1] for lane in self.lanes)

    def edges_at(self, s: float) -> tuple[float, float]:
        """Road edges at a station.

        Parameters
        ----------
        s : float
            Station [m].

        Returns
        -------
        right, left : float
            Lateral offsets of the right and the left road edge [m], left positive; those at the end of the
            route beyond it.

        Raises
        ------
        InputError
            If `s` is no real number.
        """
        s = min(max(check_real("s", s), self.path.start), self.path.end)
        bounds = [bounds for lane in self.lanes if (bounds := lane.bounds_at(s)) is not None]
        return min(right for right, _ in bounds), max(left for _, left in bounds)

    def highest_limit(self, start: float, end: float) -> float:
        """Highest legal speed on a part of the route.

        Parameters
        ----------
        start, end : float
            Stations [m]; the same twice for the legal speed at a station.

        Returns
        -------
        v : float
            Speed [m/s].
        """
        if self.speed_limits is None:
            return self.speed_limit
        at, limits = self.speed_limits.T
        first = max(int(np.searchsorted(at, start, side="right")) - 1, 0)
        last = max(int(np.searchsorted(at, end, side="right")), first + 1)
        return float(limits[first:last].max())

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

    def lane_at(self, d: float, s: float | None = None) -> Lane | None:
        """Lane at a lateral offset.

        Parameters
        ----------
        d : float
            Lateral offset [m], left positive.
        s : float, optional
            Station [m]. By default lanes are taken to be as long as the road, with their nominal width.

        Returns
        -------
        lane : Lane or None
            The lane that contains `d`; None off the road.

        Raises
        ------
        InputError
            If `d` or `s` is no real number.
        """
        d = check_real("d", d, allow_inf=True)
        if s is None:
            return next((lane for lane in self.lanes if lane.right <= d <= lane.left), None)
        s = check_real("s", s)
        bounds = ((lane, lane.bounds_at(s)) for lane in self.lanes)
        return next((lane for lane, at in bounds if at is not None and at[0] <= d <= at[1]), None)

    def _find_ego_lane(self) -> Lane:
        """Return the lane that contains the route all along it."""
        for lane in self.lanes:
            bounds = lane.inner_bounds(self.path.start, self.path.end)
            if bounds is not None and bounds[0] <= 0.0 <= bounds[1]:
                if lane.direction != 1 or not bounds[0] < bounds[1]:
                    break
                return lane
        raise InputError("lanes must contain the route (d = 0) all along in one lane of direction 1")


def _check_limits(limits: ArrayLike) -> Array:
    """Return stations and speed limits as a read-only table."""
    table = check_array("speed_limits", limits, (None, 2))
    if not len(table) or not (np.diff(table[:, 0]) > 0.0).all() or not (table[:, 1] > 0.0).all():
        raise InputError("speed_limits must be increasing stations and positive speeds, was not")
    table.setflags(write=False)
    return table


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
