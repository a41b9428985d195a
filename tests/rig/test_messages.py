"""CAN messages of the rig: values there and back, ranges, receivers with faulty frames."""

import math
import random
from dataclasses import replace

import pytest

from cca_core import InputError, VehicleState
from cca_core.rig import (
    COMMAND_MESSAGES,
    DBC_FILE,
    STATE_MESSAGES,
    AccelerationCommand,
    Codec,
    CommandReceiver,
    DriveByWireKit,
    Frame,
    KitState,
    KitStatus,
    StateReceiver,
    SteeringCommand,
    SteeringMap,
    StopProfile,
)

pytestmark = pytest.mark.requires("cantools")
STATE = VehicleState(x=1234.567, y=-98.765, psi=3.0, v_x=27.3, v_y=-0.4, r=0.21, delta=0.031, a_x=-3.3)
PLAN = StopProfile(
    spacing=2.3, heading=tuple(0.1 * i for i in range(40)),
    delta=tuple(0.02 * math.sin(i) for i in range(40)), a_x=(-6.512,) * 40,
)  # fmt: skip


@pytest.fixture(scope="module")
def codec() -> Codec:
    return Codec(SteeringMap(15.0))


def test_database_has_all_messages(codec: Codec) -> None:
    assert set(codec.ids) == {*STATE_MESSAGES, *COMMAND_MESSAGES}
    assert DBC_FILE.is_file()


@pytest.mark.parametrize("name", ["m", "m/s", "m/s2", "rad", "rad/s"])
def test_signals_have_units(name: str) -> None:
    assert f'"{name}"' in DBC_FILE.read_text(encoding="utf-8")


def test_state_returns_within_resolution(codec: Codec) -> None:
    status = KitStatus(state=KitState.SAFE_STOP, has_timed_out=True, cycle=70000, wrong_crc=3)
    state, again = codec.state(codec.state_frames(STATE, status, 7))
    resolution = {"x": 1e-3, "y": 1e-3, "psi": 5e-5, "v_x": 1e-3, "v_y": 5e-4, "r": 5e-5, "a_x": 5e-4}
    for name, half in resolution.items():
        assert getattr(state, name) == pytest.approx(getattr(STATE, name), abs=1.01 * half), name
    assert state.delta == pytest.approx(STATE.delta, abs=0.0003 / 15.0)
    assert again == replace(status, cycle=70000 % 65536)


def test_commands_return_within_resolution(codec: Codec) -> None:
    steering = SteeringCommand(delta=-0.123, delta_rate=0.4, enable=True, clear=True)
    acceleration = AccelerationCommand(a_x=-6.54, enable=True)
    found = [codec.command(f) for f in codec.command_frames(steering, acceleration, 3, 99)]
    turn, brake = found
    assert isinstance(turn, SteeringCommand)
    assert turn.delta == pytest.approx(-0.123, abs=2e-5)
    assert turn.delta_rate == pytest.approx(0.4, abs=4e-5)
    assert (turn.enable, turn.clear) == (True, True)
    assert brake == AccelerationCommand(a_x=pytest.approx(-6.54), enable=True)


def test_safe_stop_returns_within_resolution(codec: Codec) -> None:
    plan = codec.safe_stop(codec.safe_stop_frames(PLAN, 5, 12))
    assert plan.spacing == pytest.approx(PLAN.spacing, abs=1e-9)
    assert plan.heading == pytest.approx(PLAN.heading, abs=0.00101)
    assert plan.delta == pytest.approx(PLAN.delta, abs=0.00126 / 15.0)
    assert plan.a_x == pytest.approx(PLAN.a_x, abs=0.026)


def test_values_beyond_range_are_sent_as_limits(codec: Codec) -> None:
    extreme = VehicleState(x=9e5, y=-9e5, psi=100.0, v_x=1e4, v_y=99.0, r=-50.0, delta=50.0, a_x=1e6)
    state, _ = codec.state(codec.state_frames(extreme, KitStatus(state=KitState.DISABLED), 0))
    assert (state.x, state.v_x, state.a_x) == (67108.0, 131.0, 32.0)
    steering = SteeringCommand(delta=1e9, delta_rate=math.inf, enable=True)
    turn = codec.command(codec.command_frames(steering, AccelerationCommand(a_x=-1e9), 0, 0)[0])
    assert isinstance(turn, SteeringCommand)
    assert turn.delta == pytest.approx(16.38 / 15.0)


