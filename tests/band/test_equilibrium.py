"""Equilibrium of bands against soft bounds, and their energy, gradient and Hessian."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solveh_banded
from scipy.optimize import minimize

from cca_core.band import (
    BandStiffness,
    CurvatureBounds,
    band_energy,
    band_gradient,
    band_hessian,
    equilibrium,
    kkt_residual,
)
from cca_core.errors import InputError
from tests.support.band_scenes import SOFT, dense_stiffness

BENDING_ALONE = BandStiffness(k_s=0.0, k_b=2.0, k_c=0.0, k_e=0.01)
STIFFNESSES = [
    SOFT,
    BandStiffness(k_s=1.0, k_b=0.0, k_c=0.0, k_e=0.05),
    BENDING_ALONE,
    BandStiffness(k_s=0.1, k_b=10.0, k_c=0.0, k_e=0.5),
]
HARD_CONTACT = [
    BandStiffness(k_s=0.0, k_b=0.0, k_c=5.0, k_e=1.0),
    BandStiffness(k_s=1e-3, k_b=0.1, k_c=1.0, k_e=1e3),
]
each_stiffness = pytest.mark.parametrize("stiffness", STIFFNESSES)
some_stiffness = st.sampled_from(STIFFNESSES)
any_stiffness = st.sampled_from(STIFFNESSES + HARD_CONTACT)
seeds = st.integers(0, 10_000)


def random_bounds(rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Feasible bounds: a few stretches to be passed above or below; n is at least 20."""
    lower, upper = np.full(n, -np.inf), np.full(n, np.inf)
    index = np.arange(n)
    for at in rng.uniform(0.1, 0.9, int(rng.integers(1, 6))) * n:
        part = np.abs(index - at) <= rng.uniform(1.0, min(10.0, 0.1 * n))
        if rng.random() < 0.5:
            low = np.maximum(lower[part], rng.uniform(-0.5, 3.0))
            lower[part] = np.minimum(low, upper[part])
        else:
            up = np.minimum(upper[part], rng.uniform(-3.0, 0.5))
            upper[part] = np.maximum(up, lower[part])
    return lower, upper


def attempt(
    stiffness: BandStiffness, h: float, lower: np.ndarray, upper: np.ndarray
) -> tuple[np.ndarray, dict, bool]:
    """Displacement, the problem and whether it converged; if not, the residual is large."""
    u, _, converged = equilibrium(stiffness.stencil(h), stiffness.k_e * h, lower, upper)
    problem = {"lower": lower, "upper": upper, "spacing": h, "stiffness": stiffness}
    assert np.isfinite(u).all()
    if converged:
        assert kkt_residual(u, **problem) <= rounding(u, problem)
    else:
        assert kkt_residual(u, **problem) > rounding(u, problem)
        assert band_energy(u, **problem) < band_energy(np.zeros_like(u), **problem)
    return u, problem, bool(converged)


def solve(
    stiffness: BandStiffness, h: float, lower: np.ndarray, upper: np.ndarray
) -> tuple[np.ndarray, dict]:
    u, problem, converged = attempt(stiffness, h, lower, upper)
    assert converged
    return u, problem


def rounding(u: np.ndarray, problem: dict) -> float:
    """Residual due to rounding of the displacement [m]."""
    stiffness, h = problem["stiffness"], problem["spacing"]
    digits = np.finfo(float).eps * np.abs(u).max()
    return 1e-10 + 4.0 * digits * float(stiffness.stencil(h)[0]) / (stiffness.k_e * h)


@given(some_stiffness, seeds, st.sampled_from([0.25, 0.5, 1.0, 2.0]), st.integers(20, 300))
def test_converged_band_has_no_residual(stiffness: BandStiffness, seed: int, h: float, n: int) -> None:
    lower, upper = random_bounds(np.random.default_rng(seed), n)
    u, _ = solve(stiffness, h, lower, upper)
    assert u.shape == (n,)
    np.testing.assert_array_equal(u[[0, 1, -2, -1]], 0.0)


