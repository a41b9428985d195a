"""Feasibility of a case: all side assignments by sequential quadratic programs."""

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import scipy.sparse as sp
from qpsolvers import Problem, solve_problem

from tests.support.band_cases import Case
from tests.support.band_measure import (
    corners,
    curvature_at,
    curvature_excess,
    curve_through,
    displaced,
    edge_excess,
    interpolated,
    left_of,
    poses,
    remeasure,
    road_coordinates,
    stations,
)

Array = np.ndarray[Any, np.dtype[np.float64]]
Side = Literal["left", "right"]

PASSES = 10
LOOK = 0.5  # between two rows of an obstacle [m]
TURN = 0.02  # to both sides of the heading, for the slope of a bound [rad]
MAX_SLOPE = 6.0  # slope of a bound over heading [m/rad]
MAX_FIRST_SHORTFALL = 0.4  # in the first pass; later passes cannot remove more [m]
SOLVER: tuple[dict[str, Any], ...] = (
    {"max_iter": 60},
    {"max_iter": 200, "reg_lower_limit": 1e-8, "rho_init": 1e-4, "delta_init": 1e-2},  # where that fails
)
TOLERANCE = 1e-3  # of a solution, in meters and as a fraction of the curvature limit
PENALTY = 1e2  # of shortfall, per meter


def solvable(case: Case) -> tuple[bool, list[Side], Array]:
    """Search all sides for a displacement that keeps to clearance, edges and curvature limit.

    Returns whether there is one, the side of the ego on which it passes each obstacle, and u at each node [m]
    as a solution (measured densely, to `TOLERANCE`); without one, no sides and zeros.
    """
    search = _Search(case)
    found = search.branch([], list(range(len(case.obstacles))))
    if found is None:
        return False, [], np.zeros(len(case.nodes))
    sides: list[Side] = ["left" if found[0][j] > 0 else "right" for j in range(len(case.obstacles))]
    return True, sides, found[1]


def _violations(case: Case, u: Array) -> tuple[float, float, float]:
    """Excess of curvature [-], shortfall at edges [m] and of clearance [m]."""
    nodes = displaced(case.nodes, u)
    return (curvature_excess(nodes, case), edge_excess(nodes, case), case.clearance - remeasure(nodes, case))


@dataclass(frozen=True)
class _Rows:
    """Linear rows A x <= b, each with the slack that it may use."""

    A: sp.csr_array
    b: Array
    slack: int


@dataclass(frozen=True)
class _Aims:
    """Margins of the program: clearance [m], edges [m], curvature [-]."""

    gap: float = 1e-3
    edge: float = 5e-4
    curvature: float = 1e-3


