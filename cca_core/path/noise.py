"""Noise of waypoints: its standard deviation, and single outliers."""

import math

import numpy as np

from cca_core._checks import Array, Mask
from cca_core.geometry import arc_length

__all__ = ["estimate_noise", "find_outliers", "isolated"]

_DENSE = 0.15  # noise at which waypoints are dense [chords]
_MAX_GROWTH = 1.75  # of the estimate, from all waypoints to every second one [-]
_SPIKE_TURN = math.radians(100.0)  # at a far waypoint that is no corner [rad]


def estimate_noise(points: Array) -> float:
    """Estimate the standard deviation of waypoints in x and y [m]; 0 if there are too few points."""
    noise = 0.0
    while len(points) >= 12:
        # the road counts as error where it is no cubic; then a quintic leaves less of it
        found = min(_scatter(points, degree) for degree in (3, 5))
        if noise and found > _MAX_GROWTH * noise:
            break  # that is the shape of the road
        noise = max(noise, found)
        if noise <= _DENSE * float(np.median(np.hypot(*np.diff(points, axis=0).T))):
            break
        points = points[::2]  # the way from point to point is mostly noise, and the estimate too low
    return noise


def _scatter(points: Array, degree: int) -> float:
    """Estimate the standard deviation about polynomials through three points more than their degree."""
    width = degree + 3
    s = arc_length(points)
    rows = np.arange(len(points) - width + 1)[:, None] + np.arange(width)
    t = s[rows] - s[rows].mean(axis=1, keepdims=True)
    t /= np.abs(t).max(axis=1, keepdims=True)
    basis = np.linalg.qr(t[..., None] ** np.arange(degree + 1))[0]
    window = points[rows] - points[rows[:, :1]]
    residual = window - basis @ (basis.swapaxes(1, 2) @ window)
    squared = (residual**2).sum(axis=(1, 2))
    # The median of chi-square with four degrees of freedom is 3.357. It ignores up to half of the windows, so
    # outliers and corners do not count. The chord length follows errors along the road, and so hides a third.
    return 1.5 * math.sqrt(float(np.median(squared)) / 3.357)


def find_outliers(points: Array, noise: float, tolerance: float, max_offset: float) -> tuple[Mask, Mask]:
    """Find single waypoints that leave the course of three neighbors on both sides, and spikes among them.

    A waypoint farther away than `max_offset` is a corner of the road, unless it is a spike.
    """
    n = len(points)
    found, spikes = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
    if n < 7:
        return found, spikes
    limit = max(tolerance, 6.0 * noise)
    window = points[np.arange(n - 6)[:, None] + np.arange(7)]
    step = np.diff(window, axis=1)
    length = np.hypot(step[..., 0], step[..., 1])
    skip = np.hypot(*(window[:, 4] - window[:, 2]).T)[:, None]  # from neighbor to neighbor
    share = length[:, 2:3] / np.maximum(length[:, 2:3] + length[:, 3:4], 1e-9)
    t = np.hstack((np.cumsum(length[:, 1::-1], axis=1)[:, ::-1] * -1.0, 0.0 * skip, skip * share, skip,
                   skip + np.cumsum(length[:, 4:], axis=1)))  # fmt: skip
    t /= np.maximum(np.abs(t).max(axis=1, keepdims=True), 1e-9)
    powers = t[..., None] ** np.arange(4)
    others = np.delete(np.arange(7), 3)
    basis, triangle = np.linalg.qr(powers[:, others])
    neighbors = window[:, others] - window[:, 3:4]
    residual = neighbors - basis @ (basis.swapaxes(1, 2) @ neighbors)
    scatter = np.sqrt((residual**2).sum(axis=(1, 2)) / 4.0)
    regular = np.abs(np.diagonal(triangle, axis1=1, axis2=2)).min(axis=1) > 1e-6
    triangle[~regular] = np.eye(4)
    course = powers[:, 3:4] @ np.linalg.solve(triangle, basis.swapaxes(1, 2) @ neighbors)
    off = np.hypot(course[:, 0, 0], course[:, 0, 1])
    cosine = (step[:, 2] * step[:, 3]).sum(axis=1) / np.maximum(length[:, 2] * length[:, 3], 1e-9)
    far = off > max_offset
    spikes[3:-3] = far & (cosine < math.cos(_SPIKE_TURN))
    found[3:-3] = regular & (off > limit) & (scatter < 0.25 * np.minimum(off, limit))
    found[3:-3] &= spikes[3:-3] | ~far
    return isolated(found), spikes


def isolated(exceeding: Mask) -> Mask:
    """Find which rows exceed a limit although no row next to them does."""
    alone = exceeding.copy()
    alone[1:] &= ~exceeding[:-1]
    alone[:-1] &= ~exceeding[1:]
    return alone
