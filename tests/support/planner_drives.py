"""Planner on a straight road: its vehicles, and the closed loop with scripted traffic."""

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from cca_core import Command, Lane, Path, Planner, RemoteVehicle, Road, Status, VehicleParams, VehicleState
from cca_core.decide import Rejection, RejectionKind
from cca_core.follow import SpeedSettings
from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.geometry import box_gap, boxes, quintic_step
from cca_core.planner import EvasionSettings
from cca_core.sim import SingleTrackPlant

CAR = replace(VehicleParams.bmw_320i(), length=4.5, width=1.8)
TWO_LANES = (Lane(d=0.0), Lane(d=3.5))
ALL_KNOWN = EvasionSettings(awareness_range=math.inf)
NO_ASSUMPTIONS = EvasionSettings(assumed_braking=0.0, assumed_acceleration=0.0, awareness_range=math.inf)
BLOCKED = Rejection(kind=RejectionKind.LANE_BLOCKED, side="left", vehicle_id="B", distance=9.0, value=25.0)
START = 20.0  # station of the ego [m]
CYCLE = 0.02  # [s]
MESSAGE_PERIOD = 0.1  # [s]

Reception = Callable[[float, list[RemoteVehicle]], list[RemoteVehicle]]


def straight(length: float = 1200.0) -> Path:
    return Path([0.0, length], [[[0.0, 0.0, length, 0.0], [0.0, 0.0, 0.0, 0.0]]])


TWO_LANE_ROAD = Road(straight(), TWO_LANES)


def make_planner(
    lanes: tuple[Lane, ...] | None = TWO_LANES, *, cruise: float = 20.0, **kwargs: Any
) -> Planner:
    """Planner on a straight road that knows every vehicle; `lanes=None` is a bare path."""
    road = straight() if lanes is None else Road(straight(), lanes)
    return Planner(CAR, road, cruise_speed=cruise, **({"evasion": ALL_KNOWN} | kwargs))


def ego_state(x: float = START, v_x: float = 20.0, **kwargs: float) -> VehicleState:
    return VehicleState(**({"x": x, "y": 0.0, "psi": 0.0, "v_x": v_x} | kwargs))


def car(x: float, y: float = 0.0, v_x: float = 12.0, **kwargs: Any) -> RemoteVehicle:
    return RemoteVehicle(**({"id": "R", "x": x, "y": y, "psi": 0.0, "v_x": v_x} | kwargs))


def frenet_car(gap: float, d: float, v: float, name: str = "R", **kwargs: Any) -> FrenetVehicle:
    """A car whose center is ahead of `START` by a gap."""
    remote = car(START + gap, d, v, id=name, **kwargs)
    return FrenetVehicle.from_remote(remote, START + gap, d, 0.0, 0.0)


def frenet_ego(traveled: float = 0.0, v: float = 20.0, v_target: float | None = None) -> FrenetEgo:
    """The ego beyond `START` by a distance."""
    target = v if v_target is None else v_target
    return FrenetEgo(vehicle=CAR, s=START + traveled, v_x=v, v_target=target, speed=SpeedSettings())


def assert_valid(command: Command) -> None:
    assert math.isfinite(command.delta)
    assert math.isfinite(command.a_x)
    assert abs(command.delta) <= CAR.delta_max
    assert abs(command.a_x) < 10.0
    assert command.decision.reason
    assert isinstance(command.status, Status)
    assert isinstance(command.reference, Path)


class ScriptedVehicle:
    """Vehicle on the straight road: constant lateral offset, acceleration as a function of time."""

    def __init__(
        self, id: str, gap: float, d: float, v: float, *, a: Callable[[float], float] = lambda t: 0.0,
        psi: float = 0.0, length: float = 4.5, width: float = 1.8,
    ) -> None:  # fmt: skip
        self.id, self.x, self.d, self.v, self.a = id, START + gap, d, v, a
        self.psi, self.length, self.width, self.a_x = psi, length, width, 0.0

    def record(self) -> RemoteVehicle:
        return RemoteVehicle(
            id=self.id, x=self.x, y=self.d, psi=self.psi, v_x=self.v, a_x=self.a_x, length=self.length,
            width=self.width,
        )  # fmt: skip

    def move(self, t: float) -> None:
        self.a_x = self.a(t) if self.v > 0.0 else 0.0
        v = max(self.v + self.a_x * CYCLE, 0.0)
        self.x += math.cos(self.psi) * 0.5 * (self.v + v) * CYCLE
        self.v = v


class LaneLeavingVehicle(ScriptedVehicle):
    """Moves to a lateral offset in two seconds once it is within a range of a station."""

    def __init__(self, gap: float, v: float, *, station: float, range: float, offset: float) -> None:
        super().__init__("Y", gap, 0.0, v)
        self.station, self.range, self.offset, self.z = START + station, range, offset, 0.0

    def move(self, t: float) -> None:
        super().move(t)
        if self.x > self.station - self.range:
            self.z = min(self.z + 0.5 * CYCLE, 1.0)
            self.d = quintic_step(self.z, self.offset)


