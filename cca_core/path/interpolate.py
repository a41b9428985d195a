"""Interpolating cubics: through nodes, and along a curve over its arc length."""

import math

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_array, check_points, check_real
from cca_core.errors import InfeasibleError, InputError
from cca_core.path.path import Path


def interpolate_path(
    nodes: ArrayLike,
    *,
    start: float = 0.0,
    start_tangent: ArrayLike | None = None,
    end_tangent: ArrayLike | None = None,
) -> Path:
    """Interpolate closely spaced nodes by a path.

    Parameters
    ----------
    nodes : array_like, shape (n, 2)
        Positions [m], in driving order, no two neighbors equal.
    start : float
        Arc length of the first node [m].
    start_tangent, end_tangent : array_like, shape (2,), optional
        Direction at the first and last node [-]; by default the curvature is zero there.

    Returns
    -------
    path : Path
        The C2 interpolating spline over chord length, with one cubic between neighboring nodes.

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
    """Join the route, deformed nodes and the route again to a reference path.

    Parameters
    ----------
    path : Path
        The route.
    s : ndarray, shape (n,)
        Stations of the deformed nodes [m].
    nodes : ndarray, shape (n, 2)
        The deformed nodes [m].

    Returns
    -------
    reference : Path
        C2 curve from 20 m before the nodes to 60 m behind them.
    """
    before = np.arange(s[0] - 20.0, s[0] - 1.0, 2.0)
    behind = np.arange(s[-1] + 2.0, s[-1] + 60.0, 2.0)
    position, tangent, _ = path.derivatives(np.append(before, behind))
    n = len(before)
    first, last = ((x / math.hypot(x, y), y / math.hypot(x, y)) for x, y in tangent[[0, -1]].tolist())
    return spline_through(np.vstack((position[:n], nodes, position[n:])), float(before[0]), first, last)


def spline_through(
    points: Array, start: float, first: tuple[float, float] | None, last: tuple[float, float] | None
) -> Path:
    """Interpolate nodes by a C2 path with unit end tangents; None for zero curvature at an end."""
    from scipy.linalg import lapack  # slow to import

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
    # h_i-1 m_i-1 + 2 (h_i-1 + h_i) m_i + h_i m_i+1 = change of slope, 6 m being the second derivative
    return cubics_along(points, lapack.dptsv(diagonal, off, rhs)[2], start)


def cubics_along(points: Array, moment_over_6: Array, start: float) -> Path:
    """C2 path through nodes whose second derivatives over chord length, divided by six, are known."""
    steps = points[1:] - points[:-1]
    h = np.sqrt(steps[:, 0] ** 2 + steps[:, 1] ** 2)
    squared = (h * h)[:, None]
    now, then = squared * moment_over_6[:-1], squared * moment_over_6[1:]
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
    """Reparametrize a curve by arc length: the length of dX/ds is within 1e-3 of 1."""
    from scipy.interpolate import CubicSpline  # slow to import

    breaks = curve.breaks
    x, w = np.polynomial.legendre.leggauss(5)
    fractions = np.linspace(0.0, 1.0, 9)
    for _ in range(14):
        half = 0.5 * np.diff(breaks)[:, None]
        first = curve.derivatives(breaks[:-1, None] + half * (1.0 + x))[1]
        lengths = (half * np.hypot(first[..., 0], first[..., 1])) @ w
        kept = lengths > max(1e-9, 1e-14 * float(lengths.sum()))
        if not kept.all():  # a curve that turns back on the spot
            breaks = breaks[np.append(True, kept)]
            if len(breaks) < 2:
                raise InfeasibleError("no curve is left between the waypoints")
            continue
        s = np.concatenate(([0.0], np.cumsum(lengths)))
        nodes = curve.position(breaks)
        ends = curve.derivatives(breaks[[0, -1]])[1]
        ends /= np.hypot(*ends.T)[:, None]
        if closed:
            nodes[-1] = nodes[0]
        spline = CubicSpline(s, nodes, bc_type="periodic" if closed else ((1, ends[0]), (1, ends[1])))
        coefficients = spline.c.transpose(1, 2, 0) * lengths[:, None, None] ** np.arange(3.0, -1.0, -1.0)
        path = Path(s, coefficients)
        first = path.derivatives(s[:-1, None] + fractions * lengths[:, None])[1]
        off = np.abs(np.hypot(first[..., 0], first[..., 1]) - 1.0).max(axis=1) > 5e-4
        if not off.any():
            return path
        off[1:] |= off[:-1]
        off[:-1] |= off[1:]
        breaks = np.sort(np.concatenate((breaks, (0.5 * (breaks[1:] + breaks[:-1]))[off])))
    return path
