"""Interpolating cubics: through the nodes of a band, and through a curve over its arc length."""

import math

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_array, check_points, check_real
from cca_core.errors import InputError
from cca_core.path.path import Path

_SPEED_ERROR = 5e-4
_HALVINGS = 14
_RUN_UP = 20.0  # a detour begins on the route this far before the bent stretch [m]
_TAIL = 60.0  # and goes on along the route behind it [m]


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
        Positions [m], in driving order, no two neighbors equal.
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
        If there are fewer than two nodes, neighbors coincide, or a value is not finite.

    Examples
    --------
    >>> interpolate_path([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]).length
    2.0
    """
    points = check_points("nodes", nodes, 2)
    if (points[1:] == points[:-1]).all(axis=1).any():
        row = int(np.argmax((points[1:] == points[:-1]).all(axis=1)))
        raise InputError(f"nodes must not repeat a point, row {row} equals the next")
    tangents: list[tuple[float, float] | None] = []
    for name, tangent in (("start_tangent", start_tangent), ("end_tangent", end_tangent)):
        if tangent is None:
            tangents.append(None)
            continue
        x, y = check_array(name, tangent, (2,)).tolist()
        norm = math.hypot(x, y)
        if not norm:
            raise InputError(f"{name} must not be zero")
        tangents.append((x / norm, y / norm))
    return spline_through(points, check_real("start", start), *tangents)


def splice_path(path: Path, s: Array, nodes: Array) -> Path:
    """Lay what the steering follows on a detour: the route, the bent stretch, the route.

    Parameters
    ----------
    path : Path
        The route.
    s : ndarray, shape (n,)
        Path coordinates of the bent nodes [m].
    nodes : ndarray, shape (n, 2)
        The bent nodes [m].

    Returns
    -------
    reference : Path
        The C2 curve through all.
    """
    before = np.arange(s[0] - _RUN_UP, s[0] - 1.0, 2.0)
    ahead = np.arange(s[-1] + 2.0, s[-1] + _TAIL, 2.0)
    position, tangent, _ = path.derivatives(np.append(before, ahead))
    n = len(before)
    first, last = ((x / math.hypot(x, y), y / math.hypot(x, y)) for x, y in tangent[[0, -1]].tolist())
    return spline_through(np.vstack((position[:n], nodes, position[n:])), float(before[0]), first, last)


def spline_through(
    points: Array, start: float, first: tuple[float, float] | None, last: tuple[float, float] | None
) -> Path:
    """Lay a path through nodes, as `interpolate_path` does, without checks.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        Positions [m], no two neighbors equal.
    start : float
        Arc length of the first node [m].
    first, last : pair of float or None
        Unit tangent at the first and last node [-]; None for no curvature there.

    Returns
    -------
    path : Path
        One cubic between each two nodes.
    """
    from scipy.linalg import lapack  # slow to import, and importing the library is to be quick

    steps = points[1:] - points[:-1]
    h = np.sqrt(steps[:, 0] ** 2 + steps[:, 1] ** 2)
    slopes = steps / h[:, None]
    diagonal = np.full(len(points), 1.0)
    diagonal[1:-1] = 2.0 * (h[:-1] + h[1:])
    off = h.copy()
    rhs = np.zeros_like(points)
    rhs[1:-1] = slopes[1:] - slopes[:-1]
    for tangent, node, sign in ((first, 0, 1.0), (last, -1, -1.0)):
        if tangent is None:
            off[node] = 0.0  # natural end: no curvature
        else:
            diagonal[node] = 2.0 * h[node]
            rhs[node] = sign * (slopes[node] - tangent)
    # h_i-1 m_i-1 + 2 (h_i-1 + h_i) m_i + h_i m_i+1 = change of slope, with a sixth of the second derivative m
    return cubics_along(points, lapack.dptsv(diagonal, off, rhs)[2], start)


def cubics_along(points: Array, sixth: Array, start: float) -> Path:
    """Path of the C2 cubic through nodes whose second derivatives are known.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        Positions [m], no two neighbors equal.
    sixth : ndarray, shape (n, 2)
        A sixth of the second derivative there, over chord length [1/m].
    start : float
        Arc length of the first node [m].

    Returns
    -------
    path : Path
        One cubic between each two nodes.
    """
    steps = points[1:] - points[:-1]
    h = np.sqrt(steps[:, 0] ** 2 + steps[:, 1] ** 2)
    squared = (h * h)[:, None]
    now, then = squared * sixth[:-1], squared * sixth[1:]
    coefficients = np.empty((len(h), 2, 4))
    coefficients[:, :, 0] = then - now
    coefficients[:, :, 1] = 3.0 * now
    coefficients[:, :, 2] = steps - (2.0 * now + then)
    coefficients[:, :, 3] = points[:-1]
    breaks = np.empty(len(points))
    breaks[0] = 0.0
    h.cumsum(out=breaks[1:])
    breaks += start
    return Path._trusted(breaks, coefficients)


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