class _Search:
    """The programs of one case: unknown are u and u'' of a natural cubic spline over the nodes."""

    def __init__(self, case: Case) -> None:
        self.case = case
        self.n = n = len(case.nodes)
        h = float(stations(case.nodes)[-1]) / (n - 1)
        self.nodes = _Samples(case, h, np.arange(n, dtype=float))
        parts = max(1, round(h / LOOK))
        self.between = _Samples(case, h, np.arange((n - 1) * parts + 1) / parts)
        second = sp.diags_array([1.0, -2.0, 1.0], offsets=[0, 1, 2], shape=(n - 2, n)) * (6.0 / h**2)
        mixed = sp.diags_array([1.0, 4.0, 1.0], offsets=[0, 1, 2], shape=(n - 2, n))
        fixed = [0, 1, 2, n - 3, n - 2, n - 1]  # position, heading and curvature of the route
        ends = sp.csr_array((np.ones(2), ([0, 1], [0, n - 1])), shape=(2, n))
        self.free = np.setdiff1d(np.arange(2 * n), fixed)
        equal = sp.block_array([[-second, mixed], [None, ends]], format="csc")[:, self.free]
        count = len(case.obstacles) + 1
        self.equal = sp.hstack([equal, sp.csc_array((n, count))], format="csc")
        jerk = sp.diags_array([-1.0, 1.0], offsets=[0, 1], shape=(n - 1, n)) / math.sqrt(h)
        cost = sp.block_diag(
            [1e-9 * sp.eye_array(n), jerk.T @ jerk + 1e-2 * h * sp.eye_array(n)], format="csc"
        )
        self.cost = sp.block_diag([cost[self.free][:, self.free], 1e-6 * sp.eye_array(count)], format="csc")
        self.start = _State(self, np.zeros(2 * n))
        self.first = {
            (j, side): self.start.passing(j, side, _Aims()) for j in range(count - 1) for side in (1, -1)
        }
        self.road = [*self.start.curvature(_Aims()), *self.start.edges(_Aims())]

    def branch(self, sides: list[tuple[int, int]], rest: list[int]) -> tuple[dict[int, int], Array] | None:
        """Sides of the remaining obstacles, the more promising first; None if there are none."""
        if not rest:
            return self.refined(dict(sides))
        ranked = []
        for side in (1, -1):
            tried = [*sides, (rest[0], side)]
            rows = [self.first[pair] for pair in tried]
            if not len(rows[-1].b):  # never alongside
                return self.branch([*sides, (rest[0], self.between.natural_side(rest[0]))], rest[1:])
            found = self.solve(self.start, [*self.road, *rows])
            if found is not None and found[1] <= MAX_FIRST_SHORTFALL:
                ranked.append((found[1], tried))
        for _, tried in sorted(ranked):
            found_below = self.branch(tried, rest[1:])
            if found_below is not None:
                return found_below
        return None

    def refined(self, sides: dict[int, int]) -> tuple[dict[int, int], Array] | None:
        """Follow the true bounds until the dense measurements agree."""
        state, aims, shortfalls = self.start, _Aims(), [math.inf]
        for _ in range(PASSES):
            rows = [*state.curvature(aims), *state.edges(aims)]
            rows += [state.passing(j, side, aims) for j, side in sides.items()]
            found = self.solve(state, [r for r in rows if len(r.b)])
            if found is None:
                return None
            state = _State(self, found[0])
            shortfalls.append(found[1])
            if found[1] > 0.02:
                if len(shortfalls) > 4 and found[1] > 0.7 * shortfalls[-3]:
                    return None
                continue
            u = state.x[: self.n]
            bend, edge, gap = short = _violations(self.case, u)
            if max(short) <= TOLERANCE:
                return sides, u
            if found[1] < 1e-4:
                aims = replace(
                    aims,
                    gap=aims.gap + float(np.clip(gap, 0.0, 0.05)),
                    edge=aims.edge + float(np.clip(edge, 0.0, 0.05)),
                    curvature=aims.curvature + float(np.clip(bend, 0.0, 0.01)),
                )
        return None

    def solve(self, state: "_State", rows: list[_Rows]) -> tuple[Array, float] | None:
        """Smallest change of curvature within the rows, and the largest shortfall."""
        size, count = len(self.free), len(self.case.obstacles) + 1
        A = sp.vstack([r.A for r in rows], format="csc")[:, self.free]
        slack = np.concatenate([np.full(len(r.b), r.slack) for r in rows])
        b = np.concatenate([r.b for r in rows])
        soft = np.flatnonzero(slack >= 0)
        take = sp.csc_array((-np.ones(len(soft)), (soft, slack[soft])), shape=(len(b), count))
        below = np.full(size + count, -np.inf)
        below[size:] = 0.0
        problem = Problem(
            P=sp.csc_matrix(self.cost),
            q=np.concatenate((np.zeros(size), np.full(count, PENALTY))),
            G=sp.csc_matrix(sp.hstack([A, take])),
            h=b,
            A=sp.csc_matrix(self.equal),
            b=np.zeros(self.n),
            lb=below,
        )
        for options in SOLVER:
            solution = solve_problem(problem, solver="piqp", **options)
            if solution.found and solution.x is not None:
                x = np.zeros(2 * self.n)
                x[self.free] = solution.x[:size]
                return x, float(solution.x[size:].max())
        return None


