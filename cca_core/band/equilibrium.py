"""Equilibrium of bands against one-sided bounds: a handful of banded solves."""

from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array, Index, Mask
from cca_core.errors import InputError

_FULL_STEPS = 10  # the active set converges in 3 to 6
_MAX_SOLVES = 60  # full and damped steps together
_CORRECTIONS = 3  # rounds of iterative refinement where digits are lost
_END_STEP = 0.05  # by which an end node is bounded less than its neighbor if the band does not touch it [m]


@dataclass(frozen=True, slots=True, eq=False)
class CurvatureBounds:
    """One-sided bounds of the curvature of bands.

    Parameters
    ----------
    contact : ndarray, shape (bands,)
        Force per violation of a bound [N/m], positive.
    lower, upper : ndarray, shape (bands, n)
        Bounds of u[i-1] - 2 u[i] + u[i+1], the change of curvature times the spacing squared [m].
    """

    contact: Array
    lower: Array
    upper: Array


def equilibrium(
    stencil: Array,
    contact: float | Array,
    lower: Array,
    upper: Array,
    curvature_bounds: CurvatureBounds | None = None,
) -> tuple[Array, Index, Mask]:
    """Compute the displacement of least energy between pinned ends and one-sided bounds.

    Parameters
    ----------
    stencil : ndarray, shape (..., 4) or (4,)
        Row of the stiffness matrix from its diagonal on [N/m], see `BandStiffness.stencil`. Use
        extended precision: rounding errors tilt long bands with fine meshes.
    contact : float or ndarray, shape (...)
        Force per violation of a bound at a node [N/m], positive.
    lower, upper : ndarray, shape (..., n)
        Bounds of the displacement [m], lower <= upper; infinite where there is none.
    curvature_bounds : CurvatureBounds, optional
        Bounds of the second difference of the displacement.

    Returns
    -------
    u : ndarray, shape (..., n)
        Displacement [m], 0 at the first and last two nodes.
    solves : ndarray of int, shape (...)
        Banded systems solved [-].
    converged : ndarray of bool, shape (...)
        Whether the active set has converged; if not, `u` is the best so far.

    Notes
    -----
    Minimizes ``1/2 u K u + 1/2 contact (sum max(lower - u, 0)^2 + max(u - upper, 0)^2)``, and the same for
    curvature, by a semi-smooth Newton iteration. The energy is convex and piecewise quadratic: a step that
    reproduces its active set is the minimum. If 10 full steps do not converge, a line search damps the next
    ones, and the energy falls with every step. A batch is one block-diagonal system.

    Examples
    --------
    >>> from cca_core.band import BandStiffness
    >>> stencil = BandStiffness(k_s=1.0, k_c=0.0, k_e=1e3).stencil(1.0)
    >>> lower = np.full(9, -np.inf)
    >>> lower[4] = 1.0
    >>> u, solves, converged = equilibrium(stencil, 1e3, lower, np.full(9, np.inf))
    >>> u.round(2).tolist(), int(solves), bool(converged)
    ([0.0, 0.0, 0.33, 0.67, 1.0, 0.67, 0.33, 0.0, 0.0], 1, True)
    """
    shape = lower.shape
    low, high = (bound[..., 2:-2].reshape(-1, shape[-1] - 4) for bound in (lower, upper))
    bands = len(low)
    # in units in which the outermost coefficient is 1 the row sum keeps its digits
    stencil = np.reshape(stencil, (-1, 4))
    unit = -stencil[:, 3:] if stencil[0, 3] else np.abs(stencil[:, 2:3] if stencil[0, 2] else stencil[:, 1:2])
    scaled_contact = np.asarray(np.reshape(contact, (-1, 1)) / unit, dtype=np.float64)
    stencil = stencil / unit
    if len(stencil) != bands:
        stencil, scaled_contact = stencil.repeat(bands, axis=0), scaled_contact.repeat(bands, axis=0)
    curvature = curvature_bounds
    if curvature is not None:
        scaled = np.asarray(curvature.contact[:, None] / unit, dtype=np.float64)
        curvature = CurvatureBounds(scaled, curvature.lower[:, 1:-1], curvature.upper[:, 1:-1])
    system = _System(stencil, scaled_contact, low, high, curvature)
    u = np.zeros((bands, shape[-1]))
    solves = np.zeros(bands, dtype=np.intp)
    converged = np.zeros(bands, dtype=np.bool_)
    remaining = np.arange(bands)
    active = system.initial_active_set()
    for count in range(1, 1 + _FULL_STEPS):
        target, reached = system.solve(active)
        done = (reached[0] == active[0]).all(axis=1)
        for new, old in zip(reached[1:], active[1:], strict=True):
            done &= (new == old).all(axis=1)
        active = reached
        if not done.any():
            continue
        if count == 1 and done.all():
            u[:, 2:-2], solves[:], converged[:] = target, count, True
            return u.reshape(shape), solves.reshape(shape[:-1]), converged.reshape(shape[:-1])
        at = remaining[done]
        u[at, 2:-2], solves[at], converged[at] = target[done], count, True
        remaining = remaining[~done]
        if not len(remaining):
            break
        system, active = system.select(~done), tuple(mask[~done] for mask in active)
    for i, each in enumerate(remaining):
        u[each, 2:-2], steps, converged[each] = _damped_newton(system.select(slice(i, i + 1)))
        solves[each] = _FULL_STEPS + steps
    return u.reshape(shape), solves.reshape(shape[:-1]), converged.reshape(shape[:-1])


