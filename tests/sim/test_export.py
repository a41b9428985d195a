"""Rows of a run for other programs: CSV, Parquet, MCAP."""

import csv
import json
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, Planner, RemoteVehicle, VehicleParams, VehicleState
from cca_core.path import Path
from cca_core.sim import Log, Recorder, eebl, simulate


@pytest.fixture(scope="module")
def simulated() -> Log:
    return simulate(replace(eebl("C"), duration=4.0))


@pytest.fixture(scope="module")
def recorded(road: Callable[[str], Path]) -> Log:
    """A vehicle comes at 0.1 s and leaves at 0.4 s."""
    planner = Planner(VehicleParams.bmw_320i(), road("straight"), cruise_speed=15.0)
    recorder = Recorder(planner)
    for k in range(10):
        state = VehicleState(x=20.0 + k, y=0.0, psi=0.1, v_x=15.0)
        remotes = [RemoteVehicle(id="a, b", x=90.0, y=0.0, psi=0.5 * math.pi, v_x=1.0)]
        remotes = remotes if 2 <= k < 8 else []
        recorder.add(0.05 * k, state, remotes, planner.step(0.05 * k, state, remotes))
    return recorder.log()


def test_columns_are_those_of_the_log(simulated: Log) -> None:
    columns = simulated.columns()
    assert {len(column) for column in columns.values()} == {len(simulated.t)}
    assert (columns["x"] == simulated.ego[:, 0]).all()
    assert (columns["a_x_command"] == simulated.command[:, 1]).all()
    assert (columns["yellow.v_x"] == simulated.road_users[:, 0, 3]).all()
    assert (columns["red.gap"] == simulated.gaps()[:, 1]).all()
    assert (columns["red.s"] == simulated.user_frenet[:, 1, 0]).all()
    changes = np.flatnonzero(columns["action"][1:] != columns["action"][:-1]) + 1
    assert simulated.t[changes].tolist() == [t for t, _, _ in simulated.decisions[1:]]
    assert columns["reason"][changes].tolist() == [reason for _, _, reason in simulated.decisions[1:]]


def test_reason_changes_while_the_action_stays(simulated: Log) -> None:
    columns = simulated.columns()
    during = columns["reason"][columns["action"] == "FOLLOW"]
    assert len(set(during)) > len([name for name in simulated.actions if name == "FOLLOW"])
    without = replace(simulated, cycle_reasons=()).columns()["reason"]
    assert set(without) == {reason for _, _, reason in simulated.decisions}


