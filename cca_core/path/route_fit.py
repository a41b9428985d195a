"""Choice of tolerance and of the path within it, and its distance from every waypoint."""

import math

import numpy as np

from cca_core._checks import Array, Mask
from cca_core.errors import InfeasibleError
from cca_core.path.fit_report import FitReport
from cca_core.path.noise import estimate_noise, find_outliers, isolated
from cca_core.path.path import Path
from cca_core.path.rounding import round_bends
from cca_core.path.smooth_fit import SmoothFit, max_curvature, max_curvature_rate

__all__ = ["RouteFit"]

_TOLERANCES = (
    *(0.0, 0.001, 0.003, 0.01, 0.02, 0.03, 0.05, 0.07),
    *(
        round(digit * 10.0**k, 3)
        for k in range(-1, 5)
        for digit in (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
    ),
)  # tolerances that are tried [m]
_GENTLE = 1.0 / 200.0  # curvature up to which paths of smaller tolerances are not compared [1/m]
_CAR_RADIUS = 6.0  # of the sharpest curve of a path with chosen tolerance: a turning circle of 12 m [m]
_MAX_CURVATURE_RATE = 1.0  # that steering follows with small error [1/(m s)], at the next two values
_LATERAL_ACCELERATION, _MAX_SPEED = 2.0, 14.0  # of an ordinary car in sharp curves [m/s^2], [m/s]
_MIN_TOLERANCE = 0.3  # that is chosen [m]
_MAX_DEVIATION = 10.0  # of a waypoint that contradicts the curvature limit [m]


class RouteFit:
    """The waypoints and settings of one call of `fit_path`."""

    def __init__(
        self, points: Array, closed: bool, per_segment: int | None, max_deviation: float | None
    ) -> None:
        self._points, self._closed, self._per_segment = points, closed, per_segment
        self._max_deviation = max_deviation
        self._fitted = points  # the waypoints without outliers
        self._outliers: Mask = np.zeros(len(points), dtype=bool)

    def within(self, tolerance: float) -> Path:
        """Fit within a tolerance; what a smaller tolerance allows, a larger one does too."""
        found: list[Path] = []
        errors: list[InfeasibleError] = []
        for value in _tolerances(tolerance):
            try:
                path = self._smooth(value).free(self._per_segment)
            except InfeasibleError as error:
                errors.append(error)
                continue
            if not found and not errors and max_curvature(path) <= _GENTLE:
                return self._reported(path, tolerance)
            found.append(path)
        if not found:
            nearest = errors[0].result
            result = self._reported(nearest, tolerance) if isinstance(nearest, Path) else None
            raise InfeasibleError(str(errors[0]), result)
        # values do not depend on `tolerance`: no path is sharper by more than 2 % than one of a smaller one
        curvatures = [max_curvature(path) for path in found]
        best = next(i for i, kappa in enumerate(curvatures) if kappa <= 1.02 * min(curvatures))
        return self._reported(found[best], tolerance)

    def within_limit(self, tolerance: float, limit: float) -> Path:
        """Fit within a curvature limit, and within the tolerance where the limit allows that."""
        errors: list[InfeasibleError] = []
        for value in _tolerances(tolerance):
            try:
                return self._limited(value, tolerance, limit)
            except InfeasibleError as error:
                errors.append(error)
                nearest = error.result.fit_report if isinstance(error.result, Path) else None
                if nearest and nearest.max_deviation > 2.0 * self._bound(tolerance, limit):
                    break  # no tolerance makes up for that
        raise errors[0]

    def from_noise(self, limit: float) -> Path:
        """Fit within a tolerance chosen from the noise of the waypoints, with curves that a car can drive."""
        noise = estimate_noise(self._points)
        expected = max(3.3, math.sqrt(2.0 * math.log(len(self._points))) + 0.3)  # largest of normal errors
        tolerance = min(max(_MIN_TOLERANCE, expected * noise), _MAX_DEVIATION)
        limit = min(limit, 1.0 / _CAR_RADIUS)
        max_offset, spikes = self._max_ignored(tolerance, limit), self._outliers
        if not self._closed:
            self._outliers, spikes = find_outliers(self._points, noise, tolerance, max_offset)
            self._fitted = self._points[~self._outliers]
        for factor in (1.0, 1.5, 2.0):
            try:
                path = self._robust(factor * tolerance, self._max_ignored(factor * tolerance, limit))
            except InfeasibleError:
                continue
            if max_curvature(path) <= limit:
                found = self._reported(path, factor * tolerance, noise)
                if self._is_near(found, factor * tolerance, limit):
                    return found
        while True:
            try:
                return self._limited(tolerance, tolerance, limit, noise)
            except InfeasibleError as error:
                if not self._restored(error.result, max_offset, spikes):
                    raise

    def _restored(self, path: object, max_offset: float, spikes: Mask) -> bool:
        """Take outliers that a path misses by too much for curves; return whether there are any."""
        if not isinstance(path, Path) or path.fit_report is None:
            return False
        missed = np.zeros(len(self._points), dtype=bool)
        missed[path.fit_report.missed] = path.fit_report.missed_by > max_offset
        missed &= self._outliers & ~spikes
        self._outliers &= ~missed
        self._fitted = self._points[~self._outliers]
        return bool(missed.any())

    def _robust(self, tolerance: float, max_ignored: float) -> Path:
        """Fit without outliers, and without other single waypoints that bend the path."""
        points = self._fitted
        plain: Path | None = None
        try:
            plain = SmoothFit(points, tolerance, self._closed).free(self._per_segment)
        except InfeasibleError:
            if len(points) < 8 or self._closed:
                raise
        if plain and (max_curvature(plain) <= _GENTLE or len(points) < 8 or self._closed):
            return plain
        path = SmoothFit(points, tolerance, False, 1 + len(points) // 50).free(self._per_segment)
        if plain and max_curvature(plain) <= 1.5 * max_curvature(path):
            return plain
        s, d = path.project(points)
        exceeding = isolated(np.abs(d) > tolerance) & (np.abs(d) <= max_ignored)
        if not exceeding.any():
            return path
        points = points.copy()
        points[exceeding] = path.position(s[exceeding])
        return SmoothFit(points, tolerance, False).free(self._per_segment)

    def _smooth(self, tolerance: float) -> SmoothFit:
        return SmoothFit(self._fitted, tolerance, self._closed)

    def _limited(self, value: float, tolerance: float, limit: float, noise: float | None = None) -> Path:
        """Find the nearest path within a curvature limit that contradicts the tolerance."""
        found: list[tuple[bool, bool, float, Path]] = []
        errors: list[InfeasibleError] = []
        for fit in (self._flattened, self._rounded):
            try:
                path = self._reported(fit(value, limit), tolerance, noise)
            except InfeasibleError as error:
                errors.append(error)
                continue
            deviation = path.fit_report.max_deviation if path.fit_report else math.inf
            is_far = deviation > self._bound(tolerance, limit)
            is_jerky = max_curvature_rate(path, _LATERAL_ACCELERATION, _MAX_SPEED) > _MAX_CURVATURE_RATE
            found.append((is_far, is_jerky, deviation, path))
            if not (is_far or is_jerky or deviation > tolerance + 0.6 / limit):
                break
        if not found:
            raise errors[0]
        path = min(found, key=lambda entry: entry[:3])[3]
        if not self._is_near(path, tolerance, limit):
            raise InfeasibleError(self._refusal(path, tolerance, limit), path)
        return path

    def _flattened(self, tolerance: float, limit: float) -> Path:
        """Fit with the second derivative reduced to the limit, which cuts curves."""
        return self._smooth(tolerance).limited(limit, self._per_segment)

    def _rounded(self, tolerance: float, limit: float) -> Path:
        """Fit to the free path with arcs for its sharp curves."""
        if self._closed:
            raise InfeasibleError(f"no closed path with a curvature of at most {limit:g} 1/m was found")
        path = self._smooth(tolerance).nearest(self._per_segment)
        positions = round_bends(path, 0.95 * limit, 1.25 / limit)
        return SmoothFit(positions, 0.05 / limit, False).limited(limit, 4)

    def _bound(self, tolerance: float, limit: float) -> float:
        """Largest accepted distance of a waypoint [m]."""
        if self._max_deviation is not None:
            return max(self._max_deviation, tolerance + 0.01)
        return max(_MAX_DEVIATION, 3.0 * tolerance, min(0.6 / limit + tolerance, 3.0 * _MAX_DEVIATION))

    def _max_ignored(self, tolerance: float, limit: float) -> float:
        """Largest distance of a waypoint that is ignored [m]; a given bound refuses those farther away."""
        return self._bound(tolerance, limit) if self._max_deviation is None else math.inf

    def _is_near(self, path: Path, tolerance: float, limit: float) -> bool:
        return path.fit_report is not None and path.fit_report.max_deviation <= self._bound(tolerance, limit)

    def _refusal(self, path: Path, tolerance: float, limit: float) -> str:
        """Name the waypoints that a path misses by too much."""
        bound, off = self._bound(tolerance, limit), _nearest(path, self._points, tolerance)[1]
        far = np.flatnonzero(off > bound)
        rows = ", ".join(f"{row} by {off[row]:.1f} m" for row in far[:6].tolist())
        return (
            f"no path with a radius of at least {1.0 / limit:.3g} m within {bound:.3g} m of every waypoint "
            f"was found; missed are {len(far)}: row {rows}; split the route there or raise max_deviation"
        )  # fmt: skip

    def _reported(self, path: Path, tolerance: float, noise: float | None = None) -> Path:
        """Add to a path its distance from every waypoint."""
        s, off = _nearest(path, self._points, tolerance)
        i = int(np.argmax(off))
        missed = np.flatnonzero(off > max(tolerance, 1e-6) + 0.01)
        report = FitReport(
            tolerance=tolerance, noise=noise, max_deviation=float(off[i]), s_max_deviation=float(s[i]),
            missed=missed, missed_by=off[missed],
            outliers=np.flatnonzero(self._outliers & (off > tolerance)),
        )  # fmt: skip
        return Path._trusted(path.breaks, path.coefficients, report)


def _nearest(path: Path, points: Array, tolerance: float) -> tuple[Array, Array]:
    """Return station and distance of the nearest point between the ends; exact beyond the tolerance."""
    from scipy.spatial import cKDTree  # slow to import

    at = np.linspace(path.start, path.end, 4 * len(points))
    guess = at[cKDTree(path.position(at)).query(points)[1]]
    s = path.project(points, guess)[0].clip(path.start, path.end)
    off = np.hypot(*(path.position(s) - points).T)
    far = np.flatnonzero(off > tolerance)
    if len(far):
        exact, d = path.project(points[far])
        inside = (exact >= path.start) & (exact <= path.end) & (np.abs(d) < off[far])
        s[far[inside]], off[far[inside]] = exact[inside], np.abs(d[inside])
    return s, off


def _tolerances(tolerance: float) -> list[float]:
    """Return the tolerances to try, the largest first."""
    return [value for value in reversed(_TOLERANCES) if value <= tolerance]
