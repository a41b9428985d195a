"""Faults between plant and vehicle in virtual time: what the kit does, and where the ego comes to rest."""

import copy
import random
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from cca_core.rig import COMMAND_MESSAGES, Frame, KitState
from cca_core.sim import Scenario, paper_scenarios, simulate
from tests.support.rig_world import RigWorld
from tests.support.sweeps import sweep

pytestmark = pytest.mark.requires("cantools")
SCENARIOS = {(s.name, s.case, s.ego_type): s for s in paper_scenarios()}
EEBL = replace(SCENARIOS["eebl", "C", "v2v"], channel=None)


def maneuver(case: str, reaction_time: float = 1.15) -> Scenario:
    """Maneuvering in traffic, with drivers that keep their distance to an ego that stops ahead of them."""
    scenario = SCENARIOS["maneuver", case, "v2v"]
    users = tuple(replace(user, reaction_time=reaction_time) for user in scenario.road_users)
    return replace(scenario, road_users=users)


MANEUVER = replace(maneuver("2", 0.5), duration=36.0)


def in_maneuver(world: RigWorld) -> bool:
    """Whether the ego is leaving its lane."""
    return bool(world.plant.rows) and world.state.x != 0.0 and abs(world.d) > 1.0


def passed(world: RigWorld) -> bool:
    """Whether the ego has passed the first road user, 16 s after the start."""
    return len(world.plant.rows) > 800


def started(world: RigWorld) -> bool:
    return len(world.plant.rows) > 100


@pytest.fixture(scope="module")
def begun() -> RigWorld:
    world = RigWorld(MANEUVER)
    world.run(in_maneuver)
    assert world.plant.kit.state is KitState.ENABLED
    return world


@pytest.fixture
def world(begun: RigWorld) -> RigWorld:
    """A run in the middle of its evasive maneuver."""
    return copy.deepcopy(begun)


def stop_and_check(world: RigWorld, cycles: int = 500) -> None:
    """Run until the ego is at rest, and check that its body is inside the lanes."""
    world.run(lambda w: w.state.v_x == 0.0, cycles)
    assert world.plant.rows[-1].collided_with == ""
    assert world.state.v_x == 0.0
    assert_in_lanes(world)


def assert_in_lanes(world: RigWorld) -> None:
    road, car = world.scenario.road, world.scenario.vehicle
    corners = car.body_at(world.state.x, world.state.y, world.state.psi).corners().reshape(-1, 2)
    d = road.path.project(corners)[1]
    assert road.right_edge <= d.min()
    assert d.max() <= road.left_edge


def run_in_virtual_time(scenario: Scenario) -> RigWorld:
    world = RigWorld(scenario)
    world.run()
    return world


def test_run_equals_simulation() -> None:
    """Nothing but the resolution of the CAN signals and the own radio seed lies between both.

    Messages at other times mean decisions up to 0.1 s earlier or later, while the brakes build up 5 m/s^2.
    """
    world, log = run_in_virtual_time(EEBL), simulate(EEBL)
    driven = np.array([(row.state.x, row.state.y) for row in world.plant.rows])
    assert len(driven) == len(log.t)
    assert np.abs(driven - log.ego[:, :2]).max() < 0.5
    assert set(world.states) == {KitState.DISABLED, KitState.ENABLED}
    assert world.plant.receiver.counts["late"] == 0
    assert world.vehicle.counts["ego_sent"] == pytest.approx(10 * EEBL.duration, abs=2)


def accepted(world: RigWorld) -> int:
    """Number of commands that the kit has acted on."""
    return sum(world.plant.receiver.counts[name] for name in COMMAND_MESSAGES[:2])


def tampered(kind: str, rng: random.Random) -> Callable[[list[Frame], float], list[Frame]]:
    """A bus that spoils every frame in one way."""
    queue: list[tuple[float, Frame]] = []
    stored: dict[int, Frame] = {}

    def tamper(frames: list[Frame], t: float) -> list[Frame]:
        if kind == "lost":
            return []
        if kind == "crc":
            return [Frame(f.id, bytes([f.data[0] ^ rng.randint(1, 255)]) + f.data[1:]) for f in frames]
        if kind == "repeated":
            return [stored.setdefault(f.id, f) for f in frames]
        if kind == "bits":
            return [
                Frame(f.id, bytes(b ^ (rng.random() < 0.2) << rng.randrange(8) for b in f.data))
                for f in frames
            ]
        queue.extend((t + 0.2, frame) for frame in frames)
        due = [frame for at, frame in queue if at <= t]
        queue[:] = [each for each in queue if each[0] > t]
        return due

    return tamper


