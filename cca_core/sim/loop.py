"""Closed loop: ego, plant, scripted road users, messages and sight, in fixed steps."""

import cmath
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from cca_core.errors import Status
from cca_core.follow import steady_turn
from cca_core.planner.command import Command
from cca_core.planner.planner import Planner
from cca_core.sim.human_driver import Driver
from cca_core.sim.log import Log
from cca_core.sim.plants.build import make_plant
from cca_core.sim.plants.plant import Plant
from cca_core.sim.recorder import EventRecorder
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.sim.world.perception import Perception
from cca_core.sim.world.radio import Radio
from cca_core.sim.world.tailgating import Tailgating
from cca_core.sim.world.traffic import CYCLE_TIME, Traffic
from cca_core.vehicle import RemoteVehicle, VehicleState

__all__ = ["CYCLE_TIME", "make_driver", "make_planner", "simulate"]

_LOOKS = 5  # cycles between two looks where messages tell more


class EgoController(Protocol):
    """Whoever can drive the ego: it is called once a cycle like a `Planner`."""

    def step(
        self, t: float, state: VehicleState, remotes: Iterable[RemoteVehicle], *, awareness_range: float = ...
    ) -> Command:
        """Steer and brake for one cycle.

        Parameters
        ----------
        t : float
            Time [s].
        state : VehicleState
            The ego's motion now.
        remotes : iterable of RemoteVehicle
            What is known of others.
        awareness_range : float
            Distance up to which they are all that there are [m], if less than the pilot thinks.

        Returns
        -------
        command : Command
            Steering and acceleration.
        """


def simulate(
    scenario: Scenario,
    *,
    plant: str = "single_track",
    seed: int | None = None,
    planner: EgoController | None = None,
    progress: Callable[[float], None] | None = None,
    bsm_log: Iterable[tuple[float, bytes]] = (),
    real_time: bool = False,
) -> Log:
    """Drive a scenario to its end or to the first contact.

    Parameters
    ----------
    scenario : Scenario
        What to drive.
    plant : {"single_track", "multi_body"}
        The ego's car.
    seed : int, optional
        Seed of the senders' phases and of the radio channel; the default is the scenario's.
    planner : Pilot, optional
        Who drives the ego, such as a `Planner`, a `Driver` or an `MpcPlanner`; the default is made from the
        scenario.
    progress : callable, optional
        Called with the simulated time [s] after each cycle.
    bsm_log : iterable of (float, bytes)
        Messages of other senders with the time at which each arrives at the ego [s], in order of time, such
        as a recorded log. Without V2V they are not heard.
    real_time : bool
        Whether to run against the wall clock, one cycle every 20 ms; a cycle that ends after its time is
        counted as missed. Nothing else in the log depends on it.

    Returns
    -------
    log : Log
        Every cycle; equal seeds give equal logs, bit for bit, but for the wall-clock times.

    Raises
    ------
    InputError
        If the plant is unknown.
    MissingExtraError
        If its package is not installed.
    """
    seed = scenario.seed if seed is None else seed
    pilot = planner or (make_driver(scenario) if scenario.ego_type == "driver" else make_planner(scenario))
    path = scenario.road.path
    begin = steady_turn(path, scenario.start, scenario.v_x, scenario.vehicle)
    car = make_plant(plant, scenario.vehicle, begin)
    traffic, perception = Traffic(scenario), Perception(scenario)
    radio, recorded = Radio(scenario, np.random.default_rng(seed)), list(bsm_log)[::-1]
    pinned = None if scenario.fixed_gap is None else Tailgating(scenario, scenario.fixed_gap)
    witness, book = EventRecorder(scenario), _LogBuilder(scenario)
    seen: list[bool] = []
    foot = scenario.start
    begun = time.perf_counter()
    for k in range(book.n):
        t = k * CYCLE_TIME
        state, rows = car.state, traffic.rows()
        foot, d, _, _ = path.foot_point(state.x, state.y, foot)
        if perception.needs_every_cycle or k % _LOOKS == 0:
            seen = perception.visible(rows, state)
        messages: list[bytes] = []
        if scenario.v2v or radio.is_needed:
            messages = radio.exchange(t, traffic, state, ego_sends=scenario.v2v)
        while recorded and recorded[-1][0] <= t + 1e-9:
            messages.append(recorded.pop()[1])
        remotes = perception.remotes(t, rows, seen, messages, state)
        tick = time.perf_counter()
        command = pilot.step(t, state, remotes, awareness_range=perception.awareness_range(t))
        book.cycle_us[k] = 1e6 * (time.perf_counter() - tick)
        a_x, held = command.a_x, False
        if pinned is not None and scenario.fixed_gap is not None:
            leader = traffic.by_id[scenario.fixed_gap.leader]
            a_x, held = pinned.acceleration(remotes, command, foot, state.v_x, leader), not pinned.released
        touched = _collided_with(scenario, state, rows)
        book.write(k, t, car, command, (foot, d), rows, traffic.places())
        book.seen[k], book.held[k] = seen, held
        book.hear(k, remotes, messages if scenario.v2v else [])
        witness.record(t, state, command, remotes, seen, traffic, touched, held=held)
        if progress is not None:
            progress(t)
        if real_time:
            book.missed += _is_late(begun + t + CYCLE_TIME)
        if touched:
            break
        car.step(command.delta, a_x, CYCLE_TIME)
        traffic.step(t, state)
    return book.close(plant, seed, witness, radio, time.perf_counter() - begun)


