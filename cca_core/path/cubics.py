"""Piecewise cubics in the plane: evaluation and foot points, for arrays and single floats."""

import math
from functools import cached_property

import numpy as np

from cca_core._checks import Array
from cca_core.kernel import bind
from cca_core.kernel.curve import (
    Curve,
    CurveSamples,
    curvature_at,
    curve_point,
    foot_point,
    foot_points,
    nearest_points,
)
from cca_core.kernel.memory import lend

_curve_point, _curvature_at = bind(curve_point), bind(curvature_at)
_foot_point, _foot_points, _nearest_points = bind(foot_point), bind(foot_points), bind(nearest_points)

_SPACING = 2.0  # of the samples for a search without initial guess [m]
_SAMPLE_TURN = 0.15  # largest turn between such samples [rad]


class Cubics:
    """Cubics over s in powers of meters, straight beyond both ends; `Path` checks the arguments."""

    def __init__(self, breaks: Array, coefficients: Array) -> None:
        self._breaks, self._inner = breaks, breaks[1:-1]
        # shape (4, n_segments, 2), cubic term first
        rate = 1.0 / (breaks[1:] - breaks[:-1])
        scale = np.array((rate * rate * rate, rate * rate, rate, np.ones_like(rate)))
        self._powers = coefficients.transpose(2, 0, 1) * scale[:, :, None]

    def derivatives(self, s: Array) -> tuple[Array, Array, Array]:
        """Position, first and second derivative, shapes (..., 2)."""
        on = np.minimum(np.maximum(s, self._breaks[0]), self._breaks[-1])
        i = np.searchsorted(self._inner, on, side="right")
        a, b, c, d = self._powers.take(i, axis=1)
        t = (on - self._breaks.take(i))[..., None]
        first = (3.0 * a * t + 2.0 * b) * t + c
        position = ((a * t + b) * t + c) * t + d
        second = 6.0 * a * t + 2.0 * b
        beyond = (s - on)[..., None]
        if beyond.any():
            position = position + beyond * first
            second = np.where(beyond == 0.0, second, 0.0)
        return position, first, second

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
        return _curvature_at(self.curve, s)

    def foot_point(self, x: float, y: float, s_guess: float) -> tuple[float, float, float, float]:
        """Foot point of one position: s, d, heading and curvature."""
        return _foot_point(self.curve, x, y, s_guess)

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
        _nearest_points(self.curve, self._samples, len(x), x, y, s, d)
        return s, d

    @cached_property
    def curve(self) -> Curve:
        """The curve in the kernel."""
        lent = lend(Curve, segments=len(self._breaks) - 1)
        lent.arrays["breaks"][:] = self._breaks
        lent.arrays["powers"].reshape(-1, 4, 2)[:] = self._powers.transpose(1, 0, 2)
        return lent.workspace

    @cached_property
    def _samples(self) -> CurveSamples:
        whole = self._breaks[-1] - self._breaks[0]
        s = np.linspace(self._breaks[0], self._breaks[-1], max(2, math.ceil(whole / _SPACING) + 1))
        length = np.diff(self._breaks)
        at = self._breaks[:-1, None] + length[:, None] * np.linspace(0.0, 1.0, 9)
        _, first, second = self.derivatives(at)
        speed = np.maximum(np.hypot(first[..., 0], first[..., 1]), 1e-9)
        cross = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
        rate = (np.abs(cross) / speed**2).max(axis=1)  # of the heading along each segment [rad/m]
        tight = np.flatnonzero(rate * _SPACING > 2.5 * _SAMPLE_TURN)  # radius below 5.3 m
        parts = np.ceil(np.minimum(rate * length / _SAMPLE_TURN, 1000.0)).astype(int)
        more = [np.linspace(self._breaks[i], self._breaks[i + 1], parts[i], endpoint=False) for i in tight]
        if more:
            s = np.unique(np.concatenate([s, *more]))
        lent = lend(CurveSamples, count=len(s), stride=math.isqrt(len(s)))
        lent.workspace.spacing, lent.workspace.max_speed = float(np.diff(s).max()), self._max_speed()
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
