"""Bends beyond a curvature limit, replaced by arcs and lines that a car can drive."""

import math

import numpy as np

from cca_core._checks import Array, Index
from cca_core.path.dubins import WORDS, along_dubins, dubins_lengths
from cca_core.path.path import Path

__all__ = ["round_bends"]

_SPACING = 1.0  # of positions on arcs; a tenth of a radius where that is less [m]
_FAR_SPACING, _FAR_TURN = 8.0, 0.05  # of positions elsewhere [m], and turn between them [rad]
_NODE_SPACING = 0.75  # of the poses that arcs may join [radii]
_MARGIN = 8.0  # of path next to a bend that arcs may replace [radii]
_JUMPS = np.array([*range(1, 17), 20, 24, 32, 40, 48, 64])  # nodes that one replacement may span
_SAMPLES = 24  # of the path and of the arcs that are compared
_CHUNK = 4000  # replacements compared at once
_OUTSIDE, _ADDED = 0.25, 0.2  # weights of the distance of arcs from the path, and of the length that they add


def round_bends(path: Path, limit: float, radius: float) -> Array:
    """Positions along a path in which bends beyond the limit are arcs of a radius, shape (n, 2)."""
    spacing = min(_SPACING, 0.1 * radius)
    length = np.diff(path.breaks)
    fine = path.breaks[:-1, None] + length[:, None] * np.linspace(0.0, 1.0, 9)
    kappa = np.abs(path.curvature(fine))
    sharp = np.unique(fine[kappa > limit])
    s = _stations(path, kappa.max(axis=1) * length)
    if not len(sharp):
        return path.position(s)
    pieces, done = [path.position(s[:1])], path.start
    for start, end, arcs in _replacements(path, sharp, radius, spacing):
        pieces += [path.position(s[(s > done) & (s < start)]), arcs]
        done = end
    pieces.append(path.position(s[s > done]))
    positions = np.vstack(pieces)
    apart = np.append(True, np.hypot(*np.diff(positions, axis=0).T) > 0.2 * spacing)
    found: Array = positions[apart]
    return found


