"""Smooth a band by quadratic programming: least change of curvature within hard limits."""

import math
from dataclasses import replace

import numpy as np

from cca_core._checks import Array, Mask, check_array, check_real
from cca_core.band.band import Band, assemble_band
from cca_core.band.certificate import Certificate, certify
from cca_core.band.qp import QPSolver, solve_smoothing_qp
from cca_core.errors import InputError, Status

_PASSES = 8
_AIM = 1e-3  # beyond what is asked [m]
_MOST_SPARE = 0.05
_SPARE, _RATE_SPARE = 1e-3, 0.03  # shares of the limits that are left to their linearization


def smooth_band(
    band: Band,
    *,
    curvature_rate_limit: float = math.inf,
    weights: tuple[float, float] = (0.0, 1.0),
    solver: QPSolver = "piqp",
) -> Band:
    """Least curvature change with the sides of a band, its corridor and its limits.

    Parameters
    ----------
    band : Band
        A single band; it need not be OK: a band that bends too much may be smoothed into one that does not.
    curvature_rate_limit : float
        Largest change of curvature per length [1/m^2], without sign; the route's own changes count.
    weights : pair of float
        Weight of the curvature change squared [m^2] and of its rate squared [m^4].
    solver : {"piqp", "osqp"}
        Interior points, or operator splitting started at the band (slower on long bands).

    Returns
    -------
    band : Band
        The smoothest band, with the same promises. Where there is none the given band stands: if it was OK
        its status becomes `Status.FALLBACK`, and the message says what failed.

    Raises
    ------
    InputError
        If an argument has a wrong type or is out of range.
    MissingExtraError
        If the extra ``qp`` is not installed.

    Notes
    -----
    Bounds are hard here, those of the relaxed band give way. What turned boxes lack and what the linear
    curvature misses is corrected in a few passes.

    Examples
    --------
    >>> from cca_core import VehicleParams, relax_band
    >>> from cca_core.geometry import boxes
    >>> route = np.column_stack((np.arange(0.0, 101.0), np.zeros(101)))
    >>> band = relax_band(route, [boxes(50.0, 0.0, 0.0, 4.5, 1.8)], vehicle=VehicleParams.bmw_320i())
    >>> smooth_band(band, curvature_rate_limit=0.001).status.name
    'OK'
    """
    if not isinstance(band, Band):
        raise InputError(f"band must be a Band, was {type(band).__name__}")
    if band.nodes.ndim != 2:
        raise InputError("band must be a single band; choose one, as in band[0]")
    if band.problem.free_displacement.any():
        raise InputError("band must begin on its route to be smoothed")
    weigh = check_array("weights", weights, (2,))
    if weigh.min() < 0.0 or not weigh.any():
        raise InputError(f"weights must not be negative and not both 0, were {weights!r}")
    rate = check_real("curvature_rate_limit", curvature_rate_limit, gt=0.0, allow_inf=True)
    task = band.problem
    h = float(task.h[0])
    passes_left = band.passes_left[:, None]
    lower, upper = (bound[0].copy() for bound in task.corridor.bounds(passes_left))
    base, error = task.curvature[0], np.zeros(len(band))
    spare = _SPARE
    u, message = band.displacement, ""
    for _ in range(_PASSES):
        outcome = solve_smoothing_qp(
            spacing=h, route_curvature=base, lower=lower, upper=upper,
            curvature_limit=(1.0 - spare) * task.curvature_limit[0],
            curvature_rate_limit=(1.0 - _RATE_SPARE) * rate, weights=weights, curvature_error=error,
            solver=solver, start=u,
        )  # fmt: skip
        if not outcome.solved and message:
            message = outcome.message
            break
        if outcome.solved:
            u = outcome.u
        found = certify(task, u[None])
        true = found.curvature[0]
        wide = np.pad(u, 1)
        error = true - (base + base**2 * u + (wide[2:] - 2.0 * u + wide[:-2]) / h**2)
        missing = max(task.clearance - found.min_gap[0], -found.min_edge_clearance[0])
        bent = found.curvature_ratio[0] - 1.0
        steep = np.abs(np.diff(true)).max() / h - rate
        if outcome.solved and missing <= 0.0 and bent <= 0.0 and steep <= 0.0:
            smooth = assemble_band(
                task, (), u[None], found, passes_left=passes_left, lower=lower[None], upper=upper[None],
                solves=np.array([band.n_solves]), stuck={},
            )  # fmt: skip
            residual = max(outcome.primal_residual, outcome.dual_residual, outcome.gap)
            return replace(smooth, qp_residual=residual)
        spare = min(spare + max(bent, 0.0), _MOST_SPARE)  # corners of the curvature overshoot in the cubic
        lower, upper = _safe_displacement_bounds(found, u, band.passes_left, task.clearance)
        lacking = (
            f"{missing:.3f} m of clearance" if missing > 0.0 else
            "curvature" if bent > 0.0 else "curvature rate"
        )  # fmt: skip
        message = f"{lacking} still lacking after {_PASSES} passes"
    status = Status.DEGRADED if band.ok else band.status
    return replace(band, status=status, message=f"not smoothed ({message}); {band.message}")


def _safe_displacement_bounds(
    found: Certificate, u: Array, passes_left: Mask, clearance: float
) -> tuple[Array, Array]:
    """Bounds within which gaps stay above clearance while headings stay: no gap changes faster than u."""
    spare = found.gaps[:, 0] - (clearance + _AIM)
    left = passes_left[:, None]
    low = np.min(spare, axis=0, where=left, initial=math.inf)
    up = np.min(spare, axis=0, where=~left, initial=math.inf)
    lower = u - np.minimum(low, found.right_margin[0] - _AIM)
    upper = u + np.minimum(up, found.left_margin[0] - _AIM)
    lower[[0, 1, -2, -1]], upper[[0, 1, -2, -1]] = -math.inf, math.inf
    return lower, upper
