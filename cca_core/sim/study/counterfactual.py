"""Could a contact have been avoided? Full knowledge from the first hazard message on, and no planner."""

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
from cca_core.sim.loop import simulate
from cca_core.sim.scenarios.eebl import JERK
from cca_core.sim.world.radio import sender_id
from cca_core.sim.world.traffic import CYCLE_TIME
from cca_core.v2x import decode_bsm
from cca_core.vehicle import RemoteVehicle, VehicleState

__all__ = ["avoiding_action", "first_hazard_cycle"]

_BRAKES = 7.0  # of everybody [m/s^2]
_BESIDE = 0.2  # room that the swerve leaves [m]
_STEERING = 30.0  # what it may ask for [m/s^2]: only the tires set a limit
_NODE = 2.0  # [m]
_HAZARDS = {"ima": "red", "curbside": "red", "maneuver": "R1"}  # who is the danger; else who brakes hard


def first_hazard_cycle(log: Log) -> int | None:
    """Find the cycle in which the ego was first told of the hazard.

    Parameters
    ----------
    log : Log
        A run with messages.

    Returns
    -------
    cycle : int or None
        When the first such message was delivered, whether or not the ego made use of it; None if none was. It
        is one that announces hard braking, of whomever; in ima and curbside any of the hidden car's, in
        maneuver any of the first slow car's.
    """
    names = {sender_id(i): user.id for i, user in enumerate(log.scenario.road_users)}
    danger = _HAZARDS.get(log.scenario.name)
    for cycle, data in log.received:
        message = decode_bsm(data)
        if names.get(message.id) == danger if danger else "hard_braking" in message.events:
            return cycle
    return None


def avoiding_action(log: Log) -> str:
    """Tell what would have kept the ego from any contact.

    Parameters
    ----------
    log : Log
        A run with messages, whether or not it ended in a contact.

    Returns
    -------
    means : {"brake", "swerve", ""}
        The first that does: full braking from the cycle of `first_hazard_cycle` on, 7 m/s^2 or what the road gives,
        built up by 12.65 m/s^3 as everybody's brakes; or the least-curvature swerve from there on at constant
        speed to the lane beside. Empty if neither does, or if the ego was never told.

    Raises
    ------
    InputError
        If the run was one without messages.

    Notes
    -----
    Both are driven in the same closed loop: the same car with its true mass, friction and lags, the same
    messages, the same others, who react to the ego as they do in any run. Until the hazard message the
    commands of the log are repeated. The swerve is a quintic that ends where the ego's front reaches the
    hazard's rear, just wide enough to pass it by 0.2 m. Until the end of the run nobody may be touched and
    the road may not be left.
    """
    if not log.scenario.v2v:
        raise InputError(f"log must be of a run with messages, was of ego {log.scenario.ego_type!r}")
    cycle = first_hazard_cycle(log)
    if cycle is None:
        return ""
    if _avoids(log, _ReplayThenAct(log, cycle, log.scenario.road.path, braking=True)):
        return "brake"
    for way in _swerves(log, cycle):
        if _avoids(log, _ReplayThenAct(log, cycle, way, braking=False)):
            return "swerve"
    return ""


class _ReplayThenAct:
    """Repeats the commands of a run, then brakes fully along the route or drives a way at constant speed."""

    def __init__(self, log: Log, cycle: int, way: Path, *, braking: bool) -> None:
        car = log.scenario.vehicle
        self._commands, self._way = log.command[:cycle].tolist(), way
        self._wanted = -_BRAKES if braking else 0.0
        self._steering = PreviewController(car, a_y_max=_STEERING)
        self._decision = Decision(action=Action.BRAKE if braking else Action.EVADE_LEFT, reason="as could be")
        self._cycle, self._a_x = 0, 0.0

    def step(
        self,
        t: float,
        state: VehicleState,
        remotes: Iterable[RemoteVehicle],
        *,
        awareness_range: float = math.inf,
    ) -> Command:
        delta = self._steering.steer(state, self._way)
        if self._cycle < len(self._commands):
            delta, self._a_x = self._commands[self._cycle]
        else:
            change = JERK * CYCLE_TIME
            self._a_x = min(max(self._wanted, self._a_x - change), self._a_x + change)
        self._cycle += 1
        return Command(
            delta=delta, a_x=self._a_x, decision=self._decision, band=None, reference=self._way,
            status=Status.OK,
        )  # fmt: skip


def _avoids(log: Log, pilot: _ReplayThenAct) -> bool:
    """Whether nobody is touched, and the road not left."""
    again = simulate(log.scenario, plant=log.plant, seed=log.seed, planner=pilot)
    road, half = log.scenario.road, 0.5 * log.scenario.vehicle.width
    d = again.ego_frenet[:, 1]
    stays = bool((d >= road.right_edge + half).all() and (d <= road.left_edge - half).all())
    return stays and not again.collided_with


def _swerves(log: Log, cycle: int) -> Iterator[Path]:
    """Ways to the left and to the right of the nearest body in front that is in the ego's way."""
    road, car = log.scenario.road, log.scenario.vehicle
    s, v = float(log.ego_frenet[cycle, 0]), float(log.ego[cycle, 3])
    front, half = s + car.front, 0.5 * car.width
    for user, (at, d), (*_, v_user) in zip(
        log.scenario.road_users, log.user_frenet[cycle].tolist(), log.road_users[cycle].tolist(), strict=True
    ):
        gap, apart = at - 0.5 * user.length - front, half + 0.5 * user.width
        if user.route is not None or gap <= 0.0 or v_user >= v or abs(d) >= apart:
            continue
        for width in (d + apart + _BESIDE, d - apart - _BESIDE):
            if road.right_edge + half <= width <= road.left_edge - half:
                yield _shifted(road.path, s, gap * v / (v - v_user), width)


def _shifted(path: Path, start: float, length: float, width: float) -> Path:
    """Quintic step to the side of a path."""
    s: Array = np.arange(max(start - 20.0, path.start), path.end, _NODE)
    z = np.clip((s - start) / max(length, 1.0), 0.0, 1.0)
    return interpolate_path(path.to_cartesian(s, quintic_step(z, width)))