@each_stiffness
@pytest.mark.parametrize("seed", range(3))
def test_ten_thousand_nodes(stiffness: BandStiffness, seed: int) -> None:
    rng = np.random.default_rng(seed)
    lower, upper = random_bounds(rng, 10_000)
    for at in rng.integers(500, 9500, 20):  # many more contacts
        lower[at : at + 8] = np.minimum(rng.uniform(0.0, 3.0), upper[at : at + 8])
    converged = attempt(stiffness, 1.0, lower, upper)[2]
    assert converged or stiffness is BENDING_ALONE  # may need more steps than allowed


@pytest.mark.parametrize("stiffness", [SOFT, *HARD_CONTACT])
def test_hard_contact_converges_mostly(stiffness: BandStiffness) -> None:
    """The default stiffness always converges."""
    converged = [
        attempt(stiffness, h, *random_bounds(np.random.default_rng(seed), 100))[2]
        for h in (0.25, 0.5, 1.0, 2.0)
        for seed in range(20)
    ]
    assert np.mean(converged) >= (1.0 if stiffness is SOFT else 0.8)


@given(some_stiffness, seeds, st.sampled_from([0.5, 1.0, 2.0]))
def test_equilibrium_has_minimal_energy(stiffness: BandStiffness, seed: int, h: float) -> None:
    rng = np.random.default_rng(seed)
    n = 101
    u, problem = solve(stiffness, h, *random_bounds(rng, n))
    energy = band_energy(u, **problem)
    position = np.linspace(0.0, 1.0, n)
    for scale in (0.0, 0.99, 1.01):
        assert band_energy(scale * u, **problem) >= energy * (1.0 - 1e-9)
    for k in rng.integers(1, 8, 5):  # smooth directions, where the energy changes least
        assert band_energy(u + 0.05 * np.sin(k * np.pi * position), **problem) >= energy * (1.0 - 1e-9)


@each_stiffness
def test_equilibrium_equals_general_optimizer(stiffness: BandStiffness) -> None:
    """The public energy and gradient suffice for another solver."""
    h, n = 1.0, 31
    lower, upper = np.full(n, -np.inf), np.full(n, np.inf)
    lower[12:17], upper[20:23] = 1.0, -0.4
    u, problem = solve(stiffness, h, lower, upper)
    # in coordinates in which the elastic energy is a sphere
    root = np.linalg.inv(np.linalg.cholesky(dense_stiffness(stiffness, h, n))).T
    scale = stiffness.k_e

    def displaced(z: np.ndarray) -> np.ndarray:
        return np.pad(root @ z * scale**0.5, 2)

    other = minimize(
        lambda z: float(band_energy(displaced(z), **problem)) / scale,
        np.zeros(n - 4),
        jac=lambda z: root.T @ band_gradient(displaced(z), **problem)[2:-2] / scale**0.5,
        method="BFGS",
        options={"gtol": 1e-9, "maxiter": 2000},
    )
    np.testing.assert_allclose(displaced(other.x), u, rtol=0.0, atol=1e-5)


@pytest.mark.parametrize("stiffness", STIFFNESSES + HARD_CONTACT)
@pytest.mark.parametrize("with_curvature_bounds", [False, True])
def test_batch_is_bitwise_identical(stiffness: BandStiffness, with_curvature_bounds: bool) -> None:
    rng = np.random.default_rng(5)
    h = rng.uniform(0.5, 2.0, 24)
    lower, upper = (np.array(side) for side in zip(*(random_bounds(rng, 90) for _ in h), strict=True))
    stencil, contact = stiffness.stencil(h), stiffness.k_e * h
    free, _, _ = equilibrium(stencil, contact, lower, upper)
    bounds = None
    if with_curvature_bounds:
        peak = 0.9 * np.abs(np.diff(free, n=2)).max(axis=1)
        limit = np.repeat(peak[:, None], 90, axis=1)
        bounds = CurvatureBounds(100.0 * contact, -limit, limit)
    u, solves, converged = equilibrium(stencil, contact, lower, upper, bounds)
    for i in range(len(h)):
        one = (
            None
            if bounds is None
            else CurvatureBounds(bounds.contact[[i]], bounds.lower[[i]], bounds.upper[[i]])
        )
        alone = equilibrium(stencil[[i]], contact[[i]], lower[[i]], upper[[i]], one)
        np.testing.assert_array_equal(alone[0][0], u[i])
        assert (alone[1][0], alone[2][0]) == (solves[i], converged[i])


