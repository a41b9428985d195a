"""Eqs 3-5, 7, 9, 10 against dense algebra, and the stencil of the stiff band against D'D."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cca_core import VehicleParams
from cca_core.band import (
    BandStiffness,
    balancing_force,
    deformed,
    displacement,
    internal_force,
    relax_band,
    stiffness_matrix,
)
from cca_core.errors import InputError
from cca_core.geometry import boxes

sizes = st.integers(3, 60)


def random_rows(n: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal((n, 2))


@pytest.mark.parametrize("n", [3, 4, 5, 17, 80])
def test_inverse_of_k_closed_form(n: int) -> None:
    K, N = stiffness_matrix(n), n - 2
    assert K.shape == (N, N)
    i, j = np.meshgrid(np.arange(1, N + 1), np.arange(1, N + 1), indexing="ij")
    inverse = np.minimum(i, j) * (N + 1 - np.maximum(i, j)) / (N + 1)
    np.testing.assert_allclose(K @ inverse, np.eye(N), rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(np.linalg.inv(K), inverse, rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("n", [3, 10, 50])
def test_eigenvalues_of_k(n: int) -> None:
    N = n - 2
    expected = 2.0 - 2.0 * np.cos(np.arange(1, N + 1) * math.pi / (N + 1))
    np.testing.assert_allclose(np.linalg.eigvalsh(stiffness_matrix(n)), expected, rtol=0.0, atol=1e-12)
    assert expected.min() > 0.0


@given(sizes, st.integers(0, 1000), st.floats(0.01, 1e4))
def test_eq_9_equals_dense_solve(n: int, seed: int, k_s: float) -> None:
    F = random_rows(n, seed)
    u = displacement(F, k_s=k_s)
    dense = np.linalg.solve(stiffness_matrix(n), F[1:-1] / k_s)
    np.testing.assert_allclose(u[1:-1], dense, rtol=0.0, atol=1e-11 * max(1.0, np.abs(dense).max()))
    np.testing.assert_array_equal(u[[0, -1]], np.zeros((2, 2)))


@given(sizes, st.integers(0, 1000), st.floats(0.01, 1e4))
def test_eqs_3_4_5_7_agree(n: int, seed: int, k_s: float) -> None:
    """k_s K u = balancing force = minus the sum of both springs' forces; eq 9 inverts it."""
    u = random_rows(n, seed)
    u[[0, -1]] = 0.0
    F = balancing_force(u, k_s=k_s)
    np.testing.assert_allclose(F, k_s * stiffness_matrix(n) @ u[1:-1], rtol=0.0, atol=1e-11 * k_s)
    springs = internal_force(u, k_s=k_s)
    np.testing.assert_allclose(springs, k_s * (u[1:] - u[:-1]), rtol=0.0, atol=1e-12 * k_s)
    for i in range(1, n - 1):
        pull = k_s * (u[i + 1] - u[i]) + k_s * (u[i - 1] - u[i])
        np.testing.assert_allclose(F[i - 1], -pull, rtol=0.0, atol=1e-11 * k_s)
    back = displacement(np.vstack((np.ones((1, 2)), F, np.ones((1, 2)))), k_s=k_s)
    np.testing.assert_allclose(back, u, rtol=0.0, atol=1e-10)


def test_eq_9_mid_load_gives_triangle() -> None:
    """A unit force at the middle of 2 m + 1 springs lifts it by m / 2 and leaves straight sides."""
    n = 21
    F = np.zeros((n, 2))
    F[10, 1] = 1.0
    u = displacement(F, k_s=1.0)
    np.testing.assert_allclose(u[:, 1], np.minimum(np.arange(21), 20 - np.arange(21)) / 2.0, atol=1e-12)
    np.testing.assert_array_equal(u[:, 0], 0.0)


def test_forces_at_pins_have_no_effect() -> None:
    F = random_rows(12, 3)
    G = F.copy()
    G[[0, -1]] = 1e6
    np.testing.assert_array_equal(displacement(F, k_s=2.0), displacement(G, k_s=2.0))


def test_eqs_9_and_10_without_force() -> None:
    nodes = random_rows(9, 1)
    u = displacement(np.zeros((9, 2)), k_s=1.0)
    np.testing.assert_array_equal(deformed(nodes, u), nodes)
    moved = random_rows(9, 2)
    np.testing.assert_array_equal(deformed(nodes, moved), nodes + moved)


def test_three_nodes() -> None:
    u = displacement([[9.0, 9.0], [1.0, -3.0], [9.0, 9.0]], k_s=2.0)
    np.testing.assert_allclose(u, [[0.0, 0.0], [0.25, -0.75], [0.0, 0.0]])


@pytest.mark.parametrize("n", [2, 0, -5, math.nan, None, 3.7])
def test_invalid_size_raises(n: object) -> None:
    with pytest.raises(InputError, match=r"^n must be"):
        stiffness_matrix(n)  # type: ignore[arg-type]


