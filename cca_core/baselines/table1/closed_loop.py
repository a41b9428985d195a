"""Whole planners in closed loop: time, comfort, clearance and computing time of each drive."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from cca_core._checks import Array
from cca_core.baselines.problems.kept_row import kept_row
from cca_core.baselines.problems.verify import max_jerk
from cca_core.planner.command import Command
from cca_core.sim.log import Log
from cca_core.sim.loop import EgoController, simulate
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.sim.study.store import Store


@dataclass(frozen=True, slots=True, kw_only=True)
class ClosedLoop:
    """One drive of a planner."""

    planner: str
    case: str  # of the scenario
    completed: bool  # all slower vehicles passed without a collision, and back in the ego lane at the end
    time: float  # when the ego is 10 m ahead of the last of them [s]; NaN if it never is
    clearance: float  # smallest distance between the bodies [m]
    a_y: float  # largest absolute lateral acceleration [m/s^2]
    jerk: float  # largest change of it within 0.1 s [m/s^3]
    braking: float  # largest deceleration [m/s^2]
    tracking: float  # largest distance from the reference path [m]
    cycle_us: float  # mean processor time of a cycle of 20 ms [us]
    p99_us: float  # its 99th percentile
    worst_us: float
    degraded: float  # fraction of cycles without a valid solution [-]


def drive_closed(
    planners: Mapping[str, Callable[[Scenario], Any]],
    scenarios: Sequence[Scenario],
    *,
    store: Store | None = None,
    progress: Callable[[ClosedLoop], None] | None = None,
) -> list[ClosedLoop]:
    """Drive each scenario with each planner, on the single-track plant, unless the store holds the drive."""
    return [
        kept_row(
            store, ("drive", name, scenario.case), ClosedLoop,
            partial(_driven, name, make, scenario), progress,
        )
        for scenario in scenarios
        for name, make in planners.items()
    ]  # fmt: skip


def _driven(name: str, make: Callable[[Scenario], Any], scenario: Scenario) -> ClosedLoop:
    """Drive a scenario and measure the log."""
    controller = _TimedController(make(scenario))
    return _measured(name, simulate(scenario, planner=controller), np.array(controller.times_us))


class _TimedController:
    """A controller with the processor times of its cycles: a busy machine does not change them much."""

    def __init__(self, controller: EgoController) -> None:
        self._controller, self.times_us = controller, list[float]()

    def step(self, *arguments: Any, **named: Any) -> Command:
        begun = time.process_time()
        command = self._controller.step(*arguments, **named)
        self.times_us.append(1e6 * (time.process_time() - begun))
        return command


def _measured(name: str, log: Log, cycle_us: Array) -> ClosedLoop:
    """Figures of a log."""
    scenario = log.scenario
    slower = [
        i for i, user in enumerate(scenario.road_users)
        if user.direction > 0 and user.s > scenario.start and user.v_x < scenario.cruise_speed
    ]  # fmt: skip
    lead_distance = log.ego_frenet[:, 0, None] - log.user_frenet[:, slower, 0]
    passed = np.flatnonzero((lead_distance > 10.0).all(axis=1))
    gap = float(log.gaps().min())
    whole = log.t[-1] >= scenario.duration - 0.1
    return ClosedLoop(
        planner=name, case=str(scenario.case),
        completed=bool(len(passed)) and gap > 0.0 and whole and abs(float(log.ego_frenet[-1, 1])) < 0.5,
        time=float(log.t[passed[0]]) if len(passed) else np.nan, clearance=gap,
        a_y=float(np.abs(log.a_y).max()), jerk=max_jerk(log.t, log.a_y),
        braking=max(0.0, -float(log.ego[:, 7].min())), tracking=float(np.abs(log.tracking).max()),
        cycle_us=float(cycle_us.mean()), p99_us=float(np.percentile(cycle_us, 99)),
        worst_us=float(cycle_us.max()), degraded=float(log.degraded.mean()),
    )  # fmt: skip
