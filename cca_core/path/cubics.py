"""Piecewise cubics in the plane: evaluation and foot points, for arrays and single floats."""

import math
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, as_array, check_any, check_array, explained
from cca_core.errors import InputError
from cca_core.kernel import backend, bind
from cca_core.kernel.curve import (
    Curve,
    CurveSamples,
    curvature_at,
    curve_point,
    curve_points,
    foot_point,
    foot_points,
    nearest_points,
)
from cca_core.kernel.memory import lend

_curve_point, _curve_points = bind(curve_point), bind(curve_points)
_curvature_at = bind(curvature_at)
_foot_point, _foot_points, _nearest_points = bind(foot_point), bind(foot_points), bind(nearest_points)

_SPACING = 2.0  # of the samples for a search without initial guess [m]; longer on paths above 400 km
_MAX_SAMPLES = 200_000  # but for those in tight curves
_SAMPLE_TURN = 0.15  # largest turn between such samples [rad]


def check_cubics(breaks: ArrayLike, coefficients: ArrayLike) -> tuple[Array, Array]:
    """Return copies of breaks and coefficients if they are those of cubics."""
    s = check_array("breaks", breaks, (None,))
    c = check_array("coefficients", coefficients, (None, 2, 4))
    if len(s) < 2 or len(c) != len(s) - 1:
        raise InputError(f"breaks, coefficients must be (n + 1,), (n, 2, 4), were {s.shape}, {c.shape}")
    if not (np.diff(s) > 0.0).all():
        raise InputError("breaks must increase")
    return s, c