@pytest.mark.parametrize("function", [internal_force, balancing_force, displacement])
@pytest.mark.parametrize(
    ("rows", "k_s", "words"),
    [
        (np.zeros((5, 3)), 1.0, "must have shape"),
        (np.zeros(5), 1.0, "must have shape"),
        ([[0.0, 0.0], [0.0, math.nan], [0.0, 0.0]], 1.0, r"must be finite, was nan at \[1, 1\]"),
        (np.zeros((1, 2)), 1.0, "must have at least"),
        (np.zeros((5, 2)), 0.0, "^k_s must be greater than 0"),
        (np.zeros((5, 2)), -1.0, "^k_s must be greater than 0"),
        (np.zeros((5, 2)), math.nan, "^k_s must be finite"),
    ],
)
def test_invalid_rows_raise(function: object, rows: object, k_s: float, words: str) -> None:
    with pytest.raises(InputError, match=words):
        function(rows, k_s=k_s)  # type: ignore[operator]


def test_balancing_force_needs_an_inner_node() -> None:
    with pytest.raises(InputError, match=r"^u must have at least 3"):
        balancing_force(np.zeros((2, 2)), k_s=1.0)


def test_deformed_with_other_shape_raises() -> None:
    with pytest.raises(InputError, match=r"^u must have shape \(3, 2\), had \(2, 2\)"):
        deformed(np.zeros((3, 2)), np.zeros((2, 2)))


# --- the stiff band -----------------------------------------------------------------------------------


def dense(stiffness: BandStiffness, h: float, n: int) -> np.ndarray:
    """Hessian of the documented energy by finite differences of a band that is 0 beyond its pins."""
    padded = np.vstack((np.zeros((3, n)), np.eye(n), np.zeros((3, n))))
    total = np.zeros((n, n))
    for order, k in ((1, stiffness.k_s), (2, stiffness.k_b), (3, stiffness.k_c)):
        D = np.diff(padded, n=order, axis=0) / h**order
        total += k * h * D.T @ D
    return total


@given(
    st.floats(0.0, 10.0), st.floats(0.0, 10.0), st.floats(0.1, 10.0), st.floats(0.25, 4.0), st.integers(1, 12)
)
def test_stencil_equals_dense_form(k_s: float, k_b: float, k_c: float, h: float, n: int) -> None:
    stiffness = BandStiffness(k_s=k_s, k_b=k_b, k_c=k_c)
    row = stiffness.stencil(h)
    assert row.shape == (4,)
    toeplitz = sum(row[k] * (np.eye(n, k=k) + (np.eye(n, k=-k) if k else 0.0)) for k in range(4))
    expected = dense(stiffness, h, n)
    np.testing.assert_allclose(toeplitz, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


def test_tension_equals_spring_of_paper() -> None:
    row = BandStiffness(k_s=3.0, k_b=0.0, k_c=0.0).stencil(0.5)
    np.testing.assert_allclose(row, 6.0 * np.array([2.0, -1.0, 0.0, 0.0]))
    K = row[0] * np.eye(5) + row[1] * (np.eye(5, k=1) + np.eye(5, k=-1))
    np.testing.assert_allclose(K, 3.0 / 0.5 * stiffness_matrix(7))


@pytest.mark.parametrize("order", [1, 2, 3])
def test_stencils_vanish_on_polynomials(order: int) -> None:
    """Slope, curvature and its rate: no force on a constant, a line, a parabola."""
    row = BandStiffness(
        **{name: float(i == order) for i, name in enumerate(("k_s", "k_b", "k_c"), 1)}
    ).stencil(1.0)
    kernel = np.concatenate((row[:0:-1], row))
    x = np.arange(-3.0, 4.0)
    for power in range(order):
        assert abs(kernel @ x**power) < 1e-12
    assert (-1) ** order * (kernel @ x ** (2 * order)) == pytest.approx(math.factorial(2 * order), rel=1e-12)


@pytest.mark.parametrize("name", ["k_s", "k_b", "k_c", "k_e"])
@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf, "a"])
def test_invalid_stiffness_raises(name: str, value: object) -> None:
    with pytest.raises(InputError, match=rf"^{name} must be"):
        BandStiffness(**{name: value})


def test_zero_stiffness_raises() -> None:
    with pytest.raises(InputError, match="must be positive, all were 0"):
        BandStiffness(k_s=0.0, k_b=0.0, k_c=0.0)
    with pytest.raises(InputError, match=r"^k_e must be greater than 0"):
        BandStiffness(k_e=0.0)


@settings(max_examples=40)
@given(st.floats(-8.0, 4.0), st.floats(-8.0, 4.0), st.sampled_from([0.0, 1.0]), st.sampled_from([0.5, 1.0]))
def test_default_contact_stiffness_suffices(log_k_c: float, log_k_s: float, k_b: float, h: float) -> None:
    x = np.arange(0.0, 121.0, h)
    stiffness = BandStiffness(k_s=10.0**log_k_s, k_b=k_b * 10.0**log_k_c, k_c=10.0**log_k_c)
    band = relax_band(
        np.column_stack((x, 0.0 * x)), [boxes(60.0, 0.0, 0.0, 4.5, 1.8)], vehicle=VehicleParams.bmw_320i(),
        stiffness=stiffness,
    )  # fmt: skip
    assert band.ok, (stiffness, band.message)
