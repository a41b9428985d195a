"""Fit of a `Path` to waypoints: smoothing cubics within a tolerance and a curvature limit."""

import math

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, Index, Mask, check_points, check_real
from cca_core.errors import InfeasibleError, InputError
from cca_core.geometry import arc_length
from cca_core.path.chords import bridge_gaps, chord_deviation, max_neighbor_chord
from cca_core.path.interpolate import over_arc_length
from cca_core.path.path import Path
from cca_core.path.smoothing import SmoothingSpline

_MAX_TURN = 0.1  # of a segment that has points to be divided at [rad]


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
        Largest distance between a waypoint and the path [m]. The path is as smooth as this allows; 0
        interpolates.
    points_per_segment : int
        Waypoints in each segment of the equal segmentation [-]; halved until the tolerance is feasible.
    segmentation : {"equal", "adaptive"}
        Segments of equal waypoint count, or as long as the tolerance allows.
    curvature_limit : float, optional
        Largest curvature of the path [1/m], for example of the turning circle. If limit and tolerance
        contradict each other, the limit wins, and the path passes as near as it can.
    closed : bool
        Whether the road returns from the last waypoint to the first. The path then ends at its start, with
        the same heading and curvature.

    Returns
    -------
    path : Path
        Segments joined with continuous position, heading and curvature, over true arc length.

    Raises
    ------
    InputError
        If there are fewer than two waypoints, neighbors coincide, or an argument is out of range.
    InfeasibleError
        If no path keeps the curvature limit, or the tolerance at every waypoint. In the second case `result`
        is the nearest path.

    See Also
    --------
    clean_route : clean a recorded route into parts that can be fitted.

    Notes
    -----
    Eqs (1) and (2) of the paper with continuous second derivatives are a cubic B-spline with one knot per
    segment border. The fit minimizes ``integral |X - P|^2 + l^8 |X'''' - Q|^2 ds`` over these splines. The
    smoothing length l is the largest for which no waypoint is farther away than `tolerance`. Q is the fourth
    derivative of a clothoid: straight lines, circles and clothoids, of which roads consist, are equally
    smooth. The parameter is the chord length first, and then the arc length of the last fit. The result is
    interpolated again over its arc length, and the length of dX/ds is 1 within 1e-3. Segments that turn by
    more than 0.1 rad are divided further. The cost is linear in n.

    Between waypoints the path deviates from their chords by at most `tolerance` plus 0.3 times the longest of
    three neighboring chords (three times `tolerance` in gaps). A curve that would deviate more gets points on
    its chords. One smoothing length holds for the whole path, so a single outlier makes all of it follow the
    noise. The tolerance should therefore be three or four standard deviations of the noise.

    With a curvature limit the tolerance holds for the waypoints that a curve within the limit can reach.
    ``path.project(xy)[1]`` is the deviation of the others.

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
    """One fit: waypoints, with points added in gaps, and the tolerance at each."""

    def __init__(self, points: Array, chords: Array, tolerance: float, closed: bool) -> None:
        self._points, given = bridge_gaps(points, chords)
        # residuals count with these weights: in gaps three tolerances are allowed
        self._weight = np.where(given, 1.0, 1.0 / 3.0)
        self._chord = arc_length(self._points)
        self._accepted = max(tolerance, 1e-6)
        loose = 1.0 / np.minimum(self._weight[1:], self._weight[:-1])
        self._max_deviation = tolerance * loose + 0.3 * max_neighbor_chord(self._points, closed)
        # the final interpolation may add this difference
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
        self._limit = 0.95 * limit  # the change to arc length and the interpolation add curvature
        self._fit_without_tolerance()
        path = over_arc_length(self._segmented(per_segment).path(), self._closed)
        for _ in range(30):
            if _largest_curvature(path) <= limit:
                return path
            path = _limit_curvature(path, self._limit, self._closed)
        raise InfeasibleError(f"no path with a curvature of at most {limit:g} 1/m was found")

    def _fit_near_chords(self, per_segment: int | None) -> SmoothingSpline:
        """Fit; if the curve deviates too far from its chords, add points on them and fit again."""
        for _ in range(6):
            spline = self._segmented(per_segment)
            overshoots = self._find_overshoots(spline)
            if not overshoots.any():
                break
            self._divide(overshoots)
        return spline

    def _checked(self, path: Path, spline: SmoothingSpline) -> Path:
        """Reject a path that misses a waypoint; residuals are upper bounds of the distance."""
        limit = self._accepted + 0.01  # [m]: a slightly larger distance is accepted
        missed = self._points[spline.residuals() * self._weight > limit]
        if len(missed):
            off = float(np.abs(path.project(missed)[1]).max())
            if off > limit:
                raise InfeasibleError(
                    f"no smooth path within {self._accepted:g} m of every waypoint was found, the distance of one is "
                    f"{off:.2f} m; raise the tolerance or remove zig-zags with clean_route", path
                )  # fmt: skip
        return path

    def _find_overshoots(self, spline: SmoothingSpline) -> Mask:
        """Return which chords a fit deviates from too far."""
        fractions = np.arange(1.0, 8.0) / 8.0
        off = chord_deviation(spline.between(fractions), self._points, self._closed)
        overshoots: Mask = off.max(axis=1) > self._max_deviation
        return overshoots

    def _divide(self, chords: Mask) -> None:
        """Add a point on the middle of some chords, with less weight."""
        i = np.flatnonzero(chords)
        middle = 0.5 * (self._points[i] + self._points[i + 1])
        weight = np.minimum(self._weight[i], self._weight[i + 1])
        weight = weight * self._tolerance / (self._tolerance + self._max_deviation[i])
        self._points = np.insert(self._points, i + 1, middle, axis=0)
        self._weight = np.insert(self._weight, i + 1, weight)
        self._max_deviation = np.insert(self._max_deviation, i, self._max_deviation[i])
        self._chord = arc_length(self._points)

    def _segmented(self, per_segment: int | None) -> SmoothingSpline:
        n = len(self._points) - 1
        if per_segment is not None:
            while True:
                knots = np.linspace(0, n, max(1, n // per_segment) + 1).round().astype(np.intp)
                spline, knots = self._fit(knots)
                if per_segment == 1 or (spline.residuals() * self._weight).max() <= self._accepted:
                    return spline
                per_segment //= 2
        knots = np.linspace(0, n, max(1, n // 64) + 1).round().astype(np.intp)
        while True:
            previous = knots
            spline, knots = self._fit(previous)
            bad = np.flatnonzero(spline.residuals() * self._weight > self._accepted)
            if not len(bad):
                return spline
            split = np.zeros(len(knots) - 1, dtype=bool)
            split[np.searchsorted(knots[1:-1], np.concatenate((bad, bad - 1)))] = True
            finer = _split(knots, split)
            while len(finer) == len(previous) and not split.all():
                split[1:] |= split[:-1]
                split[:-1] |= split[1:]
                finer = _split(knots, split)
            if len(finer) == len(previous):
                return spline
            knots = finer

    def _fit_without_tolerance(self) -> None:
        """Drop the tolerance of waypoints that no curve within the limit can reach."""
        spline, _ = self._fit(np.arange(len(self._points)), smooth=False)
        self._weight = self._weight * (spline.residuals() * self._weight <= self._tolerance)

    def _fit(self, knots: Index, smooth: bool = True) -> tuple[SmoothingSpline, Index]:
        """Fit with these knots, and more on curves; the parameter becomes nearly arc length."""
        s, guide, smoothing = self._chord, None, None
        kept: tuple[SmoothingSpline, Index] | None = None
        limited = self._limit < math.inf
        for remaining in range(4, -1, -1):
            spline = SmoothingSpline(s, knots, self._points, self._weight, self._closed, guide)
            if smooth:
                worst, smoothing = spline.smooth_within(self._tolerance, smoothing)
            else:
                worst = spline.interpolate()
            spline.limit_curvature(self._limit)
            lengths = spline.arc_length()
            looping = lengths[-1] > 1.2 * self._chord[-1] or (
                not limited and self._find_overshoots(spline).any()
            )
            if kept and looping:
                break  # its own length would make the loops between the points larger
            kept = spline, knots
            if not remaining or (smooth and not limited and worst > 2.0 * self._accepted):
                break
            path = spline.path()
            middle = 0.5 * (path.breaks[1:] + path.breaks[:-1])
            knots = _split(knots, np.abs(path.curvature(middle)) * np.diff(path.breaks) > _MAX_TURN)
            guide = _clothoids(path, s[knots])
            s = lengths
        return kept or (spline, knots)


def _split(knots: Index, where: Mask) -> Index:
    """Divide segments at their middle point, if they have one."""
    middle = (knots[1:] + knots[:-1]) // 2
    return np.union1d(knots, middle[where])


def _clothoids(path: Path, borders: Array) -> Array:
    """Fourth derivative at the inner borders for linear curvature."""
    _, first, _ = path.derivatives(borders)
    first /= np.hypot(first[:, 0], first[:, 1])[:, None]
    limit = 0.5 / np.gradient(borders)  # a clothoid turns by at most 0.5 rad between borders
    kappa = np.clip(path.curvature(borders), -limit, limit)
    change = np.gradient(kappa, borders)
    normal = np.column_stack((-first[:, 1], first[:, 0]))
    return -(kappa**3)[:, None] * normal - (3.0 * kappa * change)[:, None] * first


def _limit_curvature(path: Path, limit: float, closed: bool) -> Path:
    """Return a path with its curvature reduced toward `limit`, over its arc length."""
    sharp = np.abs(path.curvature(path.breaks)) > 0.5 * limit
    near = np.convolve(sharp[1:] | sharp[:-1], np.ones(3), "same") > 0.0
    parts = np.where(near, np.ceil(np.diff(path.breaks) * limit / _MAX_TURN), 1.0).astype(np.intp)
    index = np.repeat(np.arange(len(parts)), parts)
    fraction = (np.arange(len(index)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[index]
    s = np.append(path.breaks[index] + fraction * np.diff(path.breaks)[index], path.end)
    spline = SmoothingSpline(s, np.arange(len(s)), path.position(s), np.ones(len(s)), closed)
    spline.interpolate()
    spline.limit_curvature(limit)
    return over_arc_length(spline.path(), closed)


def _largest_curvature(path: Path) -> float:
    fraction = np.linspace(0.0, 1.0, 8, endpoint=False)
    s = path.breaks[:-1, None] + fraction * np.diff(path.breaks)[:, None]
    return float(np.abs(path.curvature(s)).max())
