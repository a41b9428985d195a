"""From waypoints to a `Path`: smoothing cubics that keep a tolerance and a curvature limit."""

import math

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, Index, Mask, check_points, check_real
from cca_core.errors import InfeasibleError, InputError
from cca_core.path.chords import bridge_gaps, chord_deviation, max_neighbor_chord
from cca_core.path.interpolate import over_arc_length
from cca_core.path.path import Path
from cca_core.path.smoothing import SmoothingSpline

_REPARAMETRIZATIONS = 4
_STRETCH = 1.2  # a fit this much longer than its chords is not taken as a parameter
_BENT = 0.5  # turn from border to border of the sharpest clothoid [rad]
_TURN = 0.1  # a segment turns by no more [rad], while it has points to be divided at
_LONGEST = 64  # points in the first segments of the adaptive fit
_ROUNDINGS = 30
_HEADROOM = 0.95  # of the curvature limit, for what arc length and re-interpolation change
_FREEDOM = 3.0  # tolerances that the path may swing off the chord of a gap
_SWING = 0.3  # of the longest chord nearby: by so much a path may swing off its chords beyond the tolerance
_DIVISIONS = 6  # of chords off which the path swings farther
_MISSED = 0.01  # of a waypoint beyond the tolerance, that is let pass [m]
_LOOKS = np.arange(1.0, 8.0) / 8.0  # between two points


def fit_path(
    xy: ArrayLike,
    *,
    tolerance: float = 0.3,
    points_per_segment: int = 4,
    segmentation: str = "equal",
    curvature_limit: float | None = None,
    closed: bool = False,
) -> Path:
    """Fit a smooth path through waypoints.

    Parameters
    ----------
    xy : array_like, shape (n, 2)
        Waypoints [m], in driving order, no two neighbors equal.
    tolerance : float
        Largest distance allowed between a waypoint and the path [m]. Within it the path is as smooth as
        it can be; 0 interpolates.
    points_per_segment : int
        Waypoints in each segment [-] of the equal segmentation; halved until the tolerance can be kept.
    segmentation : {"equal", "adaptive"}
        Segments of equal waypoint count, or as long as the tolerance allows.
    curvature_limit : float, optional
        Largest curvature of the path [1/m], such as that of a car's turning circle. Where limit and
        tolerance contradict each other the limit is kept, and the path passes as near as it can.
    closed : bool
        Whether the road leads from the last waypoint back to the first. The path then ends where it
        starts, with the same heading and curvature.

    Returns
    -------
    path : Path
        Segments joined with continuous position, heading and curvature, over true arc length.

    Raises
    ------
    InputError
        If there are fewer than two waypoints, neighbors coincide, or an argument is out of range.
    InfeasibleError
        If no path within the curvature limit, or within the tolerance of every waypoint, is found; of the
        latter its `result` is the path that comes nearest.

    See Also
    --------
    clean_route : make parts that can be fitted from a recorded route.

    Notes
    -----
    Eqs (1) and (2) of the paper with continuous second derivatives are a cubic B-spline with one knot per
    segment border. Among the splines with these knots the one is taken that minimizes
    ``integral |X - P|^2 + l^8 |X'''' - Q|^2 ds`` with the largest smoothing length l for which no
    waypoint is farther away than `tolerance`. Q is the fourth derivative of a clothoid: straight lines,
    circles and clothoids, of which roads are made, are smooth alike. The parameter is chord length first,
    then the arc length of the curve fitted before. The result is interpolated anew over its arc length,
    so that the length of dX/ds is 1 within 1e-3. Segments that turn by more than 0.1 rad are divided
    further. Cost is linear in n.

    Between waypoints the path stays within `tolerance` and 0.3 times the longest of three neighboring
    chords of them (three times `tolerance` in gaps): where a curve would swing farther it gets points on
    its chords. One smoothing length holds for the whole path, so a single waypoint far off its neighbors
    makes all of it follow the noise: the tolerance should be three or four standard deviations of it.

    With a curvature limit the tolerance holds for those waypoints that a curve within the limit can
    reach. How far the path leaves the others shows ``path.project(xy)[1]``.

    Examples
    --------
    >>> path = fit_path([[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [30.0, 0.0]])
    >>> round(path.length, 6), bool(abs(path.curvature(15.0)) < 1e-9)
    (30.0, True)
    """
    points = check_points("xy", xy, 2)
    tolerance = check_real("tolerance", tolerance, ge=0.0)
    per_segment = check_real("points_per_segment", points_per_segment, ge=1)
    if per_segment != int(per_segment):
        raise InputError(f"points_per_segment must be a whole number, was {per_segment:g}")
    if segmentation not in ("equal", "adaptive"):
        raise InputError(f"segmentation must be 'equal' or 'adaptive', was {segmentation!r}")
    limit = math.inf
    if curvature_limit is not None:
        limit = check_real("curvature_limit", curvature_limit, gt=0.0)
    if closed:
        if not np.array_equal(points[0], points[-1]):
            points = np.vstack((points, points[:1]))
        if len(points) < 4:
            raise InputError(
                f"xy must have at least 3 different points for a closed path, had {len(points) - 1}"
            )
    chords = np.hypot(*np.diff(points, axis=0).T)
    if (chords <= 0.0).any():
        i = int(np.argmin(chords))
        raise InputError(f"xy must not repeat a point, row {i} equals the next; clean_route drops it")
    fit = _Fit(points, chords, max(tolerance, 1e-9), closed)
    return fit.within(limit, int(per_segment) if segmentation == "equal" else None)


