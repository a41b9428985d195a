"""Interpolating cubics: through the nodes of a band, and through a curve over its arc length."""

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import check_array, check_points, check_real
from cca_core.errors import InputError
from cca_core.path.path import Path

_SPEED_ERROR = 5e-4
_HALVINGS = 14


def interpolate_path(
    nodes: ArrayLike,
    *,
    start: float = 0.0,
    start_tangent: ArrayLike | None = None,
    end_tangent: ArrayLike | None = None,
) -> Path:
    """Lay a path exactly through closely spaced nodes.

    Parameters
    ----------
    nodes : array_like, shape (n, 2)
        Positions [m], in driving order, no two neighbours equal.
    start : float
        Arc length of the first node [m].
    start_tangent, end_tangent : array_like, shape (2,), optional
        Direction at the first and last node [-]. Without them the curvature is zero there.

    Returns
    -------
    path : Path
        One cubic between each two nodes (the C2 interpolating spline over chord length).

    Raises
    ------
    InputError
        If there are fewer than two nodes, neighbours coincide, or a value is not finite.

    Examples
    --------
    >>> interpolate_path([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]).length
    2.0
    """
    from scipy.linalg import lapack  # slow to import, and importing the library is to be quick

    points = check_points("nodes", nodes, 2)
    steps = np.diff(points, axis=0)
    h = np.sqrt(steps[:, 0] ** 2 + steps[:, 1] ** 2)
    if not h.all():
        raise InputError(f"nodes must not repeat a point, row {int(np.argmin(h))} equals the next")
    slopes = steps / h[:, None]
    diagonal = np.full(len(points), 1.0)
    diagonal[1:-1] = 2.0 * (h[:-1] + h[1:])
    off = h.copy()
    rhs = np.zeros_like(points)
    rhs[1:-1] = 6.0 * np.diff(slopes, axis=0)
    start = check_real("start", start)
    ends = (("start_tangent", start_tangent, 0, 1.0), ("end_tangent", end_tangent, -1, -1.0))
    for name, tangent, node, sign in ends:
        if tangent is None:
            off[node] = 0.0  # natural end: no curvature
        else:
            unit = check_array(name, tangent, (2,))
            if not unit.any():
                raise InputError(f"{name} must not be zero")
            diagonal[node] = 2.0 * h[node]
            rhs[node] = 6.0 * sign * (slopes[node] - unit / np.hypot(*unit))
    second = lapack.dptsv(diagonal, off, rhs)[2]  # h_i-1 M_i-1 + 2 (h_i-1 + h_i) M_i + h_i M_i+1 = 6 [slope]
    squared = (h * h)[:, None]
    coefficients = np.empty((len(h), 2, 4))
    coefficients[:, :, 0] = squared * (second[1:] - second[:-1]) / 6.0
    coefficients[:, :, 1] = squared * second[:-1] / 2.0
    coefficients[:, :, 2] = steps - squared * (2.0 * second[:-1] + second[1:]) / 6.0
    coefficients[:, :, 3] = points[:-1]
    return Path(start + np.concatenate(([0.0], np.cumsum(h))), coefficients)


def over_arc_length(curve: Path, closed: bool) -> Path:
    """Describe a curve over its arc length.

    Parameters
    ----------
    curve : Path
        A curve over any parameter.
    closed : bool
        Whether it ends where it starts, with the same curvature.

    Returns
    -------
    path : Path
        The curve with the length of dX/ds within 1e-3 of 1, in more segments where it bends.
    """
    from scipy.interpolate import CubicSpline  # slow to import, and only fitting needs it

    borders = curve.breaks
    x, w = np.polynomial.legendre.leggauss(5)
    share = np.linspace(0.0, 1.0, 9)
    for _ in range(_HALVINGS):
        half = 0.5 * np.diff(borders)[:, None]
        first = curve.derivatives(borders[:-1, None] + half * (1.0 + x))[1]
        lengths = (half * np.hypot(first[..., 0], first[..., 1])) @ w
        s = np.concatenate(([0.0], np.cumsum(lengths)))
        nodes = curve.position(borders)
        ends = curve.derivatives(borders[[0, -1]])[1]
        ends /= np.hypot(*ends.T)[:, None]
        if closed:
            nodes[-1] = nodes[0]
        spline = CubicSpline(s, nodes, bc_type="periodic" if closed else ((1, ends[0]), (1, ends[1])))
        coefficients = spline.c.transpose(1, 2, 0) * lengths[:, None, None] ** np.arange(3.0, -1.0, -1.0)
        path = Path(s, coefficients)
        first = path.derivatives(s[:-1, None] + share * lengths[:, None])[1]
        off = np.abs(np.hypot(first[..., 0], first[..., 1]) - 1.0).max(axis=1) > _SPEED_ERROR
        if not off.any():
            return path
        off[1:] |= off[:-1]
        off[:-1] |= off[1:]
        borders = np.sort(np.concatenate((borders, (0.5 * (borders[1:] + borders[:-1]))[off])))
    return path
