"""Smooth a band: the same maneuver around a parked car with a bounded curvature rate (extra qp)."""

import numpy as np

from cca_core import VehicleParams, relax_band, smooth_band
from cca_core.band import BandStiffness
from cca_core.geometry import boxes

SPEED = 20.0  # [m/s]
route = np.column_stack((np.arange(0.0, 121.0), np.zeros(121)))
parked = boxes(60.0, -0.5, 0.0, 4.5, 1.8)
taut = BandStiffness(k_s=5e-3)  # a band under high tension leaves the route abruptly
band = relax_band(route, [parked], vehicle=VehicleParams.bmw_320i(), stiffness=taut)


def describe(name, band):
    """Print lateral acceleration, jerk and clearance of a band."""
    path = band.path()
    a_y = SPEED**2 * path.curvature(path.breaks)
    jerk = SPEED * np.abs(np.diff(a_y) / np.diff(path.breaks)).max()
    print(f"{name:22} a_y {np.abs(a_y).max():.1f} m/s², jerk {jerk:4.1f} m/s³,", end=" ")
    print(f"clearance {band.clearance:.2f} m, {band.status.name}: {band.message}")


describe("relaxed", band)
for rate in (1e-3, 4e-4, 2e-4):  # the last one is infeasible in this window
    describe(f"rate up to {rate:g} 1/m²", smooth_band(band, curvature_rate_limit=rate))