class _Fit:
    """One fit: the waypoints, made dense over gaps, and what is asked of the path."""

    def __init__(self, points: Array, chords: Array, tolerance: float, closed: bool) -> None:
        self._points, given = bridge_gaps(points, chords)
        self._asked = np.where(given, 1.0, 1.0 / _FREEDOM)  # share of the tolerance
        self._chord = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(self._points, axis=0).T))))
        self._accepted = max(tolerance, 1e-6)
        loose = 1.0 / np.minimum(self._asked[1:], self._asked[:-1])
        self._room = tolerance * loose + _SWING * max_neighbor_chord(self._points, closed)  # off each chord
        # what the interpolation at the end may add
        self._tolerance = max(tolerance - min(1e-3 * tolerance, 1e-4), 1e-9)
        self._closed, self._limit = closed, math.inf

    def within(self, limit: float, per_segment: int | None) -> Path:
        """Find the path with curvature up to `limit`, in equal segments or (None) adaptive ones."""
        spline = self._fit_near_chords(per_segment)
        path = over_arc_length(spline.path(), self._closed)
        if _largest_curvature(path) <= limit:
            return self._checked(path, spline)
        if self._closed and limit * self._chord[-1] < 2.0 * math.pi:
            raise InfeasibleError(
                f"no path of {self._chord[-1]:.0f} m closes with a curvature of at most {limit:g} 1/m"
            )
        self._limit = _HEADROOM * limit
        self._fit_without_tolerance()
        path = over_arc_length(self._segmented(per_segment).path(), self._closed)
        for _ in range(_ROUNDINGS):
            if _largest_curvature(path) <= limit:
                return path
            path = _limit_curvature(path, self._limit, self._closed)
        raise InfeasibleError(f"no path with a curvature of at most {limit:g} 1/m was found")

    def _fit_near_chords(self, per_segment: int | None) -> SmoothingSpline:
        """Fit; where the curve swings off its chords, put points on them and fit again."""
        for _ in range(_DIVISIONS):
            spline = self._segmented(per_segment)
            astray = self._find_overshoots(spline)
            if not astray.any():
                break
            self._divide(astray)
        return spline

    def _checked(self, path: Path, spline: SmoothingSpline) -> Path:
        """Refuse a path that misses a waypoint; residuals bound its distance and are known already."""
        missed = self._points[spline.residuals() * self._asked > self._accepted + _MISSED]
        if len(missed):
            off = float(np.abs(path.project(missed)[1]).max())
            if off > self._accepted + _MISSED:
                raise InfeasibleError(
                    f"no smooth path within {self._accepted:g} m of every waypoint was found, one is "
                    f"{off:.2f} m off it; raise the tolerance or drop what zig-zags with clean_route", path
                )  # fmt: skip
        return path

    def _find_overshoots(self, spline: SmoothingSpline) -> Mask:
        """Tell between which neighboring points a fit swings too far off the chords there."""
        off = chord_deviation(spline.between(_LOOKS), self._points, self._closed)
        astray: Mask = off.max(axis=1) > self._room
        return astray

    def _divide(self, chords: Mask) -> None:
        """Put a point on the middle of some chords, of which less is asked."""
        i = np.flatnonzero(chords)
        middle = 0.5 * (self._points[i] + self._points[i + 1])
        asked = np.minimum(self._asked[i], self._asked[i + 1])
        asked = asked * self._tolerance / (self._tolerance + self._room[i])
        self._points = np.insert(self._points, i + 1, middle, axis=0)
        self._asked = np.insert(self._asked, i + 1, asked)
        self._room = np.insert(self._room, i, self._room[i])
        self._chord = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(self._points, axis=0).T))))

    def _segmented(self, per_segment: int | None) -> SmoothingSpline:
        n = len(self._points) - 1
        if per_segment is not None:
            while True:
                knots = np.linspace(0, n, max(1, n // per_segment) + 1).round().astype(np.intp)
                spline, knots = self._fit(knots)
                if per_segment == 1 or (spline.residuals() * self._asked).max() <= self._accepted:
                    return spline
                per_segment //= 2
        knots = np.linspace(0, n, max(1, n // _LONGEST) + 1).round().astype(np.intp)
        while True:
            asked = knots
            spline, knots = self._fit(asked)
            bad = np.flatnonzero(spline.residuals() * self._asked > self._accepted)
            if not len(bad):
                return spline
            split = np.zeros(len(knots) - 1, dtype=bool)
            split[np.searchsorted(knots[1:-1], np.concatenate((bad, bad - 1)))] = True
            finer = _split(knots, split)
            while len(finer) == len(asked) and not split.all():
                split[1:] |= split[:-1]
                split[:-1] |= split[1:]
                finer = _split(knots, split)
            if len(finer) == len(asked):
                return spline
            knots = finer

    def _fit_without_tolerance(self) -> None:
        """Ask no tolerance of waypoints that no curve within the limit comes near."""
        spline, _ = self._fit(np.arange(len(self._points)), smooth=False)
        self._asked = self._asked * (spline.residuals() * self._asked <= self._tolerance)

    def _fit(self, knots: Index, smooth: bool = True) -> tuple[SmoothingSpline, Index]:
        """Fit with these knots and more where it bends; the parameter is nearly arc length."""
        s, guide, smoothing = self._chord, None, None
        kept: tuple[SmoothingSpline, Index] | None = None
        limited = self._limit < math.inf
        for more in range(_REPARAMETRIZATIONS, -1, -1):
            spline = SmoothingSpline(s, knots, self._points, self._asked, self._closed, guide)
            if smooth:
                worst, smoothing = spline.smooth_within(self._tolerance, smoothing)
            else:
                worst = spline.interpolate()
            spline.limit_curvature(self._limit)
            lengths = spline.arc_length()
            looping = lengths[-1] > _STRETCH * self._chord[-1] or (
                not limited and self._find_overshoots(spline).any()
            )
            if kept and looping:
                break  # a curve that loops between its points only gets worse with its own length
            kept = spline, knots
            if not more or (smooth and not limited and worst > 2.0 * self._accepted):
                break
            path = spline.path()
            middle = 0.5 * (path.breaks[1:] + path.breaks[:-1])
            knots = _split(knots, np.abs(path.curvature(middle)) * np.diff(path.breaks) > _TURN)
            guide = _clothoids(path, s[knots])
            s = lengths
        return kept or (spline, knots)


def _split(knots: Index, where: Mask) -> Index:
    """Divide some segments at their middle point, if they have one."""
    middle = (knots[1:] + knots[:-1]) // 2
    return np.union1d(knots, middle[where])


def _clothoids(path: Path, borders: Array) -> Array:
    """Fourth derivative at the inner borders if the curvature there changed evenly."""
    _, first, _ = path.derivatives(borders)
    first /= np.hypot(first[:, 0], first[:, 1])[:, None]
    most = _BENT / np.gradient(borders)  # no clothoid turns further between its neighbors
    kappa = np.clip(path.curvature(borders), -most, most)
    change = np.gradient(kappa, borders)
    normal = np.column_stack((-first[:, 1], first[:, 0]))
    return -(kappa**3)[:, None] * normal - (3.0 * kappa * change)[:, None] * first


def _limit_curvature(path: Path, limit: float, closed: bool) -> Path:
    """Return a path with its bends brought toward `limit`, and over its arc length again."""
    bent = np.abs(path.curvature(path.breaks)) > 0.5 * limit
    near = np.convolve(bent[1:] | bent[:-1], np.ones(3), "same") > 0.0
    parts = np.where(near, np.ceil(np.diff(path.breaks) * limit / _TURN), 1.0).astype(np.intp)
    index = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(index)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[index]
    s = np.append(path.breaks[index] + share * np.diff(path.breaks)[index], path.end)
    spline = SmoothingSpline(s, np.arange(len(s)), path.position(s), np.ones(len(s)), closed)
    spline.interpolate()
    spline.limit_curvature(limit)
    return over_arc_length(spline.path(), closed)


def _largest_curvature(path: Path) -> float:
    share = np.linspace(0.0, 1.0, 8, endpoint=False)
    s = path.breaks[:-1, None] + share * np.diff(path.breaks)[:, None]
    return float(np.abs(path.curvature(s)).max())