@pytest.mark.parametrize("kind", ["lost", "crc", "repeated", "late"])
def test_faulty_commands_make_kit_stop_in_lanes(world: RigWorld, kind: str) -> None:
    begin, acted = len(world.states), accepted(world)
    world.vehicle_bus.tamper = tampered(kind, random.Random(1))
    cycles, last = 0, acted
    while world.plant.kit.state is KitState.ENABLED:
        world.cycle()
        cycles, last = 0 if accepted(world) > last else cycles + 1, accepted(world)
    assert cycles <= 5 + 2  # the timeout of 100 ms and two cycles after the last valid command
    stop_and_check(world)
    assert accepted(world) <= acted + 4  # those on their way, and the first of the repeated ones
    assert all(state in (KitState.ENABLED, KitState.SAFE_STOP) for state in world.states[begin:])


@pytest.mark.parametrize("kind", ["lost", "crc", "repeated"])
def test_faulty_states_make_vehicle_stop_in_lanes(world: RigWorld, kind: str) -> None:
    world.plant_bus.tamper = tampered(kind, random.Random(2))
    answered = world.vehicle.counts["answered"]
    stop_and_check(world)
    assert world.vehicle.counts["answered"] <= answered + 2
    assert world.vehicle.counts["blind"] > 20


def test_delayed_states_make_kit_refuse_their_commands(world: RigWorld) -> None:
    """The counters of delayed states are good; the kit sees from the echoed cycle that they were old."""
    world.plant_bus.tamper = tampered("late", random.Random(2))
    stop_and_check(world)
    assert world.plant.receiver.counts["late"] > 20


def test_frozen_state_makes_vehicle_stop_in_lanes(world: RigWorld) -> None:
    state_frames, frozen = world.codec.state_frames, world.state

    def freeze(state, status, counter):
        return state_frames(frozen, status, counter)

    world.plant._codec = type("Frozen", (), {"state_frames": staticmethod(freeze)})()
    stop_and_check(world)
    assert world.vehicle.receiver.counts["frozen"] > 20


def test_random_bits_on_bus_are_never_acted_on(world: RigWorld) -> None:
    rng = random.Random(3)
    world.vehicle_bus.tamper = tampered("bits", rng)
    world.plant_bus.tamper = tampered("bits", rng)
    stop_and_check(world)


@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, 30))])
def test_bursts_of_faults_are_survived_or_end_in_lanes(world: RigWorld, seed: int) -> None:
    """Short faults of all kinds on both directions; at the end the ego is inside the lanes."""
    rng = random.Random(seed)
    for _ in range(12):
        kind = rng.choice(["lost", "crc", "repeated", "late", "bits"])
        end = rng.choice([world.plant_bus, world.vehicle_bus])
        end.tamper = tampered(kind, rng)
        world.run(cycles=rng.randint(1, 12))
        end.tamper = lambda frames, t: frames
        world.run(cycles=rng.randint(5, 25))
        assert world.plant.rows[-1].collided_with == ""
    world.dead = True
    stop_and_check(world, 1100)  # the safe stop may complete the maneuver first, in up to 20 s


def test_stopped_process_is_cleared_and_passes(world: RigWorld) -> None:
    """SIGSTOP for 0.6 s in the maneuver: the kit brakes, is cleared, and the ego completes the run."""
    world.stopped = True
    world.run(cycles=30)
    assert world.plant.kit.state is KitState.SAFE_STOP
    assert world.states[-30:].count(KitState.SAFE_STOP) >= 30 - 7
    world.stopped = False
    world.run(lambda w: w.plant.kit.state is KitState.ENABLED, 40)
    assert world.plant.kit.state is KitState.ENABLED
    world.run(passed)
    assert world.plant.rows[-1].collided_with == ""
    assert abs(world.d) < 0.5


def test_killed_process_makes_kit_stop_in_lanes(world: RigWorld) -> None:
    world.dead = True
    stop_and_check(world)
    assert world.plant.kit.state is KitState.SAFE_STOP


