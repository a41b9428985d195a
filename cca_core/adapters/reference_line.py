"""Reference lines of OpenDRIVE: lines, arcs, spirals and cubics, and polynomials along s."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cca_core._checks import Array

__all__ = ["Cubic", "Geometry", "PlanView", "cubic_at"]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)  # exact for turns of up to about 10 rad
_GRID = 400  # points of the arc length of a poly3


class Cubic(NamedTuple):
    """a + b ds + c ds^2 + d ds^3 from a station on."""

    s: float
    a: float
    b: float
    c: float
    d: float


class PlanarPoints(NamedTuple):
    """Points of a reference line, shape (n,) each."""

    x: Array
    y: Array
    heading: Array
    curvature: Array
    speed: Array  # arc length by s; 1 but for paramPoly3


def cubic_at(records: Sequence[Cubic], s: Array, middle: Array) -> tuple[Array, Array]:
    """Return values and derivatives at stations, of the records that hold at `middle`; 0 without records."""
    if not records:
        return np.zeros_like(s), np.zeros_like(s)
    table = np.array(records)
    row = table[np.maximum(np.searchsorted(table[:, 0], middle, side="right") - 1, 0)]
    ds = s - row[:, 0]
    value = row[:, 1] + ds * (row[:, 2] + ds * (row[:, 3] + ds * row[:, 4]))
    return value, row[:, 2] + ds * (2.0 * row[:, 3] + ds * 3.0 * row[:, 4])


@dataclass(frozen=True, kw_only=True, eq=False)
class Geometry:
    """One element of a planView.

    `curvature` is that at both ends of a line, arc or spiral. Otherwise `u` and `v` are the coefficients of
    cubics over a parameter from 0 to `p_end`, in axes along the heading.
    """

    s: float
    x: float
    y: float
    heading: float
    length: float
    curvature: tuple[float, float] = (0.0, 0.0)
    u: tuple[float, float, float, float] | None = None
    v: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    p_end: float | None = None  # None for poly3, whose parameter is u itself

    def at(self, ds: Array) -> PlanarPoints:
        """Return points at distances from the start."""
        if self.u is not None:
            return self._at_cubic(ds, self.u)
        k, rate = self.curvature[0], (self.curvature[1] - self.curvature[0]) / self.length
        turned = ds * (k + 0.5 * rate * ds)
        half = 0.5 * ds[:, None]
        along = half * (1.0 + _NODES)
        angle = self.heading + along * (k + 0.5 * rate * along)
        x, y = ((half * f(angle)) @ _WEIGHTS for f in (np.cos, np.sin))
        return PlanarPoints(self.x + x, self.y + y, self.heading + turned, k + rate * ds, np.ones_like(ds))

    def _at_cubic(self, ds: Array, u: tuple[float, float, float, float]) -> PlanarPoints:
        p = (
            np.interp(ds, self._lengths, self._parameters)
            if self.p_end is None
            else ds / self.length * self.p_end
        )
        (pu, du, ddu), (pv, dv, ddv) = _cubic(u, p), _cubic(self.v, p)
        norm = np.maximum(np.hypot(du, dv), 1e-9)
        cosine, sine = math.cos(self.heading), math.sin(self.heading)
        rate = 1.0 / norm if self.p_end is None else np.full_like(ds, self.p_end / self.length)
        return PlanarPoints(
            self.x + cosine * pu - sine * pv, self.y + sine * pu + cosine * pv,
            self.heading + np.arctan2(dv, du), (du * ddv - dv * ddu) / norm**3, norm * rate,
        )  # fmt: skip

    @cached_property
    def _parameters(self) -> Array:
        """Values of u from 0 to at least the length."""
        return np.linspace(0.0, self.length, _GRID + 1)

    @cached_property
    def _lengths(self) -> Array:
        """Arc lengths of a poly3 at these."""
        x, w = np.polynomial.legendre.leggauss(5)
        step = self.length / _GRID
        inner = self._parameters[:-1, None] + 0.5 * step * (1.0 + x)
        speed = np.sqrt(1.0 + _cubic(self.v, inner)[1] ** 2)
        return np.append(0.0, np.cumsum(0.5 * step * (speed @ w)))


def _cubic(c: tuple[float, float, float, float], p: Array) -> tuple[Array, Array, Array]:
    """Return a cubic with its derivatives."""
    value = c[0] + p * (c[1] + p * (c[2] + p * c[3]))
    return value, c[1] + p * (2.0 * c[2] + 3.0 * c[3] * p), 2.0 * c[2] + 6.0 * c[3] * p


class PlanView:
    """The reference line of a road."""

    def __init__(self, geometries: Sequence[Geometry]) -> None:
        self.geometries = sorted(geometries, key=lambda geometry: geometry.s)
        self.starts = np.array([geometry.s for geometry in self.geometries])

    def at(self, s: Array, middle: Array) -> PlanarPoints:
        """Return points at stations, of the elements that hold at `middle`."""
        index = np.maximum(np.searchsorted(self.starts, middle, side="right") - 1, 0)
        found = np.empty((5, len(s)))
        for i in np.unique(index).tolist():
            rows = index == i
            found[:, rows] = self.geometries[i].at(s[rows] - self.starts[i])
        return PlanarPoints(*found)
