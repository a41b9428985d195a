"""Equilibrium of bands against one-sided bounds: a handful of banded solves.

The system, its contacts, the steps toward its minimum and the band without contacts share one stiffness and
one way to keep its digits, so this module is a little longer than others.
"""

from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array, Index, Mask
from cca_core.errors import InputError

__all__ = ["CurvatureBounds", "equilibrium"]

_FULL_STEPS = 10  # a contact set settles in 3 to 6
_SOLVES = 60  # full and shortened steps together
_SECANTS = 12
_FLAT = 1e-3  # share of the first slope that is flat enough
_STIFF = 1e5  # stiffness per contact stiffness above which digits are lost that corrections win back
_CORRECTIONS = 3
_LONG = 200  # nodes from which on a band that nothing bends is corrected likewise


@dataclass(frozen=True, slots=True, eq=False)
class CurvatureBounds:
    """One-sided bounds of how bands bend.

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
    stencil: Array, contact: float | Array, lower: Array, upper: Array, bends: CurvatureBounds | None = None
) -> tuple[Array, Index, Mask]:
    """Displacement of least energy between pinned ends and one-sided bounds.

    Parameters
    ----------
    stencil : ndarray, shape (..., 4) or (4,)
        Row of the stiffness matrix from its diagonal on [N/m], see `BandStiffness.stencil`; its rounding
        errors tilt long bands with fine meshes unless it is given in extended precision.
    contact : float or ndarray, shape (...)
        Force per violation of a bound at a node [N/m], positive.
    lower, upper : ndarray, shape (..., n)
        Bounds of the displacement [m], lower <= upper; infinite where there is none.
    bends : Bends, optional
        Bounds of the bending.

    Returns
    -------
    u : ndarray, shape (..., n)
        Displacement [m], 0 at the first and last two nodes.
    solves : ndarray of int, shape (...)
        Banded systems solved [-].
    settled : ndarray of bool, shape (...)
        Whether the set of violated bounds has settled; if not, `u` is the best so far.

    Notes
    -----
    Minimizes ``1/2 u K u + 1/2 contact (sum max(lower - u, 0)^2 + max(u - upper, 0)^2)``, and the same for
    the bounds of the bending, by a semi-smooth Newton iteration. The energy is convex and quadratic in parts,
    so a step whose contact set is its own is the minimum. Where full steps have not settled after a while,
    steps are shortened to where the energy along them is least, so that it falls with every one. Bands are
    stacked into one block-diagonal system.
    """
    shape = lower.shape
    low, high = (bound[..., 2:-2].reshape(-1, shape[-1] - 4) for bound in (lower, upper))
    bands = len(low)
    # in units in which the outermost coefficient is 1 the row sum keeps its digits
    stencil = np.reshape(stencil, (-1, 4))
    unit = -stencil[:, 3:] if stencil[0, 3] else np.abs(stencil[:, 2:3] if stencil[0, 2] else stencil[:, 1:2])
    held = np.asarray(np.reshape(contact, (-1, 1)) / unit, dtype=np.float64)
    stencil = stencil / unit
    if len(stencil) != bands:
        stencil, held = stencil.repeat(bands, axis=0), held.repeat(bands, axis=0)
    if bends is not None:
        bends = CurvatureBounds(
            np.asarray(bends.contact[:, None] / unit, dtype=np.float64),
            bends.lower[:, 1:-1],
            bends.upper[:, 1:-1],
        )
    system = _System(stencil, held, low, high, bends)
    u = np.zeros((bands, shape[-1]))
    solves = np.zeros(bands, dtype=np.intp)
    settled = np.zeros(bands, dtype=np.bool_)
    left = np.arange(bands)  # those that have not settled
    contacts = system.initial_active_set()
    for count in range(1, 1 + _FULL_STEPS):
        target, reached = system.solve(contacts)
        done = (reached[0] == contacts[0]).all(axis=1)
        for now, before in zip(reached[1:], contacts[1:], strict=True):
            done &= (now == before).all(axis=1)
        contacts = reached
        if not done.any():
            continue
        if count == 1 and done.all():
            u[:, 2:-2], solves[:], settled[:] = target, count, True
            return u.reshape(shape), solves.reshape(shape[:-1]), settled.reshape(shape[:-1])
        at = left[done]
        u[at, 2:-2], solves[at], settled[at] = target[done], count, True
        left = left[~done]
        if not len(left):
            break
        system, contacts = system.select(~done), tuple(side[~done] for side in contacts)
    for i, each in enumerate(left):
        u[each, 2:-2], steps, settled[each] = _damped_newton(system.select(slice(i, i + 1)))
        solves[each] = _FULL_STEPS + steps
    return u.reshape(shape), solves.reshape(shape[:-1]), settled.reshape(shape[:-1])


def free_response(stencil: Array, start: Array, n: int) -> Array:
    """Displacement of bands that nothing but their start bends.

    Parameters
    ----------
    stencil : ndarray, shape (bands, 4)
        Row of the stiffness matrix from its diagonal on [N/m].
    start : ndarray, shape (bands, 3)
        Displacement at the node before the first and at the first two [m].
    n : int
        Nodes [-].

    Returns
    -------
    u : ndarray, shape (bands, n)
        Displacement of least energy [m], 0 at the last two nodes.

    Raises
    ------
    InputError
        If there are too many nodes for the digits of the machine.
    """
    from scipy.linalg import lapack  # slow to import, and importing the library is to be quick

    unit = stencil / stencil[:, :1]
    row = np.asarray(unit, dtype=np.float64)
    u = np.zeros((len(start), n))
    u[:, :2] = start[:, 1:]
    force = np.zeros((len(start), max(n - 4, 3)))
    for k in range(3):  # what the held nodes pull at the first three that are free
        force[:, k] = -(row[:, k + 1 :] * start[:, ::-1][:, : 3 - k]).sum(axis=1)
    for i, f in enumerate(force[:, : n - 4]):
        matrix, rest = np.repeat(row[i, ::-1, None], n - 4, axis=1), f
        for _ in range(1 + _CORRECTIONS * (n > _LONG)):
            _, solution, info = lapack.dpbsv(matrix, rest)
            if info:
                raise InputError(f"nodes must be fewer where a band begins off its route, were {n}")
            u[i, 2:-2] += solution
            rest = (f - apply_stiffness(unit[i], u[i, 2:-2])).astype(np.float64)
    return u


class _System:
    """Bands side by side: stiffness as one block-diagonal matrix in LAPACK's upper band storage.

    Contacts are masks of nodes: under the lower bound, over the upper one, and the same for bends.
    """

    def __init__(
        self, stencil: Array, contact: Array, low: Array, high: Array, bends: CurvatureBounds | None
    ) -> None:
        from scipy.linalg import lapack  # slow to import, and importing the library is to be quick

        self._lapack = lapack
        self.stencil, self.contact, self.low, self.high, self.bends = stencil, contact, low, high, bends
        rounded = stencil.astype(np.float64)
        self._stiff = rounded[:, :1] > _STIFF * contact
        self._diagonal = rounded[:, :1]
        self._string = bends is None and not rounded[:, 2:].any()
        self._matrix = np.empty((*low.shape, 4))
        self._matrix[:] = rounded[:, None, ::-1]
        for k in range(3):
            self._matrix[:, : 3 - k, k] = 0.0  # nothing couples a band's first nodes with the band before

    def select(self, bands: Mask | slice) -> "_System":
        """Return the system of some of the bands."""
        b = self.bends
        some = None if b is None else CurvatureBounds(b.contact[bands], b.lower[bands], b.upper[bands])
        return _System(self.stencil[bands], self.contact[bands], self.low[bands], self.high[bands], some)

    def initial_active_set(self) -> tuple[Mask, ...]:
        """Contacts to begin with: a stiff band touches a straight bound at its first and last node only."""
        under, over = self.low > 0.0, self.high < 0.0
        if not self._string:
            for side in (under, over):
                side[:, 1:-1] &= ~(side[:, :-2] & side[:, 2:])
        if self.bends is None:
            return under, over
        return under, over, self.bends.lower > 0.0, self.bends.upper < 0.0

    def active_set(self, u: Array) -> tuple[Mask, ...]:
        """Contacts at a displacement (bands, inner)."""
        under, over = u < self.low, u > self.high
        if self.bends is None:
            return under, over
        bend = _second_difference(u)
        return under, over, bend < self.bends.lower, bend > self.bends.upper

    def gradient(self, u: Array) -> Array:
        """Gradient of the energy."""
        pushed = self.contact * (np.maximum(self.low - u, 0.0) - np.maximum(u - self.high, 0.0))
        if self.bends is not None:
            bend = _second_difference(u)
            short = np.maximum(self.bends.lower - bend, 0.0) - np.maximum(bend - self.bends.upper, 0.0)
            pushed = pushed + np.diff(self.bends.contact * short, n=2)
        gradient: Array = apply_stiffness(self.stencil, u) - pushed
        return gradient

    def solve(self, contacts: tuple[Mask, ...]) -> tuple[Array, tuple[Mask, ...]]:
        """Equilibrium with a set of contacts held, and the contacts there."""
        under, over = contacts[:2]
        held = self.contact * (under | over)
        force = self.contact * np.where(under, self.low, np.where(over, self.high, 0.0))
        matrix = self._matrix
        if self.bends is None:
            np.add(self._diagonal, held, out=matrix[:, :, 3])
        else:
            sharp, wide = contacts[2:]
            bent = self.bends.contact * (sharp | wide)
            force = force + np.diff(bent * np.where(sharp, self.bends.lower, self.bends.upper), n=2)
            matrix = matrix.copy()
            matrix[:, :, 3] += held + (4.0 * bent[:, 1:-1] + bent[:, :-2] + bent[:, 2:])
            matrix[:, 1:, 2] -= 2.0 * (bent[:, 1:-2] + bent[:, 2:-1])
            matrix[:, 2:, 1] += bent[:, 2:-2]
        u = self._solved(matrix, force)
        if self._stiff.any():
            for _ in range(_CORRECTIONS):
                rest = force - held * u - apply_stiffness(self.stencil, u)
                if self.bends is not None:
                    rest = rest - np.diff(bent * _second_difference(u), n=2)
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
    """Return the internal forces K u at the nodes that are not pinned.

    Parameters
    ----------
    stencil : ndarray, shape (..., 4)
        Row of the stiffness matrix from its diagonal on [N/m].
    u : ndarray, shape (..., n - 4)
        Displacement of these nodes [m].

    Returns
    -------
    force : ndarray, shape (..., n - 4)
        Internal force [N], in the precision of the stencil.
    """
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
    for solve in range(_SOLVES - _FULL_STEPS):
        contacts = system.active_set(u)
        target, reached = system.solve(contacts)
        if all((now == before).all() for now, before in zip(reached, contacts, strict=True)):
            return target, solve + 1, True
        u = u + _line_search(system, u, target - u) * (target - u)
    return u, _SOLVES - _FULL_STEPS, False


def _line_search(system: _System, u: Array, step: Array) -> float:
    """Share of a Newton step at which the energy is least: the root of its slope, by the Illinois method."""

    def slope(share: float) -> float:
        return float((step * system.gradient(u + share * step)).sum())

    a, b = 0.0, 1.0
    at_a, at_b = slope(a), slope(b)
    if at_b <= 0.0 or at_a >= 0.0:
        return 1.0
    flat = -_FLAT * at_a
    for _ in range(_SECANTS):
        share = (a * at_b - b * at_a) / (at_b - at_a)
        value = slope(share)
        if abs(value) < flat or b - a < 1e-6:
            return share
        if value < 0.0:
            a, at_a, at_b = share, value, 0.5 * at_b
        else:
            b, at_b, at_a = share, value, 0.5 * at_a
    return a
