"""Studies: what is drawn, what counts as avoidable, intervals, the file, executors, resuming after a kill."""

import csv
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cca_core.sim.study.study as study_module
from cca_core.errors import InputError
from cca_core.sim import (
    BrakeAction,
    Log,
    ReactToLeadAction,
    Scenario,
    curbside,
    eebl,
    ima,
    make_planner,
    simulate,
)
from cca_core.sim.scenarios.scenario import EGO_TYPES
from cca_core.sim.study.counterfactual import avoiding_action, first_hazard_cycle
from cca_core.sim.study.parameters import ParameterRanges, nominal_scenario, sample_scenario, without_v2v
from cca_core.sim.study.run import simulate_run
from cca_core.sim.study.sampling import STUDY_SCENARIOS
from cca_core.sim.study.statistics import StudyTable, estimate_rate
from cca_core.sim.study.store import Store
from cca_core.sim.study.study import Study, run_study
from cca_core.v2x import ChannelSettings

SHORT = ParameterRanges(scenario="eebl", loss=(0.0, 0.3))
SMALL = {"eebl": 8, "ima": 5, "curbside": 5, "maneuver": 1}


def draw(name: str, index: int = 0, seed: int = 1) -> tuple[Scenario, dict[str, Any]]:
    return sample_scenario(ParameterRanges(scenario=name), seed, index)


class TestRates:
    @pytest.mark.parametrize(("hits", "n"), [(0, 5), (1, 7), (3, 30), (29, 30), (30, 30), (12, 400)])
    @pytest.mark.parametrize("confidence", [0.9, 0.95])
    def test_interval_has_the_tails_it_is_named_for(self, hits: int, n: int, confidence: float) -> None:
        """The bounds of Clopper and Pearson by their definition, as sums of binomial probabilities."""
        rate, rest = estimate_rate(hits, n, confidence=confidence), 1.0 - confidence

        def at_most(k: int, p: float) -> float:
            return sum(math.comb(n, i) * p**i * (1.0 - p) ** (n - i) for i in range(k + 1))

        if hits < n:
            assert at_most(hits, rate.ci_high) == pytest.approx(0.5 * rest, rel=1e-6)
            assert at_most(hits, rate.upper_bound) == pytest.approx(rest, rel=1e-6)
        else:
            assert rate.ci_high == rate.upper_bound == 1.0
        if hits:
            assert 1.0 - at_most(hits - 1, rate.ci_low) == pytest.approx(0.5 * rest, rel=1e-6)
        else:
            assert rate.ci_low == 0.0
        assert rate.ci_low <= rate.value <= rate.upper_bound <= rate.ci_high

    def test_nothing_in_two_thousand(self) -> None:
        assert estimate_rate(0, 2000).upper_bound == pytest.approx(1.0 - 0.05 ** (1 / 2000))
        assert estimate_rate(0, 2000).upper_bound < 0.002 < estimate_rate(1, 2000).upper_bound

    def test_no_runs_say_nothing(self) -> None:
        rate = estimate_rate(0, 0)
        assert (rate.value, rate.ci_low, rate.ci_high) == (0.0, 0.0, 1.0)

    @pytest.mark.parametrize(("hits", "n", "c"), [(-1, 5, 0.9), (6, 5, 0.9), (1, 5, 1.0), (1, 5, 0.0)])
    def test_bad_arguments(self, hits: int, n: int, c: float) -> None:
        with pytest.raises(InputError, match=r"n_events|confidence"):
            estimate_rate(hits, n, confidence=c)


