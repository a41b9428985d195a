"""Drive the planner's ego through SUMO's traffic and print the table of figures; README.md says how to run."""

# fmt: off

import argparse
import math
import os
import random
import tempfile
import time
from pathlib import Path

os.environ.update({name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")})

import libsumo
import numpy as np

from cca_core import Planner, VehicleState
from cca_core.sim import SingleTrackPlant
from tests.trials.sumo.glue import CAR, Radio, move_ego, others, road_of, vehicle
from tests.trials.sumo.metrics import COLUMNS, min_gap, needed, summarize, table_row
from tests.trials.sumo.nets import SCENARIOS, write_net, write_traffic

STEP = 0.1  # of SUMO; the ego is driven five times as often [s]


class Braker:
    """Makes the ego's leader brake hard three times in an episode."""

    def __init__(self, seed: int) -> None:
        self.rnd = random.Random(seed + 77)
        self.times = [self.rnd.uniform(*span) for span in ((10.0, 20.0), (30.0, 42.0), (52.0, 64.0))]
        self.braking: list[tuple[str, float]] = []

    def step(self, t: float, leader: str | None) -> None:
        """Begin or end a braking."""
        for name, end in [b for b in self.braking if t > b[1]]:
            self.braking.remove((name, end))
            if name in libsumo.vehicle.getIDList():
                libsumo.vehicle.setSpeed(name, -1)
                libsumo.vehicle.setSpeedMode(name, 31)
        if self.times and t > self.times[0]:
            self.times.pop(0)
            if leader and libsumo.vehicle.getSpeed(leader) > 0.5:
                v = libsumo.vehicle.getSpeed(leader)
                to = self.rnd.choice([0.0, 5.0, 0.5 * v])
                lasts = max((v - to) / self.rnd.uniform(5.0, 7.0), 0.2)
                libsumo.vehicle.setSpeedMode(leader, 1)
                libsumo.vehicle.slowDown(leader, to, lasts)
                self.braking.append((leader, t + lasts + self.rnd.uniform(1.0, 5.0)))


def begin(name: str, seed: int, folder: Path) -> None:
    """Start SUMO with the net and traffic of a seed."""
    net, ego = folder / f"{name}.net.xml", f'length="{CAR.length}" width="{CAR.width}"'
    traffic = write_traffic(name, seed, folder, ego)
    libsumo.start([
        "sumo", "-n", str(net if net.exists() else write_net(name, folder)), "-r", str(traffic),
        "--step-length", str(STEP), "--seed", str(seed), "--no-step-log", "--no-warnings", "--collision.action", "none",
        "--time-to-teleport", "-1", "--lanechange.duration", "3", "--default.speeddev", "0", "--end", "1000",
    ])
    libsumo.simulationStep()


def baseline(name: str, seed: int, folder: Path, duration: float) -> float:
    """Mean speed of SUMO's own driver in the ego's place."""
    begin(name, seed, folder)
    braker, speeds = Braker(seed), []
    for k in range(int(duration / STEP)):
        if "ego" not in libsumo.vehicle.getIDList():
            break
        speeds.append(libsumo.vehicle.getSpeed("ego"))
        leader = libsumo.vehicle.getLeader("ego", 150.0)
        braker.step(STEP * k, leader[0] if leader and leader[1] < 120.0 else None)
        libsumo.simulationStep()
    libsumo.close()
    return float(np.mean(speeds))


def episode(name: str, seed: int, folder: Path, duration: float, by_radio: bool) -> dict:
    """Drive one episode."""
    begin(name, seed, folder)
    scenario, braker, radio = SCENARIOS[name], Braker(seed), Radio(seed) if by_radio else None
    beside = [(f"e_{i}", 1) for i in range(scenario.lanes) if i != scenario.own]
    beside += [("r_0", -1)] * bool(scenario.oncoming)
    road, ego, rows, cpu = road_of(f"e_{scenario.own}", beside, scenario.limit), vehicle("ego"), [], []
    plant = SingleTrackPlant(CAR, VehicleState(x=ego.x, y=ego.y, psi=ego.psi, v_x=ego.v))
    planner, path = Planner(CAR, road, cruise_speed=scenario.cruise), road.path
    libsumo.vehicle.setSpeedMode("ego", 0)
    libsumo.vehicle.setLaneChangeMode("ego", 0)
    s, need = float(path.project((ego.x, ego.y))[0]), 0.0
    for k in range(int(duration / STEP)):
        told = others(plant.state.x, plant.state.y)
        for j in range(5):
            t, tau, state = STEP * k + 0.02 * j, 0.02 * j, plant.state
            near = [o.later(tau) for o in told]
            known = radio.known(t, near, state) if radio else [o.remote(age=tau) for o in near]
            awareness_range = 0.0 if radio and radio.tracker.is_saturated(t) else math.inf
            begun = time.thread_time()
            command = planner.step(t, state, known, awareness_range=awareness_range)
            cpu.append(time.thread_time() - begun)
            s, d, _, _ = path.foot_point(state.x, state.y, s)
            gap = min_gap(state.x, state.y, state.psi, near)
            if command.a_x >= -2.5 or j in (0, 3):
                need = needed(path, s, d, state, near) if command.a_x < -2.5 else 0.0
            rows.append({
                "v": state.v_x, "a_x": state.a_x, "a_y": plant.a_y, "delta": state.delta, "wanted": command.a_x,
                "action": command.decision.action.name, "status": command.status.name, "gap": gap, "needed": need,
            })
            if gap < 0.0:
                break
            plant.step(command.delta, command.a_x, 0.02)
        if gap < 0.0 or s > path.length - 150.0:
            break
        if k % 5 == 0:
            ahead = []
            for o in told:
                s_o, d_o, heading, _ = path.foot_point(o.x, o.y, s + max(o.x - state.x, 1.0))
                if 0.0 < s_o - s < 120.0 and abs(d_o - d) < 1.5 and math.cos(o.psi - heading) > 0.0:
                    ahead.append((s_o, o.id))
            braker.step(STEP * k, min(ahead)[1] if ahead else None)
        move_ego(plant.state)
        libsumo.simulationStep()
    libsumo.close()
    return summarize(rows, cpu)


def main() -> None:
    """Run the scenarios and seeds that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenario", default=",".join(SCENARIOS), help="names, separated by commas")
    parser.add_argument("--seeds", default="0:2", help="first:last, the last not included")
    parser.add_argument("--duration", type=float, default=75.0, help="of an episode [s]")
    parser.add_argument("--radio", action="store_true", help="others are known by messages alone")
    parser.add_argument("--baseline", action="store_true", help="drive SUMO's own driver as well")
    arguments = parser.parse_args()
    seeds = range(*map(int, arguments.seeds.split(":")))
    print(" | ".join(COLUMNS))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for scenario in arguments.scenario.split(","):
            driven = [episode(scenario, seed, folder, arguments.duration, arguments.radio) for seed in seeds]
            own = seeds if arguments.baseline else ()
            speeds = [baseline(scenario, seed, folder, arguments.duration) for seed in own]
            print(table_row(scenario, driven, SCENARIOS[scenario].cruise, speeds), flush=True)


if __name__ == "__main__":
    main()