def test_batch_of_two_axes() -> None:
    rng = np.random.default_rng(6)
    lower, upper = (
        np.array(side).reshape(2, 3, 60)
        for side in zip(*(random_bounds(rng, 60) for _ in range(6)), strict=True)
    )
    u, solves, converged = equilibrium(SOFT.stencil(1.0), SOFT.k_e, lower, upper)
    assert u.shape == (2, 3, 60)
    assert solves.shape == converged.shape == (2, 3)
    np.testing.assert_array_equal(
        u[1, 2], equilibrium(SOFT.stencil(1.0), SOFT.k_e, lower[1, 2], upper[1, 2])[0]
    )


@pytest.mark.parametrize("n", [0, 1, 4])
def test_equilibrium_of_too_few_nodes_raises(n: int) -> None:
    bound = np.ones(n)
    with pytest.raises(InputError, match=r"^lower and upper must have one shape"):
        equilibrium(SOFT.stencil(1.0), SOFT.k_e, -bound, bound)
    with pytest.raises(InputError, match=r"^lower and upper must have one shape"):
        equilibrium(SOFT.stencil(1.0), SOFT.k_e, -np.ones(n + 9), bound)


def test_curvature_bounds_balance_other_forces() -> None:
    """Violation times contact stiffness balances the other forces."""
    h, n = 1.0, 81
    lower, upper = np.full(n, -np.inf), np.full(n, np.inf)
    lower[35:46] = 2.0
    stencil, contact = SOFT.stencil(h), SOFT.k_e * h
    free = equilibrium(stencil, contact, lower, upper)[0]
    limit = 0.7 * np.abs(np.diff(free, n=2)).max()
    bound = np.full((1, n), limit)
    for stiff in (0.25, 25.0):
        u, _, converged = equilibrium(
            stencil, contact, lower[None], upper[None], CurvatureBounds(np.array([stiff]), -bound, bound)
        )
        assert converged.all()
        bend = np.diff(u[0], n=2)  # at all nodes but the ends
        force = (bend.clip(-limit, limit) - bend) * stiff
        K = dense_stiffness(SOFT, h, n)
        pushed = contact * np.maximum(lower[2:-2] - u[0, 2:-2], 0.0)
        np.testing.assert_allclose(K @ u[0, 2:-2], pushed + np.diff(force, n=2), rtol=0.0, atol=1e-9)
        assert np.abs(force).max() > 0.0
        over = np.abs(bend).max() - limit
    assert over < 1e-4