def free_response(stencil: Array, start: Array, n: int) -> Array:
    """Return the displacement (bands, n) of least energy without contacts, from the first three nodes."""
    from scipy.linalg import lapack  # slow to import, and importing the library is to be quick

    unit = stencil / stencil[:, :1]
    row = np.asarray(unit, dtype=np.float64)
    u = np.zeros((len(start), n))
    u[:, :2] = start[:, 1:]
    force = np.zeros((len(start), max(n - 4, 3)))
    for k in range(3):  # of the fixed nodes on the first three that are free
        force[:, k] = -(row[:, k + 1 :] * start[:, ::-1][:, : 3 - k]).sum(axis=1)
    for i, f in enumerate(force[:, : n - 4]):
        matrix, rest = np.repeat(row[i, ::-1, None], n - 4, axis=1), f
        for _ in range(1 + _CORRECTIONS * (n > 200)):  # digits are lost on long bands
            _, solution, info = lapack.dpbsv(matrix, rest)
            if info:
                raise InputError(f"nodes must be fewer if a band begins off its route, was {n}")
            u[i, 2:-2] += solution
            rest = (f - apply_stiffness(unit[i], u[i, 2:-2])).astype(np.float64)
    return u


class _System:
    """Bands as one block-diagonal system in LAPACK's upper band storage, with masks of violated bounds."""

    def __init__(
        self, stencil: Array, contact: Array, low: Array, high: Array, curvature: CurvatureBounds | None
    ) -> None:
        from scipy.linalg import lapack  # slow to import, and importing the library is to be quick

        self._lapack = lapack
        self.stencil, self.contact, self.curvature = stencil, contact, curvature
        self.low, self.high = low, high
        rounded = stencil.astype(np.float64)
        self._stiff = rounded[:, :1] > 1e5 * contact  # where digits are lost
        self._diagonal = rounded[:, :1]
        self._string = curvature is None and not rounded[:, 2:].any()
        self._matrix = np.empty((*low.shape, 4))
        self._matrix[:] = rounded[:, None, ::-1]
        for k in range(3):
            self._matrix[:, : 3 - k, k] = 0.0  # nothing couples a band with the previous one

    def select(self, bands: Mask | slice) -> "_System":
        """Return the system of some of the bands."""
        c = self.curvature
        some = None if c is None else CurvatureBounds(c.contact[bands], c.lower[bands], c.upper[bands])
        return _System(self.stencil[bands], self.contact[bands], self.low[bands], self.high[bands], some)

    def initial_active_set(self) -> tuple[Mask, ...]:
        """Return the first guess: a stiff band touches a straight bound at its first and last node only."""
        under, over = self.low > 0.0, self.high < 0.0
        if not self._string:
            for side, bound in ((under, self.low), (over, -self.high)):
                rise = np.diff(np.maximum(bound, 0.0), axis=1)
                relieved = (rise[:, 1:] > _END_STEP) & ~side[:, :-2] | (rise[:, :-1] < -_END_STEP) & ~side[
                    :, 2:
                ]
                side[:, 1:-1] &= ~relieved
                side[:, 1:-1] &= ~(side[:, :-2] & side[:, 2:])
        if self.curvature is None:
            return under, over
        return under, over, self.curvature.lower > 0.0, self.curvature.upper < 0.0

    def active_set(self, u: Array) -> tuple[Mask, ...]:
        """Return the bounds that a displacement (bands, inner) violates: lower, upper, and of curvature."""
        under, over = u < self.low, u > self.high
        if self.curvature is None:
            return under, over
        difference = _second_difference(u)
        return under, over, difference < self.curvature.lower, difference > self.curvature.upper

    def gradient(self, u: Array) -> Array:
        """Return the gradient of the energy [N]."""
        force = self.contact * (np.maximum(self.low - u, 0.0) - np.maximum(u - self.high, 0.0))
        if self.curvature is not None:
            difference = _second_difference(u)
            shortfall = np.maximum(self.curvature.lower - difference, 0.0) - np.maximum(
                difference - self.curvature.upper, 0.0
            )
            force = force + np.diff(self.curvature.contact * shortfall, n=2)
        gradient: Array = apply_stiffness(self.stencil, u) - force
        return gradient

    def solve(self, active: tuple[Mask, ...]) -> tuple[Array, tuple[Mask, ...]]:
        """Return the equilibrium with an active set held, and the active set there."""
        under, over = active[:2]
        contact = self.contact * (under | over)
        force = self.contact * np.where(under, self.low, np.where(over, self.high, 0.0))
        matrix = self._matrix
        if self.curvature is None:
            np.add(self._diagonal, contact, out=matrix[:, :, 3])
        else:
            sharp_right, sharp_left = active[2:]
            stiff = self.curvature.contact * (sharp_right | sharp_left)
            force = force + np.diff(
                stiff * np.where(sharp_right, self.curvature.lower, self.curvature.upper), n=2
            )
            matrix = matrix.copy()
            matrix[:, :, 3] += contact + (4.0 * stiff[:, 1:-1] + stiff[:, :-2] + stiff[:, 2:])
            matrix[:, 1:, 2] -= 2.0 * (stiff[:, 1:-2] + stiff[:, 2:-1])
            matrix[:, 2:, 1] += stiff[:, 2:-2]
        u = self._solved(matrix, force)
        if self._stiff.any():
            for _ in range(_CORRECTIONS):
                rest = force - contact * u - apply_stiffness(self.stencil, u)
                if self.curvature is not None:
                    rest = rest - np.diff(stiff * _second_difference(u), n=2)
                u = np.where(self._stiff, u + self._solved(matrix, rest.astype(np.float64)), u)
        return u, self.active_set(u)

    def _solved(self, matrix: Array, force: Array) -> Array:
        if self._string and force.size > 1:
            coupling = matrix[:, :, 2].ravel()[1:]
            u: Array = self._lapack.dptsv(matrix[:, :, 3].ravel(), coupling, force.ravel())[2]
        else:
            u = self._lapack.dpbsv(matrix.reshape(-1, 4).T, force.ravel())[1]
        return u.reshape(force.shape)