@pytest.mark.parametrize("name", ["simulated", "recorded"])
def test_csv_reads_back_exactly(name: str, request: pytest.FixtureRequest, tmp_path: FilePath) -> None:
    log: Log = request.getfixturevalue(name)
    log.to_table(tmp_path / "run.csv")
    with (tmp_path / "run.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(log.t)
    for key, column in log.columns().items():
        if column.dtype.kind == "U":
            assert [row[key] for row in rows] == column.tolist()
        else:
            read = np.array([float(row[key] or "nan") for row in rows])
            assert np.array_equal(read, column.astype(float), equal_nan=True), key


@pytest.mark.requires("pyarrow")
def test_parquet_reads_back_exactly(recorded: Log, tmp_path: FilePath) -> None:
    from pyarrow import parquet

    recorded.to_table(tmp_path / "run.parquet")
    table = parquet.read_table(tmp_path / "run.parquet").to_pydict()
    for key, column in recorded.columns().items():
        if column.dtype.kind == "f":
            assert np.array_equal(table[key], column, equal_nan=True), key
        else:
            assert table[key] == column.tolist(), key


@pytest.mark.parametrize("name", ["run.txt", "run"])
def test_table_with_another_ending_raises(recorded: Log, tmp_path: FilePath, name: str) -> None:
    with pytest.raises(InputError, match=r"path must end with \.csv or \.parquet, was"):
        recorded.to_table(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def read_mcap(path: FilePath) -> list[tuple[str, str, int, Any]]:
    """Topic, name of the schema, time [ns] and content of each message; each fits its schema."""
    from mcap.reader import make_reader

    found = []
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            content = json.loads(message.data)
            assert fits(content, json.loads(schema.data)), (schema.name, content)
            found.append((channel.topic, schema.name, message.log_time, content))
    return found


def fits(value: Any, schema: dict[str, Any]) -> bool:
    """Whether a value has the types of a schema."""
    kinds = {
        "object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": float,
        "null": type(None),
    }  # fmt: skip
    allowed = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
    if not isinstance(value, tuple(kinds[kind] for kind in allowed)):
        return False
    if isinstance(value, dict) and "properties" in schema:
        inner = schema["properties"]
        return value.keys() == inner.keys() and all(fits(value[key], inner[key]) for key in inner)
    return not isinstance(value, list) or all(fits(each, schema["items"]) for each in value)


@pytest.mark.requires("mcap")
def test_mcap_has_each_cycle_on_each_channel(simulated: Log, tmp_path: FilePath) -> None:
    simulated.to_mcap(tmp_path / "run.mcap", start_time=1.7e9)
    messages = read_mcap(tmp_path / "run.mcap")
    n = len(simulated.t)
    assert Counter((topic, schema) for topic, schema, _, _ in messages) == {
        ("/ego/pose", "foxglove.PoseInFrame"): n,
        ("/vehicles", "foxglove.SceneUpdate"): n,
        ("/command", "cca.Command"): n,
        ("/diagnostics", "cca.Diagnostics"): n,
        ("/decisions", "foxglove.Log"): len(simulated.decisions),
        ("/events", "foxglove.Log"): len(simulated.events),
    }
    times = [t for _, _, t, _ in messages]
    assert times == sorted(times)
    assert times[0] == 1_700_000_000_000_000_000
    assert times[-1] == pytest.approx(1e9 * (1.7e9 + simulated.t[-1]), abs=1000)
    for _, _, t, content in messages:
        assert content.get("timestamp", {"sec": t // 10**9, "nsec": t % 10**9}) == {
            "sec": t // 10**9, "nsec": t % 10**9,
        }  # fmt: skip


@pytest.mark.requires("mcap")
def test_mcap_holds_the_values_of_the_log(simulated: Log, tmp_path: FilePath) -> None:
    simulated.to_mcap(tmp_path / "run.mcap")
    messages = read_mcap(tmp_path / "run.mcap")
    contents = {topic: [c for name, _, _, c in messages if name == topic] for topic, *_ in messages}
    commands = [[content["delta"], content["a_x"]] for content in contents["/command"]]
    assert commands == simulated.command.tolist()
    poses = contents["/ego/pose"]
    assert [list(c["pose"]["position"].values()) for c in poses] == [
        [x, y, 0.0] for x, y in simulated.ego[:, :2].tolist()
    ]
    turn = np.array([[c["pose"]["orientation"][key] for key in "xyzw"] for c in poses])
    assert 2.0 * np.arctan2(turn[:, 2], turn[:, 3]) == pytest.approx(simulated.ego[:, 2])
    gaps = [content["gap"] for content in contents["/diagnostics"]]
    assert gaps == simulated.gaps().min(axis=1).tolist()
    assert [content["message"] for content in contents["/decisions"]] == [
        f"{action}: {reason}" for _, action, reason in simulated.decisions
    ]
    ego, yellow, _ = contents["/vehicles"][-1]["entities"]
    assert (ego["id"], yellow["id"]) == ("ego", "yellow")
    box, _ = simulated.bodies()
    position = ego["cubes"][0]["pose"]["position"]
    assert (position["x"], position["y"]) == (box.x[-1, 0], box.y[-1, 0])
    assert yellow["cubes"][0]["size"]["x"] == simulated.scenario.road_users[0].length


@pytest.mark.requires("mcap")
def test_mcap_deletes_vehicles_that_leave(recorded: Log, tmp_path: FilePath) -> None:
    recorded.to_mcap(tmp_path / "run.mcap")
    scenes = [c for topic, _, _, c in read_mcap(tmp_path / "run.mcap") if topic == "/vehicles"]
    assert [[entity["id"] for entity in scene["entities"]] for scene in scenes] == (
        [["ego"]] * 2 + [["ego", "a, b"]] * 6 + [["ego"]] * 2
    )
    assert [[gone["id"] for gone in scene["deletions"]] for scene in scenes] == ([[]] * 8 + [["a, b"]] + [[]])


@pytest.mark.requires("mcap")
@pytest.mark.parametrize("start_time", [-1.0, math.nan, 1e11, "now"])
def test_mcap_with_invalid_start_time_raises(recorded: Log, tmp_path: FilePath, start_time: Any) -> None:
    with pytest.raises(InputError, match="start_time must be"):
        recorded.to_mcap(tmp_path / "run.mcap", start_time=start_time)
