"""Drive a lane of an OpenDRIVE map: ``python drive_a_map.py [MAP.xodr ROAD_ID LANE_ID]``."""

import sys
import tempfile
from pathlib import Path

from cca_core import Planner, RemoteVehicle, VehicleParams
from cca_core.adapters import read_opendrive
from cca_core.follow import steady_turn
from cca_core.sim import SingleTrackPlant

LANE = '<lane id="{}" type="driving"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>'
SHAPE = '<geometry s="{}" x="{}" y="{}" hdg="{}" length="{}">{}</geometry>'
SAMPLE = f"""<OpenDRIVE><road id="1" length="700" junction="-1">
<type s="0" type="rural"><speed max="90" unit="km/h"/></type>
<type s="450" type="town"><speed max="50" unit="km/h"/></type>
<planView>{SHAPE.format(0, 0, 0, 0, 500, "<line/>")}
{SHAPE.format(500, 500, 0, 0, 200, '<arc curvature="0.01"/>')}</planView>
<lanes><laneSection s="0"><left>{LANE.format(1)}</left><center><lane id="0" type="none"/></center>
<right>{LANE.format(-1)}</right></laneSection></lanes></road></OpenDRIVE>"""

with tempfile.TemporaryDirectory() as folder:
    file, road_id, lane_id = sys.argv[1:4] or (f"{folder}/sample.xodr", "1", "-1")
    Path(folder, "sample.xodr").write_text(SAMPLE, encoding="utf-8")
    road = read_opendrive(file).road_along([road_id], int(lane_id))
print(road, *road.lanes, sep="\n")
car = VehicleParams.bmw_320i()
v = min(20.0, road.highest_limit(0.0, 0.0))
plant = SingleTrackPlant(car, steady_turn(road.path, 10.0, v, car))
planner = Planner(car, road, cruise_speed=30.0)
x, y = road.path.position(180.0).tolist()
parked = RemoteVehicle(id="parked", x=x, y=y, psi=float(road.path.heading(180.0)), v_x=0.0)
for k in range(2400):
    command = planner.step(0.02 * k, plant.state, [parked])
    plant.step(command.delta, command.a_x, 0.02)
    if k % 200 == 0:
        print(f"{0.02 * k:4.0f} s {plant.state.v_x:5.1f} m/s: {command.decision.reason}")
