"""CAN bus: frames there and back, garbage, failures of the interface, logs and replay."""

import socket
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from cca_core import InputError
from cca_core.rig import BusLink, BusRecorder, Frame, RigSettings, read_bus_log, read_rig_settings, replay_bus

pytestmark = [pytest.mark.requires("can"), pytest.mark.requires("msgpack")]
FRAMES = [Frame(256 + i, bytes(range(i, i + 8))) for i in range(20)]
BUS = {"interface": "udp_multicast", "channel": "239.74.163.2", "port": 43190, "hop_limit": 0, "fd": False}


def plain(frames: list[Frame]) -> list[tuple[int, bytes]]:
    return [(frame.id, frame.data) for frame in frames]


@pytest.fixture
def name(request: pytest.FixtureRequest) -> dict[str, Any]:
    """A bus within this process, one for each test."""
    return {"interface": "virtual", "channel": request.node.name}


def test_frames_arrive_in_order(name: dict[str, Any]) -> None:
    here, there = BusLink(name), BusLink(name)
    assert here.send(FRAMES)
    assert plain(there.drain()) == plain(FRAMES)
    assert there.receive() is None
    here.close()
    there.close()


def test_drain_is_limited(name: dict[str, Any]) -> None:
    here, there = BusLink(name), BusLink(name)
    here.send(FRAMES)
    assert len(there.drain(5)) == 5
    here.close()
    there.close()


def test_foreign_frames_do_not_end_a_drain(name: dict[str, Any]) -> None:
    """Frames with long identifiers, and requests, between those of the rig: none has to wait for a cycle."""
    can, there = import_module("can"), BusLink(name)
    sender = can.Bus(**name)
    for frame in FRAMES:
        sender.send(can.Message(arbitration_id=0x18FEF100, data=b"12345678", is_extended_id=True))
        sender.send(can.Message(arbitration_id=frame.id, is_remote_frame=True, is_extended_id=False))
        sender.send(can.Message(arbitration_id=frame.id, data=frame.data, is_extended_id=False))
    assert plain(there.drain()) == plain(FRAMES)
    assert there.counts["foreign"] == 2 * len(FRAMES)
    sender.shutdown()
    there.close()


def test_multicast_bus_counts_garbage_and_continues() -> None:
    here, there = BusLink(BUS), BusLink(BUS)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as garbage:
        for data in (b"", b"\xff" * 7, b"no frame", bytes(2000)):
            garbage.sendto(data, (BUS["channel"], BUS["port"]))
    here.send(FRAMES)
    found: list[Frame] = []
    for _ in range(200):
        frame = there.receive(0.05)
        found += [] if frame is None else [frame]
        if len(found) == len(FRAMES):
            break
    assert plain(found) == plain(FRAMES)
    assert there.counts["unreadable"] >= 3
    assert there.counts["reopened"] == 0
    here.close()
    there.close()


class FailingBus:
    """A bus that is off for some calls."""

    opened = 0

    def __init__(self, fails: list[str]) -> None:
        self.fails = fails
        FailingBus.opened += 1

    def send(self, message: Any) -> None:
        if "send" in self.fails:
            raise import_module("can").CanOperationError("bus off")

    def recv(self, timeout: float) -> None:
        if "recv" in self.fails:
            raise import_module("can").CanOperationError("interface is down") from OSError("no device")

    def shutdown(self) -> None:
        if "shutdown" in self.fails:
            raise RuntimeError("already gone")


@pytest.mark.parametrize("call", ["send", "recv"])
def test_failed_bus_is_opened_again(call: str) -> None:
    fails = [call, "shutdown"]
    link = BusLink({}, reopen_after=0.0, open_bus=lambda: FailingBus(fails))
    for _ in range(5):
        assert link.send(FRAMES[:1]) == (call != "send")
        assert link.receive() is None
    assert link.counts["reopened"] >= 4
    fails.clear()
    assert link.send(FRAMES)


def test_bus_that_cannot_be_opened_again_is_tried_later() -> None:
    fails: list[str] = []

    def open_bus() -> FailingBus:
        if "open" in fails:
            raise OSError("no such device")
        return FailingBus(fails)

    link = BusLink({}, reopen_after=0.0, open_bus=open_bus)
    fails += ["open", "send"]
    assert not link.send(FRAMES[:3])
    assert link.receive() is None
    fails.clear()
    assert link.send(FRAMES[:1])