@pytest.mark.parametrize("cycles", [20, pytest.param(85, marks=pytest.mark.slow)])
def test_restarted_process_takes_over_by_clear(world: RigWorld, cycles: int) -> None:
    world.dead = True
    world.run(cycles=cycles)
    assert world.plant.kit.state is KitState.SAFE_STOP
    world.start_vehicle()
    world.run(lambda w: w.plant.kit.state is KitState.ENABLED, 40)
    assert world.plant.kit.state is KitState.ENABLED
    assert world.vehicle.counts["plans"] >= 1
    before = world.plant.rows[-2].actuation[0]
    assert abs(world.plant.rows[-1].actuation[0] - before) <= 0.6 * 0.02 + 1e-9
    world.run(passed)
    assert world.plant.rows[-1].collided_with == ""


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["commands", "states"])
@pytest.mark.parametrize("case", ["1-fast", "1-smooth", "2", "3"])
def test_safe_stop_from_anywhere_in_run_ends_in_lanes(case: str, fault: str) -> None:
    """Commands or states are lost every 0.8 s of the run, and every 0.2 s off the lane."""
    scenario = maneuver(case)
    # a safe stop takes up to 20 s; it may complete a maneuver first
    running, stops = RigWorld(replace(scenario, duration=scenario.duration + 13.0)), 0
    running.run(started)
    while len(running.plant.rows) + 450 < scenario.duration / 0.02:
        stopping = copy.deepcopy(running)
        stopping.dead = fault == "commands"
        if fault == "states":
            stopping.plant_bus.tamper = tampered("lost", random.Random(0))
        stopping.run(lambda w: w.state.v_x == 0.0, 1100)
        assert stopping.plant.rows[-1].collided_with == ""
        assert stopping.state.v_x == 0.0
        assert_in_lanes(stopping)
        stops += 1
        running.run(cycles=10 if abs(running.d) > 0.3 else 40)
    assert stops > 20


def test_driver_override_ends_control_until_enabled_again() -> None:
    world = RigWorld(EEBL)
    world.run(started)
    world.override = True
    world.cycle()
    assert world.plant.kit.state is KitState.OVERRIDE
    world.override = False
    world.run(cycles=60)
    assert set(world.states[-60:]) == {KitState.OVERRIDE}  # only a person clears it


@pytest.mark.parametrize("step", [-5.0, 5.0])
def test_step_of_system_clock_changes_nothing(step: float) -> None:
    """The map is made once: commands are the same bit for bit."""
    plain, stepped = RigWorld(replace(EEBL, duration=4.0)), RigWorld(replace(EEBL, duration=4.0))
    plain.run()
    stepped.run(started)
    stepped.clocks.compare(stepped.t, 1.7e9 + stepped.t + step)
    stepped.run()
    assert stepped.clocks.steps == 1
    assert [row.actuation for row in stepped.plant.rows] == [row.actuation for row in plain.plant.rows]


@pytest.mark.parametrize("offset", sweep(-5.0, 5.0, -0.3))
def test_wrong_clock_at_start_is_corrected_from_messages(offset: float) -> None:
    world = RigWorld(EEBL, utc_offset=offset)
    world.run()
    assert world.plant.rows[-1].collided_with == ""
    assert world.clocks.correction == pytest.approx(offset, abs=0.25)


@pytest.mark.parametrize("kind", ["silent", "blind", "garbage", "flood"])
def test_bad_radio_never_counts_as_free_lane(kind: str) -> None:
    """Without trusted messages the ego does not enter the lane of the oncoming vehicles."""
    world, rng = RigWorld(replace(MANEUVER, sensor_range=60.0)), random.Random(4)
    spoil = {
        "silent": lambda data: [],
        "blind": lambda data: [data[:-3] + rng.randbytes(3) + b"\x00"],
        "garbage": lambda data: [rng.randbytes(rng.randrange(200))],
        "flood": lambda data: [data] + [rng.randbytes(40) for _ in range(200)],
    }[kind]
    world.plant_radio.tamper = spoil
    world.run(cycles=420)
    assert world.plant.rows[-1].collided_with == ""
    assert world.vehicle.counts["answered"] >= 410
    if kind != "flood":
        assert abs(world.d) < 0.5


def test_flood_of_frames_does_not_hold_the_kit() -> None:
    """200 foreign frames a cycle: every state is answered, and no command is late."""
    world = RigWorld(replace(EEBL, duration=3.0))
    rng = random.Random(5)

    def flood(frames: list[Frame], t: float) -> list[Frame]:
        return [*frames, *(Frame(rng.randrange(2048), rng.randbytes(8)) for _ in range(200))]

    world.plant_bus.tamper = world.vehicle_bus.tamper = flood
    world.run()
    assert world.plant.is_over
    assert world.plant.receiver.counts["late"] == 0
    assert world.states.count(KitState.ENABLED) > 140
