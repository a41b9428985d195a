"""Quadratic program of the smoothest band within hard bounds."""

import math
import warnings
from copy import copy
from dataclasses import dataclass, field
from functools import lru_cache
from importlib.util import find_spec
from typing import Any, Literal

import numpy as np

from cca_core._checks import Array
from cca_core._optional import require_extra
from cca_core.errors import InputError

QPSolver = Literal["piqp", "osqp"]

SOLVER_OPTIONS: dict[str, dict[str, Any]] = {
    "piqp": {"max_iter": 100, "preconditioner_iter": 2},  # 8 to 15 iterations are usual
    "osqp": {"max_iter": 4000, "eps_abs": 1e-5, "eps_rel": 1e-5, "polishing": True},
}
_NO_BAND = "no band within these bounds"
_UNITS_PER_BAND = 10.0  # the unit of length is a tenth of the band, so that all numbers are near 1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class QpSolution:
    """Result of `solve_smoothing_qp`."""

    u: Array  # lateral displacement [m], (n,); zero if not solved
    solved: bool  # whether u is the optimum and satisfies all bounds
    message: str
    iterations: int = 0
    solution: Any = field(default=None, repr=False)

    @property
    def primal_residual(self) -> float:
        """Largest violation of a bound or link, in scaled units [-]; infinite if not solved."""
        return float(self.solution.primal_residual()) if self.solved else math.inf

    @property
    def dual_residual(self) -> float:
        """Largest unbalanced force, in scaled units [-]; infinite if not solved."""
        return float(self.solution.dual_residual()) if self.solved else math.inf

    @property
    def gap(self) -> float:
        """Cost minus its lower bound from the dual, in scaled units [-]; infinite if not solved."""
        return float(self.solution.duality_gap()) if self.solved else math.inf


def solve_smoothing_qp(
    *,
    spacing: float,
    route_curvature: Array,
    lower: Array,
    upper: Array,
    curvature_limit: float | Array = math.inf,
    curvature_rate_limit: float = math.inf,
    weights: tuple[float, float] = (0.0, 1.0),
    curvature_error: float | Array = 0.0,
    solver: QPSolver = "piqp",
    start: Array | None = None,
) -> QpSolution:
    """Find the displacement of least curvature change between pinned ends, with hard bounds."""
    # minimizes integral w_1 c^2 + w_2 c'^2 ds with c = u'' + kappa_0^2 u, the linear change of curvature by
    # an offset u. Unknowns are u and its second difference: all limits but those of c' are plain bounds.
    # curvature_error, true minus linear curvature, makes repeated calls converge to limits on the true one.
    if solver not in SOLVER_OPTIONS:
        raise InputError(f"solver must be 'piqp' or 'osqp', was {solver!r}")
    n = len(lower)
    ends = [0, 1, -2, -1]
    if not ((lower <= upper).all() and lower[ends].max() <= 0.0 <= upper[ends].min()):
        return QpSolution(u=np.zeros(n), solved=False, message="the bounds leave no feasible displacement")
    require_extra("qpsolvers", "qp")
    require_extra(solver, "qp")

    unit = (n - 1) / _UNITS_PER_BAND * spacing
    problem = _scaled_problem(
        unit, spacing, route_curvature, curvature_error, lower[2:-2], upper[2:-2], curvature_limit,
        curvature_rate_limit, weights,
    )  # fmt: skip
    result = _solution(problem, unit, solver, start)
    is_undecided = not result.solved and result.message != _NO_BAND  # such as bounds that miss by a hair
    if is_undecided and solver == "piqp" and find_spec("osqp"):
        result = _solution(problem, unit, "osqp", start)
    return result


def _solution(problem: Any, unit: float, solver: QPSolver, start: Array | None) -> QpSolution:
    """Return what a solver finds."""
    qpsolvers = require_extra("qpsolvers", "qp")
    n = len(problem.b)
    u, guess = np.zeros(n), None
    if start is not None and solver == "osqp":
        guess = np.concatenate((start[2:-2], problem.A[:, : n - 4] @ start[2:-2]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # infeasibility is a result
        solution = qpsolvers.solve_problem(problem, solver, initvals=guess, **SOLVER_OPTIONS[solver])
    info = solution.extras["info"]
    message = _words(solver, str(getattr(info.status, "name", info.status)))
    violation = solution.primal_residual()
    solved = bool(violation <= 1e-6 * min(unit**2, 1.0))  # [m, 1/m]
    if solved:
        u[2:-2] = solution.x[: n - 4]
    elif solution.found:
        message += f", but violates a bound by {violation:.1e}"
    return QpSolution(u=u, solved=solved, message=message, iterations=int(info.iter), solution=solution)


def _scaled_problem(
    unit: float,
    spacing: float,
    route_curvature: Array,
    curvature_error: float | Array,
    lower: Array,
    upper: Array,
    curvature_limit: float | Array,
    curvature_rate_limit: float,
    weights: tuple[float, float],
) -> Any:
    """Return the quadratic program in lengths of `unit` [m]."""
    from qpsolvers import Problem

    n = len(route_curvature)
    inner, nodes_per_unit = n - 4, (n - 1) / _UNITS_PER_BAND
    bending = weights[0] * unit**2 / (weights[0] * unit**2 + weights[1])
    level, slope, link, rates = _templates(n)
    cost = copy(level)
    cost.data = bending / nodes_per_unit * level.data + (1.0 - bending) * nodes_per_unit * slope.data
    linked = copy(link)
    linked.data = link.data.copy()
    linked.data[1 : 3 * inner : 3] += (unit * route_curvature[2:-2]) ** 2
    base = unit**2 * (route_curvature + curvature_error)
    if not np.isfinite(base).all():
        raise InputError("route_curvature and curvature_error must be finite")
    limit = unit**2 * np.asarray(curvature_limit)
    problem = Problem(
        cost, np.zeros(inner + n), A=linked, b=np.zeros(n),
        lb=np.concatenate((lower, -limit - base)), ub=np.concatenate((upper, limit - base)),
    )  # fmt: skip
    if curvature_rate_limit < math.inf:
        step = np.zeros(n + 1)
        step[1:-1] = np.diff(base)
        max_step = unit**2 * curvature_rate_limit * spacing
        problem.G, problem.h = rates, np.concatenate((max_step - step, max_step + step))
    return problem


def _words(solver: QPSolver, status: str) -> str:
    """Return the result of a solver in words."""
    words = status.lower().removeprefix("piqp_").replace("_", " ")
    return _NO_BAND if "primal infeasible" in words else f"{solver}: {words}"


@lru_cache(maxsize=32)
def _templates(n: int) -> tuple[Any, Any, Any, Any]:
    """Return the matrices of a problem with n nodes: level and slope (same structure), link, rates."""
    from scipy import sparse  # slow to import, and importing the library is to be quick

    inner = n - 4
    units = ((n - 1) / _UNITS_PER_BAND) ** 2
    bend = sparse.diags([units, -2.0 * units, units], [-1, -2, -3], shape=(n, inner))
    link = sparse.csc_matrix(sparse.hstack((bend, -sparse.identity(n))))
    change = sparse.diags([1.0, -1.0], [0, -1], shape=(n + 1, n))
    none = sparse.csc_matrix((n + 1, inner))
    rates = sparse.csc_matrix(sparse.bmat([[none, change], [none, -change]]))
    slope = sparse.csc_matrix(sparse.block_diag((sparse.csc_matrix((inner, inner)), change.T @ change)))
    level = copy(slope)
    level.data = np.where(slope.data > 0.0, 1.0, 0.0)
    return level, slope, link, rates
