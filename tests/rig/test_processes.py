"""Real processes on the bus in software: vehicle killed, stopped, restarted; floods; driver; system clock.

Judged by counts and stations, never by latency. All run in slow motion, so that a busy machine is fast
enough.
"""

import os
import signal
import socket
import subprocess
import threading
from collections.abc import Callable, Iterator
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cca_core.rig import (
    BusLink,
    Codec,
    KitState,
    ProcessRecord,
    RigOptions,
    StateReceiver,
    find_scenario,
    read_bus_log,
    read_record,
    run_scenario,
    start_process,
)
from cca_core.rig.__main__ import main
from cca_core.sim import Scenario, simulate

pytestmark = [
    pytest.mark.requires("can"), pytest.mark.requires("cantools"), pytest.mark.requires("msgpack"),
    pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="needs signals"),
]  # fmt: skip
EEBL, MANEUVER = find_scenario("eebl/C/v2v"), find_scenario("maneuver/2/v2v")
RATE = 0.5
CONTROLS = 'plant_control = "127.0.0.1:26793"\nvehicle_control = "127.0.0.1:26794"\n'


class Rig:
    """Plant and vehicle as processes, watched on the bus like by a third computer."""

    def __init__(self, scenario: Scenario, folder: Path, number: int) -> None:
        file = folder / "rig.toml"
        file.write_text(CONTROLS, encoding="utf-8")
        self.scenario = scenario
        self.options = RigOptions(number=number, rate=RATE, settings_file=file)
        self.files = {role: folder / f"{role}.pickle" for role in ("plant", "vehicle")}
        settings = self.options.settings
        self.bus, self.receiver = BusLink(settings.bus), StateReceiver(Codec(settings.steering))
        self.settings = settings
        self.vehicle = self.start("vehicle")
        self.plant = self.start("plant")

    def start(self, role: str) -> "subprocess.Popen[bytes]":
        return start_process(role, self.scenario, self.options, self.files[role])

    def until(self, holds: Callable[["Rig"], bool], cycles: int = 3000) -> None:
        """Watch the bus until something holds; `cycles` states at most."""
        last, idle = self.receiver.counts["complete"], 0
        while self.receiver.counts["complete"] - last < cycles:
            unreadable = self.bus.counts["unreadable"]
            frame = self.bus.receive(1.0)
            idle = idle + 1 if frame is None and self.bus.counts["unreadable"] == unreadable else 0
            assert idle < 60, "the bus is silent"
            assert self.plant.poll() is None, "the plant has ended"
            if frame is not None and self.receiver.take(frame, 0.0) and holds(self):
                return
        raise AssertionError("it did not happen")

    @property
    def kit(self) -> KitState:
        assert self.receiver.status is not None
        return self.receiver.status.state

    @property
    def d(self) -> float:
        state = self.receiver.state
        assert state is not None
        return float(self.scenario.road.path.project((state.x, state.y))[1])

    @property
    def v(self) -> float:
        assert self.receiver.state is not None
        return self.receiver.state.v_x

    def control(self, address: str, *words: str) -> None:
        """Give a line to a process."""
        assert main(["control", address, *words]) == 0

    def count(self, states: int) -> None:
        """Watch the bus for a number of states."""
        end = self.receiver.counts["complete"] + states
        self.until(lambda r: r.receiver.counts["complete"] >= end)

    def finish(self, role: str = "plant") -> ProcessRecord:
        """End a process; return its record."""
        process = self.plant if role == "plant" else self.vehicle
        process.terminate()
        process.wait(60.0)
        record = read_record(self.files[role])
        assert record is not None
        return record

    def close(self) -> None:
        for process in (self.vehicle, self.plant):
            if process.poll() is None:
                process.kill()
            process.wait()
        self.bus.close()


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[[Scenario], Rig]]:
    rigs: list[Rig] = []

    def begin(scenario: Scenario) -> Rig:
        rigs.append(Rig(scenario, tmp_path, 40 + os.getpid() % 400))
        return rigs[0]

    yield begin
    for rig in rigs:
        rig.close()


