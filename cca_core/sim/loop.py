"""Closed loop: planner, plant, scripted road users and messages, in fixed steps."""

import math
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.errors import Status
from cca_core.follow import steady_sideslip, steady_steering
from cca_core.geometry import box_gap, boxes
from cca_core.planner import Planner
from cca_core.sim.log import Log
from cca_core.sim.plant import SingleTrackPlant
from cca_core.sim.radio import Radio, Sight
from cca_core.sim.scenario import RoadUser, Scenario
from cca_core.vehicle import VehicleState

CYCLE = 0.02
"""Step of the closed loop [s]."""


def simulate(
    scenario: Scenario,
    *,
    seed: int = 1,
    planner: Planner | None = None,
    progress: Callable[[float], None] | None = None,
) -> Log:
    """Drive a scenario to its end or to the first contact.

    Parameters
    ----------
    scenario : Scenario
        What to drive.
    seed : int
        Seed of the senders' phases and of the radio channel.
    planner : Planner, optional
        The ego's planner; the default is made from the scenario.
    progress : callable, optional
        Called with the simulated time [s] after each cycle.

    Returns
    -------
    log : Log
        Every cycle; equal seeds give equal logs, bit for bit, but for the wall-clock times.
    """
    rng = np.random.default_rng(seed)
    planner = planner or make_planner(scenario)
    path, users = scenario.road.path, scenario.users
    plant = SingleTrackPlant(
        scenario.vehicle,
        _settled(scenario),
    )
    traffic = _Traffic(scenario)
    radio, sight = Radio(scenario, rng), Sight(scenario)
    n = round(scenario.duration / CYCLE) + 1
    rows = np.empty((n, 15))
    others, places = np.empty((n, len(users), 4)), np.empty((n, len(users), 2))
    fallback, cycle_us = np.zeros(n, dtype=bool), np.zeros(n)
    decisions: list[tuple[float, str, str]] = []
    foot, reference_foot, reference = scenario.start, scenario.start, None
    begun = time.perf_counter()
    for k in range(n):
        t = k * CYCLE
        state = plant.state
        foot, d, _, _ = path.foot_point(state.x, state.y, foot)
        others[k], places[k] = traffic.poses()
        if scenario.v2v:
            remotes = radio.receive(t, others[k], traffic.acceleration, state)
        else:
            remotes = sight.receive(others[k], traffic.acceleration, places[k], foot)
        tick = time.perf_counter()
        command = planner.step(t, state, remotes)
        cycle_us[k] = 1e6 * (time.perf_counter() - tick)
        if command.reference is not reference:
            reference, reference_foot = command.reference, foot
        reference_foot, error, _, _ = command.reference.foot_point(state.x, state.y, reference_foot)
        name = command.decision.action.value
        if not decisions or decisions[-1][1] != name:
            decisions.append((t, name, command.decision.reason))
        rows[k] = (
            t, state.x, state.y, state.psi, state.v_x, state.v_y, state.r, state.delta, state.a_x, plant.a_y,
            command.delta, command.a_x, foot, d, error,
        )  # fmt: skip
        fallback[k] = command.status is not Status.OK
        if progress is not None:
            progress(t)
        if _touching(scenario, state, others[k]):
            n = k + 1
            break
        plant.step(command.delta, command.a_x, CYCLE)
        traffic.step(foot, d, state.v_x)
    wall = time.perf_counter() - begun
    rows = rows[:n]
    return Log(
        scenario=scenario, plant=plant.name, seed=seed, t=rows[:, 0], ego=rows[:, 1:9], a_y=rows[:, 9],
        command=rows[:, 10:12], place=rows[:, 12:14], tracking=rows[:, 14], users=others[:n],
        user_places=places[:n], decisions=tuple(decisions), fallback=fallback[:n],
        cycle_us=cycle_us[:n], wall_s=wall,
    )  # fmt: skip


