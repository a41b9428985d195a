"""Record a loop of your own past a parked van, and write its report, a table and an MCAP file."""

import argparse
from pathlib import Path

from cca_core import Lane, Planner, RemoteVehicle, Road, VehicleParams, VehicleState
from cca_core.path import interpolate_path
from cca_core.report import write_report
from cca_core.sim import Recorder, SingleTrackPlant, save_log

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--out", type=Path, default=Path("out"))
out = parser.parse_args().out
out.mkdir(parents=True, exist_ok=True)

road = Road(interpolate_path([[0.0, 0.0], [600.0, 0.0]]), [Lane(d=0.0), Lane(d=3.5)])
planner = Planner(VehicleParams.bmw_320i(), road, cruise_speed=15.0)
recorder = Recorder(planner, name="parked van")
world = SingleTrackPlant(planner.vehicle, VehicleState(x=20.0, y=0.0, psi=0.0, v_x=15.0))
van = RemoteVehicle(id="van", x=150.0, y=-0.5, psi=0.0, v_x=0.0, length=6.0, width=2.0)

for k in range(600):  # in place of your simulator
    t, state = 0.02 * k, world.state
    remotes = [van] if state.x > 60.0 else []  # it comes into range
    command = planner.step(t, state, remotes)
    recorder.add(t, state, remotes, command)
    world.step(command.delta, command.a_x, 0.02)

log = recorder.log()
print(log, log.summary()["actions"])
write_report([log], out / "own_run.html", title="Past a parked van")
log.to_table(out / "own_run.csv")
log.to_mcap(out / "own_run.mcap")
save_log(log, out / "own_run.npz")
