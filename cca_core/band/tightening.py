"""Constraint tightening: solve, certify, move the bounds by the shortfall, solve again."""

import math

import numpy as np

from cca_core._checks import Array, Index, Mask
from cca_core.band.band import Band, Failure, assemble_band
from cca_core.band.certificate import certify, end_gaps
from cca_core.band.equilibrium import CurvatureBounds, equilibrium
from cca_core.band.problem import BandProblem
from cca_core.errors import Status


def relax_with_sides(problem: BandProblem, batch_shape: tuple[int, ...], passes_left: Mask) -> Band:
    """Relax bands with given sides, of shape (m, bands)."""
    lower, upper = problem.corridor.bounds(passes_left)
    solvable = np.logical_and.reduce(lower <= upper, axis=1)
    failures: dict[int, Failure] = {}
    if not solvable.all():
        failures = {
            int(i): _report_empty_interval(problem, passes_left, int(i)) for i in np.flatnonzero(~solvable)
        }
    blocked = _find_blocked_ends(problem, lower, upper)
    solvable[list(blocked)] = False
    if failures or blocked:
        lower[~solvable], upper[~solvable] = -math.inf, math.inf
    search = _Search(problem, passes_left, lower, upper)
    for i, o in blocked.items():
        gap = float(search.certificate.gaps[o, i].min())
        reason = f"clearance to obstacle {o}, at a pinned end, {gap:.3f} m (limit {problem.clearance:.3f} m)"
        failures[i] = Status.INFEASIBLE, reason, o
    search.tighten(np.flatnonzero(solvable))
    for i in np.flatnonzero(~search.converged).tolist():
        reason = f"active set did not converge in {search.solves[i]} solves"
        failures[i] = Status.NOT_CONVERGED, reason, ""
    return assemble_band(
        problem, batch_shape, search.u, search.certificate, passes_left=passes_left, lower=lower, upper=upper,
        solves=search.solves, failures=failures,
    )  # fmt: skip