def _settled(scenario: Scenario) -> VehicleState:
    """Put the ego at its start, in the steady turn of the road there."""
    path, vehicle, v_x = scenario.road.path, scenario.vehicle, scenario.v_x
    x, y = path.position(scenario.start).tolist()
    kappa = path.curvature_at(scenario.start)
    beta = float(steady_sideslip(kappa, v_x, vehicle))
    return VehicleState(
        x=x, y=y, psi=float(path.heading(scenario.start)) - beta, v_x=v_x, v_y=v_x * beta, r=v_x * kappa,
        delta=float(steady_steering(kappa, v_x, vehicle)),
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
    evasion = scenario.evasion if scenario.v2v else replace(scenario.evasion, known_range=0.0)
    return Planner(
        scenario.vehicle, scenario.road, cruise_speed=scenario.cruise_speed, evasion=evasion,
        _leader_only=_leader_only,
    )  # fmt: skip


def _touching(scenario: Scenario, state: VehicleState, others: Array) -> bool:
    """Whether the ego's box touches another's (a quick look by distance first)."""
    vehicle = scenario.vehicle
    for user, (x, y, psi, _) in zip(scenario.users, others, strict=True):
        if math.hypot(x - state.x, y - state.y) < vehicle.length + user.length:
            ego = boxes(
                state.x + vehicle.box_offset * math.cos(state.psi),
                state.y + vehicle.box_offset * math.sin(state.psi),
                state.psi, vehicle.length, vehicle.width,
            )  # fmt: skip
            if box_gap(ego, boxes(x, y, psi, user.length, user.width)) <= 0.0:
                return True
    return False


class _Traffic:
    """The scripted road users' motion along the route."""

    def __init__(self, scenario: Scenario) -> None:
        self._users, self._path = scenario.users, scenario.road.path
        self._vehicle = scenario.vehicle
        self._s = np.array([u.s for u in self._users])
        self._v = np.array([u.v_x for u in self._users])
        self._d = np.array([u.d for u in self._users])
        self._direction = np.array([float(u.direction) for u in self._users])
        self._alarmed = np.full(len(self._users), math.inf)  # time since something was in the way
        self.acceleration = np.zeros(len(self._users))

    def poses(self) -> tuple[Array, Array]:
        """x, y, psi, v_x and s, d of every user."""
        centre, tangent, _ = self._path.derivatives(self._s)
        norm = np.hypot(tangent[:, 0], tangent[:, 1])
        heading = np.arctan2(tangent[:, 1], tangent[:, 0]) + np.where(self._direction > 0.0, 0.0, math.pi)
        x = centre[:, 0] - self._d * tangent[:, 1] / norm
        y = centre[:, 1] + self._d * tangent[:, 0] / norm
        return np.column_stack((x, y, heading, self._v)), np.column_stack((self._s, self._d))

    def step(self, s: float, d: float, v_x: float) -> None:
        """Move on by one cycle, given the ego's place and speed."""
        for i, user in enumerate(self._users):
            if math.isfinite(user.reaction):
                self._react(i, user, s, d, v_x)
        v = np.maximum(self._v + self.acceleration * CYCLE, 0.0)
        self._s = self._s + self._direction * 0.5 * (self._v + v) * CYCLE
        self._v = v

    def _react(self, i: int, user: RoadUser, s: float, d: float, v_x: float) -> None:
        gap = user.direction * (s - self._s[i]) - 0.5 * (user.length + self._vehicle.length)
        closing = self._v[i] - user.direction * v_x
        beside = abs(d - user.d) >= 0.5 * (user.width + self._vehicle.width)
        if gap < 0.0 or beside or closing <= 0.0 or gap > 6.0 * closing:
            self._alarmed[i] = math.inf
        elif math.isinf(self._alarmed[i]):
            self._alarmed[i] = 0.0
        else:
            self._alarmed[i] += CYCLE
        reacts = user.reaction <= self._alarmed[i] < math.inf
        self.acceleration[i] = -user.deceleration if reacts and self._v[i] > 0.0 else 0.0
