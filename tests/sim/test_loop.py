"""Closed loop: reproducible, and fed as the scenario says."""

import dataclasses
import math
import time
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, Planner, RemoteVehicle, VehicleState
from cca_core.path import Path
from cca_core.planner.planner import Command
from cca_core.sim import Log, RoadUser, Scenario, make_planner, overtaking, simulate

Run = Callable[..., Log]
ARRAYS = (
    "t", "ego", "a_y", "command", "ego_frenet", "tracking", "road_users", "user_motion", "user_frenet", "degraded",
    "visible", "tracked", "gap_held",
)  # fmt: skip
EXACT = ("decisions", "events", "received", "messages", "seed", "plant")


class Recorder(Planner):
    """Planner that keeps what it was told."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.heard: list[tuple[float, tuple[RemoteVehicle, ...]]] = []

    def step(
        self,
        t: float,
        state: VehicleState,
        remotes: Iterable[RemoteVehicle],
        *,
        awareness_range: float = math.inf,
    ) -> Command:
        heard = tuple(remotes)
        self.heard.append((t, heard))
        return super().step(t, state, heard)


def recorder(scenario: Scenario) -> Recorder:
    plain = make_planner(scenario)
    return Recorder(plain.vehicle, plain.road, cruise_speed=plain.cruise_speed, evasion=plain.evasion)


def short(road: Path, case: str, duration: float, **kwargs: Any) -> Scenario:
    return dataclasses.replace(overtaking(case, road, **kwargs), duration=duration)


@pytest.mark.parametrize("case", ["1-fast", "3"])
def test_same_seed_same_log_bit_for_bit(run: Run, road: Callable[[str], Path], case: str) -> None:
    first, again = run(case, "curved", 2), simulate(overtaking(case, road("curved")), seed=2)
    for name in ARRAYS:
        assert getattr(first, name).tobytes() == getattr(again, name).tobytes(), name
    for name in EXACT:
        assert getattr(first, name) == getattr(again, name), name
    volatile = {"realtime_factor", "cycle_us"}
    assert {k: v for k, v in first.summary().items() if k not in volatile} == {
        k: v for k, v in again.summary().items() if k not in volatile
    }


def test_no_field_of_the_log_was_forgotten_above(run: Run) -> None:
    names = {f.name for f in dataclasses.fields(run("2"))}
    assert names == {*ARRAYS, *EXACT, "scenario", "cycle_us", "wall_s", "missed_deadlines"}


@pytest.mark.parametrize("case", ["1-smooth", "2", "3"])
def test_other_seed_differs_in_something_but_not_in_the_outcome(run: Run, case: str) -> None:
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


class TestPaced:
    def test_runs_with_the_wall_clock(self, road: Callable[[str], Path]) -> None:
        scenario = short(road("straight"), "2", 0.6)
        begun = time.perf_counter()
        log = simulate(scenario, real_time=True)
        assert time.perf_counter() - begun >= 0.6
        free = simulate(scenario)
        assert free.missed_deadlines == 0
        assert log.command.tobytes() == free.command.tobytes()

    def test_counts_what_is_late(self, road: Callable[[str], Path]) -> None:
        scenario = short(road("straight"), "2", 0.2)
        log = simulate(scenario, real_time=True, progress=lambda _: time.sleep(0.03))
        assert log.missed_deadlines == len(log.t) == 11
        assert log.summary()["missed_deadlines"] == 11


def test_unknown_plant(road: Callable[[str], Path]) -> None:
    with pytest.raises(InputError, match="plant"):
        simulate(short(road("straight"), "2", 0.2), plant="bicycle")


class TestMessages:
    def test_ten_a_second_from_everyone_late_and_dead_reckoned(self, road: Callable[[str], Path]) -> None:
        scenario = short(road("straight"), "3", 3.0)
        planner = recorder(scenario)
        log = simulate(scenario, planner=planner, seed=4)
        measured: dict[str, set[float]] = {"R1": set(), "R2": set(), "A": set()}
        for k, (t, heard) in enumerate(planner.heard):
            for remote in heard:
                i = [u.id for u in scenario.road_users].index(remote.id)
                measured[remote.id].add(round(t - remote.age, 6))
                assert scenario.latency - 1e-9 <= remote.age < scenario.latency + 0.1
                assert (remote.x, remote.y) == pytest.approx(tuple(log.road_users[k, i, :2]), abs=0.02)
                assert math.cos(remote.psi - log.road_users[k, i, 2]) > 1.0 - 1e-6
                assert remote.v_x == pytest.approx(log.road_users[k, i, 3], abs=0.011)
                assert remote.source == "v2v"
        for moments in measured.values():
            assert np.diff(sorted(moments)) == pytest.approx(0.1)
        assert all(len(heard) == 3 for t, heard in planner.heard if t > 0.2)

    def test_senders_have_phases_of_their_own(self, road: Callable[[str], Path]) -> None:
        scenario = short(road("straight"), "2", 0.3)
        phases = set()
        for seed in range(6):
            planner = recorder(scenario)
            simulate(scenario, planner=planner, seed=seed)
            heard = planner.heard[-1][1]
            phases.add(tuple(round(remote.age, 3) for remote in heard))
        assert len(phases) > 2

    def test_without_v2v_only_the_vehicle_in_front_within_sight(self, road: Callable[[str], Path]) -> None:
        scenario = dataclasses.replace(short(road("straight"), "2", 8.0, v2v=False), sensor_delay=0.0)
        planner = recorder(scenario)
        log = simulate(scenario, planner=planner)
        for k, (_, heard) in enumerate(planner.heard):
            assert [r.id for r in heard] in ([], ["R1"])
            if heard:
                assert heard[0].source == "sensor"
                assert heard[0].age == 0.0
                assert heard[0].x == log.road_users[k, 0, 0]
        assert planner.evasion.awareness_range == 0.0

    def test_sensor_range(self, road: Callable[[str], Path]) -> None:
        scenario = dataclasses.replace(
            short(road("straight"), "2", 4.0, v2v=False), sensor_range=50.0, sensor_delay=0.0
        )
        planner = recorder(scenario)
        log = simulate(scenario, planner=planner)
        for k, (_, heard) in enumerate(planner.heard):
            distance = log.road_users[k, 0, 0] - log.ego_frenet[k, 0]
            if abs(distance - 50.0) > 1e-6:
                assert bool(heard) == (distance < 50.0)
        assert any(heard for _, heard in planner.heard)
        assert not planner.heard[0][1]


class TestTraffic:
    def test_keeps_lane_and_speed(self, run: Run) -> None:
        log = run("3", "curved", 1)
        for i, user in enumerate(log.scenario.road_users):
            s, d = log.scenario.road.path.project(log.road_users[:, i, :2], log.user_frenet[:, i, 0])
            assert d == pytest.approx(np.full(len(d), user.d), abs=1e-6)
            assert s == pytest.approx(user.s + user.direction * user.v_x * log.t, abs=1e-5)
            heading = log.scenario.road.path.heading(s) + (0.0 if user.direction > 0 else np.pi)
            assert np.cos(log.road_users[:, i, 2] - heading) == pytest.approx(np.ones(len(s)))

    def test_alert_driver_brakes_after_the_reaction_time_and_only_while_needed(
        self, road: Callable[[str], Path]
    ) -> None:
        """A fast driver comes up behind the slow ego."""
        base = short(road("straight"), "2", 9.0)
        chaser = RoadUser(id="A", s=base.start - 60.0, d=0.0, v_x=20.0, reaction_time=1.15, deceleration=5.0)
        log = simulate(dataclasses.replace(base, v_x=10.0, cruise_speed=10.0, road_users=(chaser,)))
        rate = np.diff(log.road_users[:, 0, 3]) / 0.02
        braking = np.flatnonzero(rate < 0.0)
        # in its way within 6 s of contact: from the first moment on, 55.5 m at 10 m/s
        assert log.t[braking[0]] == pytest.approx(1.15, abs=0.05)
        assert rate[braking] == pytest.approx(np.full(len(braking), -5.0))
        assert log.gaps().min() > 5.0
        # it brakes only while contact is less than 6 s away
        closing = log.road_users[:-1, 0, 3] - log.ego[:-1, 3]
        assert (log.gaps()[braking, 0] <= 6.0 * closing[braking] + 0.3).all()
        assert log.road_users[-1, 0, 3] < 12.5


@pytest.mark.parametrize(
    ("kwargs", "named"),
    [
        ({"v_x": -1.0}, "v_x"), ({"s": np.nan}, "s"), ({"d": np.inf}, "d"), ({"length": 0.0}, "length"),
        ({"width": -1.0}, "width"), ({"direction": 0}, "direction"), ({"reaction_time": -0.1}, "reaction_time"),
        ({"deceleration": np.nan}, "deceleration"),
    ],
)  # fmt: skip
def test_bad_road_user(kwargs: dict[str, Any], named: str) -> None:
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
def test_bad_scenario(road: Callable[[str], Path], kwargs: dict[str, Any], named: str) -> None:
    good = overtaking("2", road("straight"))
    with pytest.raises(InputError, match=rf"\b{named}\b"):
        dataclasses.replace(good, **kwargs)


def test_empty_road_and_contact_at_once(road: Callable[[str], Path]) -> None:
    """A run without others, and one that begins in contact, still give a summary."""
    alone = dataclasses.replace(short(road("straight"), "2", 2.0), road_users=())
    summary = simulate(alone).summary()
    assert summary["collided"] is False
    assert summary["min_gap_m"] is None
    assert summary["min_ttc_s"] is None
    touching = dataclasses.replace(alone, road_users=(RoadUser(id="R", s=alone.start + 1.0, d=0.0, v_x=5.0),))
    summary = simulate(touching).summary()
    assert summary["collided"] is True
    assert summary["collided_with"] == "R"
