"""Equilibrium of a band against one-sided bounds: a handful of banded solves."""

import numpy as np

from cca_core._checks import Array

__all__ = ["equilibrium"]

_SOLVES = 30  # a contact set settles in 3 to 8
_SECANTS = 12
_FLAT = 1e-3  # share of the first slope that is flat enough


def equilibrium(stencil: Array, contact: float, lower: Array, upper: Array) -> tuple[Array, int, bool]:
    """Displacement of least energy between pinned ends and one-sided bounds.

    Parameters
    ----------
    stencil : ndarray, shape (4,)
        Row of the stiffness matrix from its diagonal on [N/m], see `BandStiffness.stencil`.
    contact : float
        Force per violation of a bound at a node [N/m], positive.
    lower, upper : ndarray, shape (n,)
        Bounds of the displacement [m], lower <= upper; infinite where there is none.

    Returns
    -------
    u : ndarray, shape (n,)
        Displacement [m], 0 at both ends.
    solves : int
        Banded systems solved [-].
    settled : bool
        Whether the set of violated bounds has settled; if not, `u` is the best so far.

    Notes
    -----
    Minimises ``1/2 u K u + 1/2 contact (sum max(lower - u, 0)^2 + max(u - upper, 0)^2)`` by a semi-smooth
    Newton iteration. The energy is convex and piecewise quadratic, so a step whose contact set is its own is
    the minimum; a step that overshoots is shortened to where the energy along it is least.
    """
    from scipy.linalg import lapack  # slow to import, and importing the library is to be quick

    n = len(lower) - 2
    low, high = lower[1:-1], upper[1:-1]
    kernel = np.concatenate((stencil[:0:-1], stencil))
    matrix = np.repeat(stencil[::-1, None], n, axis=1)
    u = np.zeros(n)
    inside = np.zeros(n)  # the internal forces at u
    active = (u < low) | (u > high)
    for solve in range(_SOLVES):
        if not active.any():
            break
        bound = np.where(u < low, low, high)
        matrix[3] = stencil[0] + contact * active
        target = lapack.dpbsv(matrix, np.where(active, contact * bound, 0.0))[1]
        reached = (target < low) | (target > high)
        if (reached == active).all():
            full = np.zeros(n + 2)
            full[1:-1] = target
            return full, solve + 1, True
        step = target - u
        forces = np.convolve(target, kernel)[3:-3] - inside
        share = _least_along(u, step, inside, forces, contact, low, high)
        u = u + share * step
        inside = inside + share * forces
        active = (u < low) | (u > high)
    full = np.zeros(n + 2)
    full[1:-1] = u
    return full, _SOLVES if active.any() else 0, not active.any()


def _least_along(
    u: Array, step: Array, inside: Array, forces: Array, contact: float, low: Array, high: Array
) -> float:
    """Share of a Newton step at which the energy is least: the root of its slope, by the Illinois method."""

    def slope(share: float) -> float:
        at = u + share * step
        push = np.maximum(low - at, 0.0) - np.maximum(at - high, 0.0)
        return float(step @ (inside + share * forces - contact * push))

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
