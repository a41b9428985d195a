"""The polyline of the waypoints: its gaps, and how far a curve swings off it."""

import math

import numpy as np

from cca_core._checks import Array, Index, Mask

__all__ = ["bridge_gaps", "chord_deviation", "max_neighbor_chord"]

_GAP_RATIO, _GAP_LEAST = 4.0, 20.0  # a chord over 4 medians (and 20 m) is a gap


def bridge_gaps(points: Array, chords: Array) -> tuple[Array, Mask]:
    """Put points on chords far longer than the others, so that a fit is straight where nothing is known.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        Waypoints [m].
    chords : ndarray, shape (n - 1,)
        Distances between them [m].

    Returns
    -------
    dense : ndarray, shape (m, 2)
        The same with points in the gaps [m].
    given : ndarray of bool, shape (m,)
        Which of them are waypoints.
    """
    parts = np.ceil(chords / max(_GAP_RATIO * float(np.median(chords)), _GAP_LEAST)).astype(int)
    index = np.repeat(np.arange(len(chords)), parts)
    share = (np.arange(len(index)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[index]
    dense = points[index] + share[:, None] * np.diff(points, axis=0)[index]
    return np.vstack((dense, points[-1:])), np.append(share == 0.0, True)


def max_neighbor_chord(points: Array, closed: bool) -> Array:
    """Return the longest of each chord and its two neighbors.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        Points of a polyline [m].
    closed : bool
        Whether its last chord and its first are neighbors.

    Returns
    -------
    longest : ndarray, shape (n - 1,)
        Lengths [m].
    """
    chord = np.hypot(*np.diff(points, axis=0).T)
    longest: Array = np.max([chord[_neighbor(len(chord), by, closed)] for by in (-1, 0, 1)], axis=0)
    return longest


def chord_deviation(curve: Array, points: Array, closed: bool) -> Array:
    """Distance of a curve from the chord that it belongs to, or the one before or after.

    Parameters
    ----------
    curve : ndarray, shape (n - 1, k, 2)
        Places on the curve between each two points [m].
    points : ndarray, shape (n, 2)
        Points of the polyline [m], no two neighbors equal.
    closed : bool
        Whether its last chord and its first are neighbors.

    Returns
    -------
    off : ndarray, shape (n - 1, k)
        Distances from the nearest of the three [m].
    """
    start, step = points[:-1], np.diff(points, axis=0)
    off = np.full(curve.shape[:2], math.inf)
    for by in (-1, 0, 1):
        i = _neighbor(len(step), by, closed)
        out, along = curve - start[i, None], step[i, None]
        share = np.clip((out * along).sum(-1) / (along * along).sum(-1), 0.0, 1.0)
        aside = out - share[..., None] * along
        off = np.minimum(off, np.hypot(aside[..., 0], aside[..., 1]))
    return off


def _neighbor(n: int, by: int, closed: bool) -> Index:
    """Place of each of n chords' neighbor `by` further on."""
    i = np.arange(n) + by
    return i % n if closed else i.clip(0, n - 1)
