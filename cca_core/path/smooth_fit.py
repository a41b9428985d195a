"""Smoothing cubics within a tolerance, near the chords of the waypoints, and within a curvature limit."""

import math

import numpy as np

from cca_core._checks import Array, Index, Mask
from cca_core.errors import InfeasibleError
from cca_core.geometry import arc_length
from cca_core.path.chords import bridge_gaps, chord_deviation, max_neighbor_chord
from cca_core.path.interpolate import over_arc_length
from cca_core.path.path import Path
from cca_core.path.smoothing import SmoothingSpline, largest_but

__all__ = ["SmoothFit", "max_curvature", "max_curvature_rate"]

_MAX_TURN = 0.1  # of a segment that has points to be divided at [rad]


class SmoothFit:
    """One fit: waypoints, with points added in gaps, and the tolerance at each."""

    def __init__(self, points: Array, tolerance: float, closed: bool, ignored: int = 0) -> None:
        tolerance = max(tolerance, 1e-9)
        self._points, given = bridge_gaps(points, np.hypot(*np.diff(points, axis=0).T))
        self._ignored = ignored  # number of the largest residuals that do not count
        # residuals count with these weights: in gaps three tolerances are allowed
        self._weight = np.where(given, 1.0, 1.0 / 3.0)
        self._chord = arc_length(self._points)
        self._accepted = max(tolerance, 1e-6)
        loose = 1.0 / np.minimum(self._weight[1:], self._weight[:-1])
        self._max_deviation = tolerance * loose + 0.3 * max_neighbor_chord(self._points, closed)
        # the final interpolation may add this difference
        self._tolerance = max(tolerance - min(1e-3 * tolerance, 1e-4), 1e-9)
        self._closed, self._limit = closed, math.inf

    def free(self, per_segment: int | None) -> Path:
        """Find the smoothest path within the tolerance, in equal segments or (None) adaptive ones."""
        spline = self._fit_near_chords(per_segment)
        return self._checked(over_arc_length(spline.path(), self._closed), spline)

    def nearest(self, per_segment: int | None) -> Path:
        """Find the smoothest path within the tolerance, or near it if there is none."""
        return over_arc_length(self._fit_near_chords(per_segment).path(), self._closed)

    def limited(self, limit: float, per_segment: int | None) -> Path:
        """Find a path with curvature up to `limit`; it may leave waypoints that this limit excludes."""
        path = self.nearest(per_segment)
        if max_curvature(path) <= limit:
            return path
        if self._closed and limit * self._chord[-1] < 2.0 * math.pi:
            raise InfeasibleError(
                f"no path of {self._chord[-1]:.0f} m closes with a curvature of at most {limit:g} 1/m"
            )
        self._limit = 0.95 * limit  # the change to arc length and the interpolation add curvature
        self._fit_without_tolerance()
        path = over_arc_length(self._segmented(per_segment).path(), self._closed)
        for _ in range(30):
            if max_curvature(path) <= limit:
                return path
            path = _limit_curvature(path, self._limit, self._closed)
        raise InfeasibleError(f"no path with a curvature of at most {limit:g} 1/m was found", path)

    def _fit_near_chords(self, per_segment: int | None) -> SmoothingSpline:
        """Fit; if the curve deviates too far from its chords, add points on them and fit again."""
        spline = self._segmented(per_segment)
        for _ in range(5):
            overshoots = self._find_overshoots(spline)
            if not overshoots.any():
                break
            self._divide(overshoots)
            spline = self._segmented(per_segment)
        return spline

    def _checked(self, path: Path, spline: SmoothingSpline) -> Path:
        """Reject a path that misses a waypoint; residuals are upper bounds of the distance."""
        limit = self._accepted + 0.01  # [m]: a slightly larger distance is accepted
        residuals = spline.residuals() * self._weight
        if self._worst(residuals) > limit:
            missed = self._points[residuals > limit]
            off = self._worst(np.abs(path.project(missed)[1]))
            if off > limit:
                raise InfeasibleError(
                    f"no smooth path within {self._accepted:g} m of every waypoint was found, "
                    f"the distance of one is {off:.2f} m; raise the tolerance or remove zig-zags with "
                    "clean_route",
                    path,
                )
        return path

    def _worst(self, residuals: Array) -> float:
        """Return the largest residual that counts."""
        return largest_but(residuals, self._ignored)

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
                if per_segment == 1 or self._worst(spline.residuals() * self._weight) <= self._accepted:
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
                worst, smoothing = spline.smooth_within(self._tolerance, smoothing, self._ignored)
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


def max_curvature(path: Path) -> float:
    """Return the largest absolute curvature of a path [1/m], from eight samples of each segment."""
    fraction = np.linspace(0.0, 1.0, 8, endpoint=False)
    s = path.breaks[:-1, None] + fraction * np.diff(path.breaks)[:, None]
    return float(np.abs(path.curvature(s)).max())


def max_curvature_rate(path: Path, a_y: float, max_speed: float) -> float:
    """Return the largest change of curvature in time [1/(m s)] at the speed that the curves allow."""
    s = (
        path.breaks[:-1, None] + np.linspace(0.0, 1.0, 4, endpoint=False) * np.diff(path.breaks)[:, None]
    ).ravel()
    s = np.append(s, path.end)
    kappa = path.curvature(s)
    sharper = np.maximum(np.abs(kappa[1:]), np.abs(kappa[:-1]))
    speed = np.minimum(np.sqrt(a_y / np.maximum(sharper, 1e-9)), max_speed)
    return float((np.abs(np.diff(kappa)) / np.diff(s) * speed).max())
