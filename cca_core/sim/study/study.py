"""Studies: thousands of varied runs on any executor, resumed where they were stopped."""

import hashlib
import json
import os
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import asdict, dataclass
from itertools import count, islice
from pathlib import Path as FilePath
from typing import Any

from cca_core.errors import InputError
from cca_core.sim.plants.build import PLANTS
from cca_core.sim.study.parameters import ParameterRanges
from cca_core.sim.study.pool import local_processes
from cca_core.sim.study.run import simulate_run
from cca_core.sim.study.statistics import StudyTable
from cca_core.sim.study.store import StudyFile

__all__ = ["Study", "run_study"]

_NOT_DRIVEN = ("plot", "baselines")  # rooms that no run depends on


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """What is studied, and how much of it.

    Parameters
    ----------
    variation : Variation
        The scenario and what is drawn.
    seed : int
        Seed of everything.
    runs : int, optional
        Number of runs.
    avoidable : int, optional
        Instead: draw until so many runs were avoidable.
    plant : {"single_track", "multi_body"}
        The ego's car.

    Raises
    ------
    InputError
        If a value is out of range, or not just one of `runs` and `avoidable` is given.
    """

    variation: ParameterRanges
    seed: int = 1
    runs: int | None = None
    avoidable: int | None = None
    plant: str = "single_track"

    def __post_init__(self) -> None:
        if (self.runs is None) == (self.avoidable is None):
            raise InputError("one of runs and avoidable must be given")
        if self.target_runs < 1:
            raise InputError(f"runs or avoidable must be at least 1, was {self.target_runs}")
        if self.seed < 0:
            raise InputError(f"seed must be at least 0, was {self.seed}")
        if self.plant not in PLANTS:
            raise InputError(f"plant must be one of {', '.join(PLANTS)}, was {self.plant!r}")

    @property
    def target_runs(self) -> int:
        """How many runs, or avoidable runs, make it complete."""
        return self.runs or self.avoidable or 0

    @property
    def fingerprint(self) -> str:
        """Text that differs wherever a row could: what is drawn, the seed, and the library's source."""
        content = asdict(self)
        del content["runs"], content["avoidable"]
        return json.dumps({**content, "source": _source()}, sort_keys=True)

    def table(self, rows: dict[int, dict[str, Any]]) -> tuple[int, StudyTable | None]:
        """Look at what has been driven.

        Parameters
        ----------
        rows : dict
            Rows by the number of their run.

        Returns
        -------
        done : int
            How many of `wanted` there are, without gaps.
        table : StudyTable or None
            The rows in order, those beyond the last wanted one left out; None until they are complete.
        """
        done, i = 0, 0
        while done < self.target_runs and i in rows:
            done += self.avoidable is None or rows[i]["avoiding_action"] != ""
            i += 1
        if done < self.target_runs:
            return done, None
        return done, StudyTable(scenario=self.variation.scenario, rows=tuple(rows[k] for k in range(i)))


def run_study(
    study: Study,
    path: str | FilePath,
    *,
    executor: Executor | None = None,
    in_flight: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> StudyTable:
    """Drive what is left of a study.

    Parameters
    ----------
    study : Study
        What to drive.
    path : str or pathlib.Path
        File that keeps every finished run; if it exists the study is resumed. One process writes it.
    executor : concurrent.futures.Executor, optional
        What drives the runs; the default is one process for each processor, with one thread each.
    in_flight : int, optional
        How many runs are handed to it at a time; the default is four for each processor of this machine.
    progress : callable, optional
        Called with how many runs (or avoidable runs) there are without gaps, and how many are wanted, at the
        start and whenever a run ends.

    Returns
    -------
    table : StudyTable
        The same, bit for bit, whatever the executor, the order and the number of interruptions.

    Raises
    ------
    InputError
        If the file is of another study or of other source code, or `in_flight` is not positive.

    Notes
    -----
    When it is interrupted, runs that have ended stay in the file. Killed at any moment, only those runs are
    driven again that were not written yet.
    """
    most = in_flight if in_flight is not None else 4 * (os.cpu_count() or 1)
    if most < 1:
        raise InputError(f"in_flight must be at least 1, was {most}")
    with StudyFile(path, study.fingerprint) as file:
        table = _report_progress(study, file, progress)
        if table is not None:
            return table
        if executor is not None:
            return _finish(study, file, executor, most, progress)
        with local_processes() as pool:
            return _finish(study, file, pool, most, progress)


def _finish(
    study: Study,
    file: StudyFile,
    executor: Executor,
    most: int,
    progress: Callable[[int, int], None] | None,
) -> StudyTable:
    indices = count() if study.runs is None else range(study.runs)
    missing = (i for i in indices if i not in file.rows)
    flying: set[Future[dict[str, Any]]] = set()
    try:
        while True:
            flying |= {
                executor.submit(simulate_run, study.variation, study.seed, i, study.plant)
                for i in islice(missing, most - len(flying))
            }
            ended, flying = wait(flying, return_when=FIRST_COMPLETED)
            for future in ended:
                file.add(future.result())
            table = _report_progress(study, file, progress)
            if table is not None:
                return table
    finally:
        for future in flying:
            future.cancel()


def _report_progress(
    study: Study, file: StudyFile, progress: Callable[[int, int], None] | None
) -> StudyTable | None:
    done, table = study.table(file.rows)
    if progress is not None:
        progress(done, study.target_runs)
    return table


def _source() -> str:
    """Digest of all source files that a run may depend on."""
    room = FilePath(__file__).resolve().parents[2]
    digest = hashlib.sha256()
    for file in sorted(room.rglob("*.py")):
        name = file.relative_to(room)
        if name.parts[0] not in _NOT_DRIVEN:
            digest.update(name.as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()