class _Samples:
    """Samples along the route at fractional node indices, and the displacement there."""

    def __init__(self, case: Case, h: float, index: Array) -> None:
        n = len(case.nodes)
        self.index = index
        s = np.interp(index, np.arange(n), stations(case.nodes))
        curve = curve_through(case.nodes)
        self.xy, self.t = curve(s), curve(s, 1)
        self.t /= np.hypot(*self.t.T)[:, None]
        self.normal = left_of(self.t)
        self.psi = np.arctan2(self.t[:, 1], self.t[:, 0])
        self.kappa = curvature_at(case.nodes, index)
        self.boxes = [interpolated(o, index, n) for o in case.obstacles]
        row = np.tile(np.arange(len(index)), 4)
        cell = np.minimum(index.astype(int), n - 2)
        b = index - cell
        a = 1.0 - b
        column = np.concatenate((cell, cell + 1, n + cell, n + cell + 1))
        one, shape = np.ones(len(index)), (len(index), 2 * n)
        u = (a, b, (a**3 - a) * h**2 / 6.0, (b**3 - b) * h**2 / 6.0)
        slope = (-one / h, one / h, (1.0 - 3.0 * a**2) * h / 6.0, (3.0 * b**2 - 1.0) * h / 6.0)
        bend = (0.0 * one, 0.0 * one, a, b)
        self.u, self.slope, self.bend = (
            sp.csr_array((np.concatenate(part), (row, column)), shape=shape) for part in (u, slope, bend)
        )

    def natural_side(self, j: int) -> int:
        """Side on which the undeformed route passes an obstacle: left (1) or right (-1)."""
        off = self.boxes[j][:, :2] - self.xy
        nearest = int(np.argmin((off**2).sum(axis=1)))
        return -1 if off[nearest] @ self.normal[nearest] > 0.0 else 1


class _State:
    """A displacement, and the rows that hold near it."""

    def __init__(self, search: _Search, x: Array) -> None:
        self.search, self.x = search, x
        self.bent = displaced(search.case.nodes, x[: search.n])
        look = search.between
        self.pose = poses(self.bent, look.index, search.case.vehicle)
        self.turn = _turning(look, x)

    def curvature(self, aims: _Aims) -> list[_Rows]:
        """Limits of the curvature, at the nodes."""
        look, x = self.search.nodes, self.x
        now = curvature_at(self.bent, look.index)
        shrunk = 1.0 - look.kappa * (look.u @ x)
        stretch = 1.0 + (look.slope @ x / shrunk) ** 2
        per_u = look.kappa**2 / shrunk**2 + 2.0 * look.kappa * (look.bend @ x) / shrunk**3
        A = _scaled(1.0 / (shrunk**2 * stretch**1.5), look.bend) + _scaled(per_u, look.u)
        limit = self.search.case.curvature_limit * (1.0 - aims.curvature)
        rest = A @ x - now
        return [_Rows(A, limit + rest, -1), _Rows(-A, limit - rest, -1)]

    def edges(self, aims: _Aims) -> list[_Rows]:
        """Edges of the road, for the four corners."""
        case, look, x = self.search.case, self.search.between, self.x
        n, half = self.search.n, 0.5 * case.vehicle.length
        index, lateral = road_coordinates(case.nodes, corners(self.pose).reshape(-1, 2))
        index, lateral = index.reshape(-1, 4), lateral.reshape(-1, 4)
        tilt = self.pose[:, 2] - look.psi
        cos, sin = np.cos(tilt), np.sin(tilt)
        rows = []
        for corner, (front, left) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
            edge = np.broadcast_to(case.corridor[left > 0], n)
            margin = left * (np.interp(index[:, corner], np.arange(n), edge) - lateral[:, corner]) - aims.edge
            arm = (case.vehicle.box_offset + front * half) * cos - left * 0.5 * case.vehicle.width * sin
            A = left * (look.u + _scaled(arm, self.turn))
            rows.append(_Rows(A, margin + A @ x, len(case.obstacles)))
        return rows

    def passing(self, j: int, side: int, aims: _Aims) -> _Rows:
        """Bounds that keep the ego to the left (1) or right (-1) of an obstacle."""
        case, look, x = self.search.case, self.search.between, self.x
        box = look.boxes[j]
        off = box[:, :2] - self.pose[:, :2]
        reach = 0.5 * math.hypot(case.vehicle.length, case.vehicle.width)
        reach += 0.5 * float(np.hypot(box[:, 3], box[:, 4]).max()) + case.clearance + aims.gap
        near = np.flatnonzero(np.abs((off * look.t).sum(axis=1)) < reach)
        bounds = []
        for turn in (0.0, TURN, -TURN):
            bounds.append(
                side
                * _barred(
                    look.t[near],
                    self.pose[near],
                    turn,
                    box[near],
                    case.vehicle.box_offset,
                    case.clearance + aims.gap,
                )[side > 0]
            )
        met = np.isfinite(bounds[0])
        at, more, less = (bound[met] for bound in bounds)
        near = near[met]
        up = np.nan_to_num(more - at).clip(-MAX_SLOPE * TURN, MAX_SLOPE * TURN) / TURN
        down = np.nan_to_num(at - less).clip(-MAX_SLOPE * TURN, MAX_SLOPE * TURN) / TURN
        kink = up > down + 0.1
        slope = np.concatenate((np.where(kink, up, 0.5 * (up + down)), down[kink]))
        rows, bound = np.concatenate((near, near[kink])), np.concatenate((at, at[kink]))
        A = _scaled(slope, self.turn[rows]) - side * look.u[rows]
        return _Rows(A, A @ x - bound, j)


