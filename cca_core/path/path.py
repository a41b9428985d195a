"""Center line of a road: piecewise cubics X_i(lambda), Y_i(lambda), twice continuously differentiable."""

import math
from functools import cached_property
from importlib import import_module
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_any, check_real
from cca_core.kernel.curve import Curve, CurveSamples
from cca_core.path.cubics import Cubics, check_cubics
from cca_core.path.fit_report import FitReport


class Path:
    """Planar curve in segments, with one cubic for x and one for y (eqs 1-2 of the paper).

    Beyond its ends the path continues straight along the end tangents, so queries never fail.

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
        If the shapes disagree, a value (here or in a query) is no number, or `breaks` does not increase.

    Examples
    --------
    >>> path = Path([0.0, 10.0], [[[0, 0, 10, 0], [0, 0, 0, 0]]])
    >>> path.position(4.0)
    array([4., 0.])
    """

    def __init__(self, breaks: ArrayLike, coefficients: ArrayLike) -> None:
        self._set(*check_cubics(breaks, coefficients))

    @classmethod
    def _trusted(cls, breaks: Array, coefficients: Array, report: FitReport | None = None) -> Self:
        """Make a path without checks and copies; the arrays become read-only."""
        path = cls.__new__(cls)
        path._set(breaks, coefficients, report)
        return path

    def _set(self, breaks: Array, coefficients: Array, report: FitReport | None = None) -> None:
        breaks.setflags(write=False)
        coefficients.setflags(write=False)
        self._breaks, self._coefficients = breaks, coefficients
        self._fit_report = report

    @cached_property
    def _cubics(self) -> Cubics:
        return Cubics(self._breaks, self._coefficients)

    @property
    def curve(self) -> Curve:
        """The path in the kernel, for its calls."""
        return self._cubics.curve

    @property
    def samples(self) -> CurveSamples:
        """Points of the path in the kernel, for the search of the nearest one."""
        return self._cubics.samples

    def __repr__(self) -> str:
        radius, report = self.min_radius, self._fit_report
        curve = "straight" if radius > 1e5 else f"min radius {radius:.3g} m at s={self.s_min_radius:.1f}"
        farthest = f", {report.farthest}" if report is not None else ""
        return f"Path({len(self._coefficients)} segments, {self.length:.1f} m, {curve}{farthest})"

    def _repr_svg_(self) -> str:
        svg: str = import_module("cca_core.plot.svg").to_svg(self)
        return svg

    def __reduce__(self) -> tuple[Any, ...]:
        return Path._trusted, (self._breaks, self._coefficients, self._fit_report)

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
        """Arc length of the first point [m]; 0 unless the path is a part of a longer route."""
        return float(self._breaks[0])

    @property
    def end(self) -> float:
        """Arc length of the last point [m]."""
        return float(self._breaks[-1])

    @property
    def length(self) -> float:
        """Arc length from the first to the last point [m]."""
        return float(self._breaks[-1] - self._breaks[0])

    @property
    def min_radius(self) -> float:
        """Least radius of curvature [m]; infinite on a straight path."""
        kappa = self._cubics.sharpest[1]
        return 1.0 / kappa if kappa > 1e-12 else math.inf

    @property
    def s_min_radius(self) -> float:
        """Station of the least radius [m]."""
        return self._cubics.sharpest[0]

    @property
    def fit_report(self) -> FitReport | None:
        """Distance from the waypoints of `fit_path`; None for other paths."""
        return self._fit_report

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
        first, second : ndarray, shape (..., 2)
            Tangent [-], of length 1 if `s` is exact arc length, and its rate of change [1/m].
        """
        return self._cubics.derivatives(s)

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
        return self._cubics.heading(s)

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
        return self._cubics.curvature(s)

    def to_cartesian(self, s: ArrayLike, d: ArrayLike) -> Array:
        """Cartesian position of Frenet coordinates.

        Parameters
        ----------
        s : array_like, shape (...)
            Arc length [m].
        d : array_like, shape (...)
            Lateral offset [m], left positive.

        Returns
        -------
        xy : ndarray, shape (..., 2)
            Position [m].
        """
        return self._cubics.to_cartesian(s, d)

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
        spacing = check_real("spacing", spacing, gt=0.0)
        n = max(2, math.ceil(self.length / spacing - 1e-9) + 1)
        return self.position(np.linspace(self.start, self.end, n))

    def cut(self, start: float, end: float) -> "Path":
        """Return an exact part of the path, with the arc lengths of the whole.

        Parameters
        ----------
        start, end : float
            Arc lengths of the first and last point of the part [m], on the path.

        Returns
        -------
        part : Path
            The same curve from `start` to `end`.

        Raises
        ------
        InputError
            If `start` is not less than `end`, or one of both is not on the path.
        """
        start = check_real("start", start, ge=self.start, le=self.end)
        end = check_real("end", end, gt=start, le=self.end)
        return Path(*self._cubics.cut(start, end, self._coefficients))

    def project(self, xy: ArrayLike, s_guess: ArrayLike | None = None) -> tuple[Array, Array]:
        """Frenet coordinates of positions, by Newton's method.

        Parameters
        ----------
        xy : array_like, shape (..., 2)
            Positions [m].
        s_guess : array_like, shape (...), optional
            Initial guess of the arc length [m], such as the result of the last cycle. It selects the branch
            if the road passes near itself. By default the nearest point of the whole path is found.

        Returns
        -------
        s : ndarray, shape (...)
            Arc length of the foot point [m]; beyond [start, end] on the straight continuations.
        d : ndarray, shape (...)
            Distance from the path [m], left positive.

        Raises
        ------
        InputError
            If `xy` or `s_guess` has the wrong shape or is not finite.
        """
        return self._cubics.project(check_any("xy", xy, (2,)), s_guess)

    def foot_point(self, x: float, y: float, s_guess: float) -> tuple[float, float, float, float]:
        """Project one position in plain floats, for control loops.

        Parameters
        ----------
        x, y : float
            Position [m].
        s_guess : float
            Initial guess of the arc length [m].

        Returns
        -------
        s, d, psi, kappa : float
            Arc length [m] and lateral offset [m], left positive; heading [rad], counter-clockwise from +x,
            and curvature [1/m], left turn positive, of the path there.
        """
        return self._cubics.foot_point(x, y, s_guess)

    def curvature_at(self, s: float) -> float:
        """Signed curvature at one arc length in plain floats.

        Parameters
        ----------
        s : float
            Arc length [m].

        Returns
        -------
        kappa : float
            Curvature [1/m], left turn positive.
        """
        return self._cubics.curvature_at(s)
