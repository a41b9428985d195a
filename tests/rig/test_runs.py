"""Records of plant and vehicle to a log, its links and figure; options; the monitor."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cca_core import InputError, RemoteVehicle
from cca_core.rig import (
    ProcessRecord,
    RigOptions,
    decode_detections,
    encode_detections,
    find_scenario,
    measure_links,
    merge_log,
    plot_links,
    read_record,
    scenario_id,
    write_record,
)
from cca_core.rig.__main__ import main
from cca_core.sim import Log, paper_scenarios, replay, simulate
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
    assert np.abs(log.ego[:, :2] - simulated.ego[:, :2]).max() < 0.15
    assert log.actions == simulated.actions
    assert [event[1:] for event in log.events] == [event[1:] for event in simulated.events]
    assert log.gaps().min() == pytest.approx(simulated.gaps().min(), abs=0.3)
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