def _turning(look: _Samples, x: Array) -> sp.csr_array:
    """How the heading changes with the displacement."""
    shrunk = 1.0 - look.kappa * (look.u @ x)
    return _scaled(1.0 / (shrunk * (1.0 + (look.slope @ x / shrunk) ** 2)), look.slope)


def _scaled(factor: Array, rows: sp.csr_array) -> sp.csr_array:
    return sp.csr_array(sp.diags_array(factor) @ rows)


def _barred(
    t: Array, pose: Array, turn: float, box: Array, offset: float, clearance: float
) -> tuple[Array, Array]:
    """Shifts of the ego along the normal of t between which it is too near to a box; NaN if none is.

    They end where that line meets the sum of both boxes, grown by the clearance: eight straight sides and an
    arc around each corner.
    """
    frame = np.arctan2(t[:, 1], t[:, 0])
    psi = pose[:, 2] + turn
    rotated = np.column_stack((np.cos(psi) - np.cos(pose[:, 2]), np.sin(psi) - np.sin(pose[:, 2])))
    off = box[:, :2] - pose[:, :2] - offset * rotated
    a = (off * t).sum(axis=1)
    b = t[:, 0] * off[:, 1] - t[:, 1] * off[:, 0]
    angle = np.column_stack((psi, psi + 0.5 * math.pi, box[:, 2], box[:, 2] + 0.5 * math.pi))
    angle = (angle - frame[:, None]) % math.pi
    half = 0.5 * np.column_stack((pose[:, 3:], box[:, 3:]))
    order = np.argsort(angle, axis=1)
    angle, half = np.take_along_axis(angle, order, axis=1), np.take_along_axis(half, order, axis=1)
    sides = 2.0 * half[..., None] * np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    begin = -0.5 * sides.sum(axis=1, keepdims=True)
    ring = begin + np.concatenate((np.zeros_like(begin), np.cumsum(sides, axis=1)), axis=1)
    ring = np.concatenate((ring[:, :4], -ring[:, :4]), axis=1) + np.column_stack((a, b))[:, None]
    outward = clearance * np.stack((np.sin(angle), -np.cos(angle)), axis=-1)
    outward = np.concatenate((outward, -outward), axis=1)
    (x1, y1), (x2, y2) = (np.moveaxis(p + outward, -1, 0) for p in (ring, np.roll(ring, -1, axis=1)))
    with np.errstate(divide="ignore", invalid="ignore"):
        straight = np.where(x1 * x2 <= 0.0, y1 - x1 * (y2 - y1) / (x2 - x1), np.nan)
        round_ = np.sqrt(clearance**2 - ring[..., 0] ** 2)
    ends = np.concatenate((straight, ring[..., 1] + round_, ring[..., 1] - round_), axis=1)
    low = np.fmin.reduce(ends, axis=1)
    return low, np.fmax.reduce(ends, axis=1)
