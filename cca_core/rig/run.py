"""Runs of scenarios through the processes of the rig, one or several at a time."""

import json
import queue
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

from cca_core._repr import short_repr
from cca_core.errors import CcaError
from cca_core.rig.bus_log import BusRecorder
from cca_core.rig.merge import measure_links, merge_log
from cca_core.rig.processes import find_scenario, scenario_id
from cca_core.rig.records import ProcessRecord, read_record
from cca_core.rig.settings import RigSettings, read_rig_settings
from cca_core.sim.log import Log
from cca_core.sim.scenarios.scenario import Scenario

__all__ = ["RigError", "RigOptions", "RigRun", "run_scenario", "run_scenarios", "start_process"]


class RigError(CcaError, RuntimeError):
    """A run of the rig has no result: a process ended early or did not start."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RigOptions:
    """How the processes of a rig run.

    Parameters
    ----------
    settings_file : pathlib.Path, optional
        TOML file of `RigSettings`; the default is a rig in software.
    number : int
        Number of the rig on this machine [-]; each has ports of its own.
    rate : float
        Seconds of the rig per second of the wall clock [-].
    plant : {"single_track", "multi_body"}
        The ego's plant.
    seed : int, optional
        Seed of the messages; the default is the scenario's.
    priority : int
        Priority of the class SCHED_FIFO [-]; 0 is the normal class.
    """

    settings_file: FilePath | None = None
    number: int = 0
    rate: float = 1.0
    plant: str = "single_track"
    seed: int | None = None
    priority: int = 0

    @property
    def settings(self) -> RigSettings:
        """Interfaces of this rig."""
        made = RigSettings() if self.settings_file is None else read_rig_settings(self.settings_file)
        return made.shifted(self.number)

    def arguments(self) -> list[str]:
        """Arguments of a process.

        Returns
        -------
        arguments : list of str
            For ``python -m cca_core.rig plant`` and ``vehicle``.
        """
        listed = [f"--number={self.number}", f"--rate={self.rate}", f"--priority={self.priority}"]
        return listed + ([] if self.settings_file is None else [f"--settings={self.settings_file}"])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RigRun:
    """One run through the processes.

    Parameters
    ----------
    log : Log
        The run, as `cca_core.sim.simulate` returns it.
    links : dict
        Latencies, as `measure_links` returns them.
    plant, vehicle : ProcessRecord
        What the processes left.
    """

    log: Log
    links: dict[str, dict[str, Any]]
    plant: ProcessRecord
    vehicle: ProcessRecord

    __repr__ = short_repr

    def summary(self) -> dict[str, Any]:
        """Key figures of the run.

        Returns
        -------
        summary : dict
            `Log.summary`, with the latencies of the links, the loops and the counters of both processes.
        """
        return self.log.summary() | {
            "links": self.links,
            "loops": {"plant": self.plant.loop, "vehicle": self.vehicle.loop},
            "refused": {"plant": self.plant.refused, "vehicle": self.vehicle.refused},
            "counts": {"plant": self.plant.counts, "vehicle": self.vehicle.counts},
        }


def start_process(
    role: str, scenario: Scenario, options: RigOptions, record: FilePath | None = None
) -> "subprocess.Popen[bytes]":
    """Start a process of the rig.

    Parameters
    ----------
    role : {"plant", "vehicle"}
        Which one.
    scenario : Scenario
        One of the paper's scenarios.
    options : RigOptions
        How it runs.
    record : pathlib.Path, optional
        File for its record.

    Returns
    -------
    process : subprocess.Popen
        The process.
    """
    command = [sys.executable, "-m", "cca_core.rig", role, scenario_id(scenario), *options.arguments()]
    if role == "plant":
        command += [f"--plant={options.plant}"] + ([] if options.seed is None else [f"--seed={options.seed}"])
    if record is not None:
        command.append(f"--record={record}")
    return subprocess.Popen(command, stdin=subprocess.DEVNULL)


def run_scenario(
    scenario: Scenario,
    options: RigOptions | None = None,
    *,
    bus_log: FilePath | None = None,
    during: Callable[["subprocess.Popen[bytes]", FilePath], object] | None = None,
) -> RigRun:
    """Drive a scenario through the processes of plant and vehicle.

    Parameters
    ----------
    scenario : Scenario
        One of the paper's scenarios.
    options : RigOptions, optional
        How the processes run.
    bus_log : pathlib.Path, optional
        File for the log of the CAN bus.
    during : callable, optional
        Called with the process of the vehicle and its record file while both run.

    Returns
    -------
    run : RigRun
        Log and measurements.

    Raises
    ------
    RigError
        If a process failed, or the vehicle never enabled the kit.
    """
    options = options or RigOptions()
    with tempfile.TemporaryDirectory() as name:
        files = {role: FilePath(name) / f"{role}.pickle" for role in ("plant", "vehicle")}
        recorder = None if bus_log is None else BusRecorder(options.settings.bus, bus_log)
        started = {role: start_process(role, scenario, options, files[role]) for role in ("vehicle", "plant")}
        try:
            if during is not None:
                during(started["vehicle"], files["vehicle"])
            started["plant"].wait((scenario.duration + 45.0) / options.rate + 30.0)
            started["vehicle"].terminate()
            started["vehicle"].wait(30.0)
        except subprocess.TimeoutExpired:
            raise RigError(f"{scenario_id(scenario)}: a process did not end") from None
        finally:
            for process in started.values():
                if process.poll() is None:
                    process.kill()
                    process.wait()
            if recorder is not None:
                recorder.close()
        records = {role: read_record(file) for role, file in files.items()}
    plant, vehicle = records["plant"], records["vehicle"]
    if plant is None or vehicle is None:
        missing = "plant" if plant is None else "vehicle"
        raise RigError(f"{scenario_id(scenario)}: the process {missing} left no record")
    return _joined(scenario, options, plant, vehicle)


def _joined(scenario: Scenario, options: RigOptions, plant: ProcessRecord, vehicle: ProcessRecord) -> RigRun:
    """Join both records."""
    plant_rows: Any = plant.rows
    vehicle_rows: Any = vehicle.rows
    if not plant_rows:
        raise RigError(f"{scenario_id(scenario)}: the vehicle did not enable the kit")
    log = merge_log(
        scenario, plant_rows, vehicle_rows, plant=options.plant, seed=options.seed,
        messages=plant.messages | vehicle.messages, missed_deadlines=int(plant.loop["missed"]),
    )  # fmt: skip
    return RigRun(log=log, links=measure_links(plant_rows, vehicle_rows), plant=plant, vehicle=vehicle)


def run_scenarios(
    names: Sequence[str],
    folder: FilePath,
    options: RigOptions | None = None,
    *,
    jobs: int = 4,
    log_ending: str = ".blf",
    progress: Callable[[str], object] | None = None,
) -> list[RigRun]:
    """Drive scenarios through several rigs at the same time.

    Parameters
    ----------
    names : sequence of str
        Names as `scenario_id` returns them.
    folder : pathlib.Path
        Folder for the bus logs.
    options : RigOptions, optional
        How the processes run; each rig gets a number of its own.
    jobs : int
        Number of rigs [-].
    log_ending : str
        Ending of the bus logs, one of `LOG_ENDINGS`.
    progress : callable, optional
        Called with the name of each scenario that is done.

    Returns
    -------
    runs : list of RigRun
        In the order of the names.

    Raises
    ------
    RigError
        If a run has no result.
    """
    options = options or RigOptions()
    free: queue.SimpleQueue[int] = queue.SimpleQueue()
    for number in range(jobs):
        free.put(options.number + number)

    def drive(name: str) -> RigRun:
        number = free.get()
        try:
            own = RigOptions(
                settings_file=options.settings_file, number=number, rate=options.rate, plant=options.plant,
                seed=options.seed, priority=options.priority,
            )  # fmt: skip
            run = run_scenario(
                find_scenario(name), own, bus_log=folder / (name.replace("/", "_") + log_ending)
            )
        finally:
            free.put(number)
        if progress is not None:
            progress(name)
        return run

    # the longest first, so that all rigs end at about the same time
    order = sorted(names, key=lambda name: -find_scenario(name).duration)
    with ThreadPoolExecutor(jobs) as pool:
        done = dict(zip(order, pool.map(drive, order), strict=True))
    return [done[name] for name in names]


def write_summary(runs: Sequence[RigRun], file: FilePath) -> None:
    """Write the key figures of runs as JSON."""
    text = json.dumps({"runs": [run.summary() for run in runs]}, indent=2)
    file.write_text(text + "\n", encoding="utf-8")
