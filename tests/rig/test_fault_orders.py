"""Random orders of faults in virtual time: no mixed states, checks as in their table, odd frames are void."""

import copy
import random
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import pytest

from cca_core import VehicleState
from cca_core.rig import (
    AccelerationCommand,
    CheckStatus,
    Codec,
    CommandReceiver,
    DriveByWireKit,
    Frame,
    KitState,
    KitStatus,
    ProtectedReceiver,
    ProtectionSettings,
    StateReceiver,
    SteeringCommand,
    SteeringMap,
    find_scenario,
    protect,
)
from tests.support.rig_world import RigWorld

pytestmark = pytest.mark.requires("cantools")
CYCLE = 0.02


@cache
def codec() -> Codec:
    return Codec(SteeringMap(15.0))


def state_at(cycle: int) -> VehicleState:
    """Motion at 20 m/s, whose every signal tells the cycle."""
    small = 1e-3 * (cycle % 1000)
    return VehicleState(
        x=0.4 * (cycle % 10_000),
        y=0.02 * (cycle % 10_000),
        psi=small,
        v_x=20.0,
        v_y=small,
        r=small,
        a_x=small,
    )


def states(cycle: int) -> list[Frame]:
    return codec().state_frames(state_at(cycle), KitStatus(state=KitState.ENABLED, cycle=cycle), cycle)


def commands(cycle: int, answered: int | None = None) -> list[Frame]:
    steering = SteeringCommand(delta=0.01, enable=cycle % 1000 > 5)
    acceleration = AccelerationCommand(a_x=0.5, enable=cycle % 1000 > 5)
    return codec().command_frames(steering, acceleration, cycle, cycle if answered is None else answered)


def faulty(rng: random.Random) -> Callable[[list[Frame]], list[Frame]]:
    """A bus that loses, spoils, repeats, delays and reorders single messages, each for a while."""
    lost: dict[int, int] = {}
    delayed: list[list] = []

    def tamper(frames: list[Frame]) -> list[Frame]:
        out = []
        for frame in frames:
            kind = rng.random()
            if lost.get(frame.id, 0) > 0:
                lost[frame.id] -= 1
            elif kind < 0.02:
                lost[frame.id] = rng.choice((0, 1, 2, 5, 13, 14, 15, 16, 29, 44))
            elif kind < 0.03:
                out.append(frame._replace(data=bytes([frame.data[0] ^ rng.randint(1, 255)]) + frame.data[1:]))
            elif kind < 0.04:
                out += [frame] * rng.randint(2, 4)
            elif kind < 0.05:
                delayed.append([rng.randint(1, 12), frame])
            elif kind < 0.06:
                out.append(
                    frame._replace(
                        data=protect(rng.randbytes(rng.randint(2, 7)), frame.id, rng.randrange(15))
                    )
                )
            else:
                out.append(frame)
        for each in delayed:
            each[0] -= 1
        out += [frame for left, frame in delayed if left == 0]
        delayed[:] = [each for each in delayed if each[0] > 0]
        if rng.random() < 0.05:
            rng.shuffle(out)
        return out

    return tamper


def receive_states(seed: int, cycles: int = 150) -> int:
    """Check every state that is accepted; return their number."""
    rng, receiver = random.Random(seed), StateReceiver(codec())
    tamper, begin = faulty(rng), rng.choice((1, 65_500))
    for cycle in range(begin, begin + cycles):
        for frame in tamper(states(cycle)):
            if receiver.take(frame, CYCLE * cycle):
                state, status = receiver.state, receiver.status
                assert state is not None
                assert status is not None
                sent = cycle - (cycle - status.cycle) % 65_536
                assert cycle - sent <= 15
                true = state_at(sent)
                for name, limit in (("x", 2e-3), ("y", 2e-3), ("psi", 1e-4), ("v_y", 1e-3), ("a_x", 1e-3)):
                    assert getattr(state, name) == pytest.approx(getattr(true, name), abs=limit), name
    return receiver.counts["complete"]


