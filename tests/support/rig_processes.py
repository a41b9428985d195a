"""Plant and vehicle as processes, watched on the bus like by a third computer; what every fault must keep."""

import signal
import subprocess
from collections.abc import Callable
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
    read_record,
    start_process,
)
from cca_core.rig.__main__ import main
from cca_core.sim import Scenario

RIG_MARKS = [
    pytest.mark.requires("can"), pytest.mark.requires("cantools"), pytest.mark.requires("msgpack"),
    pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="needs signals"),
]  # fmt: skip
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
