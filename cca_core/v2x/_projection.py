"""Projection of one geodetic position into a local frame and back, without the cost of arrays."""

import math
from collections.abc import Callable
from functools import partial

from cca_core.path.local_frame import ECCENTRICITY_SQUARED as E2
from cca_core.path.local_frame import SEMI_MAJOR_AXIS as A
from cca_core.path.local_frame import LocalFrame


def projector(frame: LocalFrame) -> Callable[[float, float], tuple[float, float]]:
    """Return the function that maps latitude and longitude [deg] to `frame`, as `frame.to_local` does."""
    lat0, lon0 = math.radians(frame.lat0), math.radians(frame.lon0)
    sin0, cos0 = math.sin(lat0), math.cos(lat0)
    n0 = A / math.sqrt(1.0 - E2 * sin0 * sin0)
    out0, up0 = n0 * cos0, n0 * (1.0 - E2) * sin0

    def project(lat_deg: float, lon_deg: float) -> tuple[float, float]:
        lat, lon = math.radians(lat_deg), math.radians(lon_deg) - lon0
        sin, cos = math.sin(lat), math.cos(lat)
        n = A / math.sqrt(1.0 - E2 * sin * sin)
        out, up = n * cos, n * (1.0 - E2) * sin
        return out * math.sin(lon), (up - up0) * cos0 - (out * math.cos(lon) - out0) * sin0

    return project


def unprojector(frame: LocalFrame) -> Callable[[float, float], tuple[float, float]]:
    """Return the function that maps x, y [m] to latitude, longitude [deg], as `frame.to_geodetic` does."""
    lat0, lon0 = math.radians(frame.lat0), math.radians(frame.lon0)
    sin0, cos0 = math.sin(lat0), math.cos(lat0)
    n0 = A / math.sqrt(1.0 - E2 * sin0 * sin0)
    return partial(_unproject, (sin0, cos0, lon0, n0 * cos0, n0 * (1.0 - E2) * sin0))


def _unproject(origin: tuple[float, float, float, float, float], x: float, y: float) -> tuple[float, float]:
    """Find the point of the ellipsoid above or below a point of the plane."""
    sin0, cos0, lon0, out0, up0 = origin
    # in the meridian plane of the origin, away from the axis of the earth and along it; x is perpendicular
    out, up, flat = out0 - y * sin0, up0 + y * cos0, 1.0 - E2
    a = cos0 * cos0 + sin0 * sin0 / flat
    b = out * cos0 + up * sin0 / flat
    c = out * out + x * x + up * up / flat - A * A
    height = (-b + math.sqrt(b * b - a * c)) / a
    out, up = out + height * cos0, up + height * sin0
    lat, lon = math.atan2(up, flat * math.hypot(out, x)), lon0 + math.atan2(x, out)
    return math.degrees(lat), math.degrees(math.remainder(lon, 2.0 * math.pi))
