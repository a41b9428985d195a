"""Smoothing of a band by quadratic programming: least change of curvature within hard limits."""

import math
from dataclasses import replace

import numpy as np

from cca_core._checks import Array, Mask, check_array, check_real
from cca_core.band.band import Band, assemble_band
from cca_core.band.qp import QPSolver, solve_smoothing_qp
from cca_core.band.solver import Measured, measure
from cca_core.errors import InputError, Status

_MAX_PASSES = 8
_MARGIN = 1e-3  # clearance beyond the one asked [m], curvature below its limit as a fraction [-]


def smooth_band(
    band: Band,
    *,
    curvature_rate_limit: float = math.inf,
    weights: tuple[float, float] = (0.0, 1.0),
    solver: QPSolver = "piqp",
) -> Band:
    """Minimize the change of curvature with the sides, corridor and limits of a band.

    Parameters
    ----------
    band : Band
        A single band. It need not be OK: smoothing may satisfy a curvature limit that the band exceeds.
    curvature_rate_limit : float
        Largest change of curvature per length [1/m^2], without sign, the route's own changes included.
    weights : pair of float
        Weight of the curvature change squared [m^2] and of its rate squared [m^4].
    solver : {"piqp", "osqp"}
        Interior points, or operator splitting that starts at the band (slower on long bands).

    Returns
    -------
    band : Band
        The smoothest band, certified like the given one. Without a solution, the given band with the reason
        in its message; its status is then `Status.DEGRADED` if it was OK.

    Raises
    ------
    InputError
        If an argument has a wrong type or is out of range.
    MissingExtraError
        If the extra ``qp`` is not installed.

    Notes
    -----
    Bounds are hard here; those of `relax_band` yield. A few passes correct the effect of rotated boxes and
    of the linearized curvature.

    Examples
    --------
    >>> from cca_core import VehicleParams, relax_band
    >>> from cca_core.geometry import boxes
    >>> route = np.column_stack((np.arange(0.0, 101.0), np.zeros(101)))
    >>> band = relax_band(route, [boxes(50.0, 0.0, 0.0, 4.5, 1.8)], vehicle=VehicleParams.bmw_320i())
    >>> smooth_band(band, curvature_rate_limit=0.001).status.name
    'OK'
    """
    _check(band, weights)
    rate_limit = check_real("curvature_rate_limit", curvature_rate_limit, gt=0.0, allow_inf=True)
    problem, h, start = band.problem, band.spacing, measure(band.problem, passes_left=band.passes_left)
    route_curvature, lower, upper = start.route_curvature, start.lower, start.upper
    error, margin = np.zeros(len(band)), _MARGIN
    u, message = band.displacement, ""
    for _ in range(_MAX_PASSES):
        result = solve_smoothing_qp(
            spacing=h, route_curvature=route_curvature, lower=lower, upper=upper,
            curvature_limit=(1.0 - margin) * problem.curvature_limit[0],
            curvature_rate_limit=(1.0 - 0.03) * rate_limit,  # 3 % for the linearization
            weights=weights, curvature_error=error, solver=solver, start=u,
        )  # fmt: skip
        if not result.solved and message:
            message = result.message
            break
        if result.solved:
            u = result.u
        found = measure(problem, u, band.passes_left)
        curvature = found.curvature
        wide = np.pad(u, 1)
        linear = route_curvature + route_curvature**2 * u + (wide[2:] - 2.0 * u + wide[:-2]) / h**2
        error = curvature - linear
        shortfall = max(problem.clearance - found.min_gap, -found.min_edge_clearance)
        excess = found.curvature_ratio - 1.0
        rate_excess = np.abs(np.diff(curvature)).max() / h - rate_limit
        if result.solved and shortfall <= 0.0 and excess <= 0.0 and rate_excess <= 0.0:
            for bound in (lower, upper):
                bound.setflags(write=False)
            residual = max(result.primal_residual, result.dual_residual, result.gap)
            return replace(
                assemble_band(problem, (), found.found), lower=lower, upper=upper, n_solves=band.n_solves,
                qp_residual=residual,
            )  # fmt: skip
        margin = min(margin + max(excess, 0.0), 0.05)  # corners of the curvature overshoot in the cubic
        lower, upper = _safe_displacement_bounds(found, u, band.passes_left, problem.clearance)
        missing = (
            f"{shortfall:.3f} m of clearance" if shortfall > 0.0 else
            "curvature" if excess > 0.0 else "curvature rate"
        )  # fmt: skip
        message = f"{missing} still missing after {_MAX_PASSES} passes"
    status = Status.DEGRADED if band.ok else band.status
    return replace(band, status=status, message=f"not smoothed ({message}); {band.message}")


def _check(band: Band, weights: tuple[float, float]) -> None:
    """Check that a band can be smoothed with weights."""
    kind: object = band
    if not isinstance(kind, Band):
        raise InputError(f"band must be a Band, was {type(band).__name__}")
    if band.nodes.ndim != 2:
        raise InputError("band must be a single band; choose one, as in band[0]")
    if band.problem.start.any():
        raise InputError("band must begin on its route to be smoothed")
    pair = check_array("weights", weights, (2,))
    if pair.min() < 0.0 or not pair.any():
        raise InputError(f"weights must not be negative and not both 0, were {weights!r}")


def _safe_displacement_bounds(
    found: Measured, u: Array, passes_left: Mask, clearance: float
) -> tuple[Array, Array]:
    """Return bounds of u that keep gaps above the clearance: no gap changes faster than u."""
    excess = found.gaps - (clearance + _MARGIN)
    left = passes_left[:, None]
    low = np.min(excess, axis=0, where=left, initial=math.inf)
    up = np.min(excess, axis=0, where=~left, initial=math.inf)
    lower = u - np.minimum(low, found.right_margin - _MARGIN)
    upper = u + np.minimum(up, found.left_margin - _MARGIN)
    lower[[0, 1, -2, -1]], upper[[0, 1, -2, -1]] = -math.inf, math.inf
    return lower, upper