def is_driving(rig: Rig) -> bool:
    """Whether the vehicle controls a scenario that has begun; a busy machine may interrupt it before."""
    status = rig.receiver.status
    return status is not None and status.cycle > 20 and status.state is KitState.ENABLED


def corners(rig: Rig, record: ProcessRecord) -> np.ndarray:
    """Lateral offsets of the body's corners in the last row [m]."""
    state: Any = record.rows[-1].state  # type: ignore[union-attr]
    body = rig.scenario.vehicle.body_at(state.x, state.y, state.psi)
    return rig.scenario.road.path.project(body.corners().reshape(-1, 2))[1]


def assert_at_rest_in_lanes(rig: Rig, record: ProcessRecord) -> None:
    road, d = rig.scenario.road, corners(rig, record)
    assert record.rows[-1].state.v_x < 0.1  # type: ignore[union-attr]
    assert road.right_edge <= d.min()
    assert d.max() <= road.left_edge


def assert_kit_acts_in_time(record: ProcessRecord) -> None:
    """Each safe stop begins within the timeout and two cycles of the last command, by the plant's count."""
    rows: Any = record.rows
    fresh = 0
    for i, (before, row) in enumerate(pairwise(rows), 1):
        if row.answered != before.answered:
            fresh = i
        if row.kit is KitState.SAFE_STOP and before.kit is KitState.ENABLED:
            assert i - fresh <= 5 + 2


def test_killed_vehicle_process_stops_in_lane(start: Callable[[Scenario], Rig]) -> None:
    rig = start(EEBL)
    rig.until(is_driving)
    rig.vehicle.send_signal(signal.SIGKILL)
    rig.until(lambda r: r.kit is KitState.SAFE_STOP)
    rig.until(lambda r: r.v < 0.05)
    record = rig.finish()
    assert_at_rest_in_lanes(rig, record)
    assert_kit_acts_in_time(record)
    kits = [row.kit for row in record.rows]  # type: ignore[union-attr]
    assert set(kits[kits.index(KitState.SAFE_STOP) :]) == {KitState.SAFE_STOP}


@pytest.mark.slow
def test_driver_override_ends_control(start: Callable[[Scenario], Rig]) -> None:
    """The wheels stay and the car coasts; control does not come back by itself."""
    rig = start(EEBL)
    rig.until(is_driving)
    rig.control(rig.settings.plant_control, "driver", "on")
    rig.until(lambda r: r.kit is KitState.OVERRIDE)
    rig.control(rig.settings.plant_control, "driver", "off")
    rig.count(100)
    rows: Any = rig.finish().rows
    kits = [row.kit for row in rows]
    first = kits.index(KitState.OVERRIDE)
    assert set(kits[first:]) == {KitState.OVERRIDE}
    assert len(kits) - first > 90
    assert {row.actuation[1] for row in rows[first:]} == {0.0}
    assert rows[-1].state.v_x > 10.0


@pytest.mark.slow
def test_steps_and_drift_of_clock_change_nothing(start: Callable[[Scenario], Rig]) -> None:
    """The vehicle's system clock steps by 5 s, then by -10 s, and drifts: messages are used all the time."""
    rig = start(EEBL)
    rig.until(is_driving)
    for words in (("utc", "5.0"), ("utc", "-5.0"), ("drift", "0.002")):
        rig.control(rig.settings.vehicle_control, *words)
        rig.count(40)
    rig.until(lambda r: r.v < 0.05)
    record, vehicle = rig.finish(), rig.finish("vehicle")
    assert_at_rest_in_lanes(rig, record)
    assert all(row.collided_with == "" for row in record.rows)  # type: ignore[union-attr]
    assert vehicle.counts["vehicle"]["clock_steps"] >= 2
    known: Any = [{remote.source for remote in row.remotes} for row in vehicle.rows]  # type: ignore[union-attr]
    begin = next(i for i, sources in enumerate(known) if sources)
    assert sum("v2v" in sources for sources in known[begin:]) > 0.9 * len(known[begin:]) > 100