class _Search:
    """Displacements and bounds of bands while the bounds are tightened, beginning at the equilibrium."""

    def __init__(self, problem: BandProblem, passes_left: Mask, lower: Array, upper: Array) -> None:
        self.problem, self.passes_left, self.lower, self.upper = problem, passes_left, lower, upper
        stiffness = problem.stiffness
        self._contact = stiffness.k_e * problem.h
        self._stencil = stiffness.stencil(problem.h)
        # contact stiffness of the curvature limit: 0.25 per k_c [1/m^2] and 10 per k_b [-]
        self._curvature_contact = (0.25 * stiffness.k_c + 10.0 * stiffness.k_b) / problem.h**3
        self._difference_bounds: tuple[Array, Array] | None = None
        free = problem.free_displacement
        self.u, self.solves, self.converged = equilibrium(
            self._stencil, self._contact, lower - free, upper - free
        )
        self.u += free
        self.certificate = certify(problem, self.u)

    def tighten(self, bands: Index) -> None:
        """Move the bounds of bands until the certificate holds or there is no progress; keep the best."""
        settings, problem, found = self.problem.settings, self.problem, self.certificate
        n_bands = len(self.u)
        last_shortfall = np.full(n_bands, math.inf)
        best, best_u = np.full(n_bands, math.inf), self.u.copy()
        stalls = np.zeros(n_bands, dtype=np.intp)
        for _ in range(settings.max_tightenings):
            shortfall = np.maximum(problem.clearance - found.min_gap, -found.min_edge_clearance)
            bands = bands[(shortfall[bands] > 0.0) | (found.curvature_ratio[bands] > 1.0)]
            if not len(bands):
                break
            violation = found.violation(problem)
            better = bands[violation[bands] < best[bands]]
            progress = violation[bands] < settings.min_progress * best[bands]
            stalls[bands] = np.where(progress, 0, stalls[bands] + 1)
            best[better], best_u[better] = violation[better], self.u[better]
            bands = bands[(stalls[bands] < settings.max_stalls) & (self.solves[bands] < settings.max_solves)]
            if not len(bands):
                break
            # contact yields by a fraction of each move: extrapolate to no shortfall, by a factor of 5 at most
            gain = 1.0 / (1.0 - np.clip(shortfall[bands] / last_shortfall[bands], 0.0, 0.8))
            last_shortfall[bands] = np.maximum(shortfall[bands], settings.clearance_margin)
            bands = self._solve_tighter(bands, gain)
            if not len(bands):
                break
        worse = (found.violation(problem) > best).nonzero()[0]
        if len(worse):
            self.u[worse] = best_u[worse]
            found.update(worse, certify(problem.select(worse), self.u[worse]))

    def _solve_tighter(self, bands: Index, gain: Array) -> Index:
        """Tighten and solve bands once; return those that can go on."""
        problem, found, free = self.problem, self.certificate, self.problem.free_displacement
        lower, upper = self._tighten_positions(bands, gain)
        fits = np.all(lower <= upper, axis=1)
        bands, lower, upper = bands[fits], lower[fits], upper[fits]
        if not len(bands):
            return bands
        self.lower[bands], self.upper[bands] = lower, upper
        bounds = None
        if self._difference_bounds is None and found.curvature_ratio[bands].max() > 1.0:
            self._difference_bounds = np.full(self.u.shape, -math.inf), np.full(self.u.shape, math.inf)
        if self._difference_bounds is not None:
            low, high = self._difference_bounds
            low[bands], high[bands] = self._tighten_curvature(bands, low[bands], high[bands])
            of_free = problem.second_difference(free)[bands]
            bounds = CurvatureBounds(
                self._curvature_contact[bands], low[bands] - of_free, high[bands] - of_free
            )
        u, solves, self.converged[bands] = equilibrium(
            self._stencil[bands], self._contact[bands], lower - free[bands], upper - free[bands], bounds
        )
        self.u[bands] = free[bands] + u
        self.solves[bands] += solves
        found.update(bands, certify(problem.select(bands), self.u[bands]))
        return bands[self.converged[bands]]

    def _tighten_positions(self, bands: Index, gain: Array) -> tuple[Array, Array]:
        """Return the bounds of some bands, moved by their shortfall of clearance."""
        problem, found = self.problem, self.certificate
        shortfall, left = problem.clearance - found.gaps[:, bands], self.passes_left[:, bands, None]
        short_low = np.max(shortfall, axis=0, where=left, initial=-math.inf)
        short_up = np.max(shortfall, axis=0, where=~left, initial=-math.inf)
        short_low = np.maximum(short_low, -found.right_margin[bands])
        short_up = np.maximum(short_up, -found.left_margin[bands])
        lower, upper, u = self.lower[bands], self.upper[bands], self.u[bands]
        margin = problem.settings.clearance_margin
        move_low, move_up = (gain[:, None] * short + margin for short in (short_low, short_up))
        lower = np.where(short_low > 0.0, np.maximum(lower, u) + move_low, lower)
        upper = np.where(short_up > 0.0, np.minimum(upper, u) - move_up, upper)
        return lower, upper

    def _tighten_curvature(self, bands: Index, low: Array, high: Array) -> tuple[Array, Array]:
        """Return the bounds of the second difference of some bands, moved by their excess curvature."""
        problem, found = self.problem, self.certificate
        squared = problem.h[bands, None] ** 2
        curvature, limit = found.curvature[bands] * squared, problem.curvature_limit[bands] * squared
        difference = problem.second_difference(self.u)[bands]
        of_route, aim = curvature - difference, (1.0 - problem.settings.curvature_margin) * limit
        excess = np.maximum(np.abs(curvature) - aim, 0.0)
        low, high = np.maximum(low, -aim - of_route), np.minimum(high, aim - of_route)
        low = np.where((curvature < 0.0) & (excess > 0.0), np.maximum(low, difference) + excess, low)
        high = np.where((curvature > 0.0) & (excess > 0.0), np.minimum(high, difference) - excess, high)
        return np.minimum(low, 0.5 * (low + high)), np.maximum(high, 0.5 * (low + high))


def _report_empty_interval(problem: BandProblem, passes_left: Mask, band: int) -> Failure:
    """Return status, message and active constraint where no displacement is feasible."""
    c = problem.corridor
    lower, upper = c.bounds(passes_left)
    node = int(np.argmax(lower[band] - upper[band]))
    right: int | str = "right edge"
    left: int | str = "left edge"
    for o in np.flatnonzero(c.alongside[:, band, node]).tolist():
        if passes_left[o, band] and c.left[o, band, node] == lower[band, node]:
            right = o
        if not passes_left[o, band] and c.right[o, band, node] == upper[band, node]:
            left = o
    constraint = right if isinstance(right, int) else left
    names = (f"obstacle {one}" if isinstance(one, int) else f"the {one}" for one in (right, left))
    return Status.INFEASIBLE, "no space between {} and {} at node {}".format(*names, node), constraint


def _find_blocked_ends(problem: BandProblem, lower: Array, upper: Array) -> dict[int, int]:
    """Return the nearest obstacle of each band that has one too close to a pinned end."""
    ends = problem.free_displacement[:, [0, -1]]
    if not ((lower[:, [0, -1]] > ends).any() or (upper[:, [0, -1]] < ends).any()):
        return {}
    gaps = end_gaps(problem)
    limit = problem.clearance - problem.settings.max_end_shortfall
    return {int(i): int(gaps[:, i].argmin()) for i in np.flatnonzero((gaps < limit).any(axis=0))}
