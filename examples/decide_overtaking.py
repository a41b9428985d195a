"""One planner cycle: pass a slow car, or follow it because of an oncoming vehicle."""

import math

from cca_core import (
    EvasionSettings,
    Lane,
    Planner,
    RemoteVehicle,
    Road,
    VehicleParams,
    VehicleState,
    fit_path,
)

path = fit_path([(10.0 * i, 0.0) for i in range(201)])  # 2 km straight
road = Road(path, [Lane(d=0.0), Lane(d=3.5, direction=-1)], speed_limit=25.0)
car = VehicleParams.bmw_320i()
ego = VehicleState(x=100.0, y=0.0, psi=0.0, v_x=20.0)
settings = EvasionSettings(awareness_range=1000.0)  # every vehicle within this distance has sent a message
slow = RemoteVehicle(id="slow", x=140.0, y=0.0, psi=0.0, v_x=12.0)

for distance in (100.0, 300.0, 400.0, 600.0):
    oncoming = RemoteVehicle(id="oncoming", x=100.0 + distance, y=3.5, psi=math.pi, v_x=20.0)
    planner = Planner(car, road, cruise_speed=20.0, evasion=settings)
    command = planner.step(0.0, ego, [slow, oncoming])
    print(
        f"oncoming car {distance:3.0f} m ahead: {command.decision.action.name:10}  {command.decision.reason}"
    )
