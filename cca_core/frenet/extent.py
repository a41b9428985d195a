"""Extent of a straight body on a curved route, whose ends reach across the bend."""

import math

import numpy as np

from cca_core.path import Path
from cca_core.vehicle import RemoteVehicle

__all__ = ["Extent", "extent_in_bend"]

Extent = tuple[float, float, float, float]
"""Least and largest station, least and largest lateral offset of a body [m]."""

_TOLERANCE = 0.1  # distance between a body and the route's curve that does not matter [m]
_SHORT = 6.0  # length of a body that the curvature at its foot point describes [m]
_COARSE, _SPACING = 2.0, 0.25  # of stations at which the route may be curved; of its cross sections [m]
_TO_CENTER = 0.95  # part of the radius on which a point has one cross section [-]


def extent_in_bend(
    remote: RemoteVehicle,
    path: Path,
    foot: tuple[float, float, float, float],
    lateral_range: tuple[float, float],
) -> Extent | None:
    """Return what a body covers within the lateral range; None if its length along the route describes it."""
    s, d, _, kappa = foot
    bulge = 0.125 * remote.length**2
    curvature = abs(kappa) / max(1.0 - d * kappa, 0.1)
    if remote.length > _SHORT:
        curvature = max(curvature, 1.0 / path.min_radius)
    if bulge * curvature <= _TOLERANCE:
        return None
    reach = remote.length + abs(d)
    curvatures = path.curvature(s + np.arange(-reach, reach + _COARSE, _COARSE))
    if bulge * float((np.abs(curvatures) / np.maximum(1.0 - d * curvatures, 0.1)).max()) <= _TOLERANCE:
        return None
    stations = s + np.arange(-reach, reach + _SPACING, _SPACING)
    xy, tangent, second = path.derivatives(stations)
    norm = np.hypot(tangent[:, 0], tangent[:, 1])
    # each cross section of the route is a line up to the center of curvature; the body is where it is inside
    # both pairs of sides
    curvatures = (tangent[:, 0] * second[:, 1] - tangent[:, 1] * second[:, 0]) / norm**3
    center = _TO_CENTER / np.maximum(np.abs(curvatures), 1e-6)
    low = np.maximum(lateral_range[0], np.where(curvatures < 0.0, -center, -math.inf))
    high = np.minimum(lateral_range[1], np.where(curvatures > 0.0, center, math.inf))
    cos, sin = math.cos(remote.psi), math.sin(remote.psi)
    for x, y, half in ((cos, sin, 0.5 * (remote.length + _SPACING)), (-sin, cos, 0.5 * remote.width)):
        begin = (xy[:, 0] - remote.x) * x + (xy[:, 1] - remote.y) * y
        rate = (tangent[:, 0] * y - tangent[:, 1] * x) / norm
        rate = np.where(np.abs(rate) < 1e-9, 1e-9, rate)
        ends = (-half - begin) / rate, (half - begin) / rate
        low, high = np.maximum(low, np.minimum(*ends)), np.minimum(high, np.maximum(*ends))
    inside = low <= high
    if not inside.any():
        return None
    first, last = stations[inside][[0, -1]]
    return (
        float(first) - 0.5 * _SPACING, float(last) + 0.5 * _SPACING, float(low[inside].min()),
        float(high[inside].max()),
    )  # fmt: skip
