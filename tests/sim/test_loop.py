"""Closed loop: reproducibility, real time, messages, detections and road users."""

import dataclasses
import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, Planner, RemoteVehicle, VehicleState
from cca_core.path import Path
from cca_core.planner.planner import Command
from cca_core.sim import Log, RoadUser, Scenario, make_planner, overtaking, simulate
from tests.support.sweeps import sweep

Run = Callable[..., Log]
ARRAYS = (
    "t", "ego", "a_y", "command", "ego_frenet", "tracking", "road_users", "user_motion", "user_frenet",
    "degraded", "visible", "tracked", "gap_held",
)  # fmt: skip
EXACT = (
    "decisions", "reasons", "cycle_reasons", "events", "received", "messages", "seed", "plant", "remotes",
    "awareness_range", "overlaps",
)  # fmt: skip


class Recorder(Planner):
    """Planner that records its inputs."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.received: list[tuple[float, tuple[RemoteVehicle, ...]]] = []

    def step(
        self,
        t: float,
        state: VehicleState,
        remotes: Iterable[RemoteVehicle],
        *,
        awareness_range: float = math.inf,
    ) -> Command:
        received = tuple(remotes)
        self.received.append((t, received))
        return super().step(t, state, received)


def recorder(scenario: Scenario) -> Recorder:
    plain = make_planner(scenario)
    return Recorder(plain.vehicle, plain.road, cruise_speed=plain.cruise_speed, evasion=plain.evasion)


def short(road: Path, case: str, duration: float, **kwargs: Any) -> Scenario:
    return dataclasses.replace(overtaking(case, road, **kwargs), duration=duration)


@pytest.mark.parametrize("case", sweep("3", "1-fast"))
def test_same_seed_is_bitwise_identical(run: Run, road: Callable[[str], Path], case: str) -> None:
    first, again = run(case, "curved", 2), simulate(overtaking(case, road("curved")), seed=2)
    for name in ARRAYS:
        assert getattr(first, name).tobytes() == getattr(again, name).tobytes(), name
    for name in EXACT:
        assert getattr(first, name) == getattr(again, name), name
    volatile = {"realtime_factor", "cycle_us"}
    assert {k: v for k, v in first.summary().items() if k not in volatile} == {
        k: v for k, v in again.summary().items() if k not in volatile
    }


def test_all_fields_of_log_are_compared(run: Run) -> None:
    names = {f.name for f in dataclasses.fields(run("2"))}
    assert names == {*ARRAYS, *EXACT, "scenario", "cycle_us", "wall_s", "missed_deadlines"}


@pytest.mark.parametrize(
    "case", ["2", *(pytest.param(case, marks=pytest.mark.slow) for case in ("1-smooth", "3"))]
)
def test_other_seed_changes_log_but_not_outcome(run: Run, case: str) -> None:
    logs = [run(case, "straight", seed) for seed in (1, 2, 3)]
    assert len({log.ego.tobytes() for log in logs}) > 1
    assert len({tuple(log.actions) for log in logs}) == 1
    assert np.ptp([log.gaps().min() for log in logs]) < 0.2
    assert max(abs(log.decisions[1][0] - logs[0].decisions[1][0]) for log in logs) <= 0.21  # two messages


def test_progress_is_called_each_cycle(road: Callable[[str], Path]) -> None:
    seen: list[float] = []
    log = simulate(short(road("straight"), "2", 1.0), progress=seen.append)
    assert seen == log.t.tolist()
    assert len(seen) == 51


class Clock:
    """Wall clock that only sleeping moves."""

    def __init__(self) -> None:
        self.now = 100.0

    def perf_counter(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr("cca_core.sim.loop.time", clock)
    return clock


def test_real_time_run_waits_for_each_cycle(road: Callable[[str], Path], clock: Clock) -> None:
    scenario, ends = short(road("straight"), "2", 0.6), []
    log = simulate(scenario, real_time=True, progress=lambda _: ends.append(clock.now))
    assert ends == pytest.approx([100.0 + t for t in log.t])
    assert clock.now == pytest.approx(100.62)
    assert log.missed_deadlines == 0
    assert log.command.tobytes() == simulate(scenario).command.tobytes()


def test_missed_deadlines_are_counted(road: Callable[[str], Path], clock: Clock) -> None:
    log = simulate(short(road("straight"), "2", 0.2), real_time=True, progress=lambda _: clock.sleep(0.03))
    assert log.missed_deadlines == len(log.t) == 11
    assert log.summary()["missed_deadlines"] == 11


def test_unknown_plant_raises(road: Callable[[str], Path]) -> None:
    with pytest.raises(InputError, match="plant"):
        simulate(short(road("straight"), "2", 0.2), plant="bicycle")


class TestMessages:
    def test_ten_messages_a_second_with_latency(self, road: Callable[[str], Path]) -> None:
        scenario = short(road("straight"), "3", 3.0)
        planner = recorder(scenario)
        log = simulate(scenario, planner=planner, seed=4)
        measured: dict[str, set[float]] = {"R1": set(), "R2": set(), "A": set()}
        for k, (t, received) in enumerate(planner.received):
            for remote in received:
                i = [u.id for u in scenario.road_users].index(remote.id)
                measured[remote.id].add(round(t - remote.age, 6))
                assert scenario.latency - 1e-9 <= remote.age < scenario.latency + 0.1
                assert (remote.x, remote.y) == pytest.approx(tuple(log.road_users[k, i, :2]), abs=0.02)
                assert math.cos(remote.psi - log.road_users[k, i, 2]) > 1.0 - 1e-6
                assert remote.v_x == pytest.approx(log.road_users[k, i, 3], abs=0.011)
                assert remote.source == "v2v"
        for moments in measured.values():
            assert np.diff(sorted(moments)) == pytest.approx(0.1)
        assert all(len(received) == 3 for t, received in planner.received if t > 0.2)

    def test_senders_have_own_phases(self, road: Callable[[str], Path]) -> None:
        scenario = short(road("straight"), "2", 0.3)
        phases = set()
        for seed in range(6):
            planner = recorder(scenario)
            simulate(scenario, planner=planner, seed=seed)
            received = planner.received[-1][1]
            phases.add(tuple(round(remote.age, 3) for remote in received))
        assert len(phases) > 2

    def test_without_v2v_only_lead_vehicle_is_detected(self, road: Callable[[str], Path]) -> None:
        scenario = dataclasses.replace(short(road("straight"), "2", 8.0, v2v=False), sensor_delay=0.0)
        planner = recorder(scenario)
        log = simulate(scenario, planner=planner)
        for k, (_, received) in enumerate(planner.received):
            assert [r.id for r in received] in ([], ["R1"])
            if received:
                assert received[0].source == "sensor"
                assert received[0].age == 0.0
                assert received[0].x == log.road_users[k, 0, 0]
        assert planner.evasion.awareness_range == 0.0

    def test_sensor_range(self, road: Callable[[str], Path]) -> None:
        scenario = dataclasses.replace(
            short(road("straight"), "2", 4.0, v2v=False), sensor_range=50.0, sensor_delay=0.0
        )
        planner = recorder(scenario)
        log = simulate(scenario, planner=planner)
        for k, (_, received) in enumerate(planner.received):
            distance = log.road_users[k, 0, 0] - log.ego_frenet[k, 0]
            if abs(distance - 50.0) > 1e-6:
                assert bool(received) == (distance < 50.0)
        assert any(received for _, received in planner.received)
        assert not planner.received[0][1]


class TestTraffic:
    def test_road_user_keeps_lane_and_speed(self, run: Run) -> None:
        log = run("3", "curved", 1)
        for i, user in enumerate(log.scenario.road_users):
            s, d = log.scenario.road.path.project(log.road_users[:, i, :2], log.user_frenet[:, i, 0])
            assert d == pytest.approx(np.full(len(d), user.d), abs=1e-6)
            assert s == pytest.approx(user.s + user.direction * user.v_x * log.t, abs=1e-5)
            heading = log.scenario.road.path.heading(s) + (0.0 if user.direction > 0 else np.pi)
            assert np.cos(log.road_users[:, i, 2] - heading) == pytest.approx(np.ones(len(s)))

    def test_road_user_brakes_after_reaction_time(self, road: Callable[[str], Path]) -> None:
        """A fast driver comes up behind the slow ego."""
        base = short(road("straight"), "2", 9.0)
        chaser = RoadUser(id="A", s=base.start - 60.0, d=0.0, v_x=20.0, reaction_time=1.15, deceleration=5.0)
        log = simulate(dataclasses.replace(base, v_x=10.0, cruise_speed=10.0, road_users=(chaser,)))
        rate = np.diff(log.road_users[:, 0, 3]) / 0.02
        braking = np.flatnonzero(rate < 0.0)
        # the time to collision is below 6 s from the start on, 55.5 m at 10 m/s
        assert log.t[braking[0]] == pytest.approx(1.15, abs=0.05)
        assert rate[braking] == pytest.approx(np.full(len(braking), -5.0))
        assert log.gaps().min() > 5.0
        # it brakes only while the time to collision is below 6 s
        closing = log.road_users[:-1, 0, 3] - log.ego[:-1, 3]
        assert (log.gaps()[braking, 0] <= 6.0 * closing[braking] + 0.3).all()
        assert log.road_users[-1, 0, 3] < 12.5


@pytest.mark.parametrize(
    ("kwargs", "named"),
    [
        ({"v_x": -1.0}, "v_x"), ({"s": np.nan}, "s"), ({"d": np.inf}, "d"), ({"length": 0.0}, "length"),
        ({"width": -1.0}, "width"), ({"direction": 0}, "direction"),
        ({"reaction_time": -0.1}, "reaction_time"), ({"deceleration": np.nan}, "deceleration"),
    ],
)  # fmt: skip
def test_invalid_road_user_raises(kwargs: dict[str, Any], named: str) -> None:
    with pytest.raises(InputError, match=rf"\b{named}\b"):
        RoadUser(**({"id": "R", "s": 0.0, "d": 0.0, "v_x": 1.0} | kwargs))


@pytest.mark.parametrize(
    ("kwargs", "named"),
    [
        ({"start": -1.0}, "start"), ({"start": 1e4}, "start"), ({"v_x": -1.0}, "v_x"),
        ({"cruise_speed": 0.0}, "cruise_speed"), ({"duration": 0.0}, "duration"),
        ({"sensor_range": -1.0}, "sensor_range"), ({"latency": np.nan}, "latency"),
    ],
)  # fmt: skip
def test_invalid_scenario_raises(road: Callable[[str], Path], kwargs: dict[str, Any], named: str) -> None:
    good = overtaking("2", road("straight"))
    with pytest.raises(InputError, match=rf"\b{named}\b"):
        dataclasses.replace(good, **kwargs)


def test_empty_road_and_immediate_collision(road: Callable[[str], Path]) -> None:
    """A run without road users, and one that begins with a collision, give a summary."""
    alone = dataclasses.replace(short(road("straight"), "2", 2.0), road_users=())
    summary = simulate(alone).summary()
    assert summary["collided"] is False
    assert summary["min_gap_m"] is None
    assert summary["min_ttc_s"] is None
    touching = dataclasses.replace(alone, road_users=(RoadUser(id="R", s=alone.start + 1.0, d=0.0, v_x=5.0),))
    summary = simulate(touching).summary()
    assert summary["collided"] is True
    assert summary["collided_with"] == "R"
