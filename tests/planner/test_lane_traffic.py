"""Lane changes in random traffic whose drivers react as is assumed of them: no collision."""

import math

import numpy as np
import pytest

from cca_core import Lane, Planner, RemoteVehicle, Road, VehicleState
from cca_core.planner import EvasionSettings
from tests.support.planner_drives import CAR, CYCLE, ClosedLoop, ScriptedVehicle, straight
from tests.support.sweeps import sweep

LANES = (-3.5, 0.0, 3.5)
ROAD = Road(straight(3000.0), tuple(Lane(d=d) for d in LANES))
REACTION = EvasionSettings().rear_reaction_time
BRAKING = EvasionSettings().rear_braking


class Driver(ScriptedVehicle):
    """Follows what is ahead of it; an ego that enters its lane only after the assumed reaction time."""

    def __init__(self, id: str, gap: float, d: float, v: float, world: "World") -> None:
        super().__init__(id, gap, d, v)
        self.wish, self.world, self.since = v, world, math.inf

    def move(self, t: float) -> None:
        a = 1.0 - (self.v / self.wish) ** 4
        for x, d, v, length, is_ego in self.world.bodies():
            gap = x - self.x - 0.5 * (length + self.length)
            if x <= self.x or abs(d - self.d) > 1.8:
                if is_ego:
                    self.since = math.inf
                continue
            self.since = min(self.since, t) if is_ego else self.since
            if is_ego and t < self.since + REACTION:
                continue
            wanted = 2.0 + max(self.v * 1.0 + self.v * (self.v - v) / 3.5, 0.0)
            limit = -BRAKING if is_ego and t < self.since + 2.0 * REACTION else -7.0
            a = min(a, max(1.5 * (1.0 - (wanted / max(gap, 0.1)) ** 2), limit))
        self.a_x = a
        v_then = max(self.v + a * CYCLE, 0.0)
        self.x += 0.5 * (self.v + v_then) * CYCLE
        self.v = v_then


class World:
    """Three lanes of cars around an ego that is asked for another lane every few seconds."""

    def __init__(self, seed: int, seconds: float) -> None:
        rng = np.random.default_rng(seed)
        self.ego = VehicleState(x=20.0, y=0.0, psi=0.0, v_x=20.0)
        self.planner = Planner(
            CAR, ROAD, cruise_speed=22.0, evasion=EvasionSettings(awareness_range=math.inf)
        )
        self.drivers: list[Driver] = []
        for lane, d in enumerate(LANES):
            for k, x in enumerate(np.arange(-150.0, 400.0, rng.uniform(35.0, 90.0)).tolist()):
                x += rng.uniform(-10.0, 10.0)
                if d != 0.0 or abs(x) > 45.0:
                    v = 18.0 + 2.5 * lane + rng.uniform(-2.0, 2.0)
                    self.drivers.append(Driver(f"{lane}-{k}", x, d, v, self))
        self.asked = [(2.0 + 6.0 * i, float(rng.choice(LANES))) for i in range(int(seconds / 6.0))]
        self.lanes: set[float] = set()
        self.run = ClosedLoop(self.planner, self.drivers, seconds, receive=self.receive, done=self.see)

    def bodies(self) -> list[tuple[float, float, float, float, bool]]:
        ego = self.ego
        return [(ego.x, ego.y, ego.v_x, CAR.length, True)] + [
            (n.x, n.d, n.v, n.length, False) for n in self.drivers
        ]

    def receive(self, t: float, remotes: list[RemoteVehicle]) -> list[RemoteVehicle]:
        while self.asked and t >= self.asked[0][0]:
            self.planner.request_lane(self.asked.pop(0)[1])
        self.lanes.add(self.planner.lane)
        return remotes

    def see(self, state: VehicleState) -> bool:
        self.ego = state
        return False


def assert_safe(world: World) -> None:
    assert world.run.collided_with is None
    assert min(world.run.gaps.values()) > 0.3
    assert min(world.run.a_x) > -7.5
    assert min(world.run.y) - 0.5 * CAR.width > -5.3
    assert max(world.run.y) + 0.5 * CAR.width < 5.3


@pytest.mark.parametrize("seed", sweep(0, 1, 2))
def test_changes_in_traffic_are_safe(seed: int) -> None:
    assert_safe(World(seed, 30.0))


@pytest.mark.slow
def test_changes_in_much_traffic_are_safe() -> None:
    changed = 0
    for seed in range(100, 140):
        world = World(seed, 40.0)
        assert_safe(world)
        changed += len(world.lanes) > 1
    assert changed > 20