@pytest.mark.parametrize("count", [60, pytest.param(3000, marks=pytest.mark.slow)])
def test_states_never_mix_two_cycles(count: int) -> None:
    """Counters repeat after fifteen cycles: a part that was left over must not meet the next round."""
    assert sum(receive_states(seed) for seed in range(count)) > 20 * count


class Table:
    """The check of Profile 1 by the table of its specification, with the counters as it names them."""

    def __init__(self, settings: ProtectionSettings) -> None:
        self.settings = settings
        self.waits, self.last, self.max_delta = True, 0, settings.max_delta
        self.no_new, self.sync = 0, 0

    def check(self, counter: int | None, is_good: bool) -> CheckStatus:
        s = self.settings
        self.max_delta = min(self.max_delta + 1, 14) if counter is None else self.max_delta
        if counter is None:
            self.no_new += 1
            return CheckStatus.NO_NEW_DATA
        if not is_good:
            return CheckStatus.WRONG_CRC
        delta = (counter - self.last) % 15
        if self.waits:
            self.waits, self.last, self.max_delta, self.no_new = False, counter, s.max_delta, 0
            return CheckStatus.INITIAL
        if delta == 0:
            self.no_new += 1
            return CheckStatus.REPEATED
        known, gap = delta <= self.max_delta, self.no_new > s.max_missing
        self.last, self.max_delta, self.no_new = counter, s.max_delta, 0
        if not known:
            self.sync = s.sync_messages
            return CheckStatus.WRONG_SEQUENCE
        if gap:
            self.sync = s.sync_messages
            return CheckStatus.SYNC
        if self.sync > 0:
            self.sync -= 1
            return CheckStatus.SYNC
        return CheckStatus.OK if delta == 1 else CheckStatus.SOME_LOST


@pytest.mark.parametrize("count", [300, pytest.param(10_000, marks=pytest.mark.slow)])
def test_check_equals_table_of_specification(count: int) -> None:
    for seed in range(count):
        rng = random.Random(seed)
        settings = ProtectionSettings(
            max_delta=rng.randint(1, 4), max_missing=rng.randint(0, 8), sync_messages=rng.randint(1, 4)
        )
        receiver, table, counter = ProtectedReceiver(7, settings), Table(settings), rng.randrange(15)
        for _ in range(100):
            kind = rng.choice(("next",) * 8 + ("none",) * 4 + ("repeat", "jump", "crc", "skip"))
            step = {"repeat": 0, "jump": rng.randint(3, 14), "skip": 2}.get(kind, 1)
            counter = (counter + (step if kind != "none" else 0)) % 15
            data = protect(rng.randbytes(8), 7, counter)
            if kind == "crc":
                data = bytes([data[0] ^ rng.randint(1, 255)]) + data[1:]
            expected = table.check(None if kind == "none" else counter, kind != "crc")
            assert receiver.check(None if kind == "none" else data) is expected, (seed, kind)


@pytest.mark.parametrize("length", [0, 1, 2, 3, 7, 9, 64])
def test_frame_of_other_length_is_ignored(length: int) -> None:
    """Its CRC and counter are good; a signal would be missing or shifted."""
    kit, vehicle = DriveByWireKit(), StateReceiver(codec())
    receiver = CommandReceiver(kit, codec())
    for cycle in range(1, 30):
        receiver.take(commands(cycle), CYCLE * cycle, cycle)
        taken = [vehicle.take(frame, CYCLE * cycle) for frame in states(cycle)]
    assert taken[-1]
    plan = Frame(codec().ids["SAFE_STOP"], bytes(8))
    for frame in (*states(30), *commands(30), plan):
        data = (frame.data * 8)[:length]
        odd = frame._replace(data=protect(data, frame.id, 30) if length > 1 else data)
        receiver.take([odd], 0.6, 30)
        assert not vehicle.take(odd, 0.6)
    assert receiver.wrong_crc == 3
    assert receiver.cycle == 29


