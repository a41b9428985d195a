"""Internal forces of a band with pinned ends: eqs 3-5, 7, 9 and 10, and a band with bending stiffness."""

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, as_array, check_array, check_points, check_real
from cca_core.errors import InputError

_TENSION, _BENDING = np.array([2, -1, 0, 0]), np.array([6, -4, 1, 0])
_CURVATURE_RATE = np.array([20, -15, 6, -1])


def stiffness_matrix(n: int) -> Array:
    """K of eq 7 with pinned ends.

    Parameters
    ----------
    n : int
        Nodes of the band [-], its two ends included; at least 3.

    Returns
    -------
    K : ndarray, shape (n - 2, n - 2)
        tridiag(-1, 2, -1) [-], symmetric and positive definite.

    Raises
    ------
    InputError
        If `n` is below 3 or above 10 000.

    Notes
    -----
    The printed K is (n-2) x n and has no inverse. With u_1 = u_n = 0 its first and last column drop out, and
    ``inv(K)[i, j] = min(i, j) (N + 1 - max(i, j)) / (N + 1)`` with N = n - 2 and i, j counted from 1.

    Examples
    --------
    >>> stiffness_matrix(4)
    array([[ 2., -1.],
           [-1.,  2.]])
    """
    if check_real("n", n, ge=3, le=1e4) != int(n):
        raise InputError(f"n must be a whole number, was {n}")
    inner = int(n) - 2
    return 2.0 * np.eye(inner) - np.eye(inner, k=1) - np.eye(inner, k=-1)


def internal_force(u: ArrayLike, *, k_s: float) -> Array:
    """Change of the internal force between neighboring nodes, eq 3.

    Parameters
    ----------
    u : array_like, shape (n, 2)
        Displacement of each node [m].
    k_s : float
        Spring constant [N/m].

    Returns
    -------
    F_int : ndarray, shape (n - 1, 2)
        k_s (u_{i+1} - u_i) [N].

    Raises
    ------
    InputError
        If a value is not finite, the shape is wrong, or `k_s` is not positive.
    """
    change: Array = check_real("k_s", k_s, gt=0.0) * np.diff(check_points("u", u, 2), axis=0)
    return change


def balancing_force(u: ArrayLike, *, k_s: float) -> Array:
    """External force that balances a displacement of the inner nodes, eqs 4 and 5.

    Parameters
    ----------
    u : array_like, shape (n, 2)
        Displacement of each node [m].
    k_s : float
        Spring constant [N/m].

    Returns
    -------
    F_e : ndarray, shape (n - 2, 2)
        -[k_s (u_{i+1} - u_i) + k_s (u_{i-1} - u_i)] = k_s K u [N].

    Raises
    ------
    InputError
        If a value is not finite, the shape is wrong, or `k_s` is not positive.
    """
    force: Array = -np.diff(internal_force(check_points("u", u, 3), k_s=k_s), axis=0)
    return force


def displacement(F_e: ArrayLike, *, k_s: float) -> Array:
    """Displacement under given external forces with pinned ends, eq 9.

    Parameters
    ----------
    F_e : array_like, shape (n, 2)
        External force on each node [N]; the rows of the two pinned ends are not used.
    k_s : float
        Spring constant [N/m].

    Returns
    -------
    u : ndarray, shape (n, 2)
        inv(K) F_e / k_s [m], zero at both ends.

    Raises
    ------
    InputError
        If a value is not finite, the shape is wrong, or `k_s` is not positive.

    Notes
    -----
    Eq (9) is one shot: the forces are those at the undeformed nodes. Solved as a tridiagonal system.
    """
    from scipy.linalg import lapack  # slow to import, and importing the library is to be quick

    forces = check_points("F_e", F_e, 3)
    k_s = check_real("k_s", k_s, gt=0.0)
    inner = len(forces) - 2
    u = np.zeros_like(forces)
    off_diagonal = np.full(max(inner - 1, 1), -1.0)  # LAPACK wants one even where there is none
    u[1:-1] = lapack.dptsv(np.full(inner, 2.0), off_diagonal, forces[1:-1] / k_s)[2]
    return u


def deformed(nodes: ArrayLike, u: ArrayLike) -> Array:
    """Deformed band, eq 10.

    Parameters
    ----------
    nodes : array_like, shape (n, 2)
        Undeformed nodes [m].
    u : array_like, shape (n, 2)
        Displacement of each node [m].

    Returns
    -------
    P_def : ndarray, shape (n, 2)
        Nodes plus displacement [m].

    Raises
    ------
    InputError
        If a value is not finite or the shapes differ.
    """
    points = check_points("nodes", nodes, 1)
    moved: Array = points + check_array("u", u, points.shape)
    return moved


@dataclass(frozen=True, slots=True, kw_only=True)
class BandStiffness:
    """Stiffness of a band that resists stretching, bending and change of bending.

    Parameters
    ----------
    k_s : float
        Tension [N]: resists slope, makes free spans straight. The paper's spring between nodes a distance
        h apart has the constant k_s / h.
    k_b : float
        Bending stiffness [N m^2]: resists curvature, rounds the corners.
    k_c : float
        Curvature-rate stiffness [N m^4]: resists change of curvature, makes curvature continuous.
    k_e : float
        Contact stiffness of obstacles and edges [N/m^2], per meter of band. By default the largest of
        0.05 k_s, 0.01 k_b and 3e-4 k_c (in meters). Much softer contacts may yield by more than tightening
        compensates.

    Raises
    ------
    InputError
        If a value is not finite or negative, `k_e` is zero, or all of the others are.

    Notes
    -----
    The energy of a lateral displacement u(s) is
    ``1/2 integral k_s u'^2 + k_b u''^2 + k_c u'''^2 + k_e max(lower - u, 0)^2 ds``. The shape depends
    on ratios only, not on the mesh. Between pins and contacts, k_c alone gives the quintic lane change, whose
    peak lateral acceleration is 5.7735 w v^2 / L^2 for an offset w over a length L.
    """

    k_s: float = 5e-5
    k_b: float = 0.0
    k_c: float = 1.0
    k_e: Annotated[Any, float] = None

    def __post_init__(self) -> None:
        for name in ("k_s", "k_b", "k_c"):
            check_real(name, getattr(self, name), ge=0.0)
        if self.k_e is None:
            object.__setattr__(self, "k_e", max(0.05 * self.k_s, 0.01 * self.k_b, 3e-4 * self.k_c, 1e-300))
        check_real("k_e", self.k_e, gt=0.0)
        if self.k_s + self.k_b + self.k_c <= 0.0:
            raise InputError("k_s, k_b or k_c must be positive, all were 0")

    def stencil(self, h: ArrayLike) -> Array:
        """Return the internal force per displacement of a node and of its three neighbors on one side.

        Parameters
        ----------
        h : array_like, shape (...)
            Distance between nodes [m].

        Returns
        -------
        stencil : ndarray, shape (..., 4)
            Diagonal and three off-diagonals of the stiffness [N/m]; every row of the matrix is the same
            because the band continues undisplaced beyond its pinned ends. In extended precision: a
            rounding error of the row sum would act like a spring to the ground.

        Raises
        ------
        InputError
            If `h` is no array of real numbers.
        """
        spacing = as_array("h", h).astype(np.longdouble)[..., None]
        squared = spacing * spacing
        stencil: Array = self.k_c / (squared * squared * spacing) * _CURVATURE_RATE
        if self.k_s:
            stencil += self.k_s / spacing * _TENSION
        if self.k_b:
            stencil += self.k_b / (squared * spacing) * _BENDING
        return stencil
