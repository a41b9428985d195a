"""Piecewise cubics in the plane: evaluation and foot points, for arrays and single floats."""

import math
from bisect import bisect_right
from functools import cached_property
from typing import Any

import numpy as np

from cca_core._checks import Array

_MAX_ITERATIONS = 12  # Newton converges in 2 to 4; points far off a tight curve need more
_STEP_TOLERANCE = 1e-9  # [m]
_CHUNK = 8192  # positions whose intermediate results stay in the cache
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
        breaks, pieces = self._lists
        on = s if breaks[0] <= s <= breaks[-1] else min(max(s, breaks[0]), breaks[-1])
        i = bisect_right(breaks, on, 1, len(pieces)) - 1
        ax, ay, bx, by, cx, cy, dx, dy = pieces[i]
        t = on - breaks[i]
        px, py = ((ax * t + bx) * t + cx) * t + dx, ((ay * t + by) * t + cy) * t + dy
        tx, ty = (3.0 * ax * t + 2.0 * bx) * t + cx, (3.0 * ay * t + 2.0 * by) * t + cy
        if s == on:
            return px, py, tx, ty, 6.0 * ax * t + 2.0 * bx, 6.0 * ay * t + 2.0 * by
        return px + (s - on) * tx, py + (s - on) * ty, tx, ty, 0.0, 0.0

    def foot_point(self, x: float, y: float, s_guess: float) -> tuple[float, float, float, float]:
        """Foot point of one position: s, d, heading and curvature."""
        s = s_guess
        for _ in range(_MAX_ITERATIONS):
            px, py, tx, ty, nx, ny = self.at(s)
            speed2 = tx * tx + ty * ty
            out = (px - x) * tx + (py - y) * ty
            step = out / max(speed2 + (px - x) * nx + (py - y) * ny, 0.2 * speed2)
            if -_STEP_TOLERANCE < step < _STEP_TOLERANCE:
                break
            s -= step
        else:
            px, py, tx, ty, nx, ny = self.at(s)
        speed = math.hypot(tx, ty)
        d = (tx * (y - py) - ty * (x - px)) / speed
        return s, d, math.atan2(ty, tx), (tx * ny - ty * nx) / speed**3

    def foot_points(self, xy: Array, s_guess: Array) -> tuple[Array, Array]:
        """Foot points s, d of positions, shape (n, 2), by Newton from initial guesses, shape (n,)."""
        s, d = s_guess.copy(), np.empty(len(xy))
        for begin in range(0, len(xy), _CHUNK):
            chunk = slice(begin, begin + _CHUNK)
            self._newton(xy[chunk, 0].copy(), xy[chunk, 1].copy(), s[chunk], d[chunk])
        return s, d

    def nearest(self, xy: Array) -> tuple[Array, Array]:
        """Foot points s, d of positions, shape (n, 2), nearest on the whole curve."""
        s, d = np.empty(len(xy)), np.empty(len(xy))
        for begin in range(0, len(xy), _CHUNK):
            chunk = slice(begin, begin + _CHUNK)
            self._search(xy[chunk], s[chunk], d[chunk])
        return s, d

    def _newton(self, x: Array, y: Array, s: Array, d: Array) -> None:
        """Iterate `s` to the foot points and fill `d`; converged positions are skipped."""
        left = np.arange(len(s))
        u = s.copy()
        for iteration in range(_MAX_ITERATIONS + 1):
            on = np.minimum(np.maximum(u, self._breaks[0]), self._breaks[-1])
            i = np.searchsorted(self._inner, on, side="right")
            ax, ay, bx, by, cx, cy, dx, dy = (row.take(i) for row in self._table)
            t, beyond = on - self._breaks.take(i), u - on
            tx, ty = (3.0 * ax * t + 2.0 * bx) * t + cx, (3.0 * ay * t + 2.0 * by) * t + cy
            px = ((ax * t + bx) * t + cx) * t + dx + beyond * tx - x
            py = ((ay * t + by) * t + cy) * t + dy + beyond * ty - y
            speed2 = tx * tx + ty * ty
            curved = px * (6.0 * ax * t + 2.0 * bx) + py * (6.0 * ay * t + 2.0 * by)
            curved[beyond != 0.0] = 0.0
            step = (px * tx + py * ty) / np.maximum(speed2 + curved, 0.2 * speed2)
            s[left], d[left] = u, (ty * px - tx * py) / np.sqrt(speed2)
            far = np.flatnonzero(np.abs(step) >= _STEP_TOLERANCE)
            if not len(far) or iteration == _MAX_ITERATIONS:
                return
            left, x, y, u = left[far], x[far], y[far], (u - step)[far]

    def _search(self, xy: Array, s: Array, d: Array) -> None:
        """Run Newton from every local minimum of the samples that may lead to the nearest point."""
        at, tree, points = self._samples
        left, k = np.arange(len(xy)), min(4, len(at))
        while len(left):
            distance, sample = tree.query(xy[left], k=k)
            # the nearest point of the curve has a sample within half a spacing
            limit = distance[:, :1] + 0.5 * _SPACING
            complete = (distance[:, -1:] >= limit)[:, 0] | (k == len(at))
            here = xy[left[complete], None, :]
            near, index = distance[complete], sample[complete]
            minimum = near <= limit[complete]
            for side in (-1, 1):
                other = points[np.clip(index + side, 0, len(at) - 1)] - here
                minimum &= near <= np.hypot(other[..., 0], other[..., 1])
            minimum[:, 0] = True  # even if rounding decides between two
            row, column = np.nonzero(minimum)
            owner = left[complete][row]
            u, offset = self._descend(xy[owner], index[row, column])
            best = np.lexsort((np.abs(offset), owner))
            best = best[np.unique(owner[best], return_index=True)[1]]
            s[owner[best]], d[owner[best]] = u[best], offset[best]
            left, k = left[~complete], min(4 * k, len(at))

    def _descend(self, xy: Array, sample: Any) -> tuple[Array, Array]:
        """Foot points next to samples; where Newton leaves the interval of a sample, by bisection in it."""
        at, _, _ = self._samples
        u, offset = self.foot_points(xy, at[sample])
        low, high = at[np.maximum(sample - 1, 0)], at[np.minimum(sample + 1, len(at) - 1)]
        beyond = (sample == 0) & (u < low) | (sample == len(at) - 1) & (u > high)
        lost = np.flatnonzero(((u < low) | (u > high)) & ~beyond)
        if len(lost):
            low, high, to = low[lost], high[lost], xy[lost]
            for _ in range(50):
                middle = 0.5 * (low + high)
                position, first, _ = self.derivatives(middle)
                ahead = ((position - to) * first).sum(-1) < 0.0
                low, high = np.where(ahead, middle, low), np.where(ahead, high, middle)
            position, first, _ = self.derivatives(low)
            out = to - position
            left_of = first[:, 0] * out[:, 1] - first[:, 1] * out[:, 0] >= 0.0
            u[lost], offset[lost] = low, np.where(left_of, 1.0, -1.0) * np.hypot(out[:, 0], out[:, 1])
        return u, offset

    @cached_property
    def _lists(self) -> tuple[list[float], list[list[float]]]:
        return self._breaks.tolist(), self._table.T.tolist()

    @cached_property
    def _table(self) -> Array:
        """The powers as rows ax, ay, bx, by, cx, cy, dx, dy, shape (8, n_segments)."""
        return np.ascontiguousarray(self._powers.transpose(0, 2, 1).reshape(8, -1))

    @cached_property
    def _samples(self) -> tuple[Array, Any, Array]:
        from scipy.spatial import cKDTree  # slow to import

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
        points = self.derivatives(s)[0]
        return s, cKDTree(points), points
