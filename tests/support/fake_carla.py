"""A small CARLA: what the program of the documentation asks of it, in axes with y to the right."""

import math
from types import ModuleType
from types import SimpleNamespace as Stub
from typing import Any


class OutOfTicksError(Exception):
    """Raised by the world after its last tick."""


class Waypoint:
    """A point on a lane to the east that curves to the right."""

    lane_width = 3.5

    def __init__(self, s: float) -> None:
        self.s = s
        angle = s / 200.0
        x, y = 200.0 * math.sin(angle), 5.0 + 200.0 * (1.0 - math.cos(angle))
        self.transform = Stub(location=Stub(x=x, y=y), rotation=Stub(yaw=math.degrees(angle)))

    def next(self, distance: float) -> list["Waypoint"]:
        return [Waypoint(self.s + distance)] if self.s < 500.0 else []


class Actor:
    """A kinematic bicycle of which only a tick tells the position."""

    def __init__(self, id: int, transform: Any) -> None:
        self.id, self._start = id, transform
        self.x, self.y, self.yaw, self.v, self.a, self.turn = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        self.control: Any = None
        self.bounding_box = Stub(extent=Stub(x=2.3, y=0.9, z=0.7), location=Stub(x=0.1, y=0.0, z=0.0))

    def apply_control(self, control: Any) -> None:
        self.control = control

    def get_transform(self) -> Any:
        return Stub(location=Stub(x=self.x, y=self.y), rotation=Stub(yaw=math.degrees(self.yaw)))

    def _along(self, size: float) -> Any:
        return Stub(x=size * math.cos(self.yaw), y=size * math.sin(self.yaw), z=0.0)

    def get_velocity(self) -> Any:
        return self._along(self.v)

    def get_acceleration(self) -> Any:
        return self._along(self.a)

    def get_angular_velocity(self) -> Any:
        return Stub(x=0.0, y=0.0, z=math.degrees(self.turn))

    def tick(self, dt: float) -> None:
        if self._start is not None:
            at, self._start = self._start, None
            self.x, self.y, self.yaw = at.location.x, at.location.y, math.radians(at.rotation.yaw)
        if self.control is None:
            return
        throttle, steer, brake = self.control
        self.a = 4.0 * throttle - 8.0 * brake - 0.3
        self.turn = self.v * math.tan(math.radians(70.0 * steer)) / 2.6
        self.x, self.y = self.x + dt * self._along(self.v).x, self.y + dt * self._along(self.v).y
        self.yaw, self.v = self.yaw + dt * self.turn, max(self.v + dt * self.a, 0.0)


class World:
    """A world of the ego and a car that stands on its lane."""

    def __init__(self, ticks: int, parked_at: float) -> None:
        self.left, self.settings = ticks, Stub(synchronous_mode=False, fixed_delta_seconds=None)
        self.actors = [Actor(7, Waypoint(parked_at).transform)]

    def get_settings(self) -> Any:
        return self.settings

    def apply_settings(self, settings: Any) -> None:
        self.settings = settings

    def get_map(self) -> Any:
        start = Stub(location=Stub(x=0.0, y=5.0, z=0.0), rotation=Stub(yaw=0.0))
        return Stub(get_spawn_points=lambda: [start], get_waypoint=lambda location: Waypoint(0.0))

    def get_blueprint_library(self) -> Any:
        return Stub(find=lambda name: name)

    def spawn_actor(self, blueprint: str, transform: Any) -> Actor:
        self.actors.append(Actor(8, transform))
        return self.actors[-1]

    def get_actors(self) -> Any:
        return Stub(filter=lambda name: self.actors if name.startswith("vehicle") else [])

    def tick(self) -> None:
        if not self.left:
            raise OutOfTicksError
        self.left -= 1
        for actor in self.actors:
            actor.tick(self.settings.fixed_delta_seconds)


def fake_carla(world: World) -> ModuleType:
    """The module `carla` of a world."""
    module: Any = ModuleType("carla")
    module.Client = lambda host, port: Stub(get_world=lambda: world)
    module.VehicleControl = lambda throttle, steer, brake: (throttle, steer, brake)
    return module  # type: ignore[no-any-return]
