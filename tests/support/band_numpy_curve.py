"""Curves through the nodes of a band, for `band_numpy`."""

import math
from typing import Any

import numpy as np
from scipy.linalg import solveh_banded

Array = np.ndarray[Any, Any]


def curvature_of(nodes: Array) -> Array:
    """Curvature of the circles through three neighboring nodes."""
    steps = np.diff(nodes)
    cross = (steps[:-1].conj() * steps[1:]).imag
    curvature: Array = 2.0 * cross / (np.abs(steps[1:]) * np.abs(steps[:-1]) * np.abs(nodes[2:] - nodes[:-2]))
    return curvature


def offset(kappa: float, u: tuple[float, ...], h: float) -> tuple[complex, float]:
    """Relative tangent and curvature of the curve at a lateral offset."""
    slope, change = 0.5 * (u[2] - u[0]) / h, (u[2] - 2.0 * u[1] + u[0]) / h**2
    along = 1.0 - kappa * u[1]
    speed = math.hypot(along, slope)
    return complex(along, slope) / speed, (
        along * (change + kappa * along) + 2.0 * kappa * slope**2
    ) / speed**3


def spline(nodes: Array, end_moments: Array) -> tuple[Array, Array]:
    """Unit tangents and curvature of the C2 cubic through nodes, with given moments / 6 at its ends."""
    steps = np.diff(nodes)
    h = np.abs(steps)
    slopes = steps / h
    rhs = np.diff(slopes)
    rhs[0] -= h[0] * end_moments[0]
    rhs[-1] -= h[-1] * end_moments[1]
    matrix = np.array((np.append(0.0, h[1:-1]), 2.0 * (h[1:] + h[:-1])))
    moments = np.concatenate((end_moments[:1], solveh_banded(matrix, rhs), end_moments[1:]))
    along = np.append(
        slopes - h * (2.0 * moments[:-1] + moments[1:]),
        slopes[-1] + h[-1] * (2.0 * moments[-1] + moments[-2]),
    )
    speed = np.abs(along)
    along = along / speed
    return along, 6.0 * (along.conj() * moments).imag / speed**2
