"""The formulas of the kernel once more, on NumPy arrays, to compare with."""

from typing import Any

import numpy as np
from scipy.integrate import trapezoid  # NumPy 1.26 has none

Array = np.ndarray[Any, np.dtype[np.float64]]


def corners(box: Array) -> Array:
    """Corners of boxes (n, 5), as complex numbers (n, 4)."""
    x, y, psi, length, width = box.T[..., None]
    return (
        x
        + 1j * y
        + np.exp(1j * psi) * 0.5 * (length * [1, -1, -1, 1] + 1j * width * np.array([1, 1, -1, -1]))
    )


def box_gaps(a: Array, b: Array) -> Array:
    """Signed distances of pairs of boxes: of corners from boxes, or the smallest overlap along an axis."""
    far, near = [], []
    for one, other in ((a, b), (b, a)):
        seen = (corners(other) - (one[:, :1] + 1j * one[:, 1:2])) * np.exp(-1j * one[:, 2:3])
        half = 0.5 * one[:, 3:, None]
        for part, h in ((seen.real, half[:, 0]), (seen.imag, half[:, 1])):
            far.append(np.maximum(part.min(axis=1), -part.max(axis=1)) - h[:, 0])
        out = np.maximum(np.abs(seen.real) - half[:, 0], 0.0), np.maximum(np.abs(seen.imag) - half[:, 1], 0.0)
        near.append(np.hypot(*out).min(axis=1))
    apart = np.max(far, axis=0)
    return np.where(apart > 0.0, np.min(near, axis=0), apart)


def reachable(v: Array, t: Array, age: Array, rate: Array, b: float, a: float) -> tuple[Array, Array]:
    """Displacements between braking with b and accelerating with a since the measurement."""
    known, measured = np.minimum(age, 1.0), np.maximum(np.abs(v) - rate * np.minimum(age, 1.0), 0.0)
    since = t + age
    stop = np.minimum(since, measured / b) if b > 0.0 else since
    counted = np.abs(v) * age - 0.5 * rate * known**2
    low, high = (measured * u + 0.5 * c * u**2 - counted for u, c in ((stop, -b), (since, a)))
    past = np.abs(v) * t
    low, high = np.where(t < 0.0, past, low), np.where(t < 0.0, past, high)
    creep = 0.5 if a > 0.0 else 0.0
    return np.where(v < creep, -high, low), np.where(v > -creep, high, -low)


def arrival_times(v: float, target: float, distance: Array, a: float) -> Array:
    """Times on a ramp of constant acceleration, and at constant speeds before and behind it."""
    ramp = (target**2 - v**2) / (2.0 * a)
    on_ramp = np.clip(distance, 0.0, ramp)
    times: Array = (np.sqrt(v**2 + 2.0 * a * on_ramp) - v) / a
    return times + np.minimum(distance, 0.0) / v + np.maximum(distance - ramp, 0.0) / target


def squared_speeds(s: Array, kappa: Array, cruise: float, a_y: float, b: float) -> Array:
    """Squares of the highest speeds from which every slower point and the end can be braked for."""
    limit = np.minimum(cruise**2, a_y / np.maximum(np.abs(kappa), 1e-9))
    limit[-1] = 0.0
    reach = limit[None, :] + 2.0 * b * (s[None, :] - s[:, None])
    return np.where(s[None, :] >= s[:, None], reach, np.inf).min(axis=1)


def stopping(v: Array, rho: float, a: float, b: float, v_max: float) -> Array:
    """Distance of a vehicle that accelerates up to v_max in its response time and then brakes."""
    top = np.maximum(v, np.minimum(v + rho * a, v_max))
    t = np.linspace(0.0, rho, 2001)[:, None]
    driven = trapezoid(np.minimum(v + a * t, top), t, axis=0)
    return np.asarray(driven + top**2 / (2.0 * b))