class Cubics:
    """Cubics over s in powers of meters, straight beyond both ends; `Path` checks the arguments."""

    def __init__(self, breaks: Array, coefficients: Array) -> None:
        self._breaks = breaks
        # shape (4, n_segments, 2), cubic term first
        rate = 1.0 / (breaks[1:] - breaks[:-1])
        scale = np.array((rate * rate * rate, rate * rate, rate, np.ones_like(rate)))
        self._powers = coefficients.transpose(2, 0, 1) * scale[:, :, None]

    def derivatives(self, s: ArrayLike) -> tuple[Array, Array, Array]:
        """Position, first and second derivative, shapes (..., 2)."""
        s = np.asarray(as_array("s", s), order="C")
        if backend() == "python":
            return self._derivatives_without_c(s)
        points = np.empty((3, *s.shape, 2))
        position, first, second = points.reshape(3, -1, 2)
        _curve_points(self.curve, s.size, s.reshape(-1), position, first, second)
        return points[0], points[1], points[2]

    def _derivatives_without_c(self, s: Array) -> tuple[Array, Array, Array]:
        """Return the same bits: a loop over the many points of a fit is slow in Python."""
        on = np.minimum(np.maximum(s, self._breaks[0]), self._breaks[-1])
        i = np.searchsorted(self._breaks[1:-1], on, side="right")
        a, b, c, d = self._powers.take(i, axis=1)
        t, beyond = (on - self._breaks.take(i))[..., None], (s - on)[..., None]
        position, first = ((a * t + b) * t + c) * t + d, (3.0 * a * t + 2.0 * b) * t + c
        inside = beyond == 0.0
        ahead = np.where(inside, position, position + beyond * first)
        return ahead, first, np.where(inside, 6.0 * a * t + 2.0 * b, 0.0)

    def heading(self, s: ArrayLike) -> Array:
        """Direction of the tangent."""
        first = self.derivatives(s)[1]
        psi: Array = np.arctan2(first[..., 1], first[..., 0])
        return psi

    def curvature(self, s: ArrayLike) -> Array:
        """Signed curvature."""
        _, first, second = self.derivatives(s)
        cross = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
        kappa: Array = cross / np.sum(first * first, axis=-1) ** 1.5
        return kappa

    def to_cartesian(self, s: ArrayLike, d: ArrayLike) -> Array:
        """Positions at lateral offsets, shape (..., 2)."""
        position, first, _ = self.derivatives(s)
        normal = np.stack((-first[..., 1], first[..., 0]), axis=-1)
        normal /= np.hypot(first[..., 0], first[..., 1])[..., None]
        xy: Array = position + as_array("d", d)[..., None] * normal
        return xy

    def cut(self, start: float, end: float, coefficients: Array) -> tuple[Array, Array]:
        """Return breaks and coefficients over lambda between two s."""
        breaks = self._breaks
        first = int(np.searchsorted(breaks, start, side="right")) - 1
        last = int(np.searchsorted(breaks, end))
        inner = np.concatenate(([start], breaks[first + 1 : last], [end]))
        length = np.diff(breaks[first : last + 1])
        scale = (np.diff(inner) / length)[:, None]
        offset = ((inner[:-1] - breaks[first:last]) / length)[:, None]
        a, b, c, d = np.moveaxis(coefficients[first:last], -1, 0)
        taylor = (
            a * scale**3,
            (3.0 * a * offset + b) * scale**2,
            ((3.0 * a * offset + 2.0 * b) * offset + c) * scale,
            ((a * offset + b) * offset + c) * offset + d,
        )
        return inner, np.stack(taylor, axis=-1)

    def at(self, s: float) -> tuple[float, float, float, float, float, float]:
        """Position, first and second derivative at one s, as six floats."""
        return _curve_point(self.curve, s)

    def curvature_at(self, s: float) -> float:
        """Signed curvature at one s."""
        try:
            return _curvature_at(self.curve, s)
        except (TypeError, ValueError, ArithmeticError) as error:
            raise explained(error, {"s": s}) from None

    def foot_point(self, x: float, y: float, s_guess: float) -> tuple[float, float, float, float]:
        """Foot point of one position: s, d, heading and curvature."""
        try:
            return _foot_point(self.curve, x, y, s_guess)
        except (TypeError, ValueError, ArithmeticError) as error:
            raise explained(error, {"x": x, "y": y, "s_guess": s_guess}) from None

    def project(self, xy: Array, s_guess: ArrayLike | None) -> tuple[Array, Array]:
        """Foot points s, d of positions, shape (..., 2), nearest on all or from initial guesses."""
        shape, points = xy.shape[:-1], xy.reshape(-1, 2)
        if s_guess is None:
            s, d = self.nearest(points)
        else:
            start = check_any("s_guess", s_guess)
            if start.shape not in ((), shape):
                raise InputError(f"s_guess must have shape () or {shape}, had {start.shape}")
            s, d = self.foot_points(points, np.broadcast_to(start, shape).reshape(-1))
        return s.reshape(shape)[()], d.reshape(shape)[()]  # scalars for one position

    def foot_points(self, xy: Array, s_guess: Array) -> tuple[Array, Array]:
        """Foot points s, d of positions, shape (n, 2), by Newton from initial guesses, shape (n,)."""
        x, y, guess = (np.ascontiguousarray(a) for a in (xy[:, 0], xy[:, 1], s_guess))
        s, d, heading, curvature = np.empty((4, len(x)))
        _foot_points(self.curve, len(x), x, y, guess, s, d, heading, curvature)
        return s, d

    def nearest(self, xy: Array) -> tuple[Array, Array]:
        """Foot points s, d of positions, shape (n, 2), nearest on the whole curve."""
        x, y = np.ascontiguousarray(xy[:, 0]), np.ascontiguousarray(xy[:, 1])
        s, d = np.empty((2, len(x)))
        _nearest_points(self.curve, self.samples, len(x), x, y, s, d)
        return s, d

    @cached_property
    def curve(self) -> Curve:
        """The curve in the kernel."""
        lent = lend(Curve, segments=len(self._breaks) - 1)
        lent.arrays["breaks"][:] = self._breaks
        lent.arrays["powers"].reshape(-1, 4, 2)[:] = self._powers.transpose(1, 0, 2)
        return lent.workspace

    @cached_property
    def sharpest(self) -> tuple[float, float]:
        """Station of the largest absolute curvature of nine samples a segment, and its value."""
        s = self._breaks[:-1, None] + np.linspace(0.0, 1.0, 9) * np.diff(self._breaks)[:, None]
        kappa = np.abs(self.curvature(s)).ravel()
        i = int(np.argmax(kappa))
        return float(s.ravel()[i]), float(kappa[i])

    @cached_property
    def samples(self) -> CurveSamples:
        """Points for the search of the nearest one, in the kernel."""
        whole = self._breaks[-1] - self._breaks[0]
        spacing = max(_SPACING, whole / _MAX_SAMPLES)
        s = np.linspace(self._breaks[0], self._breaks[-1], max(2, math.ceil(whole / spacing) + 1))
        length = np.diff(self._breaks)
        at = self._breaks[:-1, None] + length[:, None] * np.linspace(0.0, 1.0, 9)
        _, first, second = self.derivatives(at)
        speed = np.maximum(np.hypot(first[..., 0], first[..., 1]), 1e-9)
        cross = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
        rate = (np.abs(cross) / speed**2).max(axis=1)  # of the heading along each segment [rad/m]
        tight = np.flatnonzero(rate * spacing > 2.5 * _SAMPLE_TURN)  # radius below 5.3 m
        parts = np.ceil(np.minimum(rate * length / _SAMPLE_TURN, 1000.0)).astype(int)
        more = [np.linspace(self._breaks[i], self._breaks[i + 1], parts[i], endpoint=False) for i in tight]
        if more:
            s = np.unique(np.concatenate([s, *more]))
        lent = lend(CurveSamples, count=len(s), stride=math.isqrt(len(s)))
        lent.workspace.max_gap = float(np.diff(s).max()) * self._max_speed()
        lent.arrays["s"][:] = s
        lent.arrays["x"][:], lent.arrays["y"][:] = self.derivatives(s)[0].T
        return lent.workspace

    def _max_speed(self) -> float:
        """Bound of the length of the first derivative, from the control points of that parabola."""
        a, b, c = self._powers[:3]
        length = np.diff(self._breaks)[:, None]
        speeds = [
            np.hypot(*control.T).max()
            for control in (c, c + b * length, c + (2.0 * b + 3.0 * a * length) * length)
        ]
        return max(float(max(speeds)), 1e-9)
