"""The cubic smoothing spline behind `fit_path`: knots at some of the points, linear cost, curvature limit."""

from typing import Any

import numpy as np
from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded

from cca_core._checks import Array, Index, Mask
from cca_core.path.path import Path

_BISECTIONS = 16
_STIFFEST = 10.0  # longest smoothing length tried, in segments
_PROJECTIONS = 100  # of the second derivative onto its limit
_GAUSS_X, _GAUSS_W = np.polynomial.legendre.leggauss(4)


class SmoothingSpline:
    """Cubic B-spline fitted at parameters s, with a penalty on how the curvature changes.

    The penalty is on X''' - g, where g = -kappa^2 T is the third derivative of the circle that an earlier
    fit had in each segment: a circle is as free as a straight line. A closed spline has as many
    coefficients as segments; they count round and round.
    """

    def __init__(
        self, s: Array, knots: Index, points: Array, given: Mask, closed: bool, guide: Array | None = None
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
        # what an affine function explains costs no roughness; the rest is fitted
        slope = np.zeros(2) if closed else (points[-1] - points[0]) / s[-1]
        greville = (self._knots[1:-3] + self._knots[2:-2] + self._knots[3:-1]) / 3.0
        self._affine = points[0] + greville[: self._count, None] * slope
        self._data = points[: len(at)] - points[0] - at[:, None] * slope
        self._given = given[: len(at)]
        weight = np.gradient(s)[: len(at)]
        length = np.diff(breaks)
        bends, jerks = self._differences()
        segments = self._wrap(np.arange(len(length)))
        self._fit_matrix = self._normal(self._basis, self._columns, weight)
        self._fit_right = self._spread(self._basis, self._columns, weight[:, None] * self._data)
        self._roughness = self._normal(jerks, segments, length)
        self._rough_right = np.zeros((self._count, 2))
        if guide is not None:
            self._rough_right = self._spread(jerks, segments, length[:, None] * guide)
        borders = self._count if closed else len(breaks)
        self._bends, self._bend_columns = bends[:borders], self._wrap(np.arange(borders))
        self._bend_weight = np.gradient(breaks)[:borders]
        self._span = float(np.median(length))
        self._rest = np.zeros((self._count, 2))

    def smooth_within(self, tolerance: float) -> float:
        """Find the smoothest fit whose largest residual keeps `tolerance`; return that residual."""
        low, high = np.log(1e-2 * self._span), np.log(_STIFFEST * self._span)
        worst = self._solve(np.exp(high))
        if worst <= tolerance:
            return worst
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            if self._solve(np.exp(middle)) <= tolerance:
                low = middle
            else:
                high = middle
        return self._solve(np.exp(low))

    def limit_bends(self, limit: float) -> None:
        """Bring the second derivative under `limit`, at the least loss of fit and smoothness (ADMM)."""
        bend = self._bend(self._rest)
        if np.hypot(*bend.T).max() <= limit:
            return
        stiffness = (2.0 / limit) ** 2  # weighs a bend like the distance it causes over a short turn
        weight = stiffness * self._bend_weight
        factor = self._factor(self._matrix + self._normal(self._bends, self._bend_columns, weight))
        dual = np.zeros_like(bend)
        for _ in range(_PROJECTIONS):
            wish = bend + dual
            size = np.hypot(wish[:, 0], wish[:, 1])[:, None]
            legal = wish * np.minimum(1.0, limit / np.maximum(size, 1e-300))
            dual = wish - legal
            pull = self._spread(self._bends, self._bend_columns, weight[:, None] * (legal - dual))
            self._rest = factor(self._right + pull)
            bend = self._bend(self._rest)

    def residual(self) -> float:
        """Largest distance of a given point from where the curve is at its parameter."""
        fitted = np.einsum("ij,ijk->ik", self._basis, self._rest[self._columns])
        return float(np.hypot(*(fitted - self._data)[self._given].T).max())

    def arc_length(self) -> Array:
        """Arc length of the curve at each data parameter (Gauss-Legendre between neighbours)."""
        half = 0.5 * np.diff(self._s)[:, None]
        at = self._s[:-1, None] + half * (1.0 + _GAUSS_X)
        first = self.path().derivatives(at)[1]
        speed = np.hypot(first[..., 0], first[..., 1])
        return np.concatenate(([0.0], np.cumsum((half * speed) @ _GAUSS_W)))

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
        stiffness = smoothing_length**6
        self._matrix = self._fit_matrix + stiffness * self._roughness
        self._right = self._fit_right + stiffness * self._rough_right
        try:
            self._rest = self._factor(self._matrix)(self._right)
        except LinAlgError:
            return np.inf
        return self.residual()

    def _factor(self, matrix: Any) -> Any:
        if self._closed:
            from scipy.sparse.linalg import splu

            return splu(matrix.tocsc()).solve
        factor = cholesky_banded(matrix, check_finite=False)
        return lambda right: cho_solve_banded((factor, False), right, check_finite=False)

    def _bend(self, rest: Array) -> Array:
        """Second derivative at the segment borders (the affine part has none)."""
        bend: Array = np.einsum("ij,ijk->ik", self._bends, rest[self._bend_columns])
        return bend

    def _wrap(self, first: Index) -> Index:
        """Columns of four neighbouring coefficients from each first one on."""
        columns: Index = (first[:, None] + np.arange(4)) % self._count
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
            i, j = np.broadcast_arrays(columns[:, :, None], columns[:, None, :])
            return coo_array((block.ravel(), (i.ravel(), j.ravel())), shape=(self._count,) * 2).tocsc()
        banded = np.zeros((4, self._count))
        for p in range(4):
            for q in range(p, 4):
                product = weight * rows[:, p] * rows[:, q]
                banded[3 + p - q] += np.bincount(columns[:, q], product, self._count)
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
