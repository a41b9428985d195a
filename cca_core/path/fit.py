"""From waypoints to a `Path`: smoothing cubics for GPS, interpolating cubics for the nodes of a band."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import LinAlgError, lapack, solveh_banded

from cca_core._checks import Array, Index, Mask, check_array, check_points, check_real
from cca_core.errors import InputError
from cca_core.path.path import Path

_REPARAMETRISATIONS = 3
_BISECTIONS = 20
_GAP_RATIO, _GAP_LEAST = 4.0, 20.0  # a chord over 4 medians (and 20 m) is a gap
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
    per_segment = int(check_real("points_per_segment", points_per_segment, least=1))
    if closed:
        if len(points) > 2 and np.array_equal(points[0], points[-1]):
            points = points[:-1]
        laps = np.vstack((points, points, points, points[:1]))  # the middle lap knows no ends
    else:
        laps = points
    chords = np.hypot(*np.diff(laps, axis=0).T)
    if (chords <= 0.0).any():
        i = int(np.argmin(chords)) % len(points)
        raise InputError(f"xy must not repeat a point, row {i} equals the next; drop duplicates first")
    dense, given = _bridge_gaps(laps, chords)
    while True:
        spline, worst = _fit(dense, given, per_segment, max(tolerance, 1e-9))
        if worst <= max(tolerance, 1e-6) or per_segment == 1:
            break
        per_segment //= 2
    path = spline.path()
    if closed:
        first, last = spline.s[np.flatnonzero(given)[[len(points), 2 * len(points)]]]
        path = _cut(path, first, last)
    return path


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
    for tangent, node, span, sign in ((start_tangent, 0, 0, 1.0), (end_tangent, -1, -1, -1.0)):
        if tangent is None:
            off[span] = 0.0  # natural end: no curvature
        else:
            unit = check_array("tangent", tangent, (2,))
            diagonal[node] = 2.0 * h[span]
            rhs[node] = 6.0 * sign * (slopes[span] - unit / np.hypot(*unit))
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


def _fit(points: Array, given: Mask, per_segment: int, tolerance: float) -> tuple["_SmoothingSpline", float]:
    """Fit with a fixed number of segments; return the spline and its largest residual at given points."""
    chord_length = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
    knots = np.linspace(0, len(points) - 1, max(1, (len(points) - 1) // per_segment) + 1).round().astype(int)
    spline = _SmoothingSpline(chord_length, knots, points, given)
    worst = spline.smooth_within(tolerance)
    for _ in range(_REPARAMETRISATIONS):
        s = spline.arc_length()
        if s[-1] > _STRETCH * chord_length[-1]:
            break  # a curve that loops between its points only gets worse with its own length
        spline = _SmoothingSpline(s, knots, points, given)
        worst = spline.smooth_within(tolerance)
    return spline, worst


class _SmoothingSpline:
    """Cubic B-spline with knots at some of the points, fitted at parameters s, with a penalty on X'''."""

    def __init__(self, s: Array, knot_index: Array, points: Array, given: Mask) -> None:
        from scipy.interpolate import BSpline  # slow to import, and only fitting needs it

        self.s, self._points, self._given = s, points, given
        knots = self._breaks = s[knot_index]
        self._knots = np.concatenate((knots[[0, 0, 0]], knots, knots[[-1, -1, -1]]))
        self._size = len(knots) + 2
        matrix = BSpline.design_matrix(s, self._knots, 3)
        self._basis = matrix.data.reshape(len(s), 4)
        self._column: Index = matrix.indices.reshape(len(s), 4)[:, 0].astype(np.intp)
        weight = np.gradient(s)
        self._fit_matrix = self._normal(self._basis, self._column, weight)
        self._right = np.zeros((self._size, 2))
        for k in range(4):
            np.add.at(self._right, self._column + k, (weight * self._basis[:, k])[:, None] * points)
        length = np.diff(knots)
        columns = np.arange(len(length))
        self._roughness = self._normal(self._third_derivative(), columns, length)
        self._span = float(np.median(length))
        self._coefficients = self._right

    def smooth_within(self, tolerance: float) -> float:
        """Find the smoothest fit whose largest residual keeps `tolerance`; return that residual."""
        low, high = np.log(1e-2 * self._span), np.log(4.0 * self._span)
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
        half = 0.5 * np.diff(self.s)[:, None]
        at = self.s[:-1, None] + half * (1.0 + _GAUSS_X)
        first = self.path().derivatives(at)[1]
        speed = np.hypot(first[..., 0], first[..., 1])
        return np.concatenate(([0.0], np.cumsum((half * speed) @ _GAUSS_W)))

    def path(self) -> Path:
        """Eqs (1) and (2): the cubics of each segment over lambda in [0, 1]."""
        from scipy.interpolate import BSpline

        spline, start = BSpline(self._knots, self._coefficients, 3), self._breaks[:-1]
        length = np.diff(self._breaks)[:, None]
        taylor = [
            length**k / factorial * spline(start, k) for k, factorial in ((3, 6), (2, 2), (1, 1), (0, 1))
        ]
        return Path(self._breaks, np.stack(taylor, axis=-1))

    def _solve(self, smoothing_length: float) -> float:
        banded = self._fit_matrix + smoothing_length**6 * self._roughness
        try:
            self._coefficients = solveh_banded(banded, self._right)
        except LinAlgError:
            return np.inf
        fitted = np.einsum(
            "ij,ijk->ik", self._basis, self._coefficients[self._column[:, None] + np.arange(4)]
        )
        return float(np.hypot(*(fitted - self._points)[self._given].T).max())

    def _normal(self, rows: Array, column: Index, weight: Array) -> Array:
        """Upper banded form of rows' weight rows, each row with four entries from its column on."""
        banded = np.zeros((4, self._size))
        for p in range(4):
            for q in range(p, 4):
                product = weight * rows[:, p] * rows[:, q]
                banded[3 + p - q] += np.bincount(column + q, product, self._size)
        return banded

    def _third_derivative(self) -> Array:
        """Third derivative on each segment as four weights on the coefficients (de Boor differences)."""
        n, t = self._size, self._knots
        rows = np.zeros((n, 4))
        rows[:, 0] = 1.0
        for order in (1, 2, 3):
            count = n - order
            gap = t[4 : 4 + count] - t[order : order + count]
            shifted = np.zeros((count, 4))
            shifted[:, 1:] = rows[1 : count + 1, :3]
            rows = (shifted - rows[:count]) * ((4.0 - order) / gap)[:, None]
        return rows


def _cut(path: Path, first: float, last: float) -> Path:
    """Part of `path` between two arc lengths, with s counted from its beginning."""
    inner = path.breaks[(path.breaks > first + 1e-6) & (path.breaks < last - 1e-6)]
    breaks = np.concatenate(([first], inner, [last]))
    length = np.diff(breaks)
    middle = 0.5 * (breaks[:-1] + breaks[1:])
    i = np.searchsorted(path.breaks, middle) - 1
    whole = np.diff(path.breaks)[i]
    shift = ((breaks[:-1] - path.breaks[i]) / whole)[:, None]
    scale = (length / whole)[:, None]
    a, b, c, d = np.moveaxis(path.coefficients[i], -1, 0)
    pieces = (
        a * scale**3,
        (3.0 * a * shift + b) * scale**2,
        ((3.0 * a * shift + 2.0 * b) * shift + c) * scale,
        ((a * shift + b) * shift + c) * shift + d,
    )
    return Path(breaks - first, np.stack(pieces, axis=-1))
