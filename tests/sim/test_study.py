"""Studies: order of rows, executors, and resuming after an interruption or a kill."""

import csv
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cca_core.sim.study.study as study_module
from cca_core.errors import InputError
from cca_core.sim import EGO_TYPES, ParameterRanges, Study, StudyTable, run_study
from cca_core.sim.study.run import simulate_run
from cca_core.sim.study.store import Store
from tests.support.sweeps import sweep

SHORT = ParameterRanges(scenario="eebl", loss=(0.0, 0.3))
SMALL = sweep(
    ("eebl", 4),
    ("ima", 2),
    ("curbside", 2),
    ("maneuver", 1),
    ("eebl", 8),
    ("ima", 5),
    ("curbside", 5),
    quick=4,
)  # runs


@pytest.mark.parametrize(
    "change",
    [{"runs": 0}, {"avoidable": 0}, {"runs": 3, "avoidable": 3}, {}, {"runs": 3, "seed": -1},
     {"runs": 3, "plant": "toy"}],
)  # fmt: skip
def test_invalid_study_raises(change: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=r"runs|seed|plant"):
        Study(parameters=SHORT, **change)


def test_fingerprint_does_not_depend_on_size() -> None:
    study = Study(parameters=SHORT, runs=3)
    assert study.fingerprint == replace(study, runs=None, avoidable=9).fingerprint
    others = [replace(study, seed=2), replace(study, parameters=ParameterRanges(scenario="eebl"))]
    assert len({study.fingerprint, *(other.fingerprint for other in others)}) == 3


def pretend(parameters: ParameterRanges, seed: int, index: int, plant: str) -> dict[str, Any]:
    """A run that takes a little time; a third of the runs is not avoidable."""
    time.sleep(0.001 * (7 * index % 5))
    means = "" if index % 3 == 1 else "brake"
    egos = {f"{ego}_collided_with": "red" if index % (3 + k) == 1 else "" for k, ego in enumerate(EGO_TYPES)}
    return {"index": index, "avoiding_action": means, "value": 0.1 * index, **egos}


class Counting(ThreadPoolExecutor):
    """Threads that count the runs in flight and stop the study after some."""

    def __init__(self, stop_after: int | None = None) -> None:
        super().__init__(3)
        self.asked: list[int] = []
        self.flying = self.max_flying = 0
        self.stop_after = stop_after

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Any:
        self.asked.append(args[2])
        if self.stop_after is not None and len(self.asked) > self.stop_after:
            raise KeyboardInterrupt
        self.flying += 1
        self.max_flying = max(self.max_flying, self.flying)
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
            table = run_study(study, tmp_path / "a.db", executor=threads, in_flight=7)
        assert [row["index"] for row in table.rows] == list(range(40))
        assert sorted(threads.asked) == list(range(40))
        assert threads.max_flying <= 7

    def test_study_samples_until_enough_are_avoidable(self, tmp_path: Path) -> None:
        with Counting() as threads:
            study = Study(parameters=SHORT, avoidable=20)
            table = run_study(study, tmp_path / "a.db", executor=threads, in_flight=5)
        assert table.avoidable.sum() == 20
        assert table.rows[-1]["avoiding_action"] == "brake"
        assert len(table) == 30

    def test_interrupted_study_repeats_nothing(self, tmp_path: Path) -> None:
        study, path = Study(parameters=SHORT, runs=30), tmp_path / "a.db"
        with pytest.raises(KeyboardInterrupt), Counting(stop_after=17) as threads:
            run_study(study, path, executor=threads, in_flight=4)
        kept = stored(study, path)
        assert 8 <= len(kept) <= 17
        with Counting() as threads:
            table = run_study(study, path, executor=threads, in_flight=4)
        assert set(threads.asked) == set(range(30)) - set(kept)
        assert len(threads.asked) == 30 - len(kept)
        assert [row["index"] for row in table.rows] == list(range(30))

    def test_finished_study_runs_nothing_and_can_grow(self, tmp_path: Path) -> None:
        path = tmp_path / "a.db"
        with Counting() as threads:
            run_study(Study(parameters=SHORT, runs=10), path, executor=threads)
            threads.asked.clear()
            run_study(Study(parameters=SHORT, runs=10), path, executor=threads)
            assert threads.asked == []
            run_study(Study(parameters=SHORT, runs=12), path, executor=threads)
            assert threads.asked == [10, 11]

    def test_progress_is_reported(self, tmp_path: Path) -> None:
        reported: list[tuple[int, int]] = []
        with Counting() as threads:
            study = Study(parameters=SHORT, avoidable=9)
            run_study(
                study, tmp_path / "a", executor=threads, progress=lambda *done: reported.append(done)
            )  # fmt: skip
        assert reported[0] == (0, 9)
        assert reported[-1] == (9, 9)
        assert reported == sorted(reported)

    def test_error_in_run_is_raised(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:  # fmt: skip
        def fails(parameters: ParameterRanges, seed: int, index: int, plant: str) -> dict[str, Any]:
            if index == 3:
                raise ZeroDivisionError
            return pretend(parameters, seed, index, plant)

        monkeypatch.setattr(study_module, "simulate_run", fails)
        study = Study(parameters=SHORT, runs=9)
        with pytest.raises(ZeroDivisionError), Counting() as threads:
            run_study(study, tmp_path / "a", executor=threads, in_flight=1)
        assert stored(study, tmp_path / "a") == [0, 1, 2]

    def test_invalid_in_flight_raises(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match="in_flight"):
            run_study(Study(parameters=SHORT, runs=1), tmp_path / "a", in_flight=0)

    def test_table_counts_avoidable_runs(self, tmp_path: Path) -> None:
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


RUNS = 3
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
    """Table of a small study, in order, in this process, without interruption."""
    folder = tmp_path_factory.mktemp("straight")
    table = run_study(
        Study(parameters=SHORT, runs=RUNS), folder / "a.db", executor=SameProcess(), in_flight=1
    )
    assert isinstance(table, StudyTable)
    return written(table, folder)


class SameProcess(Executor):
    """Executor that runs each task at once in this process."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Any:
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
    def test_cluster_gives_the_same_table(self, straight: bytes, tmp_path: Path) -> None:
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
        for _ in range(400):  # the workers notice that the study has died
            if not any(members(process.pid)):
                break
            time.sleep(0.05)
        assert list(members(process.pid)) == []
        study = Study(parameters=SHORT, runs=RUNS)
        assert 1 <= len(stored(study, path)) <= RUNS
        assert written(run_study(study, path, executor=SameProcess()), tmp_path) == straight
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
    """No avoidable run ends in a collision with V2V, some do with a driver."""

    @pytest.mark.parametrize(("name", "runs"), SMALL)
    def test_no_avoidable_collision_with_v2v(self, name: str, runs: int) -> None:
        rows = (simulate_run(ParameterRanges(scenario=name), 1, i) for i in range(runs))
        table = StudyTable(scenario=name, rows=tuple(rows))
        assert table.rate("v2v").n >= 1
        assert [row for row in table.rows if row["avoiding_action"] and row["v2v_collided_with"]] == []
        assert not table.overlapping.any()
        assert not any("internal error" in row["v2v_last_decision"] for row in table.rows)
        if name == "eebl":
            assert table.rate("driver").n_events >= runs // 2
