"""From waypoints to a `Path`: smoothing cubics for GPS, interpolating cubics for the nodes of a band."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import LinAlgError, lapack, solveh_banded

from cca_core._checks import Array, Index, Mask, check_array, check_points, check_real
from cca_core.errors import InputError
from cca_core.path.path import Path

_REPARAMETRISATIONS = 3
_BISECTIONS = 20
_GAP_RATIO, _GAP_LEAST = 4.0, 20.0  # a chord over 4 medians (and 20 m) is a gap
_STIFFEST = 10.0  # longest smoothing length tried, in segments
_STRETCH = 1.2  # a fit this much longer than its chords is not taken as a parameter
_GAUSS_X, _GAUSS_W = np.polynomial.legendre.leggauss(4)


def fit_path(
    xy: ArrayLike, *, tolerance: float = 0.3, points_per_segment: int = 4, closed: bool = False
) -> Path:
    """Fit a smooth path through waypoints.

    Parameters
    ----------
    xy : array_like, shape (n, 2)
        Waypoints [m], in driving order, no two neighbours equal.
    tolerance : float
        Largest distance allowed between a waypoint and the path [m]. Within it the path is as smooth as
        it can be; 0 interpolates.
    points_per_segment : int
        Waypoints in each segment [-]; halved until the tolerance can be kept.
    closed : bool
        Whether the road leads from the last waypoint back to the first. The path then ends where it
        starts, with the same heading and curvature.

    Returns
    -------
    path : Path
        Segments of equal waypoint count, joined with continuous position, heading and curvature.

    Raises
    ------
    InputError
        If there are fewer than two waypoints, neighbours coincide, or an argument is out of range.

    Notes
    -----
    Eqs (1) and (2) of the paper with continuous second derivatives are a cubic B-spline with one knot per
    segment border. Among the splines with these knots the one is taken that minimises
    ``integral |X - P|^2 + l^6 |X'''|^2 ds`` with the largest smoothing length l for which no waypoint is
    farther away than `tolerance`. The parameter is chord length first, then the arc length of the
    curve fitted before, so that s is arc length. Cost is linear in n.

    Examples
    --------
    >>> path = fit_path([[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [30.0, 0.0]])
    >>> round(path.length, 6), bool(abs(path.curvature(15.0)) < 1e-9)
    (30.0, True)
    """
    points = check_points("xy", xy, 2)
    tolerance = check_real("tolerance", tolerance, least=0.0)
    per_segment = check_real("points_per_segment", points_per_segment, least=1)
    if per_segment != int(per_segment):
        raise InputError(f"points_per_segment must be a whole number, was {per_segment:g}")
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
        raise InputError(f"xy must not repeat a point, row {i} equals the next; drop duplicates first")
    dense, given = _bridge_gaps(points, chords)
    count = int(per_segment)
    while True:
        spline, worst = _fit(dense, given, count, max(tolerance, 1e-9), closed)
        if worst <= max(tolerance, 1e-6) or count == 1:
            return spline.path()
        count //= 2


def interpolate_path(
    nodes: ArrayLike,
    *,
    start: float = 0.0,
    start_tangent: ArrayLike | None = None,
    end_tangent: ArrayLike | None = None,
) -> Path:
    """Lay a path exactly through closely spaced nodes.

    Parameters
    ----------
    nodes : array_like, shape (n, 2)
        Positions [m], in driving order, no two neighbours equal.
    start : float
        Arc length of the first node [m].
    start_tangent, end_tangent : array_like, shape (2,), optional
        Direction at the first and last node [-]. Without them the curvature is zero there.

    Returns
    -------
    path : Path
        One cubic between each two nodes (the C2 interpolating spline over chord length).

    Raises
    ------
    InputError
        If there are fewer than two nodes, neighbours coincide, or a value is not finite.

    Examples
    --------
    >>> interpolate_path([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]).length
    2.0
    """
    points = check_points("nodes", nodes, 2)
    steps = np.diff(points, axis=0)
    h = np.sqrt(steps[:, 0] ** 2 + steps[:, 1] ** 2)
    if not h.all():
        raise InputError(f"nodes must not repeat a point, row {int(np.argmin(h))} equals the next")
    slopes = steps / h[:, None]
    diagonal = np.full(len(points), 1.0)
    diagonal[1:-1] = 2.0 * (h[:-1] + h[1:])
    off = h.copy()
    rhs = np.zeros_like(points)
    rhs[1:-1] = 6.0 * np.diff(slopes, axis=0)
    start = check_real("start", start)
    ends = (("start_tangent", start_tangent, 0, 1.0), ("end_tangent", end_tangent, -1, -1.0))
    for name, tangent, node, sign in ends:
        if tangent is None:
            off[node] = 0.0  # natural end: no curvature
        else:
            unit = check_array(name, tangent, (2,))
            if not unit.any():
                raise InputError(f"{name} must not be zero")
            diagonal[node] = 2.0 * h[node]
            rhs[node] = 6.0 * sign * (slopes[node] - unit / np.hypot(*unit))
    second = lapack.dptsv(diagonal, off, rhs)[2]  # h_i-1 M_i-1 + 2 (h_i-1 + h_i) M_i + h_i M_i+1 = 6 [slope]
    squared = (h * h)[:, None]
    coefficients = np.empty((len(h), 2, 4))
    coefficients[:, :, 0] = squared * (second[1:] - second[:-1]) / 6.0
    coefficients[:, :, 1] = squared * second[:-1] / 2.0
    coefficients[:, :, 2] = steps - squared * (2.0 * second[:-1] + second[1:]) / 6.0
    coefficients[:, :, 3] = points[:-1]
    return Path(start + np.concatenate(([0.0], np.cumsum(h))), coefficients)


def _bridge_gaps(points: Array, chords: Array) -> tuple[Array, Mask]:
    """Put points on chords far longer than the others, so that the fit is straight where nothing is known."""
    parts = np.ceil(chords / max(_GAP_RATIO * float(np.median(chords)), _GAP_LEAST)).astype(int)
    index = np.repeat(np.arange(len(chords)), parts)
    share = (np.arange(len(index)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[index]
    dense = points[index] + share[:, None] * np.diff(points, axis=0)[index]
    return np.vstack((dense, points[-1:])), np.append(share == 0.0, True)


def _fit(
    points: Array, given: Mask, per_segment: int, tolerance: float, closed: bool
) -> tuple["_SmoothingSpline", float]:
    """Fit with a fixed number of segments; return the spline and its largest residual at given points."""
    chord_length = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
    knots = np.linspace(0, len(points) - 1, max(1, (len(points) - 1) // per_segment) + 1).round().astype(int)
    spline = _SmoothingSpline(chord_length, knots, points, given, closed)
    worst = spline.smooth_within(tolerance)
    for _ in range(_REPARAMETRISATIONS):
        s = spline.arc_length()
        if s[-1] > _STRETCH * chord_length[-1]:
            break  # a curve that loops between its points only gets worse with its own length
        spline = _SmoothingSpline(s, knots, points, given, closed)
        worst = spline.smooth_within(tolerance)
    return spline, worst


class _SmoothingSpline:
    """Cubic B-spline with knots at some of the points, fitted at parameters s, with a penalty on X'''.

    A closed spline has as many coefficients as segments; they count round and round.
    """

    def __init__(self, s: Array, knot_index: Index, points: Array, given: Mask, closed: bool) -> None:
        from scipy.interpolate import BSpline  # slow to import, and only fitting needs it

        self._s, self._closed = s, closed
        breaks = self._breaks = s[knot_index]
        self._count = len(breaks) - 1 if closed else len(breaks) + 2
        if closed:
            before, after = np.arange(-3, 0), np.arange(1, 4)
            lap, n = breaks[-1], len(breaks) - 1
            ring = [breaks[k % n] + lap * (k // n) for k in (*before, *(n + after))]
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
        self._fit_matrix = self._normal(self._basis, self._columns, weight)
        self._right = np.zeros((self._count, 2))
        weighted = (weight[:, None] * self._basis)[..., None] * self._data[:, None, :]
        np.add.at(self._right, self._columns, weighted)
        length = np.diff(breaks)
        segments = self._wrap(np.arange(len(length)))
        self._roughness = self._normal(self._third_derivative(), segments, length)
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
        matrix = self._fit_matrix + smoothing_length**6 * self._roughness
        if self._closed:
            from scipy.sparse.linalg import splu

            self._rest = splu(matrix.tocsc()).solve(self._right)
        else:
            try:
                self._rest = solveh_banded(matrix, self._right)
            except LinAlgError:
                return np.inf
        fitted = np.einsum("ij,ijk->ik", self._basis, self._rest[self._columns])
        return float(np.hypot(*(fitted - self._data)[self._given].T).max())

    def _wrap(self, first: Index) -> Index:
        """Columns of four neighbouring coefficients from each first one on."""
        columns: Index = (first[:, None] + np.arange(4)) % self._count
        return columns

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

    def _third_derivative(self) -> Array:
        """Third derivative on each segment as four weights on the coefficients (de Boor differences)."""
        t = self._knots
        n = len(t) - 4
        rows = np.zeros((n, 4))
        rows[:, 0] = 1.0
        for order in (1, 2, 3):
            count = n - order
            gap = t[4 : 4 + count] - t[order : order + count]
            shifted = np.zeros((count, 4))
            shifted[:, 1:] = rows[1 : count + 1, :3]
            rows = (shifted - rows[:count]) * ((4.0 - order) / gap)[:, None]
        return rows