class TestVariation:
    @pytest.mark.parametrize("name", STUDY_SCENARIOS)
    def test_a_run_depends_on_its_number_alone(self, name: str) -> None:
        (first, drawn), (again, same) = draw(name, 7), draw(name, 7)
        assert drawn == same
        assert [(u.id, u.s, u.v_x) for u in first.road_users] == [
            (u.id, u.s, u.v_x) for u in again.road_users
        ]
        assert draw(name, 8)[1] != drawn
        assert draw(name, 7, seed=2)[1] != drawn

    @pytest.mark.parametrize("name", STUDY_SCENARIOS)
    def test_draws_fill_their_ranges(self, name: str) -> None:
        runs = [draw(name, i) for i in range(60)]
        variation = ParameterRanges(scenario=name)
        for field in fields(variation)[1:]:
            low, high = (
                variation.radio_range_bounds
                if field.name == "radio_range"
                else getattr(variation, field.name)
            )
            values = np.array([drawn[field.name] for _, drawn in runs])
            assert low <= values.min() < low + 0.15 * (high - low)
            assert high - 0.15 * (high - low) < values.max() <= high
        for scenario, drawn in runs:
            channel, most = scenario.channel, drawn["friction"] * 9.81
            assert channel is not None
            assert (channel.latency, channel.loss_probability, channel.range) == (
                drawn["latency"], drawn["loss"], drawn["radio_range"],
            )  # fmt: skip
            assert scenario.vehicle.mu == drawn["friction"]
            assert scenario.vehicle.m == pytest.approx(1093.3 * drawn["mass"])
            assert scenario.reaction_time == drawn["ego_reaction_time"]
            for user in scenario.road_users:
                assert user.deceleration <= most
                acts = [act for act in user.actions if isinstance(act, BrakeAction | ReactToLeadAction)]
                assert all(act.deceleration <= most for act in acts)
        assert len({scenario.case for scenario, _ in runs}) == {"curbside": 1, "maneuver": 4}.get(name, 2)

    def test_reach_is_that_of_the_scenario(self) -> None:
        assert ParameterRanges(scenario="ima").radio_range_bounds == (50.0, 400.0)
        assert ParameterRanges(scenario="maneuver").radio_range_bounds == (300.0, 1000.0)
        assert ParameterRanges(scenario="maneuver", radio_range=(9.0, 10.0)).radio_range_bounds == (9.0, 10.0)

    @pytest.mark.parametrize("name", STUDY_SCENARIOS)
    def test_equal_bounds_hold_a_value(self, name: str) -> None:
        held = ParameterRanges(scenario=name, latency=(0.2, 0.2), loss=(0.0, 0.0))
        assert {sample_scenario(held, 1, i)[1]["latency"] for i in range(5)} == {0.2}

    def test_planner_knows_the_friction_but_not_the_load(self) -> None:
        scenario, _ = draw("curbside")
        car = nominal_scenario(scenario).vehicle
        assert car.m == 1093.3
        assert car.mu == scenario.vehicle.mu
        assert replace(car, m=scenario.vehicle.m, I_z=scenario.vehicle.I_z) == scenario.vehicle

    def test_without_messages_nobody_is_warned(self) -> None:
        scenario = next(s for s, _ in (draw("eebl", i) for i in range(9)) if s.case == "C")
        silent = without_v2v(scenario, "driver")
        follows = next(act for act in silent.road_users[0].actions if isinstance(act, ReactToLeadAction))
        assert math.isinf(follows.warning_delay)
        assert not silent.v2v
        log = simulate(silent)
        assert log.received == ()
        assert log.time_of("brakes", "yellow") - log.time_of("brakes", "red") >= follows.reaction_time - 0.1

    @pytest.mark.parametrize(
        "change",
        [
            {"scenario": "zebra"}, {"loss": (0.5, 0.2)}, {"loss": (0.0, 0.95)}, {"latency": (-0.1, 0.0)},
            {"mass": (math.nan, 1.0)}, {"radio_range": (5.0,)},
        ],
    )  # fmt: skip
    def test_bad_arguments(self, change: dict[str, Any]) -> None:
        with pytest.raises(InputError, match=rf"\b{next(iter(change))}\b"):
            ParameterRanges(**{"scenario": "eebl", **change})

    def test_bad_numbers(self) -> None:
        with pytest.raises(InputError, match="index"):
            draw("eebl", -1)


@cache
def curb(reach: float, **change: float) -> Log:
    """An ego that knows red by its messages alone."""
    blind = replace(curbside("fast", channel=ChannelSettings(range=reach), **change), sensor_range=0.0)
    return simulate(blind)


