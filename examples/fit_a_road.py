"""From latitude and longitude to a smooth road: position, heading and curvature at any arc length."""

import numpy as np

from cca_core import LocalFrame, fit_path
from cca_core.sim import demo_route

route = demo_route()
frame = LocalFrame(route.lat[0], route.lon[0])
xy = frame.to_local(route.lat, route.lon)
path = fit_path(xy)  # the tolerance follows from the noise of the waypoints

print(f"{len(xy)} waypoints became {path}")
print(path.fit_report)

for s in np.linspace(0.0, path.length, 6):
    x, y = path.position(s)
    radius = 1.0 / path.curvature(s)
    turn = (
        f"{abs(radius):6.0f} m {'left' if radius > 0.0 else 'right'}" if abs(radius) < 2000.0 else "straight"
    )
    print(f"at {s:6.0f} m: east {x:6.0f} m, north {y:5.0f} m, heading {path.heading(s):5.2f} rad, {turn}")

lat, lon = frame.to_geodetic(path.to_cartesian(1000.0, 3.5))
print(f"the center of the left lane, 1 km down the road: {lat:.6f}, {lon:.6f}")
