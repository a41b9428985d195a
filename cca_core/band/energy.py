"""Energy of a band with its gradient, Hessian and KKT residual."""

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_any, check_real
from cca_core.band.equilibrium import apply_stiffness
from cca_core.band.stiffness import BandStiffness
from cca_core.errors import InputError

__all__ = ["band_energy", "band_gradient", "band_hessian", "kkt_residual"]


def band_energy(
    u: ArrayLike, *, lower: ArrayLike, upper: ArrayLike, spacing: float, stiffness: BandStiffness
) -> Array:
    """Elastic energy of a band and of its contacts.

    Parameters
    ----------
    u : array_like, shape (..., n)
        Displacement [m]; the first and last two nodes are pinned, their values are not used. For a band
        with a start off its route, subtract `band.problem.free_displacement` from displacement and bounds.
    lower, upper : array_like, shape (..., n) or ()
        Bounds of the displacement [m], infinite where there is none.
    spacing : float
        Distance between nodes [m].
    stiffness : BandStiffness
        Elasticity.

    Returns
    -------
    energy : ndarray, shape (...)
        ``1/2 u K u + 1/2 k_e h (sum max(lower - u, 0)^2 + max(u - upper, 0)^2)`` over the other nodes [J].

    Raises
    ------
    InputError
        If a shape does not fit or a value is not finite (bounds: is NaN).

    Notes
    -----
    Convex, once continuously differentiable and piecewise quadratic. The paper's eq 4 is its gradient for
    tension alone and a given force.

    Examples
    --------
    >>> stiffness = BandStiffness(k_e=1.0)
    >>> float(band_energy(np.zeros(9), lower=0.5, upper=np.inf, spacing=1.0, stiffness=stiffness))
    0.625
    """
    inner, violation, stencil, contact = _parts(u, lower, upper, spacing, stiffness)
    energy: Array = 0.5 * (inner * apply_stiffness(stencil, inner) + contact * violation**2).sum(axis=-1)
    return energy


def band_gradient(
    u: ArrayLike, *, lower: ArrayLike, upper: ArrayLike, spacing: float, stiffness: BandStiffness
) -> Array:
    """Gradient of `band_energy`: the unbalanced force.

    Parameters
    ----------
    u : array_like, shape (..., n)
        Displacement [m]; the first and last two nodes are pinned, their values are not used. For a band
        with a start off its route, subtract `band.problem.free_displacement` from displacement and bounds.
    lower, upper : array_like, shape (..., n) or ()
        Bounds of the displacement [m], infinite where there is none.
    spacing : float
        Distance between nodes [m].
    stiffness : BandStiffness
        Elasticity.

    Returns
    -------
    gradient : ndarray, shape (..., n)
        ``K u - k_e h (max(lower - u, 0) - max(u - upper, 0))`` [N]; 0 at the pinned nodes.

    Raises
    ------
    InputError
        If a shape does not fit or a value is not finite (bounds: is NaN).
    """
    inner, violation, stencil, contact = _parts(u, lower, upper, spacing, stiffness)
    gradient = np.zeros((*inner.shape[:-1], inner.shape[-1] + 4))
    gradient[..., 2:-2] = apply_stiffness(stencil, inner) + contact * violation
    return gradient


def band_hessian(
    u: ArrayLike, *, lower: ArrayLike, upper: ArrayLike, spacing: float, stiffness: BandStiffness
) -> Array:
    """Generalized Hessian of `band_energy` at the nodes that are not pinned, in upper band storage.

    Parameters
    ----------
    u : array_like, shape (..., n)
        Displacement [m]; the first and last two nodes are pinned, their values are not used. For a band
        with a start off its route, subtract `band.problem.free_displacement` from displacement and bounds.
    lower, upper : array_like, shape (..., n) or ()
        Bounds of the displacement [m], infinite where there is none.
    spacing : float
        Distance between nodes [m].
    stiffness : BandStiffness
        Elasticity.

    Returns
    -------
    hessian : ndarray, shape (..., 4, n - 4)
        Row 3 is the diagonal, row 3 - k the k-th superdiagonal [N/m], as `scipy.linalg.solveh_banded` and
        LAPACK's ``dpbsv`` take it.

    Raises
    ------
    InputError
        If a shape does not fit or a value is not finite (bounds: is NaN).
    """
    inner, violation, stencil, contact = _parts(u, lower, upper, spacing, stiffness)
    hessian = np.zeros((*inner.shape[:-1], 4, inner.shape[-1]))
    hessian[:] = stencil[::-1, None]
    for k in (1, 2, 3):
        hessian[..., 3 - k, :k] = 0.0
    hessian[..., 3, :] += contact * (violation != 0.0)
    return hessian


def kkt_residual(
    u: ArrayLike, *, lower: ArrayLike, upper: ArrayLike, spacing: float, stiffness: BandStiffness
) -> Array:
    """KKT residual of a displacement: distance from the minimum of `band_energy`.

    Parameters
    ----------
    u : array_like, shape (..., n)
        Displacement [m]; the first and last two nodes are pinned, their values are not used. For a band
        with a start off its route, subtract `band.problem.free_displacement` from displacement and bounds.
    lower, upper : array_like, shape (..., n) or ()
        Bounds of the displacement [m], infinite where there is none.
    spacing : float
        Distance between nodes [m].
    stiffness : BandStiffness
        Elasticity.

    Returns
    -------
    residual : ndarray, shape (...)
        Largest unbalanced force, as the distance [m] by which a node would have to be beyond its bound to
        cause it.

    Raises
    ------
    InputError
        If a shape does not fit or a value is not finite (bounds: is NaN).

    Notes
    -----
    Bounds are soft, so the KKT conditions of the minimization are that the gradient vanishes.
    """
    gradient = band_gradient(u, lower=lower, upper=upper, spacing=spacing, stiffness=stiffness)
    residual: Array = np.abs(gradient).max(axis=-1) / (stiffness.k_e * spacing)
    return residual


def _parts(
    u: ArrayLike, lower: ArrayLike, upper: ArrayLike, spacing: float, stiffness: BandStiffness
) -> tuple[Array, Array, Array, float]:
    """Inner displacement, signed violation of the bounds, stencil and contact stiffness of a node."""
    at = check_any("u", u)
    if not at.ndim or at.shape[-1] < 5:
        raise InputError(f"u must have shape (..., n) with at least 5 nodes, had {at.shape}")
    h = check_real("spacing", spacing, gt=0.0)
    bounds = []
    for name, bound in (("lower", lower), ("upper", upper)):
        try:
            full = np.broadcast_to(np.asarray(bound, dtype=np.float64), at.shape)
        except (TypeError, ValueError, OverflowError):
            raise InputError(f"{name} must have shape () or {at.shape}, had {np.shape(bound)}") from None
        if np.isnan(full).any():
            raise InputError(f"{name} must not be NaN")
        bounds.append(full[..., 2:-2])
    inner = at[..., 2:-2]
    violation = np.maximum(inner - bounds[1], 0.0) - np.maximum(bounds[0] - inner, 0.0)
    return inner, violation, stiffness.stencil(h), stiffness.k_e * h
