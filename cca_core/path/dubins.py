"""Paths of arcs and lines between two poses (Dubins, 1957)."""

import math

import numpy as np

from cca_core._checks import Array

__all__ = ["WORDS", "along_dubins", "dubins_lengths"]

WORDS = np.array(
    [
        [1, 0, 1], [1, 0, -1], [-1, 0, 1], [-1, 0, -1],
        [1, -1, 1], [1, -1, 1], [-1, 1, -1], [-1, 1, -1],
    ],
    dtype=np.float64,
)  # fmt: skip
"""Turns of the three pieces of each path: left 1, right -1, straight 0."""


def dubins_lengths(first: Array, last: Array, radius: float) -> Array:
    """Lengths of the pieces of every path between poses (n, 3), shape (n, 8, 3); inf if there is none."""
    lengths = np.full((len(first), len(WORDS), 3), math.inf)
    for word, (a, b, c) in enumerate(WORDS):
        # centers of the first and the last circle
        ends = [
            pose[:, :2] + turn * radius * np.column_stack((-np.sin(pose[:, 2]), np.cos(pose[:, 2])))
            for pose, turn in ((first, a), (last, c))
        ]
        x, y = (ends[1] - ends[0]).T
        distance, bearing = np.hypot(x, y), np.arctan2(y, x)
        if b:
            possible = distance < 4.0 * radius
            # headings where the middle circle touches the first and the last one
            angle = (1.0 if word % 2 else -1.0) * np.arccos(np.minimum(distance / (4.0 * radius), 1.0))
            enter, leave = bearing + angle + 0.5 * math.pi * a, bearing + math.pi - angle + 0.5 * math.pi * a
            middle = _arc(b, enter, leave, radius)
        elif a == c:
            possible, enter, leave, middle = distance >= 0.0, bearing, bearing, distance
        else:
            possible = distance >= 2.0 * radius
            safe = np.where(possible, distance, 2.0 * radius)
            enter = leave = bearing + a * np.arcsin(2.0 * radius / safe)
            middle = np.sqrt(safe**2 - 4.0 * radius**2)
        found = (_arc(a, first[:, 2], enter, radius), middle, _arc(c, leave, last[:, 2], radius))
        lengths[possible, word] = np.column_stack(found)[possible]
    return lengths


def along_dubins(first: Array, turns: Array, lengths: Array, radius: float, s: Array) -> Array:
    """Positions at arc lengths (n, k) on paths from poses (n, 3), shape (n, k, 2)."""
    x, y, psi = (column[:, None] for column in first.T)
    for turn, length, before in zip(
        turns.T, lengths.T, (np.cumsum(lengths, axis=1) - lengths).T, strict=True
    ):
        step, rate = np.clip(s - before[:, None], 0.0, length[:, None]), turn[:, None] / radius
        heading, side = psi + rate * step, turn[:, None] * radius
        is_arc = side != 0.0
        x = x + np.where(is_arc, side * (np.sin(heading) - np.sin(psi)), step * np.cos(psi))
        y = y - np.where(is_arc, side * (np.cos(heading) - np.cos(psi)), -step * np.sin(psi))
        psi = heading
    return np.stack((x, y), axis=-1)


def _arc(turn: float, start: Array, end: Array, radius: float) -> Array:
    """Length of an arc between two headings."""
    angle = (turn * (end - start)) % (2.0 * math.pi)
    length: Array = np.where(2.0 * math.pi - angle < 1e-6, 0.0, angle * radius)
    return length
