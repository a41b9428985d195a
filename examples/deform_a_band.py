"""Deform a straight route around a parked car, for several clearances."""

import numpy as np

from cca_core import InfeasibleError, VehicleParams, relax_band
from cca_core.geometry import boxes

route = np.column_stack((np.arange(0.0, 101.0), np.zeros(101)))  # 100 m straight ahead, a node each meter
parked = boxes(50.0, -0.8, 0.0, 4.5, 1.8)  # its left side is 0.1 m left of the route
car = VehicleParams.bmw_320i()

print("clearance   offset   smallest radius   status")
for clearance in (0.5, 1.0, 1.5):
    band = relax_band(route, [parked], side="left", vehicle=car, clearance=clearance)
    offset, radius = np.abs(band.displacement).max(), 1.0 / band.curvature
    print(f"{band.clearance:7.2f} m {offset:6.2f} m {radius:15.0f} m   {band.status.name}")

narrow = (-1.0, 1.0)  # the car's body may not leave this corridor [m]
band = relax_band(route, [parked], side="left", vehicle=car, clearance=1.0, corridor=narrow)
print(f"within 1 m of the route: {band.status.name}, {band.clearance:.2f} m clearance ({band.message})")
try:
    band.require()
except InfeasibleError:
    print("require() raises an exception instead")
