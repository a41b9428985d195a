"""Equilibrium of bands against one-sided bounds, by the kernel."""

from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array, Index, Mask
from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.kernel import bind
from cca_core.kernel.band_workspace import Equilibrium
from cca_core.kernel.equilibrium_batch import find_equilibria
from cca_core.kernel.memory import give_back, reuse

_find_equilibria = bind(find_equilibria)


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

    __repr__ = short_repr


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

    Raises
    ------
    InputError
        If there are fewer than 5 nodes, or the bounds have different shapes.

    Notes
    -----
    Minimizes ``1/2 u K u + 1/2 contact (sum max(lower - u, 0)^2 + max(u - upper, 0)^2)``, and the same for
    curvature, by a semi-smooth Newton iteration. The energy is convex and piecewise quadratic: a step that
    reproduces its active set is the minimum. If 10 full steps do not converge, a line search damps the next
    ones, and the energy falls with every step. A batch is a loop in the kernel.

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
    shape, n = lower.shape, lower.shape[-1]
    if n < 5 or upper.shape != shape:
        raise InputError(f"lower and upper must have one shape (..., n) with at least 5 nodes, had {shape}")
    low, high = (np.ascontiguousarray(bound, dtype=np.float64).reshape(-1, n) for bound in (lower, upper))
    bands = len(low)
    rows = np.empty((bands, 5))
    rows[:, :3] = elasticity_of(np.reshape(stencil, (-1, 4)))
    rows[:, 3] = np.reshape(contact, -1)
    rows[:, 4] = 0.0 if curvature_bounds is None else curvature_bounds.contact
    sharp = (low, high) if curvature_bounds is None else (curvature_bounds.lower, curvature_bounds.upper)
    low_difference, high_difference = (np.ascontiguousarray(side, dtype=np.float64) for side in sharp)
    u = np.empty((bands, n))
    solves, converged = np.empty(bands, dtype=np.int32), np.empty(bands, dtype=np.int32)
    space = reuse(Equilibrium, max_n=1 << (n - 1).bit_length())
    _find_equilibria(
        space.workspace, bands, n, curvature_bounds is not None, rows, low, high,
        low_difference, high_difference, u, solves, converged,
    )  # fmt: skip
    give_back(space)
    batch_shape = shape[:-1]
    return (
        u.reshape(shape), solves.astype(np.intp).reshape(batch_shape),
        converged.astype(np.bool_).reshape(batch_shape),
    )  # fmt: skip


def elasticity_of(stencil: Array) -> Array:
    """Return curvature-rate, bending and tension coefficients of stencils (..., 4), shape (..., 3)."""
    rate = -stencil[..., 3]
    bending = stencil[..., 2] - 6.0 * rate
    return np.stack((rate, bending, -stencil[..., 1] - 4.0 * bending - 15.0 * rate), axis=-1)


def apply_stiffness(stencil: Array, u: Array) -> Array:
    """Return the internal forces K u [N] at the inner nodes, in the precision of the stencil."""
    rate, bending, tension = (each[..., None] for each in np.moveaxis(elasticity_of(stencil), -1, 0))
    wide = np.zeros((*u.shape[:-1], u.shape[-1] + 6), dtype=stencil.dtype)
    wide[..., 3:-3] = u
    # differences of neighbors keep the digits that a sum with the stencil loses
    slope = np.diff(wide)
    bend = np.diff(slope)
    moment = bending * bend[..., 1:-1] - np.diff(rate * np.diff(bend))
    force: Array = -np.diff(tension * slope[..., 2:-2] - np.diff(moment))
    return force
