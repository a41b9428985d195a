"""The relaxed band with given sides in NumPy and LAPACK: what the kernel must agree with.

It is the form that the library had before its kernel, for one band: cold starts, a line search on all forces,
extended precision. Lengths in meters; complex numbers are positions and directions.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import solveh_banded

from cca_core.band import BandSettings, BandStiffness
from cca_core.geometry import Boxes, box_gap
from tests.support.band_cases import Case
from tests.support.band_numpy_curve import curvature_of, offset, spline
from tests.support.band_numpy_equilibrium import NumpyEquilibrium

Array = np.ndarray[Any, Any]

ALIGNED, PARALLEL, END_SLOPE = 0.02, 1e-9, 0.5
CURVE_ERROR, LOOSE, DECISIVE = 2e-3, 4e-3, 1e-2
ROUNDING, MAX_DISPLACEMENT = 1e-9, 30.0
SETTINGS, STIFFNESS = BandSettings(), BandStiffness()


@dataclass
class Certificate:
    """Gaps, margins and curvature along a displaced band."""

    gaps: Array  # (m, n)
    right: Array
    left: Array
    curvature: Array
    min_gap: float
    min_edge: float
    ratio: float


class NumpyBand:
    """One band on its route: the bounds, and certificates of its displacements."""

    def __init__(self, case: Case, sides: tuple[str, ...], start: tuple[float, ...] = (0.0,) * 3) -> None:
        self.case, self.start = case, start
        self.route = np.ascontiguousarray(case.nodes).view(complex)[:, 0]
        n = self.n = len(self.route)
        steps = np.diff(self.route)
        self.h = float(np.abs(steps).mean())
        along = np.concatenate((steps[:1], steps[1:] + steps[:-1], steps[-1:]))
        length = np.sqrt(along.real**2 + along.imag**2)
        self.tangents = along.real / length + 1j * (along.imag / length)
        curvature = curvature_of(self.route)
        self.route_curvature = np.concatenate((curvature[:1], curvature, curvature[-1:]))
        ends = [2.0 * curvature[0] - curvature[1], 2.0 * curvature[-1] - curvature[-2]]
        headings = self.tangents[[0, -1]]
        self.equilibrium = NumpyEquilibrium(STIFFNESS, self.h)
        self.free = np.zeros(n)
        if any(start):
            self.tangents[0] *= np.exp(-0.5j * self.h * ends[0])
            headings[0] = self.tangents[0]
            self.free = self.free_response()
            turn, ends[0] = offset(ends[0], start, self.h)
            headings[0] *= turn
        self.end_headings = headings
        self.end_moments = 1j * np.array(ends) * headings / 6.0
        self.passes_left = np.array([side == "left" for side in sides], dtype=bool)
        shape = (len(sides), n)
        fields = [np.empty(shape) for _ in range(5)]
        for i, o in enumerate(case.obstacles):
            for field, value in zip(fields, (o.x, o.y, o.psi, o.length, o.width), strict=True):
                field[i] = value
        self.center, self.ahead = fields[0] + 1j * fields[1], np.cos(fields[2]) + 1j * np.sin(fields[2])
        self.half_length, self.half_width = 0.5 * fields[3], 0.5 * fields[4]
        self.radius = np.hypot(self.half_length, self.half_width)
        corners = np.abs(np.diff(self.ahead)) * self.radius[:, 1:]
        self.max_step = (np.abs(np.diff(self.center)) + corners).max(axis=1, initial=0.0)
        self.right_edge, self.left_edge = (np.broadcast_to(edge, n) for edge in case.corridor)

    def free_response(self) -> Array:
        """Displacement that the start alone causes."""
        row = self.equilibrium.row
        u = np.zeros(self.n)
        u[:2] = self.start[1:]
        wide = np.concatenate(([self.start[0]], self.start[1:], np.zeros(self.n)))
        force = np.zeros(self.n - 4)
        for k in range(3):
            force[k] = -sum(float(row[j]) * wide[3 + k - j] for j in range(k + 1, 4))
        matrix, rest = np.repeat(row[::-1, None].astype(float), self.n - 4, axis=1), force
        for _ in range(4):
            u[2:-2] += solveh_banded(matrix, rest)
            rest = (force - self.equilibrium.stiffness(u[2:-2])).astype(float)
        return u

    def bounds(self) -> tuple[Array, Array]:
        """Bounds of the displacement that edges and obstacles leave."""
        car, clearance = self.case.vehicle, self.case.clearance
        half, reach = 0.5 * car.width, 0.5 * car.length
        lower, upper = self.right_edge + half, self.left_edge - half
        relative = (self.center - self.route) * self.tangents.conj() - car.box_offset
        a, t, x, y = self.ahead, self.tangents, relative.real, relative.imag
        turn = a.real * t.real + a.imag * t.imag + 1j * (a.imag * t.real - a.real * t.imag)
        length, width = self.half_length + clearance, self.half_width + clearance
        c, s = np.abs(turn.real), np.abs(turn.imag)
        overlap, half_y = length * c + width * s + reach - np.abs(x), length * s + width * c
        top, bottom = half_y, half_y
        if s.max(initial=0.0) >= ALIGNED:
            counter = turn.real * turn.imag >= 0.0
            ridge = np.where(counter, length * c - width * s, width * s - length * c)
            one, other = s / np.maximum(c, ALIGNED), c / np.maximum(s, ALIGNED)
            rise, fall = np.where(counter, one, other), np.where(counter, other, one)
            before, behind = -reach - x, reach - x
            top = half_y - np.maximum(ridge - behind, 0.0) * rise - np.maximum(before - ridge, 0.0) * fall
            bottom = half_y - np.maximum(ridge + before, 0.0) * rise - np.maximum(-behind - ridge, 0.0) * fall
            top, bottom = (np.where(s > PARALLEL, roof, half_y) for roof in (top, bottom))
        wide = np.pad(overlap, ((0, 0), (1, 1)), mode="edge")
        near = np.maximum(np.maximum(wide[:, :-2], wide[:, 2:]), overlap)
        outside = np.minimum(overlap, 0.0) / np.minimum(overlap - near, -1e-9)
        relief = END_SLOPE * np.abs(self.route[1] - self.route[0]) * outside
        right = np.where(near >= 0.0, y - np.maximum(bottom, -half_y) + relief - half, math.inf)
        left = np.where(near >= 0.0, y + np.maximum(top, -half_y) - relief + half, -math.inf)
        side = self.passes_left[:, None]
        lower = np.maximum(lower, np.max(left, axis=0, where=side, initial=-math.inf))
        return lower, np.minimum(upper, np.min(right, axis=0, where=~side, initial=math.inf))

    def certify(self, u: Array) -> Certificate:
        """Sweep the body along a displacement."""
        case, car, h = self.case, self.case.vehicle, self.h
        nodes = self.route + 1j * self.tangents * u
        along, kappa = spline(nodes, self.end_moments)
        every = np.arange(self.n)
        sampled = np.array([self.gap(o, nodes, along, every) for o in range(len(self.center))])
        gaps = sampled.reshape(-1, self.n).copy()
        for o in range(len(gaps)):
            gaps[o] = self.gaps_to(o, nodes, along, kappa, sampled)
        turn = along * self.tangents.conj()
        reach = 0.5 * car.width * turn.real + 0.125 * np.abs(kappa) * h**2
        right, left = np.full(self.n, math.inf), np.full(self.n, math.inf)
        sections = [(car.front, 0), (car.box_offset, 0), (car.rear, 0)]
        if np.ptp(self.right_edge) or np.ptp(self.left_edge):
            reached = range(math.floor(car.rear / h), math.ceil(car.front / h) + 1)
            sections = [(min(max(k * h, car.rear), car.front), k) for k in reached]
        for x, k in sections:
            at = np.clip(np.arange(self.n) + k, 0, self.n - 1)
            middle = u + x * turn.imag - 0.5 * self.route_curvature * x * x
            right = np.minimum(right, middle - reach - self.right_edge[at])
            left = np.minimum(left, self.left_edge[at] - middle - reach)
        ratio = float(np.abs(kappa / case.curvature_limit).max())
        edge = float(np.minimum(right, left).min())
        return Certificate(gaps, right, left, kappa, gaps.min(initial=math.inf), edge, ratio)

    def gaps_to(self, o: int, nodes: Array, along: Array, kappa: Array, samples: Array) -> Array:
        """Lower bounds of the gap to an obstacle from each node to the next."""
        clearance, car = self.case.clearance, self.case.vehicle
        half = 0.5 * math.hypot(car.length, car.width)
        far = np.abs(self.center - nodes - car.box_offset * along)
        near = (far - self.half_width).min() - 0.5 * car.width
        moves = self.max_step[o] + self.h * (1.0 + 0.6 * car.length * np.abs(kappa).max())
        gaps = far[o] - self.radius[o] - half
        at = np.flatnonzero(gaps <= max(clearance, near) + 2.0 * moves)
        if not len(at):
            return gaps
        sampled, floor = samples[o], samples.min()
        turn = self.h * np.abs(kappa)
        bulge = 0.125 * self.h * turn + 0.5 * moves * (turn + np.append(np.abs(np.diff(self.ahead[o])), 0.0))
        bulge += CURVE_ERROR if self.max_step.any() or kappa.any() else 0.0
        gaps[at] = sampled[at]
        change = np.diff(sampled)
        for i in at[:-1][np.diff(at) == 1]:
            bound = min(sampled[i], sampled[i + 1]) - max(bulge[i], bulge[i + 1])
            if {i - 1, i + 2} <= set(at) and change[i - 1] < 0.0 < change[i + 1]:
                dip = change[i - 1] * (change[i] - change[i + 1]) / (change[i - 1] - change[i + 1])
                bound = min(bound, sampled[i] + dip - bulge[i - 1 : i + 3].max())
            if i in (0, self.n - 2):
                bound -= 0.5 * moves
            low = min(sampled[i], sampled[i + 1])
            decisive = clearance if low >= clearance else low - LOOSE
            if self.max_step[o] == 0.0:
                decisive = (
                    max(clearance, min(floor - LOOSE, clearance + DECISIVE))
                    if low >= clearance
                    else -math.inf
                )
            if bound < decisive:
                bent = self.h * np.abs(kappa[i : i + 2]).max()
                bound = self.between(o, nodes, along, int(i), 0.6 * car.length * bent)
            gaps[i] = bound
        return gaps

    def gap(self, o: int, position: Array, ahead: Array, i: Array, f: Array | float = 0.0) -> Array:
        """Gap to an obstacle with the ego at positions, a fraction of the way from node i to the next."""
        car, j = self.case.vehicle, np.minimum(i + 1, self.n - 1)

        def mixed(values: Array) -> Array:
            mix: Array = values[o, i] + f * (values[o, j] - values[o, i])
            return mix

        heading, lengths = mixed(self.ahead), (mixed(self.half_length), mixed(self.half_width))
        relative = mixed(self.center) - position - car.box_offset * ahead
        size = np.array(car.length), np.array(car.width)
        ego = Boxes(0.0 * relative.real, 0.0 * relative.imag, np.angle(ahead), *size)
        other = Boxes(relative.real, relative.imag, np.angle(heading), *(2.0 * each for each in lengths))
        return box_gap(ego, other)

    def between(self, o: int, nodes: Array, along: Array, i: int, swing: float) -> float:
        """Least gap from a node to the next, closely sampled."""
        f, chord = np.linspace(0.0, 1.0, 17), nodes[i + 1] - nodes[i]
        a, b = along[i] * abs(chord) - chord, chord - along[i + 1] * abs(chord)
        position = nodes[i] + f * chord + f * (1.0 - f) * ((1.0 - f) * a + f * b)
        ahead = chord + (1.0 - f) * (1.0 - 3.0 * f) * a + f * (2.0 - 3.0 * f) * b
        gap = self.gap(o, position, ahead / np.abs(ahead), np.array(i), f)
        change = np.diff(gap)
        bound = gap.min()
        if self.max_step[o] > 0.0:
            turn = abs(self.ahead[o, i + 1] - self.ahead[o, i])
            bound -= 0.125 * (self.radius[o, i] * turn + swing)
        bound = min(bound, gap[1] - max(change[1], 0.0), gap[-2] + min(change[-2], 0.0))
        for k in np.flatnonzero((change[:-2] < 0.0) & (change[2:] > 0.0)):
            dip = change[k] * (change[k + 1] - change[k + 2]) / (change[k] - change[k + 2])
            bound = min(bound, gap[k + 1] + dip)
        return float(bound)

    def relax(self) -> tuple[Array, str]:
        """Return the displacement and the status."""
        self.lower, self.upper = self.bounds()
        solvable = bool((self.lower <= self.upper).all()) and not self.has_blocked_end()
        if not solvable:
            self.lower, self.upper = np.full(self.n, -math.inf), np.full(self.n, math.inf)
        self.difference_bounds: tuple[Array, Array] | None = None
        u, converged = self.solve()
        found = self.certify(u)
        if solvable:
            u, found, converged = self.tighten(u, found, converged)
        kept = found.min_gap >= self.case.clearance - ROUNDING and found.min_edge >= -ROUNDING
        kept &= np.abs(u).max() <= MAX_DISPLACEMENT and found.ratio <= 1.0 + ROUNDING
        return u, "NOT_CONVERGED" if not converged else "OK" if kept and solvable else "INFEASIBLE"

    def has_blocked_end(self) -> bool:
        """Whether an obstacle is too close to a pinned end."""
        free, ends = self.free, [0, -1]
        if (self.lower[ends] <= free[ends]).all() and (free[ends] <= self.upper[ends]).all():
            return False
        nodes, along = self.route + 1j * self.tangents * free, self.tangents.copy()
        along[ends] = self.end_headings
        every = np.arange(self.n)
        gaps = [self.gap(o, nodes, along, every)[ends].min() for o in range(len(self.center))]
        return bool(min(gaps, default=math.inf) < self.case.clearance - SETTINGS.max_end_shortfall)

    def tighten(self, u: Array, found: Certificate, converged: bool) -> tuple[Array, Certificate, bool]:
        """Move the bounds by the shortfall until there is none, or no progress."""
        best, best_u, last, stalls = math.inf, u, math.inf, 0
        for _ in range(SETTINGS.max_tightenings):
            shortfall = max(self.case.clearance - found.min_gap, -found.min_edge)
            if shortfall <= 0.0 and found.ratio <= 1.0:
                break
            violation = self.violation(found)
            stalls = 0 if violation < SETTINGS.min_progress * best else stalls + 1
            if violation < best:
                best, best_u = violation, u
            if stalls >= SETTINGS.max_stalls or self.equilibrium.solves >= SETTINGS.max_solves:
                break
            gain = 1.0 / (1.0 - min(max(shortfall / last, 0.0), 0.8))
            last = max(shortfall, SETTINGS.clearance_margin)
            lower, upper = self.tightened(u, found, gain)
            if (lower > upper).any():
                break
            self.lower, self.upper = lower, upper
            if found.ratio > 1.0 or self.difference_bounds is not None:
                self.tighten_curvature(u, found)
            u, converged = self.solve()
            found = self.certify(u)
            if not converged:
                break
        if self.violation(found) > best:
            u, found = best_u, self.certify(best_u)
        return u, found, converged

    def violation(self, found: Certificate) -> float:
        """Violation of clearance and limits; a meter counts as 5."""
        shortfall = max(self.case.clearance - found.min_gap, -found.min_edge, 0.0)
        return 5.0 * shortfall + max(found.ratio - 1.0, 0.0)

    def tightened(self, u: Array, found: Certificate, gain: float) -> tuple[Array, Array]:
        """Bounds moved by the shortfall of clearance."""
        short, side = self.case.clearance - found.gaps, self.passes_left[:, None]
        low = np.maximum(np.max(short, axis=0, where=side, initial=-math.inf), -found.right)
        high = np.maximum(np.max(short, axis=0, where=~side, initial=-math.inf), -found.left)
        move_low, move_high = (gain * each + SETTINGS.clearance_margin for each in (low, high))
        return (
            np.where(low > 0.0, np.maximum(self.lower, u) + move_low, self.lower),
            np.where(high > 0.0, np.minimum(self.upper, u) - move_high, self.upper),
        )

    def bend(self, u: Array) -> Array:
        """Second difference of a displacement at all nodes."""
        return np.diff(u, n=2, prepend=self.start[0], append=0.0)

    def tighten_curvature(self, u: Array, found: Certificate) -> None:
        """Move the bounds of the second difference by the excess curvature; limits must be finite."""
        low, high = self.difference_bounds or (np.full(self.n, -math.inf), np.full(self.n, math.inf))
        curvature, limit = found.curvature * self.h**2, self.case.curvature_limit * self.h**2
        bend, aim = self.bend(u), (1.0 - SETTINGS.curvature_margin) * limit
        excess = np.maximum(np.abs(curvature) - aim, 0.0)
        low, high = np.maximum(low, bend - curvature - aim), np.minimum(high, bend - curvature + aim)
        low = np.where((curvature < 0.0) & (excess > 0.0), np.maximum(low, bend) + excess, low)
        high = np.where((curvature > 0.0) & (excess > 0.0), np.minimum(high, bend) - excess, high)
        middle = 0.5 * (low + high)
        self.difference_bounds = np.minimum(low, middle), np.maximum(high, middle)

    def solve(self) -> tuple[Array, bool]:
        """Equilibrium between the bounds."""
        low, high = ((bound - self.free)[2:-2] for bound in (self.lower, self.upper))
        sharp = None
        if self.difference_bounds is not None:
            of_free = self.bend(self.free)
            below, above = ((bound - of_free)[1:-1] for bound in self.difference_bounds)
            sharp = below, above
        u, converged = self.equilibrium.solve(low, high, sharp)
        return self.free + np.pad(u, 2), converged
