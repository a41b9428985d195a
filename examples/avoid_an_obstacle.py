"""Drive a route of your own around an obstacle of your own.

``python avoid_an_obstacle.py ROUTE.gpx --station 300 --offset -0.4``, or any other file with a route.
"""

import argparse

from cca_core import (
    EvasionSettings,
    Lane,
    LocalFrame,
    Planner,
    RemoteVehicle,
    Road,
    Status,
    VehicleParams,
    VehicleState,
    fit_path,
)
from cca_core.sim import SingleTrackPlant, demo_route

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("route", nargs="?", help="GPX, KML, GeoJSON, NMEA or CSV; default: a road of the package")
parser.add_argument("--station", type=float, default=160.0, help="of the obstacle, along the route [m]")
parser.add_argument("--offset", type=float, default=-0.4, help="of the obstacle, left positive [m]")
given = parser.parse_args()

lanes = [Lane(d=0.0), Lane(d=3.5)]  # a second lane to the left
if given.route:
    road = Road.from_file(given.route, lanes, speed_limit=25.0)
else:
    route = demo_route()
    frame = LocalFrame(route.lat[0], route.lon[0])
    road = Road(fit_path(frame.to_local(route.lat, route.lon)), lanes, speed_limit=25.0)
path = road.path
print(road)

x, y = path.to_cartesian(given.station, given.offset)
psi = float(path.heading(given.station))
obstacle = RemoteVehicle(id="broken down", x=x, y=y, psi=psi, v_x=0.0, length=6.0, width=2.0)

car = VehicleParams.bmw_320i()
x, y = path.position(20.0)
plant = SingleTrackPlant(car, VehicleState(x=x, y=y, psi=float(path.heading(20.0)), v_x=0.0))
planner = Planner(car, road, cruise_speed=15.0, evasion=EvasionSettings(awareness_range=1000.0))

s, last_action, k = 20.0, None, 0
while s < min(given.station + 80.0, path.length - 20.0) and k < 10_000:
    state = plant.state
    command = planner.step(0.02 * k, state, [obstacle])
    plant.step(command.delta, command.a_x, 0.02)
    s, d, _, _ = path.foot_point(state.x, state.y, s_guess=s)
    if k % 50 == 0 or command.decision.action is not last_action:
        last_action, reason = command.decision.action, command.decision.reason
        print(f"{0.02 * k:5.1f} s: s {s:4.0f} m, d {d:5.2f} m, {last_action.name:10} {reason}")
    if command.status is Status.INVALID_INPUT and state.v_x == 0.0:
        break  # a safe stop is over
    k += 1
