"""Records of plant and vehicle to a log, its links and figure; options; the monitor."""

import json
import socket
import threading
import urllib.request
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cca_core import InputError, RemoteVehicle
from cca_core.real_time import RealTimeLoop
from cca_core.rig import (
    BusLink,
    Codec,
    KitState,
    KitStatus,
    Monitor,
    ProcessRecord,
    RigOptions,
    RigSettings,
    SteeringMap,
    UdpLink,
    decode_detections,
    encode_detections,
    encode_telemetry,
    find_scenario,
    measure_links,
    merge_log,
    plot_links,
    read_record,
    scenario_id,
    serve,
    wrap_message,
    write_record,
)
from cca_core.rig.__main__ import main
from cca_core.sim import Log, paper_scenarios, replay, simulate
from cca_core.v2x import Bsm, encode_bsm
from tests.support.rig_world import RigWorld

pytestmark = [pytest.mark.requires("cantools"), pytest.mark.requires("can")]
SCENARIO = replace(find_scenario("eebl/C/v2v"), duration=6.0)


@pytest.fixture(scope="module")
def world() -> RigWorld:
    made = RigWorld(SCENARIO)
    made.run()
    return made


@pytest.fixture(scope="module")
def log(world: RigWorld) -> Log:
    return merge_log(SCENARIO, world.plant.rows, world.vehicle.rows, messages=world.plant.messages)


def test_merged_log_equals_simulation(log: Log) -> None:
    simulated = simulate(SCENARIO)
    assert log.t == pytest.approx(simulated.t)
    assert np.abs(log.ego[:, :2] - simulated.ego[:, :2]).max() < 0.5  # decisions are up to 0.1 s apart
    assert log.actions == simulated.actions
    assert [event[1:] for event in log.events] == [event[1:] for event in simulated.events]
    assert log.gaps().min() == pytest.approx(simulated.gaps().min(), abs=0.5)
    assert len(log.received) == pytest.approx(len(simulated.received), abs=3)


def test_merged_log_can_be_replayed(log: Log) -> None:
    """The record holds what the controller knew: its commands return, but for the resolution of times."""
    again = replay(log)
    assert np.abs(again[:, 0] - log.command[:, 0]).max() < 0.01


def test_cycles_without_command_keep_the_one_before(world: RigWorld) -> None:
    merged = merge_log(SCENARIO, world.plant.rows, world.vehicle.rows[:50])
    assert len(merged.t) == len(world.plant.rows)
    assert (merged.command[60:] == merged.command[60]).all()


def test_log_without_rows_raises() -> None:
    with pytest.raises(InputError, match="plant_rows"):
        merge_log(SCENARIO, [], [])


def test_latencies_of_links(world: RigWorld) -> None:
    """In virtual time nothing passes between sending and answering."""
    links = measure_links(world.plant.rows, world.vehicle.rows)
    assert links["state"]["count"] == links["command"]["count"] == len(world.vehicle.rows)
    assert links["state"]["max_us"] < 1.0
    assert links["radio"]["count"] == world.plant.messages["delivered"]
    assert links["commands"] == {"cycles": len(world.plant.rows), "late": 0}
    delayed = [replace(row, received=row.received + 0.003) for row in world.vehicle.rows]
    assert measure_links(world.plant.rows, delayed)["state"]["median_us"] == pytest.approx(3000.0, rel=0.2)


@pytest.mark.requires("matplotlib")
def test_figure_shows_latencies(world: RigWorld) -> None:
    links = measure_links(world.plant.rows, world.vehicle.rows)
    texts = [text.get_text() for text in plot_links([links]).axes[0].texts]
    assert any("0 of 301 commands late" in text for text in texts)
    assert sum("median" in text for text in texts) == 4


def test_names_of_scenarios_are_unique() -> None:
    names = [scenario_id(each) for each in paper_scenarios()]
    assert len(set(names)) == len(names)
    with pytest.raises(InputError, match="maneuver/2/v2v"):
        find_scenario("moon landing")


@pytest.mark.parametrize("command", ["run", "plant", "vehicle", "monitor"])
def test_unknown_scenario_ends_with_message(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "moon landing"]) == 2
    assert "scenario must be one of" in capsys.readouterr().err


def test_record_returns(tmp_path: Path) -> None:
    record = ProcessRecord(rows=[], loop={"missed": 3}, refused={})
    write_record(record, tmp_path / "a.pickle")
    again = read_record(tmp_path / "a.pickle")
    assert again is not None
    assert again.loop == {"missed": 3}
    assert read_record(tmp_path / "missing.pickle") is None