@given(any_stiffness, seeds, st.sampled_from([0.5, 1.0, 2.0]))
def test_energy_and_derivatives_equal_dense_matrices(stiffness: BandStiffness, seed: int, h: float) -> None:
    rng = np.random.default_rng(seed)
    n = 24
    lower, upper = random_bounds(rng, n)
    u = rng.uniform(-2.0, 2.0, (3, n))
    K, contact = dense_stiffness(stiffness, h, n), stiffness.k_e * h
    problem = {"lower": lower, "upper": upper, "spacing": h, "stiffness": stiffness}
    energy, gradient, hessian = (f(u, **problem) for f in (band_energy, band_gradient, band_hessian))
    assert energy.shape == (3,)
    assert hessian.shape == (3, 4, n - 4)
    for i in range(3):
        x = u[i, 2:-2]
        under, over = np.maximum(lower[2:-2] - x, 0.0), np.maximum(x - upper[2:-2], 0.0)
        scale = np.abs(K).max() * 2.0
        expected = 0.5 * x @ K @ x + 0.5 * contact * (under @ under + over @ over)
        assert energy[i] == pytest.approx(expected, rel=1e-10)
        np.testing.assert_allclose(
            gradient[i, 2:-2], K @ x - contact * (under - over), rtol=0.0, atol=1e-12 * scale
        )
        np.testing.assert_array_equal(gradient[i, [0, 1, -2, -1]], 0.0)
        dense = np.diag(hessian[i, 3])
        for k in (1, 2, 3):
            np.testing.assert_array_equal(hessian[i, 3 - k, :k], 0.0)
            dense += np.diag(hessian[i, 3 - k, k:], k) + np.diag(hessian[i, 3 - k, k:], -k)
        contacts = np.diag(contact * ((under > 0.0) | (over > 0.0)))
        np.testing.assert_allclose(dense, K + contacts, rtol=0.0, atol=1e-12 * scale)
        assert kkt_residual(u[i], **problem) == pytest.approx(np.abs(gradient[i]).max() / contact, rel=1e-12)


@given(any_stiffness, seeds)
def test_derivatives_equal_finite_differences(stiffness: BandStiffness, seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, h, step = 16, 1.0, 1e-5
    lower, upper = random_bounds(rng, n)
    u = rng.uniform(-2.0, 2.0, n)
    edges = np.concatenate((np.abs(u - lower), np.abs(u - upper)))
    if edges.min() <= 2.0 * step:
        return  # at a kink
    problem = {"lower": lower, "upper": upper, "spacing": h, "stiffness": stiffness}
    gradient = band_gradient(u, **problem)
    moves = step * np.eye(n)[2:-2]
    slope = (band_energy(u + moves, **problem) - band_energy(u - moves, **problem)) / (2.0 * step)
    scale = band_energy(u, **problem)
    np.testing.assert_allclose(slope, gradient[2:-2], rtol=0.0, atol=1e-9 * scale / step * 0.01 + 1e-12)
    change = (band_gradient(u + moves, **problem) - band_gradient(u - moves, **problem)) / (2.0 * step)
    banded = band_hessian(u, **problem)
    dense = sum(
        np.diag(banded[3 - k, k:], k) + (np.diag(banded[3 - k, k:], -k) if k else 0.0) for k in range(4)
    )
    np.testing.assert_allclose(change[:, 2:-2], dense, rtol=0.0, atol=1e-7 * np.abs(dense).max())


def test_newton_with_hessian_finds_equilibrium() -> None:
    """The Hessian has the storage of SciPy's banded solver."""
    n, h = 80, 1.0
    lower = np.full(n, -np.inf)
    lower[35:45] = 1.5
    u, problem = solve(SOFT, h, lower, np.full(n, np.inf))
    at = np.zeros(n)
    for _ in range(20):
        step = solveh_banded(band_hessian(at, **problem), band_gradient(at, **problem)[2:-2])
        at = at - np.pad(step, 2)
    np.testing.assert_allclose(at, u, rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("function", [band_energy, band_gradient, band_hessian, kkt_residual])
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"u": 1.0}, "^u must have shape"),
        ({"u": [0.0, 1.0]}, "^u must have shape"),
        ({"u": [0.0, np.nan, 0.0]}, "^u must be finite"),
        ({"lower": [0.0, 1.0]}, "^lower must have shape"),
        ({"upper": np.nan}, "^upper must not be NaN"),
        ({"spacing": 0.0}, "^spacing must be greater than 0"),
    ],
)
def test_invalid_argument_raises(function: object, changes: dict, words: str) -> None:
    good = {"u": np.zeros(9), "lower": -1.0, "upper": 1.0, "spacing": 1.0, "stiffness": SOFT}
    arguments = {**good, **changes}
    with pytest.raises(InputError, match=words):
        function(arguments.pop("u"), **arguments)  # type: ignore[operator]
