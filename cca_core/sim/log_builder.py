"""Log of a run of the closed loop while it is driven: decisions, events, arrays."""

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from cca_core.errors import Status
from cca_core.kernel import bind
from cca_core.kernel.box_gaps import box_gap
from cca_core.path import Path
from cca_core.planner.command import Command
from cca_core.sim.log import Log
from cca_core.sim.overlaps import Overlap, find_overlaps
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.sim.world.traffic import CYCLE_TIME, TrafficMotion
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState

_box_gap = bind(box_gap)


class EventRecorder:
    """Collect each change of action, and the first time of each event of `Log.events`."""

    def __init__(
        self, *, has_fixed_gap: bool = False, braking: float = -1.0, rest_speed: float = 0.05
    ) -> None:
        # braking [m/s^2]: beyond drag and speed control
        # rest_speed [m/s]: simulated speeds are exact, unlike reported ones, which STANDSTILL_SPEED is for
        self._has_fixed_gap, self._braking, self._rest_speed = has_fixed_gap, braking, rest_speed
        self._have_moved: set[str] = set()
        self._first: dict[tuple[str, str], float] = {}
        self.decisions: list[tuple[float, str, str]] = []
        self.reasons: list[tuple[str, str]] = []
        self.cycle_reasons: list[str] = []

    @property
    def events(self) -> list[tuple[float, str, str]]:
        """Time [s], kind and vehicle of each event, in order."""
        return [(t, kind, vehicle_id) for (kind, vehicle_id), t in self._first.items()]

    def record(
        self,
        t: float,
        state: VehicleState,
        command: Command,
        remotes: Iterable[RemoteVehicle],
        visible: Iterable[str],
        motions: Iterable[tuple[str, float, float, bool]],
        collided_with: str,
        *,
        gap_held: bool = False,
    ) -> None:
        """Record a cycle; motions are id, speed, acceleration and whether it moves laterally, in SI units."""
        decision = command.decision
        self.cycle_reasons.append(decision.reason)
        if not self.decisions or self.decisions[-1][1] != decision.action.value:
            self.decisions.append((t, decision.action.value, decision.reason))
            self.reasons.append((decision.activity or decision.reason, decision.cause))
        for vehicle_id in visible:
            self._note(t, "first_visible", vehicle_id)
        for remote in remotes:
            if remote.source == "v2v":
                self._note(t, "first_received", remote.id)
                if "hard_braking" in remote.events:
                    self._note(t, "hazard_received", remote.id)
        for vehicle_id, v, a_x, is_shifting in motions:
            if a_x <= self._braking:
                self._note(t, "brakes", vehicle_id)
            if v > self._rest_speed:
                self._have_moved.add(vehicle_id)
            elif vehicle_id in self._have_moved:
                self._note(t, "stopped", vehicle_id)
            if is_shifting:
                self._note(t, "lateral_shift", vehicle_id)
        ego = {
            "gap_released": self._has_fixed_gap and not gap_held,
            "brakes": not gap_held and command.a_x <= self._braking,
            "stopped": state.v_x <= self._rest_speed,
            "lateral_shift": decision.action.is_evading,
        }
        for kind, happened in ego.items():
            if happened:
                self._note(t, kind, "ego")
        if collided_with:
            self._note(t, "collision", collided_with)

    def _note(self, t: float, kind: str, vehicle_id: str) -> None:
        self._first.setdefault((kind, vehicle_id), t)


class TrackingError:
    """Lateral error to the reference path of each command."""

    def __init__(self, route: Path, s: float) -> None:
        self._route, self._reference, self._s = route, route, s

    def error(self, state: VehicleState, reference: Path, ego_frenet: tuple[float, float]) -> float:
        """Return the error of a cycle [m], left positive."""
        if reference is not self._reference:
            self._reference, self._s = reference, ego_frenet[0]
        if reference is self._route:
            return ego_frenet[1]
        self._s, error, _, _ = reference.foot_point(state.x, state.y, self._s)
        return error


