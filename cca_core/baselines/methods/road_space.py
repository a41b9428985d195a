"""The road as the states of a random tree see it: samples of it, and whether a pose on it is free."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from cca_core._checks import Array
from cca_core.baselines.methods.free_space import RouteSamples, free_cells, sample_route
from cca_core.baselines.problems.problem import Problem

STATION = 0.5
"""Between states of a motion that are checked, and between stations of the table [m]."""

State = Any
"""A state of OMPL, with getX, getY and getYaw."""

_CELL = 0.05  # lateral spacing of the table [m]
_TURN = 0.0125  # spacing of its headings [rad]
_STEEPEST = 0.6  # largest heading relative to the road [rad]
_SPREAD = 0.4  # standard deviation of sampled headings, as a part of the steepest
_GOAL = 0.05  # part of the samples that are the goal
_DRAWS = 4  # poses drawn for each sample, of which those that are free are taken
_TILE = 1.0  # of the grid in which the station near a place is looked up [m]


@dataclass(frozen=True, slots=True, eq=False)
class RoadSpace:
    """The road as the tree sees it.

    Parameters
    ----------
    at : Stretch
        Stations of the table.
    table : bytes
        Whether poses are free, at stations, headings and offsets.
    shape : tuple of int
        Of the table.
    offsets : ndarray, shape (shape[2],)
        Lateral coordinates of the table [m], left positive.
    steepest : float
        Largest heading relative to the road of a sample [rad].
    kappa : float
        Curvature of the motions [1/m], such that the limits hold at the speed driven.
    message : str
        Why there is no path at all, or nothing.
    """

    at: RouteSamples
    table: bytes
    shape: tuple[int, int, int]
    offsets: Array
    steepest: float
    kappa: float
    message: str

    @classmethod
    def of(cls, problem: Problem) -> Self:
        """Look where the body is free.

        Parameters
        ----------
        problem : Problem
            What is to be driven.

        Returns
        -------
        corridor : Corridor
            Its road between start and goal.
        """
        half, road = 0.5 * problem.vehicle.width, problem.road
        right, left = road.right_edge + half, road.left_edge - half
        n = math.ceil((problem.goal - problem.start) / STATION) + 1
        at = sample_route(problem, np.linspace(problem.start, problem.goal, n))
        steepest = min(math.sqrt(max(left - right, _CELL) * problem.kappa_max), _STEEPEST)
        fastest = (1.0 + float(np.abs(at.kappa).max()) * max(-right, left)) ** 2 + math.tan(steepest) ** 2
        steering = math.tan(problem.vehicle.delta_max) / problem.vehicle.wheelbase
        kappa = min(problem.a_y_max / (problem.v_x**2 * fastest), steering)
        widest = math.ceil(steepest / _TURN)
        headings: Array = _TURN * np.arange(-widest, widest + 1, dtype=np.float64)
        # the route itself is the middle of a cell
        least, most = math.ceil(right / _CELL - 1e-9), math.floor(left / _CELL + 1e-9)
        offsets: Array = _CELL * np.arange(least, most + 1, dtype=np.float64)
        if len(offsets) < 2:
            return cls(at, b"", (0, 0, 0), offsets, steepest, kappa, "the body does not fit on the road")
        others = max((abs(other.v_x) for other in problem.others), default=0.0)
        margin = 0.5 * STATION * (1.0 + others / problem.v_x)
        cells = free_cells(problem, at, headings, offsets, station_margin=margin)
        free = np.repeat(cells.between_edges[None], n, axis=0)
        free[cells.near] = cells.there
        blocked = np.flatnonzero(~free.any(axis=(1, 2)))
        message = f"no pose is free {at.s[blocked[0]] - problem.start:.1f} m ahead" if len(blocked) else ""
        return cls(at, free.tobytes(), free.shape, offsets, steepest, kappa, message)

    @property
    def start(self) -> tuple[float, float, float]:
        """First pose: x, y [m] and heading [rad]."""
        return self._pose(0)

    @property
    def goal(self) -> tuple[float, float, float]:
        """Last pose: x, y [m] and heading [rad]."""
        return self._pose(-1)

    def _pose(self, i: int) -> tuple[float, float, float]:
        place, along = self.at.place[i], self.at.along[i]
        return float(place.real), float(place.imag), float(np.angle(along))

    def samples(self, rng: np.random.Generator, count: int) -> list[tuple[float, float, float]]:
        """Draw free poses on the road.

        Parameters
        ----------
        rng : numpy.random.Generator
            Source of randomness.
        count : int
            How many.

        Returns
        -------
        samples : list of tuple of float
            x, y [m] and heading [rad]; one in twenty is the goal.
        """
        n, turns, cells = self.shape
        free = np.frombuffer(self.table, dtype=np.bool_)
        i, k = rng.integers(0, n, _DRAWS * count), rng.integers(0, cells, _DRAWS * count)
        angle = np.clip(_SPREAD * self.steepest * rng.standard_normal(len(i)), -self.steepest, self.steepest)
        h = turns // 2 + np.rint(angle / _TURN).astype(int)
        keep = np.flatnonzero(free[(i * turns + h) * cells + k])[:count]
        keep = np.resize(keep, count) if len(keep) else np.arange(count)
        i, d, angle = i[keep], self.offsets[k[keep]], angle[keep]
        place = self.at.place[i] + 1j * d * self.at.along[i]
        drawn = np.column_stack((place.real, place.imag, np.angle(self.at.along[i] * np.exp(1j * angle))))
        drawn[rng.random(count) < _GOAL] = self.goal
        return [(x, y, angle) for x, y, angle in drawn.tolist()]

    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Least and largest x and y of the road [m]."""
        sides = np.array((self.offsets[0], self.offsets[-1]))
        border = (self.at.place + 1j * sides[:, None] * self.at.along).ravel()
        x, y = border.real, border.imag
        return (float(x.min()) - 1.0, float(x.max()) + 1.0), (float(y.min()) - 1.0, float(y.max()) + 1.0)

    def check(self) -> Callable[[State], bool]:
        """Make the validity check of a state: a few look-ups in plain Python.

        Returns
        -------
        check : callable
            Whether the body is free in a state.
        """
        (x_0, x_1), (y_0, y_1) = self.bounds()
        columns, rows = int((x_1 - x_0) / _TILE) + 1, int((y_1 - y_0) / _TILE) + 1
        across = np.arange(self.offsets[0] - 1.0, self.offsets[-1] + 1.0, 0.4 * _TILE)
        place = (self.at.place[:, None] + 1j * across * self.at.along[:, None]).ravel()
        column, row = ((place.real - x_0) / _TILE).astype(int), ((place.imag - y_0) / _TILE).astype(int)
        inside = (place.real >= x_0) & (place.imag >= y_0) & (column < columns) & (row < rows)
        tiles = np.full(columns * rows, -1)
        tiles[(row * columns + column)[inside]] = np.repeat(np.arange(len(self.at.s)), len(across))[inside]
        station = tiles.tolist()
        place, along = self.at.place, self.at.along
        px, py, tx, ty = place.real.tolist(), place.imag.tolist(), along.real.tolist(), along.imag.tolist()
        bend = self.at.kappa.tolist()
        heading = np.angle(along).tolist()
        free, (n, turns, cells) = self.table, self.shape
        lowest, spacing = float(self.offsets[0]), float(self.at.s[1] - self.at.s[0])
        middle, two_pi = turns // 2, 2.0 * math.pi

        def check(state: State) -> bool:
            x: float = state.getX()
            y: float = state.getY()
            c, r = int((x - x_0) / _TILE), int((y - y_0) / _TILE)
            if not (0 <= c < columns and 0 <= r < rows):
                return False
            i = station[r * columns + c]
            if i < 0:
                return False
            dx, dy, a, b, kappa = x - px[i], y - py[i], tx[i], ty[i], bend[i]
            ahead, d = dx * a + dy * b, dy * a - dx * b
            d -= 0.5 * kappa * ahead * ahead
            ahead /= 1.0 - kappa * d
            turn: float = math.remainder(state.getYaw() - heading[i] - kappa * ahead, two_pi)
            i += round(ahead / spacing)
            h, k = middle + round(turn / _TURN), round((d - lowest) / _CELL)
            if not (0 <= i < n and 0 <= h < turns and 0 <= k < cells):
                return False
            found: bool = free[(i * turns + h) * cells + k] == 1
            return found

        return check