def test_options_of_processes() -> None:
    options = RigOptions(number=2, rate=0.5, settings_file=Path("rig.toml"))
    assert options.arguments() == ["--number=2", "--rate=0.5", "--priority=0", "--settings=rig.toml"]


def test_detections_return() -> None:
    vehicle = RemoteVehicle(id="R1", x=1.0, y=2.0, psi=0.1, v_x=3.0, age=0.4, source="sensor")
    assert decode_detections(encode_detections(7, [vehicle])) == (7, [vehicle])


@pytest.mark.parametrize(
    "data",
    [b"", b"\xff\xfe", b"[]", b"{}", b'{"cycle": 1, "vehicles": [{}]}', b"[" * 100_000, b'{"cycle": "x"}'],
)
def test_unreadable_detections_are_none(data: bytes) -> None:
    assert decode_detections(data) is None


MONITORED = RigSettings(
    bus={"interface": "virtual", "channel": "monitor"}, radio_to_vehicle="239.74.163.3:43301",
    radio_to_plant="239.74.163.3:43302", telemetry_address="239.74.163.3:43303", monitor_port=43304,
)  # fmt: skip


@pytest.fixture
def senders(world: RigWorld) -> Iterator[None]:
    """A bus with a state and a spoiled frame, a readable and an unreadable message, and telemetry."""
    codec, bus = Codec(SteeringMap()), BusLink(MONITORED.bus)
    frames = codec.state_frames(world.state, KitStatus(state=KitState.ENABLED, cycle=5), 1)
    message = wrap_message(encode_bsm(Bsm(msg_count=1, id="00c0ffee")), "wsmp")
    links = [UdpLink(None, [a]) for a in (MONITORED.radio_to_vehicle, MONITORED.telemetry_address)]
    stop = threading.Event()

    def send() -> None:
        while not stop.wait(0.05):
            bus.send([*frames, frames[0]._replace(data=b"\x00" * 8)])
            links[0].send(message)
            links[0].send(b"garbage")
            links[1].send(encode_telemetry(world.vehicle, world.t, RealTimeLoop(0.02)))

    thread = threading.Thread(target=send)
    thread.start()
    yield
    stop.set()
    thread.join()
    for link in (bus, *links):
        link.close()


def test_monitor_shows_rates_and_telemetry(senders: None) -> None:
    monitor, t = Monitor(SCENARIO, MONITORED), 0.0
    pause = threading.Event()
    while not monitor.snapshot(t)["vehicle"] or "wrong CRC" not in monitor.snapshot(t)["rates"]:
        pause.wait(0.02)
        t += 0.02
        monitor.poll(t)
        assert t < 20.0
    shown = monitor.snapshot(t)
    assert {"EGO_POSE", "KIT_STATUS", "wrong CRC"} <= shown["rates"].keys()
    assert {"radio to_vehicle: BSM", "radio to_vehicle: unreadable"} <= shown["rates"].keys()
    assert shown["vehicle"]["kit"] == "ENABLED"
    assert shown["vehicle"]["action"] in {"KEEP", "FOLLOW", "BRAKE"}
    assert monitor.snapshot(t + 2.0)["rates"] == {}
    monitor.close()


def test_page_is_served_and_ends(senders: None) -> None:
    stop = threading.Event()
    thread = threading.Thread(target=serve, args=(SCENARIO, MONITORED), kwargs={"is_stopped": stop.is_set})
    thread.start()
    url = f"http://127.0.0.1:{MONITORED.monitor_port}"
    for _ in range(100):
        try:
            socket.create_connection(("127.0.0.1", MONITORED.monitor_port), 1.0).close()
            break
        except OSError:
            stop.wait(0.05)
    with urllib.request.urlopen(f"{url}/", timeout=20.0) as answer:
        page = answer.read().decode("utf-8")
    with urllib.request.urlopen(f"{url}/road", timeout=20.0) as answer:
        road = json.loads(answer.read())
    with urllib.request.urlopen(f"{url}/events", timeout=20.0) as answer:
        event = answer.readline().decode("utf-8")
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(f"{url}/secret", timeout=20.0)
    stop.set()
    thread.join(20.0)
    assert not thread.is_alive()
    assert "EventSource" in page
    assert "http:" not in page
    assert len(road["lines"]) == 2
    assert event.startswith("data: {")
