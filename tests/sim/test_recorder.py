"""Runs of a user's own loop as logs."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path as FilePath
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cca_core import EvasionSettings, InputError, Lane, Planner, RemoteVehicle, Road, VehicleParams
from cca_core import VehicleState as State
from cca_core.follow import SpeedSettings
from cca_core.path import Path
from cca_core.sim import (
    Log,
    Recorder,
    SingleTrackPlant,
    first_collision,
    lead_speed,
    load_log,
    replay,
    save_log,
)

CAR = VehicleParams.bmw_320i()
DT = 0.05  # not the cycle of the library's own loop [s]


def planner_on(path: Path) -> Planner:
    road = Road(path, [Lane(d=0.0), Lane(d=3.5)])
    return Planner(CAR, road, cruise_speed=15.0, evasion=EvasionSettings(awareness_range=500.0))


def vehicles(path: Path, t: float) -> Iterator[RemoteVehicle]:
    """A parked van that the ego knows from 1 s on, a car that it knows until 4 s, a crossing car."""
    if t >= 1.0:
        x, y = path.to_cartesian(160.0, -0.4)
        yield RemoteVehicle(id="van", x=x, y=y, psi=0.0, v_x=0.0, length=6.0, width=2.0)
    if t < 4.0:
        x, y = path.to_cartesian(60.0 + 20.0 * t, 0.0)
        yield RemoteVehicle(id="car", x=x, y=y, psi=0.0, v_x=20.0, a_x=-1.5, source="sensor")
    if 2.0 <= t < 6.0:
        x, y = path.to_cartesian(400.0, -80.0 + 10.0 * t)
        yield RemoteVehicle(id="crossing", x=x, y=y, psi=0.5 * math.pi, v_x=10.0)


def drive(path: Path, duration: float = 12.0, t_0: float = 0.0, **kwargs: Any) -> Recorder:
    """A loop that knows nothing of the library's simulation."""
    planner = planner_on(path)
    recorder = Recorder(planner, **kwargs)
    plant = SingleTrackPlant(CAR, State(x=20.0, y=0.0, psi=0.0, v_x=15.0))
    for k in range(round(duration / DT)):
        t, state, remotes = t_0 + DT * k, plant.state, list(vehicles(path, DT * k))
        command = planner.step(t, state, remotes, awareness_range=400.0)
        recorder.add(t, state, remotes, command, awareness_range=400.0)
        plant.step(command.delta, command.a_x, DT)
    return recorder


@pytest.fixture(scope="module")
def route(road: Callable[[str], Path]) -> Path:
    return road("straight")


@pytest.fixture(scope="module")
def log(route: Path) -> Log:
    return drive(route, name="van", t_0=100.0).log()


def test_log_holds_what_was_added(log: Log, route: Path) -> None:
    assert log.t[0] == 100.0
    assert log.duration == pytest.approx(12.0 - DT)
    assert (log.plant, log.seed, log.wall_s, log.cycle_us) == (None, None, None, None)
    assert log.received == ()
    assert log.messages == {}
    assert log.scenario.name == "van"
    assert log.scenario.start == pytest.approx(20.0)
    assert log.scenario.cruise_speed == 15.0
    assert log.ego_frenet[:, 0] == pytest.approx(log.ego[:, 0], abs=1e-6)
    s, d = route.project(log.ego[:, :2])
    assert log.ego_frenet == pytest.approx(np.column_stack((s, d)), abs=1e-6)


def test_vehicles_come_and_go(log: Log) -> None:
    users = log.scenario.road_users
    assert [user.id for user in users] == ["car", "van", "crossing"]
    t = log.t - 100.0
    expected = np.column_stack((t < 3.99, t > 0.99, (t > 1.99) & (t < 5.99)))
    assert (log.present == expected).all()
    assert (np.isfinite(log.gaps()) == expected).all()
    assert (np.isfinite(log.user_frenet).all(axis=2) == expected).all()
    assert (log.visible == expected * [True, False, False]).all()
    assert (log.tracked == expected * [False, True, True]).all()
    assert [user.connected for user in users] == [False, True, True]


def test_road_users_are_as_they_appeared(log: Log) -> None:
    car, van, crossing = log.scenario.road_users
    assert (car.s, car.d, car.v_x, car.direction) == pytest.approx((60.0, 0.0, 20.0, 1.0), abs=1e-6)
    assert (van.s, van.d, van.v_x) == pytest.approx((160.0, -0.4, 0.0), abs=1e-6)
    assert (van.length, van.width) == (6.0, 2.0)
    assert car.route is None
    assert van.route is None
    assert crossing.route is not None
    assert crossing.route.position(0.0) == pytest.approx(log.road_users[40, 2, :2], abs=1e-6)
    assert crossing.route.length == pytest.approx(39.5, abs=1.5)