@pytest.mark.parametrize("steering", [SteeringMap(16.0), SteeringMap(points=[(0.2, 3.5), (0.6, 9.0)])])
def test_steering_map_and_its_inverse(steering: SteeringMap) -> None:
    for angle in (-12.0, -3.4, 0.0, 1.0, 5.0, 9.0, 11.0):
        assert steering.to_steering_wheel(steering.to_road_wheel(angle)) == pytest.approx(angle)
        assert steering.to_road_wheel(-angle) == -steering.to_road_wheel(angle)


@pytest.mark.parametrize("points", [[(0.2, 3.0), (0.1, 4.0)], [(0.2, -3.0)], [[1.0]], []])
def test_steering_map_that_does_not_increase_raises(points: list[tuple[float, ...]]) -> None:
    with pytest.raises(InputError, match="points"):
        SteeringMap(points=points)


class States:
    """A vehicle in uniform motion that reports its state."""

    def __init__(self, codec: Codec) -> None:
        self.codec, self.receiver, self.k, self.t = codec, StateReceiver(codec), 0, 0.0
        self.state = replace(STATE, x=0.0, y=0.0, psi=0.0, v_x=20.0)

    def frames(self, *, frozen: bool = False, cycle: int | None = None) -> list[Frame]:
        self.k, self.t = self.k + 1, self.t + 0.02
        if not frozen:
            self.state = replace(self.state, x=self.state.x + 0.4)
        status = KitStatus(state=KitState.ENABLED, cycle=self.k if cycle is None else cycle)
        return self.codec.state_frames(self.state, status, self.k)

    def send(self, frames: list[Frame]) -> bool:
        return [self.receiver.take(frame, self.t) for frame in frames][-1]

    def start(self) -> "States":
        for _ in range(8):
            self.send(self.frames())
        assert not self.receiver.is_lost(self.t)
        return self


def test_state_is_complete_with_its_last_frame(codec: Codec) -> None:
    states = States(codec).start()
    assert states.send(states.frames())
    assert states.receiver.state is not None
    assert states.receiver.state.t == states.t
    assert states.receiver.state.x == pytest.approx(states.state.x, abs=1e-3)


@pytest.mark.parametrize("missing", range(4))
def test_state_without_one_frame_is_not_used(codec: Codec, missing: int) -> None:
    states = States(codec).start()
    frames = states.frames()
    assert not states.send(frames[:missing] + frames[missing + 1 :])
    assert states.send(states.frames())


def test_frames_of_two_states_are_not_mixed(codec: Codec) -> None:
    states = States(codec).start()
    first, second = states.frames(), states.frames()
    assert not states.send([first[0], *second[1:]])


def test_state_with_wrong_crc_is_lost_after_timeout(codec: Codec) -> None:
    states = States(codec).start()
    for k in range(4):
        pose, *others = states.frames()
        assert not states.send([Frame(pose.id, bytes([pose.data[0] ^ 1]) + pose.data[1:]), *others])
        assert states.receiver.is_lost(states.t) == (k == 3)
    assert states.receiver.counts["wrong_crc"] == 4


def test_frozen_content_with_running_counter_is_lost(codec: Codec) -> None:
    states = States(codec).start()
    n = 0
    while not states.receiver.is_lost(states.t):
        states.send(states.frames(frozen=True))
        n += 1
    assert n <= 3 + 4  # as many as are compared, then the timeout
    while states.receiver.is_lost(states.t):
        states.send(states.frames())
        n += 1
    assert n < 15


def test_cycle_that_does_not_advance_is_lost(codec: Codec) -> None:
    states = States(codec).start()
    cycle = states.k
    for _ in range(4):
        assert not states.send(states.frames(cycle=cycle))
    assert states.receiver.is_lost(states.t)


def test_stationary_vehicle_is_not_frozen(codec: Codec) -> None:
    states = States(codec).start()
    states.state = replace(states.state, v_x=0.0)
    for _ in range(40):
        states.send(states.frames(frozen=True))
    assert not states.receiver.is_lost(states.t)


def test_random_bytes_never_raise_and_never_make_a_state(codec: Codec) -> None:
    states, rng = States(codec).start(), random.Random(4)
    kit = DriveByWireKit()
    commands, before = CommandReceiver(kit, codec), states.receiver.counts["complete"]
    for _ in range(3000):
        frame = Frame(rng.choice([*codec.ids.values(), 5]), rng.randbytes(rng.randrange(9)))
        states.receiver.take(frame, states.t)
        commands.take([frame], states.t)
    assert states.receiver.counts["complete"] == before
    assert sum(commands.counts[name] for name in COMMAND_MESSAGES) == 0


def command_frames(codec: Codec, k: int, *, enable: bool = True, cycle: int | None = None) -> list[Frame]:
    steering = SteeringCommand(delta=0.01, delta_rate=0.6, enable=enable)
    answered = k if cycle is None else cycle
    return codec.command_frames(steering, AccelerationCommand(a_x=-1.0, enable=enable), k, answered)


