"""Smoothing QP against an independent dense solve, its limits and its failures."""

import math
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_triangular
from scipy.optimize import nnls

from cca_core.band import qp as quadratic
from cca_core.band.qp import solve_smoothing_qp
from cca_core.errors import InputError, MissingExtraError

pytestmark = [pytest.mark.requires(module) for module in ("qpsolvers", "piqp", "osqp")]
both = pytest.mark.parametrize("solver", ["piqp", "osqp"])


def passing(n: int, *, h: float = 1.0, at: float = 1.0, kappa: float = 0.0, **limits: Any) -> dict[str, Any]:
    """Pass an obstacle in the middle of the band at a displacement of at least `at`."""
    s = np.linspace(-1.0, 1.0, n)
    return {
        "spacing": h,
        "route_curvature": np.full(n, kappa),
        "lower": np.where(np.abs(s) < 0.1, at, -4.0),
        "upper": np.full(n, 4.0),
        **limits,
    }


def linear_curvature(u: np.ndarray, h: float, kappa: np.ndarray) -> np.ndarray:
    return kappa + kappa**2 * u + np.diff(np.pad(u, 1), 2) / h**2


def solve_by_nnls(problem: dict[str, Any]) -> np.ndarray | None:
    """Solve the problem by Lawson and Hanson's reduction to NNLS; None if infeasible."""
    h, kappa = problem["spacing"], problem["route_curvature"]
    n = len(kappa)
    inner = np.eye(n)[:, 2:-2]
    curvature = np.diff(np.pad(inner, ((1, 1), (0, 0))), 2, axis=0) / h**2 + kappa[:, None] ** 2 * inner
    change = np.diff(np.pad(curvature, ((1, 1), (0, 0))), axis=0) / h
    first, second = problem.get("weights", (0.0, 1.0))
    R = np.linalg.qr(np.vstack((math.sqrt(first) * curvature, math.sqrt(second) * change)), mode="r")
    before = np.diff(np.pad(kappa, 1, mode="edge")) / h
    rows, bounds = [inner, -inner], [problem["lower"], -problem["upper"]]
    for matrix, offset, name in (
        (curvature, kappa, "curvature_limit"),
        (change, before, "curvature_rate_limit"),
    ):
        limit = problem.get(name, math.inf)
        if limit < math.inf:
            rows += [matrix, -matrix]
            bounds += [-limit - offset, offset - limit]
    G, bound = np.vstack(rows), np.concatenate(bounds)
    size = np.abs(G).max(axis=1)
    keep = (size > 0.0) & np.isfinite(bound)
    G, bound = G[keep] / size[keep, None], bound[keep] / size[keep]
    E = np.vstack((solve_triangular(R, G.T, trans="T"), bound))
    f = np.zeros(len(E))
    f[-1] = 1.0
    y, distance = nnls(E, f, maxiter=100 * E.shape[1])
    if distance < 1e-7:
        return None
    rest = E @ y - f
    return inner @ solve_triangular(R, -rest[:-1] / rest[-1])


PROBLEMS = [
    passing(40),
    passing(41, h=2.0, at=2.5, kappa=0.005, curvature_limit=0.05),
    passing(40, weights=(1.0, 0.0)),
    passing(40, weights=(0.02, 1.0), curvature_limit=0.02, kappa=-0.01),
    passing(30, h=0.5, at=0.1, curvature_limit=0.03, curvature_rate_limit=0.02),
    passing(50, curvature_rate_limit=0.0035),
]


@both
@pytest.mark.parametrize("problem", PROBLEMS)
def test_optimum_equals_nnls_solution(problem: dict[str, Any], solver: Any) -> None:
    expected = solve_by_nnls(problem)
    assert expected is not None
    band = solve_smoothing_qp(**problem, solver=solver)
    assert band.solved, band.message
    np.testing.assert_allclose(band.u, expected, rtol=0.0, atol=1e-5 if solver == "piqp" else 1e-4)


@both
def test_free_route_has_zero_displacement(solver: Any) -> None:
    band = solve_smoothing_qp(**passing(100, at=-4.0, curvature_limit=0.1), solver=solver)
    assert band.solved
    np.testing.assert_allclose(band.u, 0.0, atol=1e-6)


def test_limits_are_reached() -> None:
    free = solve_smoothing_qp(**passing(100, at=2.5)).u
    kappa = np.zeros(100)
    peak = np.abs(linear_curvature(free, 1.0, kappa)).max()
    rate = np.abs(np.diff(np.pad(free, 2), 3)).max()
    limited = solve_smoothing_qp(**passing(100, at=2.5, curvature_limit=0.9 * peak)).u
    assert np.abs(linear_curvature(limited, 1.0, kappa)).max() == pytest.approx(0.9 * peak, abs=1e-8)
    limited = solve_smoothing_qp(**passing(100, at=2.5, curvature_rate_limit=0.9 * rate)).u
    assert np.abs(np.diff(np.pad(limited, 2), 3)).max() == pytest.approx(0.9 * rate, abs=1e-8)
    per_node = np.where(np.arange(100) < 50, 0.9 * peak, math.inf)
    limited = solve_smoothing_qp(**passing(100, at=2.5, curvature_limit=per_node)).u
    assert np.abs(linear_curvature(limited, 1.0, kappa))[:50].max() <= 0.9 * peak + 1e-8


