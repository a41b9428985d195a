"""Polyline of the waypoints: gaps, and deviation of a curve from the chords."""

import math

import numpy as np

from cca_core._checks import Array, Index, Mask

__all__ = ["bridge_gaps", "chord_deviation", "max_neighbor_chord"]

_MAX_ADDED = 100_000  # points on long chords [-]


def bridge_gaps(points: Array, chords: Array) -> tuple[Array, Mask]:
    """Add points on very long chords, where a fit is to be straight; return them and which are given."""
    gap = max(4.0 * float(np.median(chords)), 20.0, float(chords.sum()) / _MAX_ADDED)  # [m]
    parts = np.ceil(chords / gap).astype(int)
    index = np.repeat(np.arange(len(chords)), parts)
    fraction = (np.arange(len(index)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[index]
    dense = points[index] + fraction[:, None] * np.diff(points, axis=0)[index]
    return np.vstack((dense, points[-1:])), np.append(fraction == 0.0, True)


def max_neighbor_chord(points: Array, closed: bool) -> Array:
    """Longest of each chord and its two neighbors [m], shape (n - 1,)."""
    chord = np.hypot(*np.diff(points, axis=0).T)
    longest: Array = np.max([chord[_neighbor(len(chord), by, closed)] for by in (-1, 0, 1)], axis=0)
    return longest


def chord_deviation(curve: Array, points: Array, closed: bool) -> Array:
    """Distance of curve points (n - 1, k, 2) from the nearest of their chord and its neighbors [m]."""
    start, step = points[:-1], np.diff(points, axis=0)
    deviation = np.full(curve.shape[:2], math.inf)
    for by in (-1, 0, 1):
        i = _neighbor(len(step), by, closed)
        out, along = curve - start[i, None], step[i, None]
        fraction = np.clip((out * along).sum(-1) / (along * along).sum(-1), 0.0, 1.0)
        residual = out - fraction[..., None] * along
        deviation = np.minimum(deviation, np.hypot(residual[..., 0], residual[..., 1]))
    return deviation


def _neighbor(n: int, by: int, closed: bool) -> Index:
    """Index of the neighbor of each of n chords, `by` chords ahead."""
    i = np.arange(n) + by
    return i % n if closed else i.clip(0, n - 1)
