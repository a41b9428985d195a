"""A small SUMO with what the adapter asks of it: a net of named lanes, and vehicles that go straight on."""

import math
from dataclasses import dataclass, field
from typing import Any


@dataclass
class FakeVehicle:
    """A vehicle as SUMO reports it: front bumper, degrees clockwise from north."""

    x: float
    y: float
    angle: float
    speed: float
    length: float = 4.5
    width: float = 1.8
    acceleration: float = 0.0
    lane: str = "a_0"


@dataclass
class FakeLane:
    """A lane of the net; `links` are lanes ahead, with the lane within the junction and the direction."""

    shape: list[tuple[float, float]]
    links: list[tuple[str, str, str]] = field(default_factory=list)
    width: float = 3.5
    limit: float = 20.0
    allowed: tuple[str, ...] = ()

    @property
    def length(self) -> float:
        return sum(map(math.dist, self.shape, self.shape[1:]))


class FakeSumo:
    """SUMO with steps of 0.1 s; one object is the modules `vehicle`, `lane` and `simulation`."""

    def __init__(self, lanes: dict[str, FakeLane], route: list[str], cars: dict[str, FakeVehicle]) -> None:
        self.lanes, self.route, self.cars, self.time = lanes, route, cars, 0.0
        self.calls: list[tuple[Any, ...]] = []
        self.vehicle = self.lane = self.simulation = self
        self.edge = _FakeEdges(lanes)

    def simulationStep(self) -> None:  # noqa: N802
        self.time += 0.1
        for car in self.cars.values():
            psi = math.radians(90.0 - car.angle)
            car.x, car.y = (
                car.x + 0.1 * car.speed * math.cos(psi),
                car.y + 0.1 * car.speed * math.sin(psi),
            )

    def __getattr__(self, name: str) -> Any:
        if name.startswith(("set", "move")):
            return lambda *args, **kwargs: self.calls.append((name, *args, *kwargs.values()))
        read = {
            "getTime": lambda: self.time,
            "getPosition": lambda car: (self.cars[car].x, self.cars[car].y),
            "getAngle": lambda car: self.cars[car].angle,
            "getSpeed": lambda car: self.cars[car].speed,
            "getAcceleration": lambda car: self.cars[car].acceleration,
            "getLaneID": lambda car: self.cars[car].lane,
            "getRoute": lambda car: self.route,
            "getRouteIndex": lambda car: 0,
            "getVehicleClass": lambda car: "passenger",
            "getIDList": lambda: list(self.cars),
            "getLength": lambda name: (self.cars | self.lanes)[name].length,  # type: ignore[operator]
            "getWidth": lambda name: (self.cars | self.lanes)[name].width,  # type: ignore[operator]
            "getShape": lambda lane: self.lanes[lane].shape,
            "getMaxSpeed": lambda lane: self.lanes[lane].limit,
            "getAllowed": lambda lane: self.lanes[lane].allowed,
            "getDisallowed": lambda lane: (),
            "getEdgeID": lambda lane: lane.rpartition("_")[0],
            "getLinks": lambda lane: [
                (ahead, True, True, False, via, "M", direction, 0.0)
                for ahead, via, direction in self.lanes[lane].links
            ],
        }
        return read[name]


class _FakeEdges:
    """The module `edge`; the edge in the other direction is named `_back`."""

    def __init__(self, lanes: dict[str, FakeLane]) -> None:
        self._edges = [lane.rpartition("_")[0] for lane in lanes]

    def getIDList(self) -> list[str]:  # noqa: N802
        return sorted(set(self._edges))

    def getLaneNumber(self, edge: str) -> int:  # noqa: N802
        return self._edges.count(edge)

    def getFromJunction(self, edge: str) -> str:  # noqa: N802
        return f"{edge.removesuffix('_back')} {'end' if '_back' in edge else 'begin'}"

    def getToJunction(self, edge: str) -> str:  # noqa: N802
        return f"{edge.removesuffix('_back')} {'begin' if '_back' in edge else 'end'}"
