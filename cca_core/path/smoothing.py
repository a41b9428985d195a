"""Cubic smoothing spline of `fit_path`: knots at some of the points, linear cost, curvature limit."""

from typing import Any

import numpy as np

from cca_core._checks import Array, Index
from cca_core.path.path import Path


def largest_but(values: Array, ignored: int) -> float:
    """Largest value but for some that are larger."""
    if not ignored:
        return float(values.max())
    k = max(len(values) - 1 - ignored, 0)
    return float(np.partition(values, k)[k])


class SmoothingSpline:
    """Cubic B-spline at parameters s, with a penalty on the change of curvature."""

    # The penalty is on X'''' - q. Jumps of X''' between segments represent X''''; q is the value of a
    # clothoid from the last fit: lines, circles and clothoids cost nothing. The coefficients of a closed
    # spline are periodic, as many as segments.

    def __init__(
        self, s: Array, knots: Index, points: Array, weights: Array, closed: bool, guide: Array | None = None
    ) -> None:
        from scipy.interpolate import BSpline  # slow to import, and only fitting needs it

        self._s, self._closed = s, closed
        breaks = self._breaks = s[knots]
        self._count = len(breaks) - 1 if closed else len(breaks) + 2
        if closed:
            lap, n = breaks[-1], len(breaks) - 1
            ring = [breaks[k % n] + lap * (k // n) for k in (-3, -2, -1, n + 1, n + 2, n + 3)]
            self._knots = np.concatenate((ring[:3], breaks, ring[3:]))
        else:
            self._knots = np.concatenate((breaks[[0, 0, 0]], breaks, breaks[[-1, -1, -1]]))
        at = s[:-1] if closed else s
        matrix = BSpline.design_matrix(at, self._knots, 3)
        self._basis = matrix.data.reshape(len(at), 4)
        self._columns = self._wrap(matrix.indices.reshape(len(at), 4)[:, 0].astype(np.intp))
        # an affine function has no roughness; the rest is fitted
        slope = np.zeros(2) if closed else (points[-1] - points[0]) / s[-1]
        greville = (self._knots[1:-3] + self._knots[2:-2] + self._knots[3:-1]) / 3.0
        self._affine = points[0] + greville[: self._count, None] * slope
        self._data = points[: len(at)] - points[0] - at[:, None] * slope
        self._weights = weights
        weight = np.gradient(s)[: len(at)]
        length = np.diff(breaks)
        seconds, thirds = self._differences()
        segments = self._wrap(np.arange(len(length)))
        self._fit_matrix = self._normal(self._basis, self._columns, weight)
        self._fit_right = self._spread(self._basis, self._columns, weight[:, None] * self._data)
        # a short penalty length, in segments, keeps sparse points from loops
        self._fit_matrix += self._normal(thirds, segments, length * (0.05 * length) ** 6)
        joints = np.arange(len(length) if closed else len(length) - 1)
        jumps = np.zeros((len(joints), 5))
        jumps[:, 1:] = np.roll(thirds, -1, axis=0)[joints]
        jumps[:, :4] -= thirds[joints]
        spacing = 0.5 * (length + np.roll(length, -1))[joints]
        jumps /= spacing[:, None]
        self._roughness = self._normal(jumps, self._wrap(joints, 5), spacing)
        self._rough_right = np.zeros((self._count, 2))
        if guide is not None:
            self._rough_right = self._spread(
                jumps, self._wrap(joints, 5), spacing[:, None] * guide[1 + joints]
            )
        borders = self._count if closed else len(breaks)
        self._seconds, self._second_columns = seconds[:borders], self._wrap(np.arange(borders))
        self._second_weight = np.gradient(breaks)[:borders]
        self._span = float(np.median(length))
        self._rest = np.zeros((self._count, 2))
        self._ignored = 0

    def smooth_within(
        self, tolerance: float, length_guess: float | None = None, ignored: int = 0
    ) -> tuple[float, float]:
        """Find the smoothest fit within `tolerance`; return the largest residual and the smoothing length."""
        self._ignored = ignored
        low, high = np.log(1e-2 * self._span), np.log(10.0 * self._span)
        steps = 16
        if length_guess is not None:
            center = np.log(length_guess)
            low, high, steps = max(low, center - 0.5), min(high, center + 0.5), steps // 2
        worst = self._solve(np.exp(high))
        if worst <= tolerance:
            return worst, float(np.exp(high))
        worst = self._solve(np.exp(low))
        if worst > tolerance:
            return worst, float(np.exp(low))
        for _ in range(steps):
            middle = 0.5 * (low + high)
            if self._solve(np.exp(middle)) <= tolerance:
                low = middle
            else:
                high = middle
        return self._solve(np.exp(low)), float(np.exp(low))

    def interpolate(self) -> float:
        """Fit as closely as the knots allow; return the largest residual."""
        return self._solve(0.1 * self._span)

    def limit_curvature(self, limit: float) -> None:
        """Reduce the second derivative to `limit` at the lowest loss of fit and smoothness (ADMM)."""
        second = self._second_derivative(self._rest)
        if np.hypot(*second.T).max() <= limit:
            return
        stiffness = (2.0 / limit) ** 2  # weighs a curve like the offset that it causes over a short turn
        weight = stiffness * self._second_weight
        try:
            factor = self._factor(self._matrix + self._normal(self._seconds, self._second_columns, weight))
        except np.linalg.LinAlgError:
            return
        dual = np.zeros_like(second)
        for _ in range(100):
            target = second + dual
            size = np.hypot(target[:, 0], target[:, 1])[:, None]
            projected = target * np.minimum(1.0, limit / np.maximum(size, 1e-300))
            dual = target - projected
            pull = self._spread(self._seconds, self._second_columns, weight[:, None] * (projected - dual))
            self._rest = factor(self._right + pull)
            second = self._second_derivative(self._rest)
            if np.hypot(second[:, 0], second[:, 1]).max() <= 1.02 * limit:
                break

    def residuals(self) -> Array:
        """Distance of each point from the curve at its parameter."""
        fitted = np.einsum("ij,ijk->ik", self._basis, self._rest[self._columns])
        found = np.hypot(*(fitted - self._data).T)
        return np.append(found, found[0]) if self._closed else found

    def arc_length(self) -> Array:
        """Arc length of the curve at each data parameter (Gauss-Legendre between neighbors)."""
        half = 0.5 * np.diff(self._s)[:, None]
        x, w = np.polynomial.legendre.leggauss(4)
        at = self._s[:-1, None] + half * (1.0 + x)
        first = self.path().derivatives(at)[1]
        speed = np.hypot(first[..., 0], first[..., 1])
        return np.concatenate(([0.0], np.cumsum((half * speed) @ w)))

    def between(self, fractions: Array) -> Array:
        """Positions at fractions of the parameter between points, shape (points - 1, fractions, 2)."""
        return self.path().derivatives(self._s[:-1, None] + np.diff(self._s)[:, None] * fractions)[0]

    def path(self) -> Path:
        """Eqs (1) and (2): the cubics of each segment over lambda in [0, 1]."""
        from scipy.interpolate import BSpline

        unwrapped = (self._affine + self._rest)[np.arange(len(self._knots) - 4) % self._count]
        spline, start = BSpline(self._knots, unwrapped, 3), self._breaks[:-1]
        length = np.diff(self._breaks)[:, None]
        taylor = [
            length**k / factorial * spline(start, k) for k, factorial in ((3, 6), (2, 2), (1, 1), (0, 1))
        ]
        return Path(self._breaks, np.stack(taylor, axis=-1))

    def _solve(self, smoothing_length: float) -> float:
        stiffness = smoothing_length**8
        self._matrix = self._fit_matrix + stiffness * self._roughness
        self._right = self._fit_right + stiffness * self._rough_right
        try:
            self._rest = self._factor(self._matrix)(self._right)
        except np.linalg.LinAlgError:
            return np.inf
        return largest_but(self.residuals() * self._weights, self._ignored)

    def _factor(self, matrix: Any) -> Any:
        if self._closed:
            from scipy.sparse.linalg import splu

            return splu(matrix.tocsc()).solve
        from scipy.linalg import cho_solve_banded, cholesky_banded

        factor = cholesky_banded(matrix, check_finite=False)
        return lambda right: cho_solve_banded((factor, False), right, check_finite=False)

    def _second_derivative(self, rest: Array) -> Array:
        """Second derivative at the segment borders; the affine part has none."""
        second: Array = np.einsum("ij,ijk->ik", self._seconds, rest[self._second_columns])
        return second

    def _wrap(self, first: Index, width: int = 4) -> Index:
        """Columns of neighboring coefficients, from the first one of each row."""
        columns: Index = (first[:, None] + np.arange(width)) % self._count
        return columns

    def _spread(self, rows: Array, columns: Index, values: Array) -> Array:
        """Sum of row^T value."""
        flat = columns.ravel()
        sums = [np.bincount(flat, (rows * values[:, k, None]).ravel(), self._count) for k in (0, 1)]
        return np.column_stack(sums)

    def _normal(self, rows: Array, columns: Index, weight: Array) -> Any:
        """Sum of weight row^T row: upper banded form of an open spline, sparse matrix of a closed one."""
        if self._closed:
            from scipy.sparse import coo_array

            block = weight[:, None, None] * rows[:, :, None] * rows[:, None, :]
            columns = columns.astype(np.intc)  # the only indices that every SuperLU takes
            i, j = np.broadcast_arrays(columns[:, :, None], columns[:, None, :])
            return coo_array((block.ravel(), (i.ravel(), j.ravel())), shape=(self._count,) * 2).tocsc()
        banded = np.zeros((5, self._count))
        width = rows.shape[1]
        for p in range(width):
            for q in range(p, width):
                product = weight * rows[:, p] * rows[:, q]
                banded[4 + p - q] += np.bincount(columns[:, q], product, self._count)
        return banded

    def _differences(self) -> tuple[Array, Array]:
        """Second derivative at each border and third on each segment, as four weights (de Boor)."""
        t = self._knots
        n = len(t) - 4
        rows = np.zeros((n, 4))
        rows[:, 0] = 1.0
        found = []
        for order in (1, 2, 3):
            count = n - order
            gap = t[4 : 4 + count] - t[order : order + count]
            shifted = np.zeros((count, 4))
            shifted[:, 1:] = rows[1 : count + 1, :3]
            rows = (shifted - rows[:count]) * ((4.0 - order) / gap)[:, None]
            found.append(rows)
        return found[1], found[2]
