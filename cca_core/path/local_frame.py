"""East-north-up coordinates on the WGS 84 ellipsoid."""

import math

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_any, check_real
from cca_core.errors import InputError
from cca_core.vehicle import MAX_COORDINATE

SEMI_MAJOR_AXIS = 6378137.0  # of WGS 84 [m]
ECCENTRICITY_SQUARED = (1.0 / 298.257223563) * (2.0 - 1.0 / 298.257223563)  # from the flattening


class LocalFrame:
    """East-north-up plane that touches WGS 84 at one point.

    Parameters
    ----------
    lat0, lon0 : float
        Origin [deg], latitude in -90..90 and longitude in -180..180.

    Raises
    ------
    InputError
        If the origin is not on the ellipsoid.

    Notes
    -----
    Points are on the ellipsoid (height 0). They are converted to earth-centered coordinates and rotated into
    the plane at the origin; x is east, y is north. The height below the plane is dropped. Distances therefore
    shrink by the factor 1 - (D / 6371 km)^2 / 2 at distance D from the origin.

    Examples
    --------
    >>> LocalFrame(45.0, 14.0).to_local(45.001, 14.0).round(3)
    array([  0.   , 111.132])
    """

    def __init__(self, lat0: float, lon0: float) -> None:
        self.lat0 = check_real("lat0", lat0, ge=-90.0, le=90.0)
        self.lon0 = check_real("lon0", lon0, ge=-180.0, le=180.0)
        lat, lon = math.radians(self.lat0), math.radians(self.lon0)
        self._origin = _to_ecef(np.array(lat), np.array(lon))
        self._axes = np.array(
            [
                [-math.sin(lon), math.cos(lon), 0.0],
                [-math.sin(lat) * math.cos(lon), -math.sin(lat) * math.sin(lon), math.cos(lat)],
                [math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat)],
            ]
        )

    def __repr__(self) -> str:
        return f"LocalFrame(lat0={self.lat0}, lon0={self.lon0})"

    def to_local(self, lat: ArrayLike, lon: ArrayLike) -> Array:
        """Project geodetic positions into the plane.

        Parameters
        ----------
        lat, lon : array_like, shape (...)
            Geodetic latitude and longitude [deg].

        Returns
        -------
        xy : ndarray, shape (..., 2)
            East and north [m].

        Raises
        ------
        InputError
            If a value is not finite or out of range, the shapes differ, or a point is more than 1000 km from
            the origin: latitude and longitude are probably swapped.
        """
        lat, lon = _geodetic(lat, lon)
        enu = (_to_ecef(np.radians(lat), np.radians(lon)) - self._origin) @ self._axes.T
        far = max(np.hypot(enu[..., 0], enu[..., 1]).max(initial=0.0), -enu[..., 2].min(initial=0.0))
        if far > MAX_COORDINATE:
            raise InputError(
                f"lat, lon must be within 1000 km of the origin ({self.lat0:g}, {self.lon0:g}) deg, "
                f"was {far / 1e3:.0f} km away; are latitude and longitude mixed up?"
            )
        return np.ascontiguousarray(enu[..., :2])

    def to_geodetic(self, xy: ArrayLike) -> tuple[Array, Array]:
        """Find the geodetic positions that `to_local` maps onto the given points.

        Parameters
        ----------
        xy : array_like, shape (..., 2)
            East and north [m].

        Returns
        -------
        lat, lon : ndarray, shape (...)
            Geodetic latitude and longitude [deg].

        Raises
        ------
        InputError
            If a value is not finite, the shape is wrong, or a point is farther away than 1000 km.
        """
        xy = check_any("xy", xy, (2,))
        if np.abs(xy).max(initial=0.0) > MAX_COORDINATE:
            raise InputError("xy must be within 1000 km of the origin")
        # height above the plane of the point on the ellipsoid: the line along `up` intersects the quadric
        quadric = np.array([1.0, 1.0, 1.0 / (1.0 - ECCENTRICITY_SQUARED)])
        foot, up = self._origin + xy @ self._axes[:2], self._axes[2]
        a, b = up @ (quadric * up), foot @ (quadric * up)
        c = (foot * foot) @ quadric - SEMI_MAJOR_AXIS**2
        point = foot + ((-b + np.sqrt(b * b - a * c)) / a)[..., None] * up
        lat = np.arctan2(point[..., 2], (1.0 - ECCENTRICITY_SQUARED) * np.hypot(point[..., 0], point[..., 1]))
        return np.degrees(lat), np.degrees(np.arctan2(point[..., 1], point[..., 0]))


def _geodetic(lat: ArrayLike, lon: ArrayLike) -> tuple[Array, Array]:
    values = []
    for name, value, limit in (("lat", lat, 90.0), ("lon", lon, 180.0)):
        array = check_any(name, value)
        worst = np.abs(array).max(initial=0.0)
        if worst > limit:
            hint = "; are latitude and longitude mixed up?" if name == "lat" and worst <= 180.0 else ""
            raise InputError(f"{name} must be within +-{limit:g} deg, was {worst:g}{hint}")
        values.append(array)
    if values[0].shape != values[1].shape:
        raise InputError(f"lon must have the shape of lat {values[0].shape}, had {values[1].shape}")
    return values[0], values[1]


def _to_ecef(lat: Array, lon: Array) -> Array:
    """Earth-centered coordinates [m] of points on the ellipsoid; angles in rad."""
    n = SEMI_MAJOR_AXIS / np.sqrt(1.0 - ECCENTRICITY_SQUARED * np.sin(lat) ** 2)
    return np.stack(
        (
            n * np.cos(lat) * np.cos(lon),
            n * np.cos(lat) * np.sin(lon),
            n * (1.0 - ECCENTRICITY_SQUARED) * np.sin(lat),
        ),
        axis=-1,
    )