def test_unknown_bus_raises() -> None:
    with pytest.raises(InputError, match="bus must be"):
        BusLink({"interface": "no such interface"})


@pytest.mark.parametrize(
    "ending", [".blf", ".asc", ".log", ".csv", pytest.param(".mf4", marks=pytest.mark.requires("asammdf"))]
)
@pytest.mark.filterwarnings("ignore")  # of the log formats
def test_recorded_log_is_read_back(tmp_path: Path, name: dict[str, Any], ending: str) -> None:
    file = tmp_path / f"bus{ending}"
    recorder, link = BusRecorder(name, file), BusLink(name)
    link.send(FRAMES)
    recorder.close()
    link.close()
    assert plain(list(read_bus_log(file))) == plain(FRAMES)


def test_log_can_be_replayed(tmp_path: Path, name: dict[str, Any]) -> None:
    file = tmp_path / "bus.blf"
    recorder, link = BusRecorder(name, file), BusLink(name)
    link.send(FRAMES)
    recorder.close()
    other = BusLink(name)
    waited: list[float] = []
    assert replay_bus(read_bus_log(file), link, ids=frozenset({256, 258}), sleep=waited.append) == 2
    assert plain(other.drain()) == plain([FRAMES[0], FRAMES[2]])
    link.close()
    other.close()


def test_replay_keeps_times_between_frames(name: dict[str, Any]) -> None:
    link, waited = BusLink(name), []
    frames = [Frame(1, b"", 100.0), Frame(1, b"", 130.0), Frame(1, b"", 190.0)]
    replay_bus(frames, link, rate=2.0, sleep=waited.append)
    assert waited == pytest.approx([15.0, 45.0], abs=1.0)  # nothing sleeps here
    link.close()


@pytest.mark.parametrize("file", ["bus.txt", "missing.blf"])
def test_unknown_log_raises(tmp_path: Path, file: str) -> None:
    with pytest.raises(InputError, match="file"):
        list(read_bus_log(tmp_path / file))


def test_broken_log_raises_input_error(tmp_path: Path) -> None:
    file = tmp_path / "bus.blf"
    file.write_bytes(b"no log at all")
    with pytest.raises(InputError, match="cannot be read"):
        list(read_bus_log(file))


def test_settings_are_read_from_toml(tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    file.write_text(
        'steering_map = [[0.2, 3.5], [0.6, 9.0]]\nradio_to_vehicle = "192.168.0.54:26789"\n'
        '[bus]\ninterface = "kvaser"\nchannel = 0\nbitrate = 500000\n',
        encoding="utf-8",
    )
    settings = read_rig_settings(file)
    assert settings.bus == {"interface": "kvaser", "channel": 0, "bitrate": 500000}
    assert settings.steering.to_road_wheel(9.0) == pytest.approx(0.6)
    assert settings.radio_to_vehicle == "192.168.0.54:26789"
    assert settings.radio_to_plant == RigSettings().radio_to_plant


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("speed = 3", "speed"), ("radio_to_plant = 'nowhere'", "radio_to_plant"), ("bus = 3", "bus"),
        ("radio_wrapper = 'paper'", "radio_wrapper"), ("steering_ratio = -1", "ratio"), ("[[", "TOML"),
        ("sensor_address = 'a:99999'", "sensor_address"), ("plant_control = 'x'", "plant_control"),
        ("monitor_port = 70000", "monitor_port"),
        ("steering_map = [[1, 2], [0, 1]]", "points"), ("steering_map = 'x'", "steering_map"),
    ],
)  # fmt: skip
def test_wrong_settings_raise(tmp_path: Path, text: str, named: str) -> None:
    file = tmp_path / "rig.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=named):
        read_rig_settings(file)


def test_settings_of_further_rigs_have_other_ports() -> None:
    first = RigSettings(vehicle_control="127.0.0.1:26794")
    second = first.shifted(1)
    assert (second.plant_control, second.vehicle_control) == ("", "127.0.0.1:26804")
    assert second.bus["port"] == first.bus["port"] + 10
    assert second.radio_to_vehicle == "239.74.163.3:26799"
    assert second.steering_ratio == first.steering_ratio
