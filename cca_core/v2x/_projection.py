"""Projection of one geodetic position into a local frame, without the cost of arrays."""

import math
from collections.abc import Callable

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
