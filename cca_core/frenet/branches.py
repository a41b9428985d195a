"""Branches of a route that passes near itself: every station at which a vehicle is near it."""

import math

import numpy as np

from cca_core.path import Path

__all__ = ["Branches"]

_SPACING = 4.0  # of the samples [m]
_NEAR = 30.0  # distance between two branches up to which a vehicle may be relevant on both [m]
_APART = 120.0  # distance along the route from which on two stations are on two branches [m]
_BEHIND, _AHEAD = 150.0, 450.0  # part of the route around the ego that is searched [m]


class Branches:
    """Stations of a route near a position, within the part of the route around the ego."""

    def __init__(self, path: Path) -> None:
        self._s = np.linspace(path.start, path.end, max(2, math.ceil(path.length / _SPACING) + 1))
        self._xy = path.position(self._s)

    @property
    def passes_itself(self) -> bool:
        """Whether two branches of the route are so near that a vehicle may be relevant on both."""
        from scipy.spatial import cKDTree  # slow to import

        pairs = cKDTree(self._xy[::2]).query_pairs(_NEAR, output_type="ndarray")
        apart = _APART / (2.0 * float(self._s[1] - self._s[0]))
        return bool(len(pairs)) and int((pairs[:, 1] - pairs[:, 0]).max()) > apart

    def near(self, x: float, y: float, s_ego: float) -> list[float]:
        """Stations of the branches near a position, at least the nearest one [m]."""
        first, last = np.searchsorted(self._s, (s_ego - _BEHIND, s_ego + _AHEAD))
        first, last = min(int(first), len(self._s) - 2), max(int(last), 2)
        part = self._xy[first:last]
        distance = np.hypot(part[:, 0] - x, part[:, 1] - y)
        padded = np.concatenate(([math.inf], distance, [math.inf]))
        minimum = (distance <= padded[:-2]) & (distance < padded[2:]) & (distance <= _NEAR)
        minimum[int(np.argmin(distance))] = True
        stations: list[float] = self._s[first:last][minimum].tolist()
        return stations
