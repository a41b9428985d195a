"""One episode in SUMO: the planner's ego in traffic whose lead brakes hard, or SUMO's own driver."""

import math
import random
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import libsumo
import numpy as np

from cca_core import Path as RoutePath
from cca_core import Planner, RemoteVehicle
from cca_core.adapters import SumoWorld
from cca_core.sim import SingleTrackPlant
from tests.trials.sumo.glue import CAR, make_radio
from tests.trials.sumo.lanes import LaneRequests
from tests.trials.sumo.metrics import min_gap, needed_deceleration, summarize
from tests.trials.sumo.nets import SCENARIOS, write_net, write_traffic
from tests.trials.sumo.network import CRUISE_SPEED, write_network, write_network_traffic

STEP = 0.1  # of SUMO; the ego is driven five times as often [s]
CYCLE = 0.02  # of the ego [s]
FINISH = 250.0  # before the end of the route, where the ego would begin to stop [m]
DESIRED = {name: scenario.cruise_speed for name, scenario in SCENARIOS.items()} | {"network": CRUISE_SPEED}
OPTIONS = (
    *("--no-step-log", "--no-warnings", "--collision.action", "none", "--time-to-teleport", "-1"),
    *("--lanechange.duration", "3", "--default.speeddev", "0", "--end", "1000"),
)


class LeadBraker:
    """Makes the ego's lead brake hard three times in an episode."""

    def __init__(self, seed: int | None) -> None:
        self.rng = random.Random(0 if seed is None else seed + 77)
        spans = () if seed is None else ((10.0, 20.0), (30.0, 42.0), (52.0, 64.0))
        self.times = [self.rng.uniform(*span) for span in spans]
        self.braking: list[tuple[str, float]] = []

    def step(self, t: float, lead: str | None) -> None:
        """Begin or end a braking."""
        for name, end in [b for b in self.braking if t > b[1]]:
            self.braking.remove((name, end))
            if name in libsumo.vehicle.getIDList():
                libsumo.vehicle.setSpeed(name, -1)
                libsumo.vehicle.setSpeedMode(name, 31)
        if self.times and t > self.times[0]:
            self.times.pop(0)
            if lead and libsumo.vehicle.getSpeed(lead) > 0.5:
                v = libsumo.vehicle.getSpeed(lead)
                to = self.rng.choice([0.0, 5.0, 0.5 * v])
                lasts = max((v - to) / self.rng.uniform(5.0, 7.0), 0.2)
                libsumo.vehicle.setSpeedMode(lead, 1)
                libsumo.vehicle.slowDown(lead, to, lasts)
                self.braking.append((lead, t + lasts + self.rng.uniform(1.0, 5.0)))


def begin(name: str, seed: int, folder: Path) -> None:
    """Start SUMO with the net and traffic of a seed."""
    net, size = folder / f"{name}.net.xml", f'length="{CAR.length}" width="{CAR.width}"'
    if name == "network":
        net, traffic = write_network(folder), write_network_traffic(seed, folder, size)
    else:
        net = net if net.exists() else write_net(name, folder)
        traffic = write_traffic(name, seed, folder, size)
    files = "-n", str(net), "-r", str(traffic)
    libsumo.start(["sumo", *files, "--step-length", str(STEP), "--seed", str(seed), *OPTIONS])
    while "ego" not in libsumo.vehicle.getIDList():
        libsumo.simulationStep()


def has_finished(name: str) -> bool:
    """Whether the ego is near the end of its route, or has left it."""
    if "ego" not in libsumo.vehicle.getIDList():
        return True
    lane = libsumo.vehicle.getLaneID("ego")
    at_end = lane.startswith("out_" if name == "network" else "e_")
    return at_end and libsumo.vehicle.getLanePosition("ego") > libsumo.lane.getLength(lane) - FINISH


def baseline(name: str, seed: int, folder: Path, duration: float) -> float:
    """Mean speed of SUMO's own driver as the ego [m/s]."""
    begin(name, seed, folder)
    braker, speeds = LeadBraker(seed if name != "network" else None), []
    for k in range(int(duration / STEP)):
        if has_finished(name):
            break
        speeds.append(libsumo.vehicle.getSpeed("ego"))
        lead = libsumo.vehicle.getLeader("ego", 150.0)
        braker.step(STEP * k, lead[0] if lead and lead[1] < 120.0 else None)
        libsumo.simulationStep()
    libsumo.close()
    return float(np.mean(speeds))


