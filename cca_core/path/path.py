"""A road's centre line: piecewise cubics X_i(lambda), Y_i(lambda), twice continuously differentiable.

All queries of a path stand in one class, so this module is longer than others.
"""

import math
from bisect import bisect_right
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_any, check_array, check_real
from cca_core.errors import InputError

_SWEEPS = 12  # Newton converges in 2 to 4; the rest is for points far off a tight bend


class Path:
    """Planar curve in segments, one cubic in x and one in y each (eqs 1-2 of the paper).

    Beyond its ends the path goes on straight along its end tangents, so queries never fail.

    Parameters
    ----------
    breaks : array_like, shape (n_segments + 1,)
        Arc length at the segment borders [m], increasing.
    coefficients : array_like, shape (n_segments, 2, 4)
        For x and y: a, b, c, d of a lambda^3 + b lambda^2 + c lambda + d [m], with
        lambda = (s - s_i) / (s_{i+1} - s_i) in [0, 1].

    Raises
    ------
    InputError
        If the shapes disagree, a value is not finite, or `breaks` does not increase.

    See Also
    --------
    fit_path : make a path from waypoints.

    Examples
    --------
    >>> path = Path([0.0, 10.0], [[[0, 0, 10, 0], [0, 0, 0, 0]]])
    >>> path.position(4.0)
    array([4., 0.])
    >>> s, d = path.project([4.0, 1.5])
    >>> float(s), float(d)
    (4.0, 1.5)
    """

    def __init__(self, breaks: ArrayLike, coefficients: ArrayLike) -> None:
        s = check_array("breaks", breaks, (None,))
        c = check_array("coefficients", coefficients, (None, 2, 4))
        if len(s) < 2 or len(c) != len(s) - 1:
            raise InputError(
                f"breaks, coefficients must have shapes (n + 1,), (n, 2, 4), had {s.shape}, {c.shape}"
            )
        if not (np.diff(s) > 0.0).all():
            raise InputError("breaks must increase")
        s.setflags(write=False)
        c.setflags(write=False)
        self._breaks, self._coefficients = s, c
        self._tree: tuple[Array, Any] | None = None  # samples for cold projections, made on demand
        # the same in powers of metres, shape (4, n_segments, 2), cubic term first
        scale = np.diff(s)[:, None] ** -np.arange(3.0, -1.0, -1.0)
        self._powers = c.transpose(2, 0, 1) * scale.T[:, :, None]

    def __repr__(self) -> str:
        return f"Path({len(self._coefficients)} segments, {self.length:.1f} m)"

    @property
    def breaks(self) -> Array:
        """Arc length at the segment borders [m], shape (n_segments + 1,)."""
        return self._breaks

    @property
    def coefficients(self) -> Array:
        """The a, b, c, d of eqs 1-2 for x and y [m], shape (n_segments, 2, 4)."""
        return self._coefficients

    @property
    def start(self) -> float:
        """Arc length of the first point [m]; 0 unless the path is a stretch of a longer route."""
        return float(self._breaks[0])

    @property
    def end(self) -> float:
        """Arc length of the last point [m]."""
        return float(self._breaks[-1])

    @property
    def length(self) -> float:
        """Arc length from the first to the last point [m]."""
        return float(self._breaks[-1] - self._breaks[0])

    def derivatives(self, s: ArrayLike) -> tuple[Array, Array, Array]:
        """Position with first and second derivative by arc length.

        Parameters
        ----------
        s : array_like, shape (...)
            Arc length [m]; beyond the ends the path is straight.

        Returns
        -------
        position : ndarray, shape (..., 2)
            Point on the path [m].
        first : ndarray, shape (..., 2)
            Tangent [-], of length 1 as far as `s` is arc length.
        second : ndarray, shape (..., 2)
            Change of the tangent [1/m].
        """
        s = np.asarray(s, dtype=np.float64)
        on = np.minimum(np.maximum(s, self._breaks[0]), self._breaks[-1])
        i = np.searchsorted(self._breaks[1:-1], on, side="right")
        a, b, c, d = self._powers[:, i]
        t = (on - self._breaks[i])[..., None]
        first = (3.0 * a * t + 2.0 * b) * t + c
        position = ((a * t + b) * t + c) * t + d
        second = 6.0 * a * t + 2.0 * b
        beyond = (s - on)[..., None]
        if beyond.any():
            position = position + beyond * first
            second = np.where(beyond == 0.0, second, 0.0)
        return position, first, second

    def position(self, s: ArrayLike) -> Array:
        """Point on the path.

        Parameters
        ----------
        s : array_like, shape (...)
            Arc length [m].

        Returns
        -------
        xy : ndarray, shape (..., 2)
            Position [m].
        """
        return self.derivatives(s)[0]

    def heading(self, s: ArrayLike) -> Array:
        """Direction of the tangent.

        Parameters
        ----------
        s : array_like, shape (...)
            Arc length [m].

        Returns
        -------
        psi : ndarray, shape (...)
            Heading [rad] in (-pi, pi], counter-clockwise from +x.
        """
        first = self.derivatives(s)[1]
        psi: Array = np.arctan2(first[..., 1], first[..., 0])
        return psi

    def curvature(self, s: ArrayLike) -> Array:
        """Signed curvature (X'Y'' - Y'X'') / (X'^2 + Y'^2)^1.5.

        Parameters
        ----------
        s : array_like, shape (...)
            Arc length [m].

        Returns
        -------
        kappa : ndarray, shape (...)
            Curvature [1/m], left turn positive.
        """
        _, first, second = self.derivatives(s)
        cross = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
        kappa: Array = cross / np.sum(first * first, axis=-1) ** 1.5
        return kappa

    def to_cartesian(self, s: ArrayLike, d: ArrayLike) -> Array:
        """Point at arc length `s`, `d` to the left of the path.

        Parameters
        ----------
        s : array_like, shape (...)
            Arc length [m].
        d : array_like, shape (...)
            Lateral coordinate [m], left positive.

        Returns
        -------
        xy : ndarray, shape (..., 2)
            Position [m].
        """
        position, first, _ = self.derivatives(s)
        normal = np.stack((-first[..., 1], first[..., 0]), axis=-1)
        normal /= np.hypot(first[..., 0], first[..., 1])[..., None]
        xy: Array = position + np.asarray(d, dtype=np.float64)[..., None] * normal
        return xy

    def sample(self, spacing: float) -> Array:
        """Equidistant nodes from the first to the last point.

        Parameters
        ----------
        spacing : float
            Largest distance between nodes along the path [m].

        Returns
        -------
        nodes : ndarray, shape (n, 2)
            Positions [m], in driving order.

        Raises
        ------
        InputError
            If `spacing` is not positive.
        """
        spacing = check_real("spacing", spacing, above=0.0)
        n = max(2, math.ceil(self.length / spacing - 1e-9) + 1)
        return self.position(np.linspace(self.start, self.end, n))

    def project(self, xy: ArrayLike, near: ArrayLike | None = None) -> tuple[Array, Array]:
        """Foot points: arc length and lateral coordinate of positions.

        Parameters
        ----------
        xy : array_like, shape (..., 2)
            Positions [m].
        near : array_like, shape (...), optional
            Arc length close to the answer [m], such as last cycle's; picks the branch where the road
            passes near itself. Without it the nearest point of the whole path is found.

        Returns
        -------
        s : ndarray, shape (...)
            Arc length of the foot point [m]; outside [start, end] on the straight continuations.
        d : ndarray, shape (...)
            Distance from the path [m], left positive.

        Raises
        ------
        InputError
            If `xy` or `near` has the wrong shape or is not finite.

        Notes
        -----
        Newton on (X - x) X' + (Y - y) Y' = 0, with the second derivative kept positive.
        """
        xy = check_any("xy", xy, (2,))
        start = self._nearest_sample(xy) if near is None else check_any("near", near)
        if start.shape not in ((), xy.shape[:-1]):
            raise InputError(f"near must have shape () or {xy.shape[:-1]}, had {start.shape}")
        s = np.broadcast_to(start, xy.shape[:-1])
        for _ in range(_SWEEPS):
            position, first, second = self.derivatives(s)
            out = position - xy
            speed2 = np.sum(first * first, axis=-1)
            slope = np.maximum(speed2 + np.sum(out * second, axis=-1), 0.2 * speed2)
            step = np.sum(out * first, axis=-1) / slope
            s = s - step
            if np.abs(step).max(initial=0.0) < 1e-9:
                break
        position, first, _ = self.derivatives(s)
        out = xy - position
        d = (first[..., 0] * out[..., 1] - first[..., 1] * out[..., 0]) / np.hypot(
            first[..., 0], first[..., 1]
        )
        return s, d

    def foot_point(self, x: float, y: float, near: float) -> tuple[float, float, float, float]:
        """Project one position, in plain floats: the control loop's warm-started `project`.

        Parameters
        ----------
        x, y : float
            Position [m].
        near : float
            Arc length close to the answer [m].

        Returns
        -------
        s, d : float
            Arc length and lateral coordinate of the position [m], left positive.
        psi : float
            Heading of the path there [rad], counter-clockwise from +x.
        kappa : float
            Curvature of the path there [1/m], left turn positive.
        """
        s = near
        for _ in range(_SWEEPS):
            px, py, tx, ty, nx, ny = self._at(s)
            speed2 = tx * tx + ty * ty
            out = (px - x) * tx + (py - y) * ty
            step = out / max(speed2 + (px - x) * nx + (py - y) * ny, 0.2 * speed2)
            s -= step
            if -1e-9 < step < 1e-9:
                break
        px, py, tx, ty, nx, ny = self._at(s)
        speed = math.hypot(tx, ty)
        d = (tx * (y - py) - ty * (x - px)) / speed
        return s, d, math.atan2(ty, tx), (tx * ny - ty * nx) / speed**3

    def curvature_at(self, s: float) -> float:
        """Signed curvature at one arc length, in plain floats.

        Parameters
        ----------
        s : float
            Arc length [m].

        Returns
        -------
        kappa : float
            Curvature [1/m], left turn positive.
        """
        _, _, tx, ty, nx, ny = self._at(s)
        return float((tx * ny - ty * nx) / (tx * tx + ty * ty) ** 1.5)

    def _at(self, s: float) -> tuple[float, float, float, float, float, float]:
        """Position, first and second derivative at one arc length, as six floats."""
        breaks, pieces = self._lists
        on = min(max(s, breaks[0]), breaks[-1])
        i = min(bisect_right(breaks, on), len(pieces)) - 1
        ax, ay, bx, by, cx, cy, dx, dy = pieces[i]
        t = on - breaks[i]
        px, py = ((ax * t + bx) * t + cx) * t + dx, ((ay * t + by) * t + cy) * t + dy
        tx, ty = (3.0 * ax * t + 2.0 * bx) * t + cx, (3.0 * ay * t + 2.0 * by) * t + cy
        if s == on:
            return px, py, tx, ty, 6.0 * ax * t + 2.0 * bx, 6.0 * ay * t + 2.0 * by
        return px + (s - on) * tx, py + (s - on) * ty, tx, ty, 0.0, 0.0

    @cached_property
    def _lists(self) -> tuple[list[float], list[list[float]]]:
        pieces = self._powers.transpose(1, 0, 2).reshape(-1, 8)
        return self._breaks.tolist(), pieces.tolist()

    def _nearest_sample(self, xy: Array) -> Array:
        from scipy.spatial import cKDTree  # slow to import, and only the cold start needs it

        if self._tree is None:
            s = np.linspace(self.start, self.end, max(2, math.ceil(self.length / 2.0) + 1))
            self._tree = s, cKDTree(self.position(s))
        s, tree = self._tree
        nearest: Array = s[tree.query(xy)[1]]
        return nearest
