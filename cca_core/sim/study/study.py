"""Studies: thousands of sampled runs on any executor, resumed where they were stopped."""

import json
import os
from collections.abc import Callable, Mapping
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import asdict, dataclass, is_dataclass
from itertools import count, islice
from pathlib import Path as FilePath
from typing import Any

from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.sim.plants.build import PLANTS, PlantMaker
from cca_core.sim.study.parameters import ParameterRanges
from cca_core.sim.study.pool import local_processes
from cca_core.sim.study.run import simulate_run
from cca_core.sim.study.source import check_definition, definition, source_digest
from cca_core.sim.study.statistics import StudyTable
from cca_core.sim.study.store import Store

# no run depends on these packages
_ABOVE = ("__main__.py", "cli", "rig", "adapters", "report", "fmi", "codegen", "plot", "baselines")


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """Runs of one scenario, of the library or of one's own, with sampled parameters.

    Parameters
    ----------
    parameters : ParameterRanges
        The scenario and the ranges of its parameters.
    seed : int
        Seed of all samples, not negative.
    runs : int, optional
        Number of runs.
    avoidable : int, optional
        Number of avoidable runs; sampling goes on until there are so many. Give this or `runs`.
    plant : str or callable
        The ego's plant: ``"single_track"``, ``"multi_body"``, or a class or function at the top level of a
        module that makes one, as in `simulate`.

    Raises
    ------
    InputError
        If a value is out of range, or not exactly one of `runs` and `avoidable` is given.
    """

    parameters: ParameterRanges
    seed: int = 1
    runs: int | None = None
    avoidable: int | None = None
    plant: str | PlantMaker = "single_track"

    __repr__ = short_repr

    def __post_init__(self) -> None:
        if (self.runs is None) == (self.avoidable is None):
            raise InputError("one of runs and avoidable must be given")
        if self.target_runs < 1:
            raise InputError(f"runs or avoidable must be at least 1, was {self.target_runs}")
        if self.seed < 0:
            raise InputError(f"seed must be at least 0, was {self.seed}")
        if not isinstance(self.plant, str):
            check_definition("plant", self.plant)
        elif self.plant not in PLANTS:
            raise InputError(f"plant must be one of {', '.join(PLANTS)}, was {self.plant!r}")

    @property
    def target_runs(self) -> int:
        """Number of runs, or of avoidable runs, that completes the study."""
        return self.runs or self.avoidable or 0

    @property
    def fingerprint(self) -> str:
        """Text of everything that a row depends on: parameters, seed, plant, and source.

        The source is that of the library, and of own functions and classes, with what they use of their
        module.
        """
        content = asdict(self)
        del content["runs"], content["avoidable"]
        if is_dataclass(self.parameters.scenario):
            content["definition"] = definition(type(self.parameters.scenario))
        content["source"] = source_digest(without=_ABOVE)
        return json.dumps(content, sort_keys=True, default=definition)

    def table(self, rows: Mapping[int | str, dict[str, Any]]) -> tuple[int, StudyTable | None]:
        """Return the progress, and the table once the study is complete.

        Parameters
        ----------
        rows : mapping
            Rows by the number of their run.

        Returns
        -------
        done : int
            Number of runs, or of avoidable runs, before the first run that is missing.
        table : StudyTable or None
            Rows in order, up to the last one that counts; None while runs are missing.
        """
        done, i = 0, 0
        while done < self.target_runs and i in rows:
            done += self.avoidable is None or rows[i]["avoiding_action"] != ""
            i += 1
        if done < self.target_runs:
            return done, None
        return done, StudyTable(scenario=self.parameters.name, rows=tuple(rows[k] for k in range(i)))


def run_study(
    study: Study,
    path: str | FilePath,
    *,
    executor: Executor | None = None,
    in_flight: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> StudyTable:
    """Simulate the runs of a study that are missing in its file.

    Parameters
    ----------
    study : Study
        The study.
    path : str or pathlib.Path
        SQLite file of all finished runs. If it exists, the study is resumed. One process writes it.
    executor : concurrent.futures.Executor, optional
        Executor of the runs; the default is one process for each processor, with one thread each.
    in_flight : int, optional
        Number of runs submitted at a time; the default is four for each processor of this machine.
    progress : callable, optional
        Called with the number of runs (or avoidable runs) done without gaps and with their target, at the
        start and whenever runs end.

    Returns
    -------
    table : StudyTable
        The same, bit for bit, whatever the executor, the order and the number of interruptions.

    Raises
    ------
    InputError
        If the file belongs to another study or to other source code, with what changed, or `in_flight` is
        not positive.

    Notes
    -----
    After an interruption or a kill, only runs that had not ended are repeated.
    """
    in_flight = 4 * (os.cpu_count() or 1) if in_flight is None else in_flight
    if in_flight < 1:
        raise InputError(f"in_flight must be at least 1, was {in_flight}")
    with Store(path, study.fingerprint) as store:
        table = _report_progress(study, store, progress)
        if table is not None:
            return table
        if executor is not None:
            return _finish(study, store, executor, in_flight, progress)
        with local_processes() as pool:
            return _finish(study, store, pool, in_flight, progress)


def _finish(
    study: Study,
    store: Store,
    executor: Executor,
    in_flight: int,
    progress: Callable[[int, int], None] | None,
) -> StudyTable:
    indices = count() if study.runs is None else range(study.runs)
    missing = (i for i in indices if i not in store.rows)
    running: set[Future[dict[str, Any]]] = set()
    try:
        while True:
            running |= {
                executor.submit(simulate_run, study.parameters, study.seed, i, study.plant)
                for i in islice(missing, in_flight - len(running))
            }
            ended, running = wait(running, return_when=FIRST_COMPLETED)
            for future in ended:
                row = future.result()
                store.add(row["index"], row)
            table = _report_progress(study, store, progress)
            if table is not None:
                return table
    finally:
        for future in running:
            future.cancel()


def _report_progress(
    study: Study, store: Store, progress: Callable[[int, int], None] | None
) -> StudyTable | None:
    done, table = study.table(store.rows)
    if progress is not None:
        progress(done, study.target_runs)
    return table