@pytest.mark.parametrize("first", ["steering", "acceleration"])
def test_enable_of_one_command_alone_is_no_edge(first: str) -> None:
    """The other one was there with enable all the time."""
    kit = DriveByWireKit()
    for k in range(20):
        later = k >= 10
        steers = later if first == "steering" else True
        accelerates = later if first == "acceleration" else True
        kit.steer(CYCLE * k, SteeringCommand(delta=0.0, enable=steers))
        kit.accelerate(CYCLE * k, AccelerationCommand(a_x=0.0, enable=accelerates))
        kit.step(CYCLE * k, state_at(k))
        assert kit.state is KitState.DISABLED


def test_number_of_state_begins_anew_without_effect() -> None:
    """After 22 minutes it no longer fits its signal: the commands are those of a run that has just begun."""
    scenario = replace(find_scenario("eebl/C/v2v"), duration=4.0)
    plain, late = RigWorld(scenario), RigWorld(scenario)

    def renumber_states(frames: list[Frame], t: float) -> list[Frame]:
        state, status = late.codec.state(frames)
        number = status.cycle + 65_436 if status.cycle else 0
        return late.codec.state_frames(state, replace(status, cycle=number), frames[0].data[1] & 15)

    def renumber_commands(frames: list[Frame], t: float) -> list[Frame]:
        if frames[0].id == late.codec.ids["SAFE_STOP"]:
            begin = int(late.codec.decode(frames[0])["Cycle"]) - 65_436 if late.vehicle.last else 0
            return late.codec.safe_stop_frames(late.codec.safe_stop(frames), begin, frames[0].data[1] & 15)
        steering, acceleration = map(late.codec.command, frames)
        number = (int(late.codec.decode(frames[0])["Cycle"]) - 65_436) % 65_536 if late.vehicle.last else 0
        assert isinstance(steering, SteeringCommand)
        assert isinstance(acceleration, AccelerationCommand)
        return late.codec.command_frames(steering, acceleration, frames[0].data[1] & 15, number)

    late.plant_bus.tamper, late.vehicle_bus.tamper = renumber_states, renumber_commands
    plain.run()
    late.run()
    assert len(late.plant.rows) == 201
    assert late.plant.receiver.counts["late"] == late.vehicle.receiver.counts["frozen"] == 0
    for row, other in zip(plain.plant.rows, late.plant.rows, strict=True):
        assert row.actuation == pytest.approx(other.actuation, abs=1e-3)


@pytest.fixture(scope="module")
def begun() -> RigWorld:
    made = RigWorld(replace(find_scenario("maneuver/2/v2v"), duration=30.0))
    made.run(lambda w: bool(w.plant.rows) and w.state.x != 0.0 and abs(w.d) > 0.5)
    return made


@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, 60))])
def test_faults_of_single_messages_end_in_lanes(begun: RigWorld, seed: int) -> None:
    """Both directions lose, spoil, repeat, delay and reorder; the process is stopped and started anew."""
    world, rng = copy.deepcopy(begun), random.Random(seed)
    for _ in range(8):
        for end in rng.choice(
            ((world.plant_bus,), (world.vehicle_bus,), (world.plant_bus, world.vehicle_bus))
        ):
            tamper = faulty(rng)
            end.tamper = lambda frames, t, tamper=tamper: tamper(frames)
        world.run(cycles=rng.randint(5, 40))
        world.plant_bus.tamper = world.vehicle_bus.tamper = lambda frames, t: frames
        kind = rng.random()
        world.stopped = kind < 0.2
        if kind > 0.85:
            world.dead = True
            world.run(cycles=rng.randint(3, 20))
            world.start_vehicle()
        world.run(cycles=rng.randint(5, 30))
        world.stopped = False
        assert world.plant.rows[-1].collided_with in ("", "R1", "R2", "R3")
    world.dead = True
    world.run(lambda w: w.state.v_x == 0.0, 500)
    corners = world.scenario.vehicle.body_at(world.state.x, world.state.y, world.state.psi).corners()
    d = world.scenario.road.path.project(corners.reshape(-1, 2))[1]
    assert world.scenario.road.right_edge <= d.min()
    assert d.max() <= world.scenario.road.left_edge
