"""Closed loop at 50 Hz for the cases of `faults`: `Planner` on `SingleTrackPlant`, gaps from `boxes`."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from cca_core import (
    Command,
    EvasionSettings,
    Path,
    Planner,
    RemoteVehicle,
    Road,
    VehicleParams,
    VehicleState,
    fit_path,
)
from cca_core.sim import SingleTrackPlant
from tests.trials.boxes import ego_gap
from tests.trials.radio import Radio

CAR = VehicleParams.bmw_320i()
CYCLE = 0.02  # [s]
COLUMNS = ("t", "s", "d", "v", "a_x", "a_y", "gap", "action", "status", "reason")
World = Callable[[float, VehicleState], Sequence[RemoteVehicle]]


def remote(name: str, x: float, y: float, v_x: float = 0.0, psi: float = 0.0, **more) -> RemoteVehicle:
    """A remote vehicle."""
    return RemoteVehicle(id=name, x=x, y=y, psi=psi, v_x=v_x, **more)


def straight(length: float = 2000.0) -> Path:
    """Straight path along +x."""
    return fit_path([(x, 0.0) for x in np.arange(0.0, length + 1.0, 10.0)])


def curve(radius: float, run_in: float = 200.0, angle: float = 2.3, left: bool = True) -> Path:
    """Straight for `run_in` meters, then a circle that begins at x = 0."""
    a = np.linspace(0.0, angle, max(int(radius * angle / 4.0), 12))[1:]
    side = 1.0 if left else -1.0
    before = [(x, 0.0) for x in np.arange(-run_in, 1.0, 4.0)]
    turn = [(radius * math.sin(p), side * radius * (1.0 - math.cos(p))) for p in a]
    return fit_path(before + turn, tolerance=0.03)


def at(path: Path, name: str, s: float, d: float = 0.0, v_x: float = 0.0, **more) -> RemoteVehicle:
    """A remote vehicle at (s, d) of a path; it heads against the path if `oncoming` is true."""
    x, y = path.to_cartesian(s, d)
    psi = float(path.heading(s)) + (math.pi if more.pop("oncoming", False) else 0.0)
    return remote(name, float(x), float(y), v_x, psi, **more)


def pose_on(path: Path, s: float, v_x: float, d: float = 0.0) -> VehicleState:
    """State of an ego at (s, d) of a path, heading along it."""
    x, y = path.to_cartesian(s, d)
    return VehicleState(x=float(x), y=float(y), psi=float(path.heading(s)), v_x=v_x)


def along(v_x: float, x: float = 100.0, y: float = 0.0) -> VehicleState:
    """State of an ego that heads along +x."""
    return VehicleState(x=x, y=y, psi=0.0, v_x=v_x)


def cruise(road: Road, v: float, evasion: EvasionSettings | None = None, car: VehicleParams = CAR) -> Planner:
    """Planner of an ego with a cruise speed."""
    return Planner(car, road, cruise_speed=v, evasion=evasion)


@dataclass
class Drive:
    """A closed-loop drive: one row of `COLUMNS` for each cycle, and the last command."""

    rows: list[tuple] = field(default_factory=list)
    command: Command | None = None
    blind: bool = False  # whether the receiver reported before any collision that it is unreliable

    def column(self, name: str) -> list:
        """One quantity of all cycles."""
        i = COLUMNS.index(name)
        return [row[i] for row in self.rows]

    def minimum(self, name: str) -> float:
        """Smallest value of a quantity."""
        return min(self.column(name))

    def magnitude(self, name: str) -> float:
        """Largest magnitude of a quantity."""
        return max(map(abs, self.column(name)))

    def last(self, name: str):
        """Value at the end."""
        return self.column(name)[-1]

    @property
    def actions(self) -> list[str]:
        """Actions in their order, without repetitions."""
        names = self.column("action")
        return [name for i, name in enumerate(names) if i == 0 or name != names[i - 1]]


def drive(
    planner: Planner,
    state: VehicleState,
    world: World,
    duration: float,
    *,
    car: VehicleParams = CAR,
    radio: Radio | None = None,
    clock: Callable[[float], float] = lambda t: t,
    sensed: Callable[[float, VehicleState], VehicleState | None] = lambda t, state: state,
    reported: Callable[[float, Sequence[RemoteVehicle]], Sequence[RemoteVehicle]] = lambda t, true: true,
) -> Drive:
    """Drive until the time is over or the ego collides.

    `world` returns the true remote vehicles at a time, `reported` (or `radio`) those that the planner knows,
    `clock` the planner's time, and `sensed` the ego's state as the planner gets it.
    """
    plant, path, run = SingleTrackPlant(car, state), planner.road.path, Drive()
    s = float(path.project((state.x, state.y))[0])
    for k in range(round(duration / CYCLE)):
        t, state = k * CYCLE, plant.state
        true = list(world(t, state))
        health = None
        if radio is None:
            known = reported(t, true)
        else:
            known, health = radio.known(t, state, true), radio.health(t)
            run.blind = run.blind or not health.trusted
        command = planner.step(clock(t), sensed(t, state), known, radio=health)
        s, d, _, _ = path.foot_point(state.x, state.y, s)
        gap, decision = ego_gap(state, true, car), command.decision
        action, status = decision.action.name, command.status.name
        run.rows.append((t, s, d, state.v_x, command.a_x, plant.a_y, gap, action, status, decision.reason))
        run.command = command
        if gap <= 0.0:
            break
        plant.step(command.delta, command.a_x, CYCLE)
    return run