class _LogBuilder:
    """The arrays of a log while they are being filled."""

    def __init__(self, scenario: Scenario) -> None:
        n = self.n = round(scenario.duration / CYCLE_TIME) + 1
        users = len(scenario.road_users)
        self._scenario, self._end = scenario, 0
        self._index = {user.id: i for i, user in enumerate(scenario.road_users)}
        self._rows = np.empty((n, 15))
        self._others, self._places = np.empty((n, users, 6)), np.empty((n, users, 2))
        self.seen, self.heard = np.zeros((n, users), dtype=bool), np.zeros((n, users), dtype=bool)
        self._fallback, self.held = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
        self.cycle_us = np.zeros(n)
        self._received: list[tuple[int, bytes]] = []
        self.missed = 0
        self._foot, self._reference = scenario.start, scenario.road.path

    def write(
        self,
        k: int,
        t: float,
        car: Plant,
        command: Command,
        place: tuple[float, float],
        rows: Sequence[Sequence[float]],
        places: Sequence[Sequence[float]],
    ) -> None:
        state, self._end = car.state, k + 1
        if command.reference is not self._reference:
            self._reference, self._foot = command.reference, place[0]
        error = place[1]
        if self._reference is not self._scenario.road.path:
            self._foot, error, _, _ = self._reference.foot_point(state.x, state.y, self._foot)
        self._rows[k] = (
            t, state.x, state.y, state.psi, state.v_x, state.v_y, state.r, state.delta, state.a_x, car.a_y,
            command.delta, command.a_x, *place, error,
        )  # fmt: skip
        if rows:
            self._others[k], self._places[k] = rows, places
        self._fallback[k] = command.status is not Status.OK

    def hear(self, k: int, remotes: Iterable[RemoteVehicle], messages: Iterable[bytes]) -> None:
        self._received += [(k, data) for data in messages]
        for remote in remotes:
            i = self._index.get(remote.id)
            if i is not None and remote.source == "v2v":
                self.heard[k, i] = True

    def close(self, plant: str, seed: int, witness: EventRecorder, radio: Radio, wall_s: float) -> Log:
        n = self._end
        rows, others = self._rows[:n], self._others[:n]
        return Log(
            scenario=self._scenario, plant=plant, seed=seed, t=rows[:, 0], ego=rows[:, 1:9], a_y=rows[:, 9],
            command=rows[:, 10:12], ego_frenet=rows[:, 12:14], tracking=rows[:, 14], road_users=others[:, :, :4],
            user_motion=others[:, :, 4:], user_frenet=self._places[:n], visible=self.seen[:n],
            tracked=self.heard[:n], gap_held=self.held[:n], decisions=tuple(witness.decisions),
            events=tuple(witness.events), received=tuple(self._received), messages=dict(radio.counts),
            degraded=self._fallback[:n], cycle_us=self.cycle_us[:n], wall_s=wall_s, missed_deadlines=self.missed,
        )  # fmt: skip


def make_planner(scenario: Scenario, *, _leader_only: bool = False) -> Planner:
    """Planner as a scenario asks for it.

    Parameters
    ----------
    scenario : Scenario
        Vehicle, road, speeds and settings; without V2V no lane beside is known to be free.

    Returns
    -------
    planner : Planner
        A fresh planner.
    """
    evasion = scenario.evasion if scenario.v2v else replace(scenario.evasion, awareness_range=0.0)
    return Planner(
        scenario.vehicle, scenario.road, cruise_speed=scenario.cruise_speed, evasion=evasion,
        speed=scenario.speed, _leader_only=_leader_only,
    )  # fmt: skip


def make_driver(scenario: Scenario) -> Driver:
    """Driver as a scenario asks for him.

    Parameters
    ----------
    scenario : Scenario
        Vehicle, road, speeds and reaction time.

    Returns
    -------
    driver : Driver
        A fresh driver.
    """
    return Driver(
        scenario.vehicle, scenario.road, cruise_speed=scenario.cruise_speed, speed=scenario.speed,
        reaction=scenario.reaction_time,
    )  # fmt: skip


def _collided_with(scenario: Scenario, state: VehicleState, rows: Sequence[Sequence[float]]) -> str:
    """Id of who touches the ego's box, empty if nobody does (a quick look by distance first)."""
    vehicle = scenario.vehicle
    ahead = cmath.exp(1j * state.psi)
    middle = complex(*vehicle.center_at(state.x, state.y, state.psi))
    half = 0.5 * vehicle.length, 0.5 * vehicle.width
    for user, (x, y, psi, *_) in zip(scenario.road_users, rows, strict=True):
        to = complex(x, y) - middle
        if abs(to) < vehicle.length + user.length:
            other = cmath.exp(1j * psi)
            size = 0.5 * user.length, 0.5 * user.width
            if _overlaps_axis(to, ahead, half, other, size) and _overlaps_axis(-to, other, size, ahead, half):
                return user.id
    return ""


def _overlaps_axis(
    to: complex, ahead: complex, half: tuple[float, float], other: complex, size: tuple[float, float]
) -> bool:
    """Whether two boxes overlap along both axes of the first one."""
    seen, turn = to * ahead.conjugate(), other * ahead.conjugate()
    c, s = abs(turn.real), abs(turn.imag)
    along = abs(seen.real) <= half[0] + size[0] * c + size[1] * s
    return along and abs(seen.imag) <= half[1] + size[0] * s + size[1] * c


def _is_late(due: float) -> bool:
    """Wait for a moment of the wall clock; whether it had passed already."""
    left = due - time.perf_counter()
    if left > 0.0:
        time.sleep(left)
    return left < 0.0
