"""Plant and vehicle for minutes under SCHED_FIFO beside a bare timer loop: misses, memory, bus log.

`python -m tests.trials.rig_endurance --minutes 10 --priority 40 --log bus.blf`
"""

import argparse
import multiprocessing
import os
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np

from cca_core import Lane, Road, VehicleParams, fit_path
from cca_core.real_time import RealTimeLoop, RealTimeSettings, real_time_process
from cca_core.rig import BusRecorder, RigClock, RigOptions, read_bus_log, run_plant, run_vehicle
from cca_core.sim import RoadUser, Scenario

SPEED = 18.0  # of the lead vehicle [m/s]


def scenario(minutes: float) -> Scenario:
    """A long road on which the ego follows a lead vehicle, with oncoming traffic."""
    length = 60.0 * minutes * 20.0 + 1000.0
    x = np.arange(0.0, length, 25.0)
    path = fit_path(np.column_stack((x, 40.0 * np.sin(x / 400.0))), tolerance=0.1)
    users = [RoadUser(id="R1", s=140.0, d=0.0, v_x=SPEED)]
    users += [
        RoadUser(id=f"O{i}", s=path.end - 50.0 - 300.0 * i, d=3.5, v_x=15.0, direction=-1) for i in range(4)
    ]
    return Scenario(
        name="endurance", case=None, road=Road(path, lanes=[Lane(d=0.0), Lane(d=3.5, direction=-1)]),
        vehicle=VehicleParams.bmw_320i(), start=20.0, v_x=SPEED, cruise_speed=20.0,
        road_users=tuple(users), duration=60.0 * minutes,
    )  # fmt: skip


def memory_mb() -> float:
    """Resident memory of this process [MB]."""
    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def run(role: str, minutes: float, priority: int, stop: Any, results: Any) -> None:
    """One process: plant, vehicle or the bare loop; `stop` is a shared flag without a lock."""
    memory: list[float] = []

    def is_stopped() -> bool:
        return bool(stop.value)

    def watch() -> None:
        while not is_stopped():
            time.sleep(10.0)
            memory.append(memory_mb())

    threading.Thread(target=watch, daemon=True).start()
    settings, options = RealTimeSettings(priority=priority, lock_memory=priority > 0), RigOptions(number=90)
    if role == "bare":
        with real_time_process(settings) as refused:
            loop = RealTimeLoop(0.02)
            while not is_stopped():
                loop.wait()
        results.put((role, loop.summary(), {}, refused, memory))
        return
    drive = run_plant if role == "plant" else run_vehicle
    record = drive(
        scenario(minutes), options.settings, RigClock(), real_time=settings, is_stopped=is_stopped,
        records=False,
    )  # fmt: skip
    results.put((role, record.loop, record.counts, record.refused, memory))


def main() -> None:
    """Run all three, and print what they counted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--priority", type=int, default=40)
    parser.add_argument("--log", type=Path, default=Path("endurance.blf"))
    given = parser.parse_args()
    context = multiprocessing.get_context("spawn")
    stop, results = context.Value("b", 0, lock=False), context.Queue()
    recorder = BusRecorder(RigOptions(number=90).settings.bus, given.log)
    arguments = given.minutes, given.priority, stop, results
    processes = {
        role: context.Process(target=run, args=(role, *arguments)) for role in ("vehicle", "bare", "plant")
    }
    for process in processes.values():
        process.start()
    begin = time.monotonic()
    while time.monotonic() - begin < 60.0 * given.minutes + 90.0 and processes["plant"].is_alive():
        time.sleep(1.0)
    stop.value = 1
    for _ in processes:
        role, loop, counts, refused, memory = results.get(timeout=60.0)
        print(f"{role}: {loop}\n  refused {refused}, counts {counts}")
        if len(memory) > 6:
            print(f"  memory after a minute {memory[5]:.1f} MB, at the end {memory[-1]:.1f} MB")
    for process in processes.values():
        process.join()
    recorder.close()
    frames = [frame.id for frame in read_bus_log(given.log)]
    print(f"bus log: {len(frames)} frames, {frames.count(0x203)} states, {frames.count(0x100)} commands")


if __name__ == "__main__":
    main()
