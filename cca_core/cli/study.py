"""``cca study``: rates of collisions over sampled runs, resumed where they were stopped."""

import argparse
import os
import sys
from dataclasses import replace
from pathlib import Path as FilePath

from cca_core.cli.progress import ProgressBar
from cca_core.cli.study_changes import describe_changes, explain_no_avoidable
from cca_core.cli.study_file import read_study
from cca_core.cli.words import counted
from cca_core.errors import InputError, MissingExtraError
from cca_core.plot import plot_study
from cca_core.sim import EGO_TYPES, ParameterRanges, Study, StudyTable, run_study
from cca_core.sim.study.pool import local_processes
from cca_core.sim.study.statistics import describe_overlapping

__all__ = ["run"]

_PATIENCE = 100  # reports of progress without an avoidable run, until a word about it


def run(given: argparse.Namespace) -> int:
    """Simulate what is missing, write and print; return the exit code."""
    study = _study(given)
    jobs = os.cpu_count() or 1 if given.jobs is None else given.jobs
    if jobs < 1:
        raise InputError(f"--jobs must be at least 1, was {jobs}")
    name = given.scenario.stem if given.scenario.suffix == ".toml" else f"study_{study.parameters.name}"
    given.out.mkdir(parents=True, exist_ok=True)
    database = given.out / f"{name}.db"
    try:
        table = _simulate(study, database, jobs)
    except InputError as error:
        changes = describe_changes(study, database)
        if not changes:
            raise
        raise InputError(
            f"{database} holds runs of another study, which changed in: {changes}; "
            "--out names another folder, where a new study begins"
        ) from error
    except KeyboardInterrupt:
        sys.stderr.write(f"the runs are in {database}; the same command continues\n")
        raise
    file = given.out / f"{name}.csv"
    table.write_csv(file)
    _print_rates(table)
    if not table.avoidable.any():
        print(f"no collision was avoidable: {explain_no_avoidable(study)}")
    if table.overlapping.any():
        print(f"{describe_overlapping(table)}: these runs mean little")
    print(f"table: {file}")
    try:
        picture = given.out / f"{name}.png"
        plot_study([table]).savefig(picture, dpi=120)
        print(f"picture: {picture}")
    except MissingExtraError as error:
        sys.stderr.write(f"no picture: {error}\n")
    return 0


def _study(given: argparse.Namespace) -> Study:
    """Return the study of a file or of a scenario's name, with what the words replace."""
    if given.scenario.suffix == ".toml":
        study = read_study(given.scenario)
    else:
        study = Study(parameters=ParameterRanges(scenario=str(given.scenario)), runs=100)
    if given.runs is not None or given.avoidable is not None:
        study = replace(study, runs=given.runs, avoidable=given.avoidable)
    changes = {name: getattr(given, name) for name in ("seed", "plant")}
    return replace(study, **{name: value for name, value in changes.items() if value is not None})


def _simulate(study: Study, database: FilePath, jobs: int) -> StudyTable:
    """Return the table of all runs; a word is said where none of many is avoidable."""
    calls = 0

    def advance(done: int, _: int) -> None:
        nonlocal calls
        calls += 1
        bar.advance(done)
        if study.avoidable and done == 0 and calls == _PATIENCE:
            sys.stderr.write(f"note: no run was avoidable so far: {explain_no_avoidable(study)}\n")

    with ProgressBar("driving", study.target_runs, "runs") as bar, local_processes(jobs) as pool:
        return run_study(study, database, executor=pool, in_flight=4 * jobs, progress=advance)


def _print_rates(table: StudyTable) -> None:
    """Print the rates of collisions of each ego type."""
    n = int(table.avoidable.sum())
    print(f"{table.scenario}: {counted(len(table), 'run')}, a collision was avoidable in {n}")
    print(f"{'ego':7} {'collided':>8} {'avoidable':>10} {'rate':>7}   95 % interval")
    for ego_type in EGO_TYPES:
        rate = table.rate(ego_type)
        interval = f"{rate.ci_low:.1%} to {rate.ci_high:.1%}" if rate.n else "unknown"
        share = f"{rate.value:.1%}" if rate.n else "-"
        collided = int(table.collided(ego_type).sum())
        print(f"{ego_type:7} {collided:8d} {rate.n_events:6d}/{rate.n:<3d} {share:>7}   {interval}")