def test_curvature_rate_includes_route() -> None:
    problem = passing(60, at=-4.0)
    problem["route_curvature"] = 0.02 * np.sin(np.linspace(0.0, 2.0 * np.pi, 60))
    rate = np.abs(np.diff(problem["route_curvature"])).max()
    assert np.abs(solve_smoothing_qp(**problem, curvature_rate_limit=1.01 * rate).u).max() < 1e-6
    band = solve_smoothing_qp(**problem, curvature_rate_limit=0.95 * rate)
    assert band.solved, band.message
    curvature = linear_curvature(band.u, 1.0, problem["route_curvature"])
    assert np.abs(np.diff(curvature)).max() <= 0.95 * rate + 1e-8
    assert np.abs(band.u).max() > 0.001


@both
def test_solution_satisfies_kkt_conditions(solver: Any) -> None:
    band = solve_smoothing_qp(
        **passing(100, at=2.5, curvature_limit=0.01, curvature_rate_limit=0.02), solver=solver
    )
    other = solve_smoothing_qp(**passing(100, at=2.5, curvature_limit=0.01, curvature_rate_limit=0.02))
    assert band.solved, band.message
    assert band.primal_residual < 1e-6
    assert band.dual_residual < 1e-4
    assert band.gap < 1e-4
    np.testing.assert_allclose(band.u, other.u, rtol=0.0, atol=1e-4)


@both
@pytest.mark.parametrize(
    "problem",
    [
        passing(60, at=5.0),
        {**passing(60), "lower": np.full(60, 0.1)},
        passing(60, at=2.5, curvature_limit=0.002),
        passing(60, at=2.5, curvature_rate_limit=1e-4),
        passing(60, kappa=0.1, curvature_limit=0.05),
    ],
)
def test_infeasible_problem_is_reported(problem: dict[str, Any], solver: Any) -> None:
    band = solve_smoothing_qp(**problem, solver=solver)
    assert not band.solved
    assert "no feasible displacement" in band.message or "no band within" in band.message
    assert band.gap == band.dual_residual == band.primal_residual == math.inf
    np.testing.assert_array_equal(band.u, 0.0)


@both
def test_iteration_limit_is_reported(solver: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    for options in quadratic.SOLVER_OPTIONS.values():
        monkeypatch.setitem(options, "max_iter", 3)
    band = solve_smoothing_qp(**passing(60), solver=solver)
    assert not band.solved
    assert "max" in band.message.lower()
    np.testing.assert_array_equal(band.u, 0.0)


def test_bounds_that_miss_each_other_by_a_hair_are_infeasible() -> None:
    band = solve_smoothing_qp(**passing(5, h=0.25, at=1e-4, curvature_limit=0.05, curvature_rate_limit=0.01))
    assert not band.solved
    assert band.message == "no band within these bounds"


def test_warm_start_needs_no_more_iterations() -> None:
    previous = solve_smoothing_qp(**passing(100, at=2.5)).u
    cold = solve_smoothing_qp(**passing(100, at=2.55), solver="osqp")
    warm = solve_smoothing_qp(**passing(100, at=2.55), solver="osqp", start=previous)
    assert cold.solved
    assert warm.solved
    assert warm.iterations <= cold.iterations
    np.testing.assert_allclose(warm.u, cold.u, rtol=0.0, atol=1e-4)


def test_curvature_error_corrects_true_curvature() -> None:
    n, kappa, limit = 121, 0.02, 0.023
    error: float | np.ndarray = 0.0
    over = []
    for _ in range(4):
        band = solve_smoothing_qp(
            **passing(n, at=3.0, kappa=kappa, curvature_limit=limit), curvature_error=error
        )
        assert band.solved, band.message
        r = 1.0 / kappa - np.pad(band.u, 1)  # polar coordinates around the center of the route's circle
        slope, bend = (r[2:] - r[:-2]) / (2.0 * kappa), np.diff(r, 2) / kappa**2
        r = r[1:-1]
        true = (r**2 + 2.0 * slope**2 - r * bend) / (r**2 + slope**2) ** 1.5
        error = true - linear_curvature(band.u, 1.0, np.full(n, kappa))
        over.append(np.abs(true).max() - limit)
    assert over[0] > 1e-4
    assert over[1] < 1e-6
    assert over[3] < 1e-8


@given(
    st.integers(5, 400),
    st.floats(0.25, 2.0),
    st.floats(-1.0, 3.0),
    st.floats(-0.02, 0.02),
    st.sampled_from([0.05, 0.2, math.inf]),
    st.sampled_from([0.01, math.inf]),
)
def test_result_is_finite_and_within_its_bounds(
    n: int, h: float, at: float, kappa: float, limit: float, rate: float
) -> None:
    problem = passing(n, h=h, at=at, kappa=kappa, curvature_limit=limit, curvature_rate_limit=rate)
    band = solve_smoothing_qp(**problem)
    assert np.isfinite(band.u).all()
    assert (band.u[[0, 1, -2, -1]] == 0.0).all()
    if band.solved:
        assert (band.u >= problem["lower"] - 1e-6).all()
        assert (band.u <= problem["upper"] + 1e-6).all()
        curvature = linear_curvature(band.u, h, problem["route_curvature"])
        assert np.abs(curvature).max() <= limit + 1e-6
        assert np.abs(np.diff(np.pad(curvature, 1, constant_values=kappa))).max() <= rate * h + 1e-6
    else:
        assert "no band within" in band.message or "no feasible" in band.message, band.message


def test_invalid_or_missing_solver_raises(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="solver must be"):
        solve_smoothing_qp(**passing(10), solver="simplex")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="finite"):
        solve_smoothing_qp(**passing(10, kappa=math.nan))
    monkeypatch.setattr(
        "cca_core._optional.find_spec", lambda name: None if name == "osqp" else find_spec(name)
    )
    with pytest.raises(MissingExtraError, match=r"cca-planner\[qp\]"):
        solve_smoothing_qp(**passing(10), solver="osqp")