class ReturningVehicle(ScriptedVehicle):
    """Comes towards the ego in the ego's lane, and changes to its own within seconds from a time on."""

    def __init__(self, gap: float, v: float, *, begin: float, speed: float = 2.0, home: float = 3.5) -> None:
        super().__init__("O", gap, 0.0, v, psi=math.pi)
        self.begin, self.speed, self.home, self.t = begin, speed, home, 0.0

    def record(self) -> RemoteVehicle:
        aside = self.speed if self.is_returning else 0.0
        return replace(super().record(), psi=math.pi - math.asin(aside / self.v))

    @property
    def is_returning(self) -> bool:
        return self.t >= self.begin and self.d < self.home

    def move(self, t: float) -> None:
        super().move(t)
        self.t = t
        if self.is_returning:
            self.d = min(self.d + self.speed * CYCLE, self.home)


class CutInVehicle(ScriptedVehicle):
    """Changes from the left lane into the ego's at a lateral speed, from a time on."""

    def __init__(self, gap: float, v: float, *, begin: float, speed: float) -> None:
        super().__init__("C", gap, 3.5, v)
        self.begin, self.speed, self.t = begin, speed, 0.0

    @property
    def is_changing(self) -> bool:
        return self.t >= self.begin and self.d > 0.0

    def record(self) -> RemoteVehicle:
        aside = self.speed if self.is_changing else 0.0
        return replace(super().record(), psi=-math.atan2(aside, self.v))

    def move(self, t: float) -> None:
        super().move(t)
        self.t = t
        if self.is_changing:
            self.d = max(self.d - self.speed * CYCLE, 0.0)


class WobblingVehicle(ScriptedVehicle):
    """Keeps its lane, and reports a heading that swings."""

    def __init__(self, gap: float, d: float, v: float, *, swing: float) -> None:
        super().__init__("S", gap, d, v)
        self.swing, self.t = swing, 0.0

    def record(self) -> RemoteVehicle:
        return replace(super().record(), psi=self.swing * math.cos(8.0 * self.t))

    def move(self, t: float) -> None:
        super().move(t)
        self.t = t


class TurningVehicle(ScriptedVehicle):
    """Comes towards the ego in the left lane, and turns to its left across the ego's lane."""

    def __init__(self, gap: float, v: float, *, radius: float, begin: float) -> None:
        super().__init__("O", gap, 3.5, v, psi=math.pi)
        self.radius, self.begin, self.r = radius, begin, 0.0

    def record(self) -> RemoteVehicle:
        return replace(super().record(), psi=math.remainder(self.psi, math.tau), r=self.r)

    def move(self, t: float) -> None:
        self.r = self.v / self.radius if t >= self.begin and self.psi < 1.5 * math.pi else 0.0
        self.psi = min(self.psi + self.r * CYCLE, 1.5 * math.pi)
        self.x += math.cos(self.psi) * self.v * CYCLE
        self.d += math.sin(self.psi) * self.v * CYCLE


class CrossingVehicle(ScriptedVehicle):
    """Crosses the road at one station, with heading 90 degrees or -90 degrees."""

    def move(self, t: float) -> None:
        self.a_x = self.a(t) if self.v > 0.0 else 0.0
        self.v = max(self.v + self.a_x * CYCLE, 0.0)
        self.d += math.sin(self.psi) * self.v * CYCLE


class ClosedLoop:
    """Closed loop on the straight road with 10 Hz messages; ends at the first collision, or when `done`."""

    def __init__(
        self, planner: Planner, traffic: Iterable[ScriptedVehicle], seconds: float, *, v: float = 20.0,
        receive: Reception = lambda t, remotes: remotes, start: float = START,
        done: Callable[[VehicleState], bool] = lambda state: False,
    ) -> None:  # fmt: skip
        self.traffic = list(traffic)
        plant = SingleTrackPlant(CAR, ego_state(start, v))
        self.v: list[float] = []
        self.x: list[float] = []
        self.y: list[float] = []
        self.a_y: list[float] = []
        self.a_x: list[float] = []
        self.commands: list[Command] = []
        self.gaps: dict[str, float] = {vehicle.id: math.inf for vehicle in self.traffic}
        self.collided_with: str | None = None
        latest: list[RemoteVehicle] = []
        cycles_per_message = round(MESSAGE_PERIOD / CYCLE)
        for k in range(round(seconds / CYCLE)):
            t, state = k * CYCLE, plant.state
            age = k % cycles_per_message * CYCLE
            if age == 0.0:
                latest = [vehicle.record() for vehicle in self.traffic]
            remotes = [replace(r, x=r.x + r.v_x * math.cos(r.psi) * age, age=age) for r in latest]
            command = planner.step(t, state, receive(t, remotes))
            assert_valid(command)
            self._write(state, plant.a_y, command)
            if self.collided_with or done(state):
                break
            plant.step(command.delta, command.a_x, CYCLE)
            for vehicle in self.traffic:
                vehicle.move(t)

    def _write(self, state: VehicleState, a_y: float, command: Command) -> None:
        self.commands.append(command)
        self.v.append(state.v_x)
        self.x.append(state.x)
        self.y.append(state.y)
        self.a_y.append(a_y)
        self.a_x.append(state.a_x)
        body = boxes(state.x, state.y, state.psi, CAR.length, CAR.width)
        for vehicle in self.traffic:
            other = boxes(vehicle.x, vehicle.d, vehicle.psi, vehicle.length, vehicle.width)
            gap = float(box_gap(body, other))
            self.gaps[vehicle.id] = min(self.gaps[vehicle.id], gap)
            if gap <= 0.0:
                self.collided_with = vehicle.id

    @property
    def actions(self) -> list[str]:
        names = [c.decision.action.name for c in self.commands]
        return [name for i, name in enumerate(names) if i == 0 or names[i - 1] != name]