def test_commands_enable_kit_through_receiver(codec: Codec) -> None:
    kit = DriveByWireKit()
    receiver = CommandReceiver(kit, codec)
    for k in range(12):
        receiver.take(command_frames(codec, k, enable=k > 6), 0.02 * k, k)
        kit.step(0.02 * k, STATE)
    assert kit.state is KitState.ENABLED
    assert receiver.cycle == 11


@pytest.mark.parametrize("fault", ["crc", "repeat", "jump"])
def test_faulty_command_is_not_acted_on(codec: Codec, fault: str) -> None:
    kit = DriveByWireKit()
    receiver = CommandReceiver(kit, codec)
    for k in range(12):
        receiver.take(command_frames(codec, k, enable=k > 6), 0.02 * k, k)
        kit.step(0.02 * k, STATE)
    valid = receiver.counts["STEERING_COMMAND"]
    for k in range(12, 30):
        counter = 11 if fault == "repeat" else 5 * k if fault == "jump" else k
        frames = command_frames(codec, counter, cycle=k)
        if fault == "crc":
            frames = [Frame(f.id, f.data[:-1] + bytes([f.data[-1] ^ 4])) for f in frames]
        receiver.take(frames, 0.02 * k, k)
        kit.step(0.02 * k, STATE)
    assert receiver.counts["STEERING_COMMAND"] == valid
    assert kit.state is KitState.SAFE_STOP
    assert (receiver.wrong_crc if fault == "crc" else receiver.wrong_counter) == 2 * 18


def test_safe_stop_is_loaded_when_complete(codec: Codec) -> None:
    kit = DriveByWireKit()
    receiver = CommandReceiver(kit, codec)
    counter, loaded = 0, []
    for number in range(4):
        frames = codec.safe_stop_frames(PLAN, number, counter)
        counter += 40
        lost = 6 if number == 2 else None
        receiver.take([f for i, f in enumerate(frames) if i != lost], 0.1 * number)
        loaded.append(receiver.counts["SAFE_STOP"])
    # the first two frames of a link only make it valid, and one plan is incomplete
    assert loaded == [38, 78, 117, 157]
    for k in range(12):
        receiver.take(command_frames(codec, k, enable=k > 6), 0.02 * k, k)
        kit.step(0.02 * k, replace(STATE, v_x=0.0))
    actuation = kit.step(1.0, replace(STATE, v_x=0.0, delta=0.0))
    assert kit.state is KitState.SAFE_STOP
    assert actuation.a_x == pytest.approx(-6.5)


@pytest.mark.parametrize(("age", "loaded"), [(0, True), (5, True), (6, False), (20, False)])
def test_safe_stop_of_old_state_is_not_loaded(codec: Codec, age: int, loaded: bool) -> None:
    """It would begin at another place."""
    kit = DriveByWireKit()
    receiver = CommandReceiver(kit, codec)
    for i, cycle in enumerate((100, 105)):
        receiver.take(codec.safe_stop_frames(PLAN, cycle - age, 40 * i), 0.02 * cycle, cycle)
    assert kit.has_plan is loaded
    assert (receiver.counts["late"] == 0) is loaded


def test_safe_stop_that_does_not_end_by_braking_is_not_loaded(codec: Codec) -> None:
    kit = DriveByWireKit()
    receiver = CommandReceiver(kit, codec)
    frames = codec.safe_stop_frames(PLAN, 0, 0)
    last = codec.safe_stop_frames(replace(PLAN, a_x=(-6.5,) * 39 + (-0.001,)), 0, 0)[-1]
    receiver.take([*frames, *frames[:-1], last], 0.0)
    assert not kit.has_plan


@pytest.mark.parametrize(
    ("age", "state"),
    [
        (5, KitState.ENABLED), (6, KitState.SAFE_STOP), (-5, KitState.ENABLED), (-6, KitState.SAFE_STOP),
        (300, KitState.SAFE_STOP),
    ],
)  # fmt: skip
def test_command_that_answers_old_state_is_late(codec: Codec, age: int, state: KitState) -> None:
    """Delayed frames have good counters; the state that they answer shows their age."""
    kit = DriveByWireKit()
    receiver = CommandReceiver(kit, codec)
    for k in range(40):
        delay = age if k > 12 else 0
        receiver.take(command_frames(codec, k, enable=k > 6, cycle=k - delay), 0.02 * k, k)
        kit.step(0.02 * k, STATE)
    assert kit.state is state
    assert receiver.counts["late"] == (2 * 27 if state is KitState.SAFE_STOP else 0)
