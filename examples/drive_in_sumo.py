"""Drive in SUMO, as its vehicle ``ego``: ``python drive_in_sumo.py [NET.net.xml ROUTES.rou.xml]``."""

import sys
import tempfile
from pathlib import Path

import libsumo

from cca_core import Planner, VehicleParams
from cca_core.adapters import SumoWorld
from cca_core.sim import SingleTrackPlant

LANE = '<lane id="e_{0}" index="{0}" speed="25" length="2000" width="3.5" shape="0,{1} 2000,{1}"/>'
JUNCTION = '<junction id="{}" type="dead_end" x="{}" y="0" incLanes="{}" intLanes="" shape="{},0"/>'
NET = f"""<net version="1.20"><edge id="e" from="A" to="B">{LANE.format(0, 0)}{LANE.format(1, 3.5)}</edge>
{JUNCTION.format("A", 0, "", 0)}{JUNCTION.format("B", 2000, "e_0 e_1", 2000)}</net>"""
ROUTES = """<routes><vType id="slow" maxSpeed="10"/><route id="r" edges="e"/>
<vehicle id="ego" route="r" depart="0" departPos="50" departSpeed="20"/>
<vehicle id="slow" type="slow" route="r" depart="0" departPos="200" departSpeed="10"/></routes>"""

with tempfile.TemporaryDirectory() as folder:
    net, routes = sys.argv[1:3] or (f"{folder}/sample.net.xml", f"{folder}/sample.rou.xml")
    Path(folder, "sample.net.xml").write_text(NET, encoding="utf-8")
    Path(folder, "sample.rou.xml").write_text(ROUTES, encoding="utf-8")
    libsumo.start(["sumo", "-n", net, "-r", routes, "--step-length", "0.1", "--no-step-log"])
libsumo.simulationStep()
car = VehicleParams.bmw_320i()
world = SumoWorld("ego", car)
planner = Planner(car, world.read_road(), cruise_speed=22.0)
plant = SingleTrackPlant(car, world.ego_state())
for k in range(400):
    for j in range(5):  # the ego is driven five times as often as SUMO steps
        command = planner.step(0.1 * k + 0.02 * j, plant.state, world.remotes(age=0.02 * j))
        plant.step(command.delta, command.a_x, 0.02)
    world.move_ego(plant.state)
    world.step()
    if k % 40 == 0:
        print(f"{plant.state.x:6.0f} m {plant.state.v_x:5.1f} m/s: {command.decision.reason}")
libsumo.close()