def _stations(path: Path, turn: Array) -> Array:
    """Stations from the start to the end, closer in bends, from the turn of each segment."""
    length = np.diff(path.breaks)
    parts = np.ceil(np.maximum(length / _FAR_SPACING, np.minimum(turn / _FAR_TURN, 50.0))).astype(np.intp)
    index = np.repeat(np.arange(len(parts)), parts)
    fraction = (np.arange(len(index)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[index]
    return np.append(path.breaks[index] + fraction * length[index], path.end)


def _replacements(
    path: Path, sharp: Array, radius: float, spacing: float
) -> list[tuple[float, float, Array]]:
    """Parts of the path that are replaced, and the arcs for them: those that deviate least."""
    found = []
    margin = _MARGIN * radius
    borders = np.flatnonzero(np.diff(sharp) > 2.0 * margin)
    bends = zip(sharp[np.append(0, borders + 1)], sharp[np.append(borders, -1)], strict=True)
    for first, last in bends:
        low, high = max(first - margin, path.start), min(last + margin, path.end)
        within = sharp[(sharp >= low) & (sharp <= high)]
        runs = np.split(within, 1 + np.flatnonzero(np.diff(within) > 0.25 * radius))
        nodes = np.union1d(
            np.linspace(low, high, max(2, math.ceil((high - low) / (_NODE_SPACING * radius)) + 1)),
            [run[len(run) // 2] for run in runs],
        )
        found += _Window(path, nodes, within, radius).replaced(spacing)
    return found


class _Window:
    """Poses along a part of the path, and the arcs between them."""

    def __init__(self, path: Path, nodes: Array, sharp: Array, radius: float) -> None:
        self._path, self._nodes, self._sharp, self._radius = path, nodes, sharp, radius
        n = len(nodes)
        sharp_before = np.searchsorted(sharp, nodes)
        # away from sharp bends the heading of the path alone counts; there it may be noise
        near = np.searchsorted(sharp, nodes + 2.0 * radius) > np.searchsorted(sharp, nodes - 2.0 * radius)
        near[[0, -1]] = [nodes[0] == path.start, nodes[-1] == path.end]
        chord = path.position(np.minimum(nodes + radius, nodes[-1])) - path.position(
            np.maximum(nodes - radius, nodes[0])
        )
        self._node = np.concatenate((np.arange(n), np.flatnonzero(near)))
        heading = np.concatenate((path.heading(nodes), np.arctan2(chord[:, 1], chord[:, 0])[near]))
        self._pose = np.column_stack((path.position(nodes)[self._node], heading))
        self._edges(sharp_before, n)

    def _edges(self, sharp_before: Index, n: int) -> None:
        """List the pairs of poses that arcs may join, and the paths that deviate least."""
        states: list[list[int]] = [[] for _ in range(n)]
        for state, node in enumerate(self._node.tolist()):
            states[node].append(state)
        pairs = []
        for i in range(n):
            for j in (i + _JUMPS[_JUMPS < n - i]).tolist():
                is_sharp = sharp_before[j] > sharp_before[i]
                pairs += [(a, b) for a in states[i] for b in states[j] if is_sharp or a >= n or b >= n]
        self._pairs = np.array(pairs, dtype=np.intp).reshape(-1, 2)
        first, last = self._pairs.T
        lengths = dubins_lengths(self._pose[first], self._pose[last], self._radius)
        words = np.argsort(lengths.sum(axis=2), axis=1)[:, :3]
        cost = np.column_stack([self._costs(lengths, words[:, k]) for k in range(3)])
        best = np.argmin(cost, axis=1)
        rows = np.arange(len(best))
        self._word = words[rows, best]
        self._lengths = lengths[rows, self._word]
        self._cost = cost[rows, best]

    def _costs(self, lengths: Array, words: Index) -> Array:
        """Cost of the distance between arcs and the path that they replace."""
        cost = np.empty(len(words))
        fraction = np.linspace(0.0, 1.0, _SAMPLES)
        for begin in range(0, len(words), _CHUNK):
            rows = np.arange(begin, min(begin + _CHUNK, len(words)))
            first, last = self._pairs[rows].T
            taken = lengths[rows, words[rows]]
            at = taken.sum(axis=1)[:, None] * fraction
            arcs = along_dubins(self._pose[first], WORDS[words[rows]], taken, self._radius, at)
            start, end = self._nodes[self._node[first]], self._nodes[self._node[last]]
            replaced = self._path.position(start[:, None] + (end - start)[:, None] * fraction)
            apart = ((arcs[:, :, None] - replaced[:, None]) ** 2).sum(-1)
            from_arcs, from_path = apart.min(axis=2), apart.min(axis=1)
            area = from_path.mean(axis=1) * (end - start)
            farthest = from_path.max(axis=1) + _OUTSIDE * from_arcs.max(axis=1)
            added = np.maximum(at[:, -1] - (end - start), 0.0)
            cost[rows] = area / self._radius**3 + farthest / self._radius**2 + _ADDED * added / self._radius
        return cost

    def replaced(self, spacing: float) -> list[tuple[float, float, Array]]:
        """Parts of the path and the arcs instead, by dynamic programming over the poses."""
        n, nodes = len(self._nodes), self._nodes
        gentle = np.diff(np.searchsorted(self._sharp, nodes)) == 0
        cost = np.full(len(self._node), math.inf)
        before = np.full(len(self._node), -1)
        taken = np.full(len(self._node), -1)
        starts = self._node == 0
        cost[starts] = 0.0
        by_last: list[list[int]] = [[] for _ in range(len(self._node))]
        for edge, last in enumerate(self._pairs[:, 1].tolist()):
            by_last[last].append(edge)
        for state in np.argsort(self._node, kind="stable").tolist():
            node = int(self._node[state])
            if 0 < node == state and gentle[node - 1]:
                cost[state], before[state] = cost[state - 1], state - 1
            edges = np.array(by_last[state], dtype=np.intp)
            if len(edges):
                total = cost[self._pairs[edges, 0]] + self._cost[edges]
                k = int(np.argmin(total))
                if total[k] < cost[state]:
                    cost[state], before[state], taken[state] = total[k], self._pairs[edges[k], 0], edges[k]
        ends = np.flatnonzero(self._node == n - 1)
        state = int(ends[np.argmin(cost[ends])])
        found = []
        while before[state] >= 0:
            if taken[state] >= 0:
                found.append(self._arcs(int(taken[state]), spacing))
            state = int(before[state])
        return found[::-1]

    def _arcs(self, edge: int, spacing: float) -> tuple[float, float, Array]:
        first, last = self._pairs[edge]
        lengths = self._lengths[edge : edge + 1]
        total = float(lengths.sum())
        at = np.linspace(0.0, total, max(2, math.ceil(total / spacing) + 1))[None]
        arcs = along_dubins(self._pose[[first]], WORDS[self._word[[edge]]], lengths, self._radius, at)[0]
        return float(self._nodes[self._node[first]]), float(self._nodes[self._node[last]]), arcs
