"""The road as a random tree uses it: samples of free poses, and the validity of a pose."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from cca_core._checks import Array
from cca_core.baselines.methods.free_space import RouteSamples, free_cells, sample_route
from cca_core.baselines.problems.problem import Problem

STATION_STEP = 0.5
"""Distance between checked states of a motion, and between stations of the table [m]."""

State = Any
"""A state of OMPL, with getX, getY and getYaw."""

Pose = tuple[float, float, float]
"""x, y [m] and heading [rad]."""

_TILE = 1.0  # of the grid in which the station near a position is looked up [m]


@dataclass(frozen=True, slots=True, eq=False)
class RoadSpace:
    """Table of free poses between start and goal."""

    at: RouteSamples  # stations of the table
    table: bytes  # whether poses are free, by station, heading and offset
    shape: tuple[int, int, int]
    offsets: Array  # of the table [m], left positive
    cell_width: float  # distance between the offsets [m]
    heading_step: float  # of the table [rad]
    max_heading: float  # of a sample relative to the road [rad]
    kappa: float  # curvature of the motions, such that the limits hold at the speed driven [1/m]
    message: str  # reason why no path exists, or empty

    @classmethod
    def of(cls, problem: Problem, cell_width: float, heading_step: float, max_heading: float) -> Self:
        """Compute the table of a problem."""
        half, road = 0.5 * problem.vehicle.width, problem.road
        right, left = road.right_edge + half, road.left_edge - half
        n = math.ceil((problem.goal - problem.start) / STATION_STEP) + 1
        at = sample_route(problem, np.linspace(problem.start, problem.goal, n))
        # the heading of a shift across the whole road suffices
        steepest = min(math.sqrt(max(left - right, cell_width) * problem.kappa_max), max_heading)
        fastest = (1.0 + float(np.abs(at.kappa).max()) * max(-right, left)) ** 2 + math.tan(steepest) ** 2
        steering = math.tan(problem.vehicle.delta_max) / problem.vehicle.wheelbase
        kappa = min(problem.a_y_max / (problem.v_x**2 * fastest), steering)
        widest = math.ceil(steepest / heading_step)
        headings: Array = heading_step * np.arange(-widest, widest + 1, dtype=np.float64)
        # the route itself is the middle of a cell
        first, last = math.ceil(right / cell_width - 1e-9), math.floor(left / cell_width + 1e-9)
        offsets: Array = cell_width * np.arange(first, last + 1, dtype=np.float64)
        if len(offsets) < 2:
            message = "the body does not fit on the road"
            return cls(at, b"", (0, 0, 0), offsets, cell_width, heading_step, steepest, kappa, message)
        fastest_other = max((abs(other.v_x) for other in problem.others), default=0.0)
        margin = 0.5 * STATION_STEP * (1.0 + fastest_other / problem.v_x)
        cells = free_cells(problem, at, headings, offsets, station_margin=margin)
        free = np.repeat(cells.between_edges[None], n, axis=0)
        free[cells.near] = cells.free_near
        blocked = np.flatnonzero(~free.any(axis=(1, 2)))
        message = f"no pose is free {at.s[blocked[0]] - problem.start:.1f} m ahead" if len(blocked) else ""
        return cls(
            at, free.tobytes(), free.shape, offsets, cell_width, heading_step, steepest, kappa, message
        )

    @property
    def start(self) -> Pose:
        """First pose."""
        return self._pose(0)

    @property
    def goal(self) -> Pose:
        """Last pose."""
        return self._pose(-1)

    def _pose(self, i: int) -> Pose:
        position, tangent = self.at.position[i], self.at.tangent[i]
        return float(position.real), float(position.imag), float(np.angle(tangent))

    def samples(self, rng: np.random.Generator, count: int, spread: float, goal_bias: float) -> list[Pose]:
        """Sample free poses, with normal headings; a fraction of the samples is the goal."""
        n, turns, cells = self.shape
        free = np.frombuffer(self.table, dtype=np.bool_)
        tries = 4 * count  # of which those that are free are taken
        i, k = rng.integers(0, n, tries), rng.integers(0, cells, tries)
        angle = np.clip(
            spread * self.max_heading * rng.standard_normal(len(i)), -self.max_heading, self.max_heading
        )
        h = turns // 2 + np.rint(angle / self.heading_step).astype(int)
        keep = np.flatnonzero(free[(i * turns + h) * cells + k])[:count]
        keep = np.resize(keep, count) if len(keep) else np.arange(count)
        i, d, angle = i[keep], self.offsets[k[keep]], angle[keep]
        position = self.at.position[i] + 1j * d * self.at.tangent[i]
        heading = np.angle(self.at.tangent[i] * np.exp(1j * angle))
        poses = np.column_stack((position.real, position.imag, heading))
        poses[rng.random(count) < goal_bias] = self.goal
        return [(x, y, angle) for x, y, angle in poses.tolist()]

    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Smallest and largest x and y of the road [m]."""
        sides = np.array((self.offsets[0], self.offsets[-1]))
        edges = (self.at.position + 1j * sides[:, None] * self.at.tangent).ravel()
        x, y = edges.real, edges.imag
        return (float(x.min()) - 1.0, float(x.max()) + 1.0), (float(y.min()) - 1.0, float(y.max()) + 1.0)

    def _stations(self) -> tuple[list[int], int, int]:
        """Station near each tile of the bounds, -1 off the road, row by row; number of columns and rows."""
        (x_0, x_1), (y_0, y_1) = self.bounds()
        columns, rows = int((x_1 - x_0) / _TILE) + 1, int((y_1 - y_0) / _TILE) + 1
        across = np.arange(self.offsets[0] - 1.0, self.offsets[-1] + 1.0, 0.4 * _TILE)
        position = (self.at.position[:, None] + 1j * across * self.at.tangent[:, None]).ravel()
        column = ((position.real - x_0) / _TILE).astype(int)
        row = ((position.imag - y_0) / _TILE).astype(int)
        inside = (position.real >= x_0) & (position.imag >= y_0) & (column < columns) & (row < rows)
        tiles = np.full(columns * rows, -1)
        tiles[(row * columns + column)[inside]] = np.repeat(np.arange(len(self.at.s)), len(across))[inside]
        return tiles.tolist(), columns, rows

    def validity_check(self) -> Callable[[State], bool]:
        """Make the check whether the body is free in a state: look-ups in plain Python, which are fast."""
        (x_0, _), (y_0, _) = self.bounds()
        station, columns, rows = self._stations()
        position, tangent = self.at.position, self.at.tangent
        px, py = position.real.tolist(), position.imag.tolist()
        tx, ty = tangent.real.tolist(), tangent.imag.tolist()
        curvature, heading = self.at.kappa.tolist(), np.angle(tangent).tolist()
        free, (n, turns, cells), turn_step = self.table, self.shape, self.heading_step
        lowest, spacing = float(self.offsets[0]), float(self.at.s[1] - self.at.s[0])
        width, middle, two_pi = self.cell_width, turns // 2, 2.0 * math.pi

        def is_free(state: State) -> bool:
            x: float = state.getX()
            y: float = state.getY()
            c, r = int((x - x_0) / _TILE), int((y - y_0) / _TILE)
            if not (0 <= c < columns and 0 <= r < rows):
                return False
            i = station[r * columns + c]
            if i < 0:
                return False
            dx, dy, a, b, kappa = x - px[i], y - py[i], tx[i], ty[i], curvature[i]
            ahead, d = dx * a + dy * b, dy * a - dx * b
            d -= 0.5 * kappa * ahead * ahead
            ahead /= 1.0 - kappa * d
            turn: float = math.remainder(state.getYaw() - heading[i] - kappa * ahead, two_pi)
            i += round(ahead / spacing)
            h, k = middle + round(turn / turn_step), round((d - lowest) / width)
            if not (0 <= i < n and 0 <= h < turns and 0 <= k < cells):
                return False
            found: bool = free[(i * turns + h) * cells + k] == 1
            return found

        return is_free
