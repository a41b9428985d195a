"""Equilibrium of a band in NumPy and LAPACK, for `band_numpy`: cold starts, a line search on all forces."""

from typing import Any

import numpy as np
from scipy.linalg import solveh_banded

from cca_core.band import BandStiffness

Array = np.ndarray[Any, Any]
Sharp = tuple[Array, Array] | None
"""Bounds of the second difference."""

END_STEP = 0.05


class NumpyEquilibrium:
    """A band between pinned ends, in units of the outermost coefficient of its stiffness."""

    def __init__(self, stiffness: BandStiffness, h: float) -> None:
        stencil = stiffness.stencil(h)
        unit = -stencil[3]
        self.row, self.contact = stencil / unit, float(stiffness.k_e * h / unit)
        self.curvature_contact = float((0.25 * stiffness.k_c + 10.0 * stiffness.k_b) / h**3 / unit)
        self.solves = 0

    def stiffness(self, u: Array) -> Array:
        """Internal forces of the displacement of the inner nodes, by differences, which keep digits."""
        tension = -self.row[1] - 4.0 * (self.row[2] + 6.0 * self.row[3]) + 15.0 * self.row[3]
        bending = self.row[2] + 6.0 * self.row[3]
        slope = np.diff(np.pad(u.astype(np.longdouble), 3))
        bend = np.diff(slope)
        moment = bending * bend[1:-1] - np.diff(np.diff(bend))
        force: Array = -np.diff(tension * slope[2:-2] - np.diff(moment))
        return force

    def solve(self, low: Array, high: Array, sharp: Sharp) -> tuple[Array, bool]:
        """Displacement of the inner nodes between bounds: full steps, then damped ones."""
        active, u = first_active_set(low, high, sharp), np.zeros(len(low))
        for count in range(60):
            if count >= 10:
                active = active_set(u, low, high, sharp)
            target = self.held(active, low, high, sharp)
            self.solves += 1
            reached = active_set(target, low, high, sharp)
            converged = bool((reached == active).all())
            if converged:
                u = target
                break
            if count >= 10:
                u = u + self.line_search(u, target - u, low, high, sharp) * (target - u)
            active = reached
        return u, converged

    def held(self, active: Array, low: Array, high: Array, sharp: Sharp) -> Array:
        """Displacement with an active set held: bounds of the displacement, and then of its difference."""
        n, contact = len(low), self.contact * (active[: len(low)] != 0)
        force = contact * finite(np.where(active[:n] < 0, low, high))
        matrix = np.repeat(self.row[::-1, None].astype(float), n, axis=1)
        matrix[3] += contact
        stiff = self.curvature_contact * (active[n:] != 0) if sharp is not None else np.zeros(n + 2)
        if sharp is not None:
            force += np.diff(stiff * np.where(active[n:] < 0, *map(finite, sharp)), n=2)
            matrix[3] += 4.0 * stiff[1:-1] + stiff[:-2] + stiff[2:]
            matrix[2, 1:] -= 2.0 * (stiff[1:-2] + stiff[2:-1])
            matrix[1, 2:] += stiff[2:-2]
        u = solveh_banded(matrix, force)
        if self.row[0] > 1e5 * self.contact:
            for _ in range(3):
                rest = (
                    force - contact * u - self.stiffness(u) - np.diff(stiff * np.diff(np.pad(u, 2), n=2), n=2)
                )
                u = u + solveh_banded(matrix, rest.astype(float))
        return u

    def line_search(self, u: Array, step: Array, low: Array, high: Array, sharp: Sharp) -> float:
        """Fraction of a step with the least energy, by the Illinois method."""

        def slope(fraction: float) -> float:
            v = u + fraction * step
            force = self.contact * (np.maximum(low - v, 0.0) - np.maximum(v - high, 0.0))
            if sharp is not None:
                bend = np.diff(np.pad(v, 2), n=2)
                short = np.maximum(sharp[0] - bend, 0.0) - np.maximum(bend - sharp[1], 0.0)
                force = force + np.diff(self.curvature_contact * short, n=2)
            return float((step * (self.stiffness(v) - force)).sum())

        a, b = 0.0, 1.0
        at_a, at_b = slope(a), slope(b)
        if at_b <= 0.0 or at_a >= 0.0:
            return 1.0
        flat = -1e-3 * at_a
        for _ in range(12):
            fraction = (a * at_b - b * at_a) / (at_b - at_a)
            value = slope(fraction)
            if abs(value) < flat or b - a < 1e-6:
                return fraction
            if value < 0.0:
                a, at_a, at_b = fraction, value, 0.5 * at_b
            else:
                b, at_b, at_a = fraction, value, 0.5 * at_a
        return a


def first_active_set(low: Array, high: Array, sharp: Sharp) -> Array:
    """Bounds that zero violates, but for those that a stiff band does not touch."""
    sides = []
    for bound in (low, -high):
        side, rise = bound > 0.0, np.diff(np.maximum(bound, 0.0))
        relieved = (rise[1:] > END_STEP) & ~side[:-2] | (rise[:-1] < -END_STEP) & ~side[2:]
        side[1:-1] &= ~relieved
        side[1:-1] &= ~(side[:-2] & side[2:])
        sides.append(side)
    active = np.where(sides[0], -1, np.where(sides[1], 1, 0))
    if sharp is None:
        return active
    return np.concatenate((active, np.where(sharp[0] > 0.0, -1, np.where(sharp[1] < 0.0, 1, 0))))


def active_set(u: Array, low: Array, high: Array, sharp: Sharp) -> Array:
    """Bounds that a displacement violates."""
    active = np.where(u < low, -1, np.where(u > high, 1, 0))
    if sharp is None:
        return active
    bend = np.diff(np.pad(u, 2), n=2)
    return np.concatenate((active, np.where(bend < sharp[0], -1, np.where(bend > sharp[1], 1, 0))))


def finite(values: Array) -> Array:
    """Values, 0 where there is none."""
    return np.where(np.isfinite(values), values, 0.0)