def _second_difference(u: Array) -> Array:
    """Second difference at all nodes but the ends (bands, inner + 2) of inner nodes between pinned ones."""
    wide = np.zeros((len(u), u.shape[1] + 4))
    wide[:, 2:-2] = u
    return np.diff(wide, n=2)


def apply_stiffness(stencil: Array, u: Array) -> Array:
    """Return the internal forces K u [N] at the inner nodes, in the precision of the stencil."""
    rate = -stencil[..., 3:]
    bending = stencil[..., 2:3] - 6.0 * rate
    tension = -stencil[..., 1:2] - 4.0 * bending - 15.0 * rate
    wide = np.zeros((*u.shape[:-1], u.shape[-1] + 6), dtype=stencil.dtype)
    wide[..., 3:-3] = u
    # differences of neighbors keep the digits that a sum with the stencil loses
    slope = np.diff(wide)
    bend = np.diff(slope)
    moment = bending * bend[..., 1:-1] - np.diff(rate * np.diff(bend))
    force: Array = -np.diff(tension * slope[..., 2:-2] - np.diff(moment))
    return force


def _damped_newton(system: _System) -> tuple[Array, int, bool]:
    """Return one band's displacement (1, inner) by steps along which the energy falls."""
    u = np.zeros(system.low.shape)
    for solve in range(_MAX_SOLVES - _FULL_STEPS):
        active = system.active_set(u)
        target, reached = system.solve(active)
        if all((new == old).all() for new, old in zip(reached, active, strict=True)):
            return target, solve + 1, True
        u = u + _line_search(system, u, target - u) * (target - u)
    return u, _MAX_SOLVES - _FULL_STEPS, False


def _line_search(system: _System, u: Array, step: Array) -> float:
    """Return the fraction of a step with the least energy: the root of its slope, by the Illinois method."""

    def slope(fraction: float) -> float:
        return float((step * system.gradient(u + fraction * step)).sum())

    a, b = 0.0, 1.0
    at_a, at_b = slope(a), slope(b)
    if at_b <= 0.0 or at_a >= 0.0:
        return 1.0
    flat = -1e-3 * at_a  # an exact root is not needed
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
