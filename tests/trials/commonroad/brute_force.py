"""Search of a speed profile along a route through recorded traffic, whose future it knows."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cca_core import VehicleState
from cca_core.geometry import box_gap, boxes
from cca_core.sim import CommonRoadRun

STEP = 0.1  # [s]
STEPS_OF_CHOICE = 4  # between two choices of the acceleration
ACCELERATIONS = (-7.0, -4.5, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0)  # those of SpeedSettings [m/s^2]
CELL = 0.5, 0.5  # of stations [m] and speeds [m/s]: two profiles are kept in each
GRID = 0.1  # between stations at which gaps are computed [m]
CLEARANCE = 0.1  # least gap at these stations [m]
MAX_SPEED = 50.0  # [m/s]
NEARBY = 25.0  # distance within which gaps are computed [m]


class Profile(NamedTuple):
    """Times [s], stations of the center of gravity [m] and speeds [m/s] up to the goal."""

    t: np.ndarray
    s: np.ndarray
    v: np.ndarray


class Layer(NamedTuple):
    """All states at a time [s]: distances from the start [m], speeds [m/s], indices in the layer before."""

    t: float
    s: np.ndarray
    v: np.ndarray
    parents: np.ndarray


class Search:
    """All speed profiles along one route at once: breadth first in time, on cells of station and speed."""

    def __init__(self, run: CommonRoadRun) -> None:
        self.scenario, self.problem, self.vehicle = run.scenario, run.problem, run.vehicle
        path, vehicle, state = run.road.path, run.vehicle, run.problem.state
        x, y = (
            state.x - vehicle.box_offset * math.cos(state.psi),
            state.y - vehicle.box_offset * math.sin(state.psi),
        )
        self.s_0 = float(path.project((x, y))[0])
        s = self.s_0 + np.arange(0.0, path.end - self.s_0, GRID)
        at, self.psi = path.position(s), path.heading(s)
        self.x = at[:, 0] + vehicle.box_offset * np.cos(self.psi)
        self.y = at[:, 1] + vehicle.box_offset * np.sin(self.psi)
        grip = vehicle.mu * 9.81
        self.v_max = np.minimum(np.sqrt(grip / np.maximum(np.abs(path.curvature(s)), 1e-6)), MAX_SPEED)
        self.arrivals = [self._arrival(goal) for goal in run.problem.goals]

    def _arrival(self, goal) -> np.ndarray:  # type: ignore[no-untyped-def]
        """Return at which stations of the grid the position and heading of a goal are reached."""
        free = replace(goal, v_x=None)
        bodies = zip(self.x.tolist(), self.y.tolist(), self.psi.tolist(), strict=True)
        return np.array([
            free.reached(goal.t[0], VehicleState(x=x, y=y, psi=psi, v_x=0.0)) for x, y, psi in bodies
        ])  # fmt: skip

    def run(self) -> Profile | None:
        """Return a profile that reaches a goal without a collision, if there is one."""
        t, t_end = self.problem.t, max(goal.t[1] for goal in self.problem.goals)
        s, v, a, parents = np.array([0.0]), np.array([self.problem.state.v_x]), np.zeros(1), np.array([0])
        layers: list[Layer] = []
        while True:
            layers.append(Layer(t, s, v, parents))
            reached = self._reached(t, s, v)
            if reached is not None:
                return self._trace(layers, reached)
            if t > t_end - 0.5 * STEP or not len(s):
                return None
            parents = np.arange(len(s))
            if (len(layers) - 1) % STEPS_OF_CHOICE == 0:
                parents = np.tile(_first_and_last(s, v), len(ACCELERATIONS))
                a = np.repeat(ACCELERATIONS, len(parents) // len(ACCELERATIONS))
            t += STEP
            s, v, a, parents = self._advance(s[parents], v[parents], a, parents)
            free = self._free(t - 0.5 * STEP, 0.5 * (s + layers[-1].s[parents])) & self._free(t, s)
            s, v, a, parents = s[free], v[free], a[free], parents[free]

    def _advance(
        self, s: np.ndarray, v: np.ndarray, a: np.ndarray, parents: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return what is on the route one step later, and slow enough for its curves unless it brakes."""
        after = np.maximum(v + STEP * a, 0.0)
        ahead = s + 0.5 * STEP * (v + after)
        cells = np.round(ahead / GRID).astype(int)
        kept = cells < len(self.x)
        kept[kept] &= (after[kept] <= self.v_max[cells[kept]]) | (a[kept] < 0.0)
        return ahead[kept], after[kept], a[kept], parents[kept]

    def _free(self, t: float, s: np.ndarray) -> np.ndarray:
        """Return at which stations the ego keeps its clearance at a time."""
        cells = np.round(s / GRID).astype(int)
        free = np.ones(len(self.x), dtype=bool)
        used = np.unique(cells)
        others = [other for o in self.scenario.obstacles if (other := o.at(t)) is not None]
        for other in others:
            reach = NEARBY + 0.5 * other.length
            near = used[np.hypot(self.x[used] - other.x, self.y[used] - other.y) < reach]
            if len(near):
                ego = boxes(
                    self.x[near], self.y[near], self.psi[near], self.vehicle.length, self.vehicle.width
                )
                gap = box_gap(ego, boxes(other.x, other.y, other.psi, other.length, other.width))
                free[near] &= gap > CLEARANCE
        return free[cells]

    def _reached(self, t: float, s: np.ndarray, v: np.ndarray) -> int | None:
        """Return the index of a state in a goal."""
        cells = np.round(s / GRID).astype(int)
        for goal, arrival in zip(self.problem.goals, self.arrivals, strict=True):
            if not goal.t[0] - 1e-6 <= t <= goal.t[1] + 1e-6:
                continue
            slowest, fastest = goal.v_x or (0.0, math.inf)
            found = np.flatnonzero(arrival[cells] & (v >= slowest) & (v <= fastest))
            if len(found):
                return int(found[0])
        return None

    def _trace(self, layers: list[Layer], index: int) -> Profile:
        """Return the profile that ends in a state."""
        rows = []
        for layer in reversed(layers):
            rows.append((layer.t, self.s_0 + layer.s[index], layer.v[index]))
            index = layer.parents[index]
        return Profile(*np.array(rows[::-1]).T)


def _first_and_last(s: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return the indices of the profiles that are least and most far in each cell."""
    cells = np.round(s / CELL[0]).astype(np.int64) * 4096 + np.round(v / CELL[1]).astype(np.int64)
    order = np.lexsort((s, cells))
    changes = np.flatnonzero(np.diff(cells[order]))
    return np.asarray(order[np.unique(np.r_[0, changes, changes + 1, len(order) - 1])[: len(order)]])


def solve(run: CommonRoadRun) -> Profile | None:
    """Return a speed profile along the route of a run that reaches its goal without a collision, if any."""
    return Search(run).run()


def min_gap(run: CommonRoadRun, profile: Profile) -> float:
    """Return the least gap of a profile to all obstacles [m]."""
    search, gap = Search(run), math.inf
    for t, s in zip(profile.t.tolist(), profile.s.tolist(), strict=True):
        i = round((s - search.s_0) / GRID)
        ego = boxes(search.x[i], search.y[i], search.psi[i], run.vehicle.length, run.vehicle.width)
        for obstacle in run.scenario.obstacles:
            other = obstacle.at(t)
            if other is not None:
                body = boxes(other.x, other.y, other.psi, other.length, other.width)
                gap = min(gap, float(box_gap(ego, body)))
    return gap
