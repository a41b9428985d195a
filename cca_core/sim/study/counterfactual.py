"""Avoidability: actions with full knowledge from the first hazard message on, without planner."""

import math
from collections.abc import Iterable, Iterator

import numpy as np

from cca_core._checks import Array
from cca_core.decide import Action, Decision
from cca_core.errors import InputError, Status
from cca_core.follow import PreviewController
from cca_core.geometry import quintic_step
from cca_core.path import Path, interpolate_path
from cca_core.planner.command import Command
from cca_core.sim.log import Log
from cca_core.sim.loop import run_loop
from cca_core.sim.plants.build import PlantMaker
from cca_core.sim.scenarios.eebl import JERK
from cca_core.sim.world.radio import sender_id
from cca_core.sim.world.traffic import CYCLE_TIME
from cca_core.v2x import decode_bsm
from cca_core.vehicle import RemoteVehicle, VehicleState


def first_hazard_cycle(log: Log) -> int | None:
    """Return the cycle in which the first message of the hazard arrived at the ego; None if none did."""
    names = {sender_id(i): user.id for i, user in enumerate(log.scenario.road_users)}
    hazard_id = log.scenario.hazard_id
    for cycle, data in log.received:
        message = decode_bsm(data)
        if names.get(message.id) == hazard_id if hazard_id else "hard_braking" in message.events:
            return cycle
    return None


def avoiding_action(
    log: Log, plant: str | PlantMaker = "single_track", *, deceleration: float = 7.0, clearance: float = 0.2
) -> str:
    """Return "brake" or "evade", the first that avoids any collision, or "" if none does."""
    # The ego repeats the log's commands until the first hazard message. Then it brakes fully along its route,
    # or evades at constant speed along a quintic that passes the hazard with the clearance [m]. Both drive in
    # the same closed loop: the same plant, messages and road users. No collision may happen until the end of
    # the run, and the ego must stay on the road.
    if not log.scenario.v2v:
        raise InputError(f"log must be of a run with messages, was of ego {log.scenario.ego_type!r}")
    cycle = first_hazard_cycle(log)
    if cycle is None:
        return ""
    if _avoids(log, plant, _ReplayThenAct(log, cycle, log.scenario.road.path, a_x=-deceleration)):
        return "brake"
    for path in _evasive_paths(log, cycle, clearance):
        if _avoids(log, plant, _ReplayThenAct(log, cycle, path, a_x=0.0)):
            return "evade"
    return ""


class _ReplayThenAct:
    """Repeats the commands of a run up to a cycle, then follows a path with an acceleration."""

    def __init__(self, log: Log, cycle: int, path: Path, *, a_x: float) -> None:
        self._commands, self._path, self._a_x_target = log.command[:cycle].tolist(), path, a_x
        # 30 m/s^2: only the tires limit it
        self._controller = PreviewController(log.scenario.vehicle, a_y_max=30.0)
        action = Action.BRAKE if a_x < 0.0 else Action.EVADE_LEFT
        self._decision = Decision(action=action, reason="counterfactual")
        self._cycle, self._a_x = 0, 0.0

    def step(
        self,
        t: float,
        state: VehicleState,
        remotes: Iterable[RemoteVehicle],
        *,
        awareness_range: float = math.inf,
    ) -> Command:
        delta = self._controller.steer(state, self._path)
        if self._cycle < len(self._commands):
            delta, self._a_x = self._commands[self._cycle]
        else:
            change = JERK * CYCLE_TIME
            self._a_x = min(max(self._a_x_target, self._a_x - change), self._a_x + change)
        self._cycle += 1
        return Command(
            delta=delta, a_x=self._a_x, decision=self._decision, band=None, reference=self._path,
            status=Status.OK,
        )  # fmt: skip


def _avoids(log: Log, plant: str | PlantMaker, controller: _ReplayThenAct) -> bool:
    """Return whether the ego neither collides nor leaves the road."""
    again = run_loop(log.scenario, plant=plant, seed=log.seed, planner=controller)
    road, half = log.scenario.road, 0.5 * log.scenario.vehicle.width
    d = again.ego_frenet[:, 1]
    on_road = bool((d >= road.right_edge + half).all() and (d <= road.left_edge - half).all())
    return on_road and not again.collided_with


def _evasive_paths(log: Log, cycle: int, clearance: float) -> Iterator[Path]:
    """Yield a path to the left and one to the right of each slower vehicle ahead on the ego's route."""
    road, car = log.scenario.road, log.scenario.vehicle
    s, v = float(log.ego_frenet[cycle, 0]), float(log.ego[cycle, 3])
    front, half = s + car.front, 0.5 * car.width
    for user, (s_user, d), (*_, v_user) in zip(
        log.scenario.road_users, log.user_frenet[cycle].tolist(), log.road_users[cycle].tolist(), strict=True
    ):
        gap, lateral = s_user - 0.5 * user.length - front, half + 0.5 * user.width
        if user.route is not None or gap <= 0.0 or v_user >= v or abs(d) >= lateral:
            continue
        for offset in (d + lateral + clearance, d - lateral - clearance):
            if road.right_edge + half <= offset <= road.left_edge - half:
                yield _shifted_path(road.path, s, gap * v / (v - v_user), offset)


def _shifted_path(path: Path, start: float, length: float, offset: float) -> Path:
    """Return a path with a quintic step to an offset, with a node every 2 m."""
    s: Array = np.arange(max(start - 20.0, path.start), path.end, 2.0)
    z = np.clip((s - start) / max(length, 1.0), 0.0, 1.0)
    return interpolate_path(path.to_cartesian(s, quintic_step(z, offset)))
