"""One log of a run from the records of plant and vehicle, and the latencies of its links."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cca_core.decide import Action, Decision
from cca_core.errors import InputError, Status
from cca_core.planner.command import Command
from cca_core.real_time import DurationHistogram
from cca_core.rig.messages import N_CYCLES
from cca_core.rig.records import PlantRow, VehicleRow
from cca_core.sim.log import Log
from cca_core.sim.log_builder import LogBuilder
from cca_core.sim.scenarios.road_user import RoadUser
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.sim.world.traffic import CYCLE_TIME


@dataclass(frozen=True, slots=True)
class _RecordedAgent:
    """Motion of a road user in a row."""

    user: RoadUser
    v: float
    a: float
    is_shifting: bool


class _RecordedTraffic:
    """Motion of all road users in a row."""

    def __init__(self, scenario: Scenario, row: PlantRow) -> None:
        self._row = row
        self.agents = [
            _RecordedAgent(user, motion[3], motion[4], shifting)
            for user, motion, shifting in zip(scenario.road_users, row.users, row.shifting, strict=True)
        ]

    def rows(self) -> list[tuple[float, float, float, float, float, float]]:
        """Return x, y [m], psi [rad], speed, acceleration and yaw rate of each, in SI units."""
        return [(x, y, psi, v, a, r) for x, y, psi, v, a, r in self._row.users]

    def frenet(self) -> list[tuple[float, float]]:
        """Return s, d [m] of each on the ego's route."""
        return list(self._row.frenet)


def merge_log(
    scenario: Scenario,
    plant_rows: Sequence[PlantRow],
    vehicle_rows: Sequence[VehicleRow],
    *,
    plant: str = "single_track",
    seed: int | None = None,
    messages: Mapping[str, int] | None = None,
    missed_deadlines: int = 0,
) -> Log:
    """Make the log of a run from both records.

    Parameters
    ----------
    scenario : Scenario
        Road, ego and road users.
    plant_rows : sequence of PlantRow
        Record of the plant.
    vehicle_rows : sequence of VehicleRow
        Record of the vehicle computer; a cycle without a row keeps the command before.
    plant : str
        Name of the ego's plant.
    seed : int, optional
        Seed of the run; the default is the scenario's.
    messages : mapping, optional
        Numbers of messages, as in `Log.messages`.
    missed_deadlines : int
        Number of cycles that ended late [-].

    Returns
    -------
    log : Log
        As `cca_core.sim.simulate` returns it; the report takes both.

    Raises
    ------
    InputError
        If the plant recorded nothing.
    """
    if not plant_rows:
        raise InputError("plant_rows must have a row, was empty")
    builder = LogBuilder(scenario, plant, scenario.seed if seed is None else seed)
    by_cycle = {row.cycle: row for row in vehicle_rows}
    path, s = scenario.road.path, scenario.start
    command, last = _first_command(scenario, plant_rows[0]), None
    for row in plant_rows[: builder.max_cycles]:
        answer = by_cycle.get(row.cycle)
        if answer is not None:
            command, last = answer.command, answer
        s, d, _, _ = path.foot_point(row.state.x, row.state.y, s)
        builder.write(
            (row.cycle - 1) * CYCLE_TIME, row.state, row.a_y, (s, d), command,
            _RecordedTraffic(scenario, row), () if last is None else last.remotes, row.visible,
            () if answer is None else answer.messages, collided_with=row.collided_with,
            gap_held=last is not None and last.gap_held, cycle_us=0.0 if last is None else last.cycle_us,
        )  # fmt: skip
    wall = max(plant_rows[-1].sent - plant_rows[0].sent, CYCLE_TIME)
    return builder.finish(messages or {}, wall_s=wall, missed_deadlines=missed_deadlines)


def _first_command(scenario: Scenario, row: PlantRow) -> Command:
    """Return what counts until the vehicle has answered."""
    return Command(
        delta=row.state.delta, a_x=0.0, band=None, reference=scenario.road.path, status=Status.OK,
        decision=Decision(action=Action.KEEP, reason="keeping lane: no command yet"),
    )  # fmt: skip


def measure_links(
    plant_rows: Sequence[PlantRow], vehicle_rows: Sequence[VehicleRow]
) -> dict[str, dict[str, Any]]:
    """Measure the latencies of the links.

    Parameters
    ----------
    plant_rows : sequence of PlantRow
        Record of the plant.
    vehicle_rows : sequence of VehicleRow
        Record of the vehicle computer.

    Returns
    -------
    links : dict
        For ``"state"`` (plant to vehicle), ``"planner"``, ``"command"`` (state sent to command sent) and
        ``"radio"`` (message sent to message processed): number, median, 99th percentile and maximum [us].
        For ``"commands"``: cycles, and cycles
        whose command was not there when the next one began.
    """
    sent = {row.cycle: row.sent for row in plant_rows}
    found = {name: DurationHistogram() for name in ("state", "planner", "command", "radio")}
    for row in vehicle_rows:
        if row.cycle in sent:
            found["state"].add(row.received - sent[row.cycle])
            found["command"].add(row.sent - sent[row.cycle])
        found["planner"].add(1e-6 * row.cycle_us)
    for latency in _radio_latencies(plant_rows, vehicle_rows):
        found["radio"].add(latency)
    links: dict[str, dict[str, Any]] = {
        name: {"count": histogram.count} | histogram.summary() for name, histogram in found.items()
    }
    behind = [(row.cycle - row.answered) % N_CYCLES for row in plant_rows[1:]]
    links["commands"] = {"cycles": len(plant_rows), "late": sum(each > 1 for each in behind)}
    return links


def _radio_latencies(plant_rows: Sequence[PlantRow], vehicle_rows: Sequence[VehicleRow]) -> list[float]:
    """Time from sending to processing of each message [s], by their order; none if one was lost."""
    n = np.array([row.sent_radio for row in plant_rows])
    taken = np.cumsum([len(row.messages) for row in vehicle_rows])
    if not len(taken) or taken[-1] > n[-1]:
        return []
    numbers = np.arange(1, taken[-1] + 1)
    sent = np.array([row.sent for row in plant_rows])[np.searchsorted(n, numbers)]
    received = np.array([row.received for row in vehicle_rows])[np.searchsorted(taken, numbers)]
    return [float(each) for each in received - sent]