class EgoDrive:
    """The planner's ego on its plant in a running SUMO."""

    def __init__(self, name: str, seed: int, *, by_radio: bool, keep_lane: bool) -> None:
        self.radio = make_radio(seed) if by_radio else None
        self.world = SumoWorld("ego", CAR, turn_distance=0.0 if by_radio else None)
        road, state = self.world.read_road(), self.world.ego_state()
        self.plant = SingleTrackPlant(CAR, state)
        self.planner = Planner(CAR, road, cruise_speed=DESIRED[name])
        self.requests = None if keep_lane else LaneRequests()
        self.s, self.d, self.gap, self.needed = self._station(), 0.0, 99.0, 0.0
        self.known: Sequence[RemoteVehicle] = self.world.remotes()
        self.rows: list[dict[str, Any]] = []
        self.cpu: list[float] = []

    @property
    def path(self) -> RoutePath:
        """The route."""
        return self.planner.road.path

    def _station(self) -> float:
        """Return the ego's station on the route."""
        return float(self.path.project((self.plant.state.x, self.plant.state.y))[0])

    def step(self, t: float) -> None:
        """Drive one step of SUMO."""
        if self.requests is not None:
            self._choose_lane(t)
        for j in range(5):
            self._cycle(t + CYCLE * j, self.world.remotes(CYCLE * j), measure=j in (0, 3))
            if self.gap < 0.0:
                break

    def _choose_lane(self, t: float) -> None:
        """Ask for lane changes; once the ego has left a lane that ends, go on along its new one."""
        cars = libsumo.vehicle
        reaches = [lane[1] - cars.getLanePosition("ego") for lane in cars.getBestLanes("ego")]
        has_changed = self.planner.lane != 0.0 and self.planner.requested_lane is None
        if has_changed and self.path.end - self.s < max(reaches) - 50.0:
            self.planner.set_route(self.world.read_road())
            self.s = self._station()
        self.requests.update(t, self.planner, self.plant.state, self.s, self.known, reaches)

    def _cycle(self, t: float, near: Sequence[RemoteVehicle], measure: bool) -> None:
        """Drive one cycle and record it; `measure` whether the needed deceleration is measured."""
        state = self.plant.state
        self.known = known = self.radio.exchange(t, near, state) if self.radio else near
        awareness_range = 0.0 if self.radio and self.radio.tracker.is_saturated(t) else math.inf
        begun = time.thread_time()
        command = self.planner.step(t, state, known, awareness_range=awareness_range)
        self.cpu.append(time.thread_time() - begun)
        self.s, self.d, _, _ = self.path.foot_point(state.x, state.y, self.s)
        self.gap = min_gap(state.x, state.y, state.psi, near)
        if command.a_x >= -2.5:
            self.needed = 0.0
        elif measure:
            self.needed = needed_deceleration(self.path, self.s, self.d, state, near)
        row = {"v": state.v_x, "a_x": state.a_x, "a_y": self.plant.a_y, "delta": state.delta}
        row |= {"command": command.a_x, "gap": self.gap, "needed": self.needed}
        row |= {"action": command.decision.action.name, "status": command.status.name}
        self.rows.append(row)
        if self.gap >= 0.0:
            self.plant.step(command.delta, command.a_x, CYCLE)

    def lead(self) -> str | None:
        """Id of the next vehicle ahead on the ego's lane, up to 120 m."""
        ahead, x = [], self.plant.state.x
        for other in self.world.remotes():
            s, d, heading, _ = self.path.foot_point(other.x, other.y, self.s + max(other.x - x, 1.0))
            if 0.0 < s - self.s < 120.0 and abs(d - self.d) < 1.5 and math.cos(other.psi - heading) > 0.0:
                ahead.append((s, other.id))
        return min(ahead)[1] if ahead else None


def episode(
    name: str, seed: int, folder: Path, duration: float, *, by_radio: bool = False, keep_lane: bool = False
) -> dict[str, Any]:
    """Figures of one episode."""
    begin(name, seed, folder)
    braker = LeadBraker(seed if name != "network" else None)
    ego = EgoDrive(name, seed, by_radio=by_radio, keep_lane=keep_lane)
    for k in range(int(duration / STEP)):
        ego.step(STEP * k)
        if ego.gap < 0.0 or has_finished(name):
            break
        if k % 5 == 0:
            braker.step(STEP * k, ego.lead())
        ego.world.move_ego(ego.plant.state)
        ego.world.step()
    libsumo.close()
    return summarize(ego.rows, ego.cpu)