class TestAvoidable:
    """By closed forms: braking from v with b takes v^2 / 2b and the time of building up."""

    @pytest.mark.parametrize("make", [eebl, ima, curbside])
    def test_of_the_papers_scenarios_all_are(self, make: Any) -> None:
        assert avoiding_action(simulate(make())) == "brake"

    def test_braking_needs_its_distance(self) -> None:
        """25^2 / 14 = 44.6 m, and (0.55 / 2 + 0.1) s, half of the ramp and the lag, at 25 m/s: 54 m."""
        room = 4.5  # from middle to middle of two bodies that touch
        assert avoiding_action(curb(room + 63.0)) == "brake"
        assert avoiding_action(curb(room + 51.0)) == "evade"

    def test_a_swerve_needs_its_distance_too(self) -> None:
        """0.95 m in 1 s take 5.8 x 0.95 = 5.5 m/s^2, which mu = 0.9 gives; in half a second 22 m/s^2."""
        assert avoiding_action(curb(4.5 + 27.5)) == "evade"
        assert avoiding_action(curb(4.5 + 14.0)) == ""

    def test_there_is_no_swerve_without_a_lane_beside(self) -> None:
        log = curb(4.5 + 40.0)
        assert avoiding_action(log) == "evade"
        narrow = curbside("fast", channel=ChannelSettings(range=44.5))
        road = type(narrow.road)(narrow.road.path, speed_limit=narrow.road.speed_limit)
        assert avoiding_action(simulate(replace(narrow, road=road))) == ""

    def test_a_swerve_into_somebody_does_not_count(self) -> None:
        scenario = curbside("fast", channel=ChannelSettings(range=44.5))
        red = scenario.road_users[1]
        beside = replace(red, id="beside", d=2.6, connected=False)
        assert avoiding_action(simulate(replace(scenario, road_users=(*scenario.road_users, beside)))) == ""

    def test_who_was_never_told_could_not_know(self) -> None:
        log = curb(1.0)
        assert first_hazard_cycle(log) is None
        assert avoiding_action(log) == ""

    def test_first_hazard_is_the_first_delivered_message(self) -> None:
        late = ChannelSettings(latency=0.3)
        log = simulate(eebl(channel=late))
        hazard = first_hazard_cycle(log)
        assert hazard is not None
        # red brakes at 2 s and has 0.4 g at 2.31 s; then up to 0.1 s until it sends
        assert 2.31 + 0.3 - 0.02 <= log.t[hazard] <= 2.31 + 0.1 + 0.3 + 0.04
        assert hazard == min(k for k, _ in log.received if log.t[k] >= log.time_of("hazard_received", "red"))

    def test_until_then_the_run_is_repeated_exactly(self, monkeypatch: pytest.MonkeyPatch) -> None:
        import cca_core.sim.study.counterfactual as module

        log, again = simulate(eebl()), []
        drive = module.simulate
        monkeypatch.setattr(module, "simulate", lambda *a, **k: again.append(drive(*a, **k)) or again[-1])
        assert avoiding_action(log) == "brake"
        hazard = first_hazard_cycle(log)
        assert hazard is not None
        np.testing.assert_array_equal(again[0].ego[: hazard + 1], log.ego[: hazard + 1])
        np.testing.assert_array_equal(again[0].road_users[: hazard + 1], log.road_users[: hazard + 1])
        assert again[0].received[: len(log.received) // 4] == log.received[: len(log.received) // 4]
        assert again[0].ego[:, 7].min() == pytest.approx(-7.0, abs=0.05)

    def test_a_contact_with_messages_can_have_been_avoidable(self) -> None:
        """An ego that ignores what it hears hits, and the oracle knows that it need not have."""
        scenario = eebl("C")
        deaf = make_planner(scenario)
        step = deaf.step
        deaf.step = lambda t, state, remotes, **k: step(t, state, [], **k)  # type: ignore[method-assign]
        log = simulate(scenario, planner=deaf)
        assert log.summary()["collided"]
        assert avoiding_action(log) == "brake"

    def test_wants_messages(self) -> None:
        with pytest.raises(InputError, match="messages"):
            avoiding_action(simulate(eebl("A")))


class TestStudy:
    @pytest.mark.parametrize(
        "change",
        [{"runs": 0}, {"avoidable": 0}, {"runs": 3, "avoidable": 3}, {}, {"runs": 3, "seed": -1},
         {"runs": 3, "plant": "toy"}],
    )  # fmt: skip
    def test_bad_arguments(self, change: dict[str, Any]) -> None:
        with pytest.raises(InputError, match=r"runs|seed|plant"):
            Study(parameters=SHORT, **change)

    def test_fingerprint_tells_studies_apart_but_not_their_size(self) -> None:
        study = Study(parameters=SHORT, runs=3)
        assert study.fingerprint == replace(study, runs=None, avoidable=9).fingerprint
        others = [replace(study, seed=2), replace(study, parameters=ParameterRanges(scenario="eebl"))]
        assert len({study.fingerprint, *(other.fingerprint for other in others)}) == 3


def pretend(variation: ParameterRanges, seed: int, index: int, plant: str) -> dict[str, Any]:
    """Stand in for a run: takes a little time, a third of them cannot be avoided."""
    time.sleep(0.001 * (7 * index % 5))
    means = "" if index % 3 == 1 else "brake"
    egos = {f"{ego}_collided_with": "red" if index % (3 + k) == 1 else "" for k, ego in enumerate(EGO_TYPES)}
    return {"index": index, "avoiding_action": means, "value": 0.1 * index, **egos}


class Counting(ThreadPoolExecutor):
    """Threads; counts what is in flight and stops the study after some runs."""

    def __init__(self, stop_after: int | None = None) -> None:
        super().__init__(3)
        self.asked: list[int] = []
        self.flying = self.most = 0
        self.stop_after = stop_after

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Any:
        self.asked.append(args[2])
        if self.stop_after is not None and len(self.asked) > self.stop_after:
            raise KeyboardInterrupt
        self.flying += 1
        self.most = max(self.most, self.flying)
        future = super().submit(fn, *args, **kwargs)
        future.add_done_callback(lambda _: setattr(self, "flying", self.flying - 1))
        return future


@pytest.fixture
def pretended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study_module, "simulate_run", pretend)


