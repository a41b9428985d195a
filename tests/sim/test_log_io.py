"""Log files and replay: bitwise identical."""

import dataclasses
import json
from pathlib import Path as FilePath

import numpy as np
import pytest

from cca_core.errors import InputError
from cca_core.path import interpolate_path
from cca_core.sim import Log, curbside, eebl, ima, load_log, overtaking, replay, save_log, simulate


@pytest.fixture(scope="module", params=["eebl-B", "eebl-A", "ima-v2v", "curbside-sensor", "maneuver"])
def log(request: pytest.FixtureRequest) -> Log:
    kind, _, case = request.param.partition("-")
    if kind == "maneuver":
        path = interpolate_path(np.column_stack((np.arange(0.0, 1501.0, 20.0), np.zeros(76))))
        return simulate(dataclasses.replace(overtaking("1-fast", path), duration=8.0), seed=3)
    scenario = {
        "eebl": lambda: eebl(case), "ima": lambda: ima(ego_type=case),
        "curbside": lambda: curbside("fast", ego_type=case),
    }[kind]()  # fmt: skip
    return simulate(scenario, seed=3)


def same(one: Log, two: Log) -> bool:
    for field in dataclasses.fields(Log):
        a, b = getattr(one, field.name), getattr(two, field.name)
        if isinstance(a, np.ndarray):
            if a.dtype != b.dtype or a.shape != b.shape or a.tobytes() != b.tobytes():
                return False
        elif field.name != "scenario" and a != b:
            return False
    return True


def test_round_trip(log: Log, tmp_path: FilePath) -> None:
    save_log(log, tmp_path / "run.npz")
    again = load_log(tmp_path / "run.npz")
    assert same(log, again)
    assert again.summary() == log.summary()
    for field in dataclasses.fields(type(log.scenario)):
        if field.name not in ("road", "other_roads", "road_users"):
            assert getattr(again.scenario, field.name) == getattr(log.scenario, field.name), field.name
    s = np.linspace(0.0, 300.0, 50)
    assert (again.scenario.road.path.position(s) == log.scenario.road.path.position(s)).all()
    assert again.scenario.road.lanes == log.scenario.road.lanes
    assert len(again.scenario.other_roads) == len(log.scenario.other_roads)


def test_saving_twice_gives_the_same_file(log: Log, tmp_path: FilePath) -> None:
    save_log(log, tmp_path / "one.npz")
    save_log(load_log(tmp_path / "one.npz"), tmp_path / "two.npz")
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()


def test_file_needs_no_pickle(log: Log, tmp_path: FilePath) -> None:
    save_log(log, tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz", allow_pickle=False) as file:
        assert all(file[name].dtype != object for name in file.files)


def test_replay_gives_the_same_commands(log: Log, tmp_path: FilePath) -> None:
    assert replay(log).tobytes() == log.command.tobytes()
    save_log(log, tmp_path / "run.npz")
    assert replay(load_log(tmp_path / "run.npz")).tobytes() == log.command.tobytes()


def test_loaded_scenario_gives_the_same_run(log: Log, tmp_path: FilePath) -> None:
    save_log(log, tmp_path / "run.npz")
    again = simulate(load_log(tmp_path / "run.npz").scenario, seed=3)
    assert again.ego.tobytes() == log.ego.tobytes()


def test_version_1_is_read_with_new_names() -> None:
    """A file of version 1: eebl case C for 3 s, with one event of each kind."""
    path = FilePath(__file__).parent / "data" / "log_version_1.npz"
    log = load_log(path)
    assert [kind for _, kind, _ in log.events] == [
        "first_visible", "first_received", "hazard_received", "brakes", "stopped", "lateral_shift",
        "gap_released", "collision",
    ]  # fmt: skip
    with np.load(path) as file:
        for old, new in (
            ("place", "ego_frenet"), ("users", "road_users"), ("user_places", "user_frenet"),
            ("seen", "visible"), ("heard", "tracked"), ("held", "gap_held"), ("fallback", "degraded"),
        ):  # fmt: skip
            assert np.array_equal(file[old], getattr(log, new)), old
    assert log.missed_deadlines == 0
    assert (log.scenario.name, log.scenario.ego_type, log.scenario.reaction_time) == ("eebl", "v2v", 1.25)


def test_unknown_version_raises(log: Log, tmp_path: FilePath) -> None:
    save_log(log, tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as file:
        content = dict(file)
    meta = json.loads(content["meta"].tobytes()) | {"version": 3}
    content["meta"] = np.frombuffer(json.dumps(meta).encode(), dtype=np.uint8)
    np.savez(tmp_path / "next.npz", **content)
    with pytest.raises(InputError, match="version 1 or 2"):
        load_log(tmp_path / "next.npz")


def test_replay_without_messages_differs() -> None:
    log = simulate(eebl("C"))
    deaf = dataclasses.replace(log, received=())
    assert replay(deaf).tobytes() != log.command.tobytes()


@pytest.mark.parametrize("content", [b"", b"no log", None])
def test_invalid_log_file_raises(content: bytes | None, tmp_path: FilePath) -> None:
    file = tmp_path / "run.npz"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(InputError, match="path"):
        load_log(file)


def test_file_of_other_arrays_raises(tmp_path: FilePath) -> None:
    np.savez(tmp_path / "run.npz", a=np.zeros(3))
    with pytest.raises(InputError, match="path"):
        load_log(tmp_path / "run.npz")