def test_summary_of_a_recorded_run(log: Log) -> None:
    summary = log.summary()
    assert summary["min_gap_m"] == pytest.approx(log.gaps().min(), abs=1e-3)
    assert not summary["collided"]
    assert 0.5 < summary["min_gap_m"] < 3.0
    assert summary["max_offset_m"] > 1.0
    assert "EVADE_LEFT" in [name for _, name in summary["actions"]]
    assert all(100.0 <= t <= 112.0 for t, _ in summary["actions"])
    assert ["brakes", "car"] in [event[1:] for event in summary["events"]]
    for unknown in ("plant", "seed", "realtime_factor", "cycle_us"):
        assert summary[unknown] is None
    assert summary["duration_s"] == pytest.approx(log.duration)


def test_lateral_acceleration_follows_from_the_motion(route: Path) -> None:
    planner, recorder = planner_on(route), Recorder(planner_on(route))
    for k in range(20):
        t = DT * k
        state = State(x=20.0 + 10.0 * t, y=0.0, psi=0.0, v_x=10.0, v_y=0.5 * t, r=0.2)
        recorder.add(t, state, [], planner.step(t, state, []), a_y=7.0 if k == 3 else None)
    a_y = recorder.log().a_y
    assert a_y[3] == 7.0
    assert np.delete(a_y, 3) == pytest.approx(2.5)


def test_replay_gives_the_commands_of_the_own_loop(log: Log, tmp_path: FilePath) -> None:
    assert replay(log).tobytes() == log.command.tobytes()
    save_log(log, tmp_path / "run.npz")
    again = load_log(tmp_path / "run.npz")
    assert replay(again).tobytes() == log.command.tobytes()
    assert again.summary() == log.summary()
    assert again.remotes == log.remotes
    assert again.road_users.tobytes() == log.road_users.tobytes()


def test_log_before_the_end_leaves_the_run_open(route: Path) -> None:
    recorder = drive(route, 1.0)
    first = recorder.log()
    recorder.add(1.0, State(x=35.0, y=0.0, psi=0.0, v_x=15.0), [], planner_on(route).step(
        0.0, State(x=35.0, y=0.0, psi=0.0, v_x=15.0), []
    ))  # fmt: skip
    assert len(first.t) == 20
    assert len(recorder) == len(recorder.log().t) == 21


def test_run_without_other_vehicles(route: Path) -> None:
    planner, recorder = planner_on(route), Recorder(planner_on(route))
    for k in range(10):
        state = State(x=20.0 + k, y=0.0, psi=0.0, v_x=20.0)
        recorder.add(DT * k, state, iter(()), planner.step(DT * k, state, []))
    log = recorder.log()
    assert log.road_users.shape == (10, 0, 4)
    assert log.summary()["min_gap_m"] is None
    assert np.isnan(lead_speed(log)).all()


def test_collision_is_recorded_and_the_run_goes_on(route: Path) -> None:
    planner, recorder = planner_on(route), Recorder(planner_on(route))
    wall = RemoteVehicle(id="wall", x=60.0, y=0.0, psi=0.0, v_x=0.0)
    for k in range(60):
        state = State(x=20.0 + 20.0 * DT * k, y=0.0, psi=0.0, v_x=20.0)
        remotes = [wall] if k < 55 else []
        recorder.add(DT * k, state, remotes, planner.step(DT * k, state, remotes))
    log = recorder.log()
    collision = first_collision(log)
    assert collision is not None
    assert (collision.id, log.collided_with) == ("wall", "wall")
    assert collision.t == log.time_of("collision", "wall") < log.t[-1]
    assert collision.speed == log.closing_speed() == pytest.approx(20.0)
    assert log.summary()["closing_speed_mps"] == 20.0


def test_any_object_with_vehicle_and_road_is_recorded(route: Path) -> None:
    own = SimpleNamespace(vehicle=CAR, road=Road(route), cruise_speed=9.0, speed=3.0)
    planner, recorder = planner_on(route), Recorder(own)
    for k in range(3):
        recorder.add(1.5 * k, STATE, [], planner.step(1.5 * k, STATE, []))
    scenario = recorder.log().scenario
    assert (scenario.cruise_speed, scenario.speed) == (9.0, SpeedSettings())


def test_invalid_vehicles_are_left_out(route: Path) -> None:
    planner, recorder = planner_on(route), Recorder(planner_on(route))
    good = RemoteVehicle(id="good", x=80.0, y=0.0, psi=0.0, v_x=10.0)
    twin = replace(good, x=200.0)
    for k in range(5):
        state = State(x=20.0, y=0.0, psi=0.0, v_x=10.0)
        remotes = [good, replace(good, id="bad", x=math.nan), twin]
        recorder.add(DT * k, state, remotes, planner.step(DT * k, state, remotes))
    assert [user.id for user in recorder.log().scenario.road_users] == ["good", "good#2"]