def stored(study: Study, path: Path) -> list[int | str]:
    """Numbers of the runs in a study's file."""
    with Store(path, study.fingerprint) as store:
        return list(store.rows)


@pytest.mark.usefixtures("pretended")
class TestRunStudy:
    def test_rows_are_in_order(self, tmp_path: Path) -> None:
        with Counting() as threads:
            study = Study(parameters=SHORT, runs=40)
            table = run_study(study, tmp_path / "a.jsonl", executor=threads, in_flight=7)
        assert [row["index"] for row in table.rows] == list(range(40))
        assert sorted(threads.asked) == list(range(40))
        assert threads.most <= 7

    def test_draws_until_enough_were_avoidable(self, tmp_path: Path) -> None:
        with Counting() as threads:
            study = Study(parameters=SHORT, avoidable=20)
            table = run_study(study, tmp_path / "a.jsonl", executor=threads, in_flight=5)
        assert table.avoidable.sum() == 20
        assert table.rows[-1]["avoiding_action"] == "brake"
        assert len(table) == 30

    def test_an_interrupted_study_repeats_nothing(self, tmp_path: Path) -> None:
        study, path = Study(parameters=SHORT, runs=30), tmp_path / "a.jsonl"
        with pytest.raises(KeyboardInterrupt), Counting(stop_after=17) as threads:
            run_study(study, path, executor=threads, in_flight=4)
        kept = stored(study, path)
        assert 8 <= len(kept) <= 17
        with Counting() as threads:
            table = run_study(study, path, executor=threads, in_flight=4)
        assert set(threads.asked) == set(range(30)) - set(kept)
        assert len(threads.asked) == 30 - len(kept)
        assert [row["index"] for row in table.rows] == list(range(30))

    def test_a_finished_study_drives_nothing_and_can_grow(self, tmp_path: Path) -> None:
        path = tmp_path / "a.jsonl"
        with Counting() as threads:
            run_study(Study(parameters=SHORT, runs=10), path, executor=threads)
            threads.asked.clear()
            run_study(Study(parameters=SHORT, runs=10), path, executor=threads)
            assert threads.asked == []
            run_study(Study(parameters=SHORT, runs=12), path, executor=threads)
            assert threads.asked == [10, 11]

    def test_progress_is_told(self, tmp_path: Path) -> None:
        told: list[tuple[int, int]] = []
        with Counting() as threads:
            study = Study(parameters=SHORT, avoidable=9)
            run_study(
                study, tmp_path / "a", executor=threads, progress=lambda *done: told.append(done)
            )  # fmt: skip
        assert told[0] == (0, 9)
        assert told[-1] == (9, 9)
        assert told == sorted(told)

    def test_an_error_in_a_run_is_not_hidden(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:  # fmt: skip
        def fails(variation: ParameterRanges, seed: int, index: int, plant: str) -> dict[str, Any]:
            if index == 3:
                raise ZeroDivisionError
            return pretend(variation, seed, index, plant)

        monkeypatch.setattr(study_module, "simulate_run", fails)
        study = Study(parameters=SHORT, runs=9)
        with pytest.raises(ZeroDivisionError), Counting() as threads:
            run_study(study, tmp_path / "a", executor=threads, in_flight=1)
        assert stored(study, tmp_path / "a") == [0, 1, 2]

    def test_bad_in_flight(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match="in_flight"):
            run_study(Study(parameters=SHORT, runs=1), tmp_path / "a", in_flight=0)

    def test_table(self, tmp_path: Path) -> None:
        with Counting() as threads:
            table = run_study(Study(parameters=SHORT, runs=24), tmp_path / "a", executor=threads)
        among = [row for row in table.rows if row["avoiding_action"]]
        rate = table.rate("driver")
        assert (rate.n_events, rate.n) == (
            sum(row["driver_collided_with"] != "" for row in among),
            len(among),
        )
        assert table.rate("v2v").n_events == 0
        assert table.rate("v2v", np.ones(24, dtype=bool)).n_events == 8
        table.write_csv(tmp_path / "t.csv")
        with (tmp_path / "t.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        assert [float(row["value"]) for row in rows] == table.column("value").tolist()
        with pytest.raises(InputError, match="name"):
            table.column("no such")
        with pytest.raises(InputError, match="ego_type"):
            table.collided("cat")


RUNS = 4
SCRIPT = f"""
import sys
from cca_core.sim.study.study import Study, run_study
from cca_core.sim.study.parameters import ParameterRanges

if __name__ == "__main__":
    study = Study(parameters=ParameterRanges(scenario="eebl", loss=(0.0, 0.3)), runs={RUNS})
    run_study(study, sys.argv[1], in_flight=2, progress=lambda done, _: print(done, flush=True))
"""


@pytest.fixture(scope="module")
def straight(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Table of a small study driven in order, in this process, without interruption."""
    folder = tmp_path_factory.mktemp("straight")
    table = run_study(Study(parameters=SHORT, runs=RUNS), folder / "a.jsonl", executor=InPlace(), in_flight=1)
    assert isinstance(table, StudyTable)
    return written(table, folder)


class InPlace(Executor):
    """Runs what it is given at once."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Any:
        from concurrent.futures import Future

        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def written(table: StudyTable, folder: Path) -> bytes:
    table.write_csv(folder / "table.csv")
    return (folder / "table.csv").read_bytes()


class TestExecutors:
    def test_processes_give_the_same_table(self, straight: bytes, tmp_path: Path) -> None:
        study = Study(parameters=SHORT, runs=RUNS)
        threads = os.environ.get("OMP_NUM_THREADS")
        assert written(run_study(study, tmp_path / "a"), tmp_path) == straight
        assert os.environ.get("OMP_NUM_THREADS") == threads

    @pytest.mark.requires("distributed")
    @pytest.mark.filterwarnings("ignore")  # of the cluster's own sockets and loops
    def test_a_cluster_gives_the_same_table(self, straight: bytes, tmp_path: Path) -> None:
        from distributed import Client, LocalCluster

        cluster = LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, processes=True,
            local_directory=str(tmp_path),
        )  # fmt: skip
        with cluster, Client(cluster) as client, client.get_executor() as executor:
            table = run_study(Study(parameters=SHORT, runs=RUNS), tmp_path / "a", executor=executor)
        assert written(table, tmp_path) == straight

    def test_killed_study_resumes_to_same_table(self, straight: bytes, tmp_path: Path) -> None:
        script, path = tmp_path / "script.py", tmp_path / "a"
        script.write_text(SCRIPT)
        command = [sys.executable, str(script), str(path)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True) as process:
            assert process.stdout is not None
            process.stdout.readline()
            assert process.stdout.readline() != ""  # a run has ended
            process.send_signal(signal.SIGKILL)
        deadline = time.monotonic() + 20.0
        while any(members(process.pid)):
            assert time.monotonic() < deadline, "the workers outlive the study"
            time.sleep(0.05)
        study = Study(parameters=SHORT, runs=RUNS)
        assert 1 <= len(stored(study, path)) <= RUNS
        assert written(run_study(study, path, executor=InPlace()), tmp_path) == straight
        assert sorted(stored(study, path)) == list(range(RUNS))


def members(session: int) -> Iterator[int]:
    """Processes of a session that still run."""
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            after_name = (folder / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(after_name[3]) == session and after_name[0] != "Z":
            yield int(folder.name)


class TestSmallStudy:
    """With messages nothing happens that could have been avoided; a driver is not so lucky."""

    @pytest.mark.parametrize("name", STUDY_SCENARIOS)
    def test_of_each_scenario(self, name: str) -> None:
        rows = (simulate_run(ParameterRanges(scenario=name), 1, i) for i in range(SMALL[name]))
        table = StudyTable(scenario=name, rows=tuple(rows))
        assert table.rate("v2v").n >= 1
        assert [row for row in table.rows if row["avoiding_action"] and row["v2v_collided_with"]] == []
        assert not any("internal error" in row["v2v_last_decision"] for row in table.rows)
        if name == "eebl":
            assert table.rate("driver").n_events >= 4


@pytest.mark.requires("matplotlib")
class TestFigure:
    def table(self) -> StudyTable:
        rng = np.random.default_rng(0)
        rows = []
        for i in range(400):
            latency, loss = rng.uniform(0.0, 0.5), rng.uniform(0.0, 0.8)
            hits = {"v2v": loss > 0.7, "driver": i % 2 == 0, "sensor": False}
            told = {f"{ego}_collided_with": "red" if hit else "" for ego, hit in hits.items()}
            rows.append({"index": i, "latency": latency, "loss": loss, "avoiding_action": "", **told})
        return StudyTable(scenario="ima", rows=tuple(rows))

    def test_lines_are_the_rates_of_their_classes(self) -> None:
        from cca_core.plot.study import plot_study

        table = self.table()
        latency, loss = plot_study([table], bins=4).axes
        assert (latency.get_xlabel(), loss.get_ylabel()) == ("latency [s]", "")
        lines = {c.get_label(): c.lines[0].get_ydata() for c in loss.containers}
        x = table.column("loss")
        edges = np.linspace(x.min(), x.max(), 5)
        last = x >= edges[3]
        assert lines["with V2V"][3] == pytest.approx(table.rate("v2v", last).value)
        assert lines["with V2V"][:3].tolist() == [0.0, 0.0, 0.0]
        assert 0.3 < lines["driver without V2V"].min() < lines["driver without V2V"].max() < 0.7
        assert lines["sensor without V2V"].tolist() == [0.0] * 4

    def test_one_value_and_small_rates(self) -> None:
        from cca_core.plot.study import plot_study

        held = tuple({**row, "latency": 0.1} for row in self.table().rows)
        figure = plot_study([StudyTable(scenario="ima", rows=held)] * 2, egos=("v2v",), log=True)
        figure.canvas.draw()
        assert len(figure.axes) == 4

    @pytest.mark.parametrize("change", [{"tables": []}, {"bins": 0}, {"egos": ("cat",)}])
    def test_bad_arguments(self, change: dict[str, Any]) -> None:
        from cca_core.plot.study import plot_study

        with pytest.raises(InputError, match=next(iter(change))):
            plot_study(**{"tables": [self.table()], **change})
