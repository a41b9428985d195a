"""Whole planners in closed loop: time, comfort, clearance and load of each drive."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cca_core.baselines.csv_rows import append_row, read_rows
from cca_core.baselines.verify import jerk_of
from cca_core.sim.log import Log
from cca_core.sim.loop import simulate
from cca_core.sim.scenarios.scenario import Scenario

__all__ = ["ClosedLoop", "drive_closed"]

_PASSED = 10.0  # ahead of the last of the others that are driven past [m]


@dataclass(frozen=True, slots=True, kw_only=True)
class ClosedLoop:
    """One drive.

    Parameters
    ----------
    planner : str
        Who drove.
    case : str
        Case of the scenario.
    completed : bool
        Whether the ego passed all vehicles that go its way ahead of it, touched nobody and ended on its lane.
    time : float
        When it was 10 m ahead of the last of them [s]; NaN if it never was.
    clearance : float
        Least distance between the bodies [m].
    a_y, jerk : float
        Largest lateral acceleration [m/s^2], and change of it within 0.1 s over this time [m/s^3].
    braking : float
        Largest deceleration [m/s^2].
    tracking : float
        Largest distance from the reference that was meant [m].
    cycle_us : float
        Mean time of a cycle of 20 ms [us].
    p99_us, worst_us : float
        Its 99th percentile and maximum [us].
    fallback : float
        Share of cycles without a valid solution [-].
    """

    planner: str
    case: str
    completed: bool
    time: float
    clearance: float
    a_y: float
    jerk: float
    braking: float
    tracking: float
    cycle_us: float
    p99_us: float
    worst_us: float
    fallback: float


def drive_closed(
    planners: Mapping[str, Callable[[Scenario], Any]],
    scenarios: Sequence[Scenario],
    *,
    out: Path | str,
    progress: Callable[[ClosedLoop], None] | None = None,
) -> list[ClosedLoop]:
    """Drive scenarios with several planners.

    Parameters
    ----------
    planners : mapping of str to callable
        Makes a planner for a scenario.
    scenarios : sequence of Scenario
        What is driven, on the single-track plant.
    out : path
        File to which each drive is added at once; those that are there already are not driven again.
    progress : callable, optional
        Called with each drive.

    Returns
    -------
    drives : list of ClosedLoop
        By scenario, then by planner.
    """
    known = {(drive.planner, drive.case): drive for drive in read_rows(out, ClosedLoop)}
    drives = []
    for scenario in scenarios:
        for name, make in planners.items():
            driven = known.get((name, str(scenario.case)))
            if driven is None:
                driven = _measured(name, simulate(scenario, planner=make(scenario)))
                append_row(out, driven)
                if progress is not None:
                    progress(driven)
            drives.append(driven)
    return drives


def _measured(name: str, log: Log) -> ClosedLoop:
    scenario = log.scenario
    ahead = [
        i for i, u in enumerate(scenario.road_users)
        if u.direction > 0 and u.s > scenario.start and u.v_x < scenario.cruise_speed
    ]  # fmt: skip
    lead = log.ego_frenet[:, 0, None] - log.user_frenet[:, ahead, 0]
    past = np.flatnonzero((lead > _PASSED).all(axis=1))
    gap = float(log.gaps().min())
    whole = log.t[-1] >= scenario.duration - 0.1
    return ClosedLoop(
        planner=name, case=str(scenario.case),
        completed=bool(len(past)) and gap > 0.0 and whole and abs(float(log.ego_frenet[-1, 1])) < 0.5,
        time=float(log.t[past[0]]) if len(past) else np.nan, clearance=gap,
        a_y=float(np.abs(log.a_y).max()), jerk=jerk_of(log.t, log.a_y),
        braking=max(0.0, -float(log.ego[:, 7].min())), tracking=float(np.abs(log.tracking).max()),
        cycle_us=float(log.cycle_us.mean()), p99_us=float(np.percentile(log.cycle_us, 99)),
        worst_us=float(log.cycle_us.max()), fallback=float(log.degraded.mean()),
    )  # fmt: skip