def test_source_of_a_vehicle_can_change(route: Path) -> None:
    planner, recorder = planner_on(route), Recorder(planner_on(route))
    for k in range(6):
        state = State(x=20.0, y=0.0, psi=0.0, v_x=10.0)
        source = "v2v" if k % 2 else "sensor"
        remotes = [RemoteVehicle(id="a", x=80.0, y=0.0, psi=0.0, v_x=10.0, length=4.0 + k, source=source)]
        recorder.add(DT * k, state, remotes, planner.step(DT * k, state, remotes))
    log = recorder.log()
    assert log.tracked[:, 0].tolist() == [False, True] * 3
    assert log.visible[:, 0].tolist() == [True, False] * 3
    assert log.scenario.road_users[0].length == 9.0


STATE = State(x=20.0, y=0.0, psi=0.0, v_x=15.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"t": math.nan}, "t must be finite"),
        ({"t": "1"}, "t must be a real number"),
        ({"t": 2.0}, "t must be later than the last cycle at 2.0 s, was 2.0 s"),
        ({"t": 1.5}, "t must be later"),
        ({"state": None}, "state must be a VehicleState"),
        ({"remotes": None}, "remotes must be an iterable of RemoteVehicle"),
        ({"remotes": [STATE]}, "remotes must be an iterable of RemoteVehicle, held"),
        ({"command": None}, "command must be a Command"),
        ({"command": (0.0, 1.0)}, "command must be a Command"),
        ({"a_y": math.inf}, "a_y must be finite"),
        ({"awareness_range": -1.0}, "awareness_range must be at least 0"),
    ],
)
def test_invalid_cycle_raises_and_is_not_recorded(route: Path, change: dict[str, Any], message: str) -> None:
    planner = planner_on(route)
    recorder = Recorder(planner)
    command = planner.step(2.0, STATE, [])
    recorder.add(2.0, STATE, [], command)
    with pytest.raises(InputError, match=message):
        recorder.add(**({"t": 3.0, "state": STATE, "remotes": [], "command": command} | change))
    assert len(recorder) == 1
    with pytest.raises(InputError, match="at least twice"):
        recorder.log()
    recorder.add(2.1, STATE, [], command)
    assert len(recorder.log().t) == 2


def test_command_without_numbers_raises(route: Path) -> None:
    planner = planner_on(route)
    command = planner.step(0.0, STATE, [])
    for name, value in (("delta", math.nan), ("a_x", "fast"), ("reference", None)):
        with pytest.raises(InputError, match=rf"command\.{name} must be"):
            Recorder(planner).add(0.0, STATE, [], replace(command, **{name: value}))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"planner": None}, "planner must have vehicle, road and cruise_speed"),
        ({"planner": STATE}, "planner must have vehicle, road and cruise_speed"),
        ({"planner": SimpleNamespace(vehicle=CAR, road=3.0, cruise_speed=1.0)}, "has no such road"),
        ({"ego_type": "pilot"}, "ego_type must be one of"),
    ],
)
def test_invalid_recorder_raises(route: Path, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Recorder(**({"planner": planner_on(route)} | arguments))


@pytest.mark.parametrize(
    ("sources", "given", "expected"),
    [
        (["sensor", "sensor"], {}, "sensor"),
        (["sensor", "v2v"], {}, "v2v"),
        ([], {}, "v2v"),
        (["sensor"], {"ego_type": "v2v"}, "v2v"),
        (["v2v"], {"ego_type": "driver"}, "driver"),
    ],
)
def test_ego_type_follows_from_the_sources_unless_given(
    route: Path, sources: list[str], given: dict[str, str], expected: str
) -> None:
    planner = planner_on(route)
    recorder = Recorder(planner, **given)
    state = State(x=20.0, y=0.0, psi=0.0, v_x=15.0)
    remotes = [
        RemoteVehicle(id=str(i), x=100.0 + 30.0 * i, y=0.0, psi=0.0, v_x=15.0, source=source)
        for i, source in enumerate(sources)
    ]
    for t in (0.0, DT):
        recorder.add(t, state, remotes, planner.step(t, state, remotes))
    assert recorder.log().scenario.ego_type == expected


def test_replay_of_a_loop_with_a_sensor_alone_gives_its_commands(route: Path) -> None:
    """The planner knew what the loop stated, not what a simulated ego with a sensor knows."""
    planner, recorder = planner_on(route), Recorder(planner_on(route))
    for k in range(200):
        t = DT * k
        state = State(x=20.0 + 10.0 * t, y=0.0, psi=0.0, v_x=10.0)
        seen = [RemoteVehicle(id="van", x=90.0, y=-0.5, psi=0.0, v_x=0.0, source="sensor")]
        recorder.add(t, state, seen, planner.step(t, state, seen))
    log = recorder.log()
    assert log.scenario.ego_type == "sensor"
    assert replay(log).tobytes() == log.command.tobytes()