@pytest.mark.slow
def test_run_through_processes_equals_simulation(tmp_path: Path) -> None:
    for rate in (0.25, 0.1):
        file = tmp_path / f"bus_{rate}.blf"
        run = run_scenario(EEBL, RigOptions(number=39, rate=rate), bus_log=file)
        rows: Any = run.plant.rows
        if all(row.kit is KitState.ENABLED for row in rows):
            break
    else:
        pytest.skip("the machine interrupted the processes")
    simulated = simulate(EEBL)
    assert run.log.collided_with == ""
    assert run.log.gaps().min() == pytest.approx(simulated.gaps().min(), abs=0.3)
    assert run.log.actions[:2] == simulated.actions[:2]
    frames = list(read_bus_log(file))
    n = sum(frame.id == 0x203 for frame in frames)
    assert n >= 0.99 * len(run.log.t)
    assert sum(frame.id == 0x100 for frame in frames) >= 0.99 * len(run.vehicle.rows)


@pytest.mark.slow
def test_stopped_vehicle_process_is_cleared(start: Callable[[Scenario], Rig]) -> None:
    rig = start(MANEUVER)
    rig.until(lambda r: is_driving(r) and abs(r.d) > 1.0)
    rig.vehicle.send_signal(signal.SIGSTOP)
    rig.until(lambda r: r.kit is KitState.SAFE_STOP)
    rig.count(24)
    rig.vehicle.send_signal(signal.SIGCONT)
    rig.until(lambda r: r.kit is KitState.ENABLED)
    rig.until(lambda r: abs(r.d) < 0.3)
    record = rig.finish()
    assert_kit_acts_in_time(record)
    assert all(row.collided_with == "" for row in record.rows)  # type: ignore[union-attr]


@pytest.mark.slow
def test_restarted_vehicle_process_takes_over(start: Callable[[Scenario], Rig]) -> None:
    rig = start(MANEUVER)
    rig.until(lambda r: is_driving(r) and abs(r.d) > 1.0)
    rig.vehicle.kill()
    rig.vehicle.wait()
    rig.vehicle = rig.start("vehicle")
    rig.until(lambda r: r.kit is KitState.SAFE_STOP)
    rig.until(lambda r: r.kit is KitState.ENABLED)
    rig.until(lambda r: r.v > 3.0 or abs(r.d) < 0.3)
    record = rig.finish()
    assert_kit_acts_in_time(record)
    assert all(row.collided_with == "" for row in record.rows)  # type: ignore[union-attr]
    assert abs(corners(rig, record)).max() < 5.3


@pytest.mark.slow
@pytest.mark.parametrize("target", ["bus", "frames", "commands", "radio"])
def test_flood_of_garbage_never_ends_in_collision(start: Callable[[Scenario], Rig], target: str) -> None:
    """Some 10 000 datagrams a second: bytes, foreign frames, or spoiled commands on the bus; bytes on air."""
    rig = start(EEBL)
    rig.until(is_driving)
    stop = threading.Event()
    address = (
        rig.settings.radio_to_vehicle if target == "radio" else f"239.74.163.2:{rig.settings.bus['port']}"
    )
    host, _, port = address.rpartition(":")
    pack = import_module("can.interfaces.udp_multicast.utils").pack_message
    message = import_module("can").Message

    def content() -> bytes:
        if target in ("bus", "radio"):
            return os.urandom(40)
        number = 0x100 + os.urandom(1)[0] % 2 if target == "commands" else 0x300 + os.urandom(1)[0]
        return bytes(pack(message(arbitration_id=number, data=os.urandom(8), is_extended_id=False)))

    def flood() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
            while not stop.wait(0.01):
                for _ in range(100):
                    sender.sendto(content(), (host, int(port)))

    thread = threading.Thread(target=flood)
    thread.start()
    try:
        rig.until(lambda r: r.v < 0.05)
    finally:
        stop.set()
        thread.join()
    record = rig.finish()
    assert_at_rest_in_lanes(rig, record)
    assert all(row.collided_with == "" for row in record.rows)  # type: ignore[union-attr]
