"""Drive a route of your own around an obstacle of your own: ``python avoid_an_obstacle.py ROUTE.gpx``."""

import sys
from pathlib import Path

from cca_core import (
    EvasionSettings,
    Lane,
    LocalFrame,
    Planner,
    RemoteVehicle,
    Road,
    VehicleParams,
    VehicleState,
    fit_path,
)
from cca_core.path import read_waypoints
from cca_core.sim import SingleTrackPlant, demo_route

route = read_waypoints(Path(sys.argv[1])) if len(sys.argv) > 1 else demo_route()  # or a CSV file
frame = LocalFrame(route.lat[0], route.lon[0])
path = fit_path(frame.to_local(route.lat, route.lon), tolerance=0.5)
road = Road(path, [Lane(d=0.0), Lane(d=3.5)], speed_limit=25.0)  # a second lane to the left

x, y = path.to_cartesian(160.0, -0.4)  # 160 m down the road, a little right of the lane's center
psi = float(path.heading(160.0))
obstacle = RemoteVehicle(id="broken down", x=x, y=y, psi=psi, v_x=0.0, length=6.0, width=2.0)

car = VehicleParams.bmw_320i()
x, y = path.position(20.0)
plant = SingleTrackPlant(car, VehicleState(x=x, y=y, psi=float(path.heading(20.0)), v_x=15.0))
planner = Planner(car, road, cruise_speed=15.0, evasion=EvasionSettings(awareness_range=1000.0))

s, last_action = 20.0, None
for k in range(750):  # 15 s
    state = plant.state
    command = planner.step(0.02 * k, state, [obstacle])
    plant.step(command.delta, command.a_x, 0.02)
    s, d, _, _ = path.foot_point(state.x, state.y, s_guess=s)
    if k % 50 == 0 or command.decision.action is not last_action:
        last_action, reason = command.decision.action, command.decision.reason
        print(f"{0.02 * k:5.1f} s: s {s:4.0f} m, d {d:5.2f} m, {last_action.name:10} {reason}")