class LogBuilder:
    """The log of a run while it is being driven; one `write` for each cycle."""

    def __init__(self, scenario: Scenario, plant: str, seed: int) -> None:
        self.max_cycles = n = round(scenario.duration / CYCLE_TIME) + 1
        n_users = len(scenario.road_users)
        self._scenario, self._plant, self._seed, self._n = scenario, plant, seed, 0
        self._user_index = {user.id: i for i, user in enumerate(scenario.road_users)}
        self._ego = np.empty((n, 15))  # columns as in `write`
        self._users, self._user_frenet = np.empty((n, n_users, 6)), np.empty((n, n_users, 2))
        self._visible, self._tracked = np.zeros((2, n, n_users), dtype=bool)
        self._degraded, self._gap_held = np.zeros((2, n), dtype=bool)
        self._cycle_us = np.zeros(n)
        self._received: list[tuple[int, bytes]] = []
        self._tracking = TrackingError(scenario.road.path, scenario.start)
        self._events = EventRecorder(has_fixed_gap=scenario.fixed_gap is not None)

    def write(
        self,
        t: float,
        state: VehicleState,
        a_y: float,
        ego_frenet: tuple[float, float],
        command: Command,
        traffic: TrafficMotion,
        remotes: Sequence[RemoteVehicle],
        visible: Sequence[bool],
        messages: Iterable[bytes],
        *,
        collided_with: str,
        gap_held: bool,
        cycle_us: float,
    ) -> None:
        """Write the next cycle."""
        k = self._n
        self._n += 1
        self._ego[k] = (
            t, state.x, state.y, state.psi, state.v_x, state.v_y, state.r, state.delta, state.a_x, a_y,
            command.delta, command.a_x, *ego_frenet,
            self._tracking.error(state, command.reference, ego_frenet),
        )  # fmt: skip
        if traffic.agents:
            self._users[k], self._user_frenet[k] = traffic.rows(), traffic.frenet()
        self._visible[k], self._gap_held[k], self._cycle_us[k] = visible, gap_held, cycle_us
        self._degraded[k] = command.status is not Status.OK
        self._received += [(k, data) for data in messages]
        for remote in remotes:
            i = self._user_index.get(remote.id)
            if i is not None and remote.source == "v2v":
                self._tracked[k, i] = True
        self._events.record(
            t, state, command, remotes,
            [user_id for user_id, is_visible in zip(self._user_index, visible, strict=True) if is_visible],
            [(agent.user.id, agent.v, agent.a, agent.is_shifting) for agent in traffic.agents],
            collided_with, gap_held=gap_held,
        )  # fmt: skip

    def finish(self, messages: Mapping[str, int], *, wall_s: float, missed_deadlines: int) -> Log:
        """Return the log of all cycles written."""
        n = self._n
        ego, users = self._ego[:n], self._users[:n]
        overlaps = find_overlaps(ego[:, 0], self._scenario.road_users, users)
        return Log(
            scenario=self._scenario, plant=self._plant, seed=self._seed,
            t=ego[:, 0], ego=ego[:, 1:9], a_y=ego[:, 9], command=ego[:, 10:12], ego_frenet=ego[:, 12:14],
            tracking=ego[:, 14], road_users=users[:, :, :4], user_motion=users[:, :, 4:],
            user_frenet=self._user_frenet[:n], visible=self._visible[:n], tracked=self._tracked[:n],
            gap_held=self._gap_held[:n], decisions=tuple(self._events.decisions),
            reasons=tuple(self._events.reasons), events=_with_overlaps(self._events.events, overlaps),
            received=tuple(self._received), messages=dict(messages),
            degraded=self._degraded[:n], cycle_us=self._cycle_us[:n], wall_s=wall_s,
            missed_deadlines=missed_deadlines, cycle_reasons=tuple(self._events.cycle_reasons),
            overlaps=overlaps,
        )  # fmt: skip


def _with_overlaps(
    events: Sequence[tuple[float, str, str]], overlaps: Sequence[Overlap]
) -> tuple[tuple[float, str, str], ...]:
    """Return events in order, with the first overlap of each road user."""
    first: dict[str, float] = {}
    for t, *ids, _ in overlaps:
        for user_id in ids:
            first.setdefault(user_id, t)
    added = [(t, "overlap", user_id) for user_id, t in first.items()]
    return tuple(sorted((*events, *added), key=lambda event: event[0]) if added else events)


def find_collision(
    vehicle: VehicleParams,
    state: VehicleState,
    bodies: Iterable[tuple[str, float, float, float, float, float]],
) -> str:
    """Return the id of a body whose box overlaps the ego's; empty if none does.

    A body is its id, x, y [m], psi [rad], length and width [m].
    """
    x, y = vehicle.center_at(state.x, state.y, state.psi)
    ego = x, y, state.psi, vehicle.length, vehicle.width
    for vehicle_id, *box in bodies:
        if math.hypot(box[0] - x, box[1] - y) < vehicle.length + box[3]:  # else certainly apart
            if not _box_gap(*ego, *box) > 0.0:
                return vehicle_id
    return ""


def bodies_of(
    scenario: Scenario, rows: Sequence[Sequence[float]]
) -> list[tuple[str, float, float, float, float, float]]:
    """Return the bodies of all road users, from their rows of x, y, psi and more."""
    return [
        (user.id, row[0], row[1], row[2], user.length, user.width)
        for user, row in zip(scenario.road_users, rows, strict=True)
    ]
