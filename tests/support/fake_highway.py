"""A small highway-env with what the adapter asks of it: straight lanes, y down, named nodes."""

from types import SimpleNamespace
from typing import Any

import numpy as np

Index = tuple[str, str, int]


class FakeLane:
    """A straight lane from one point to another."""

    forbidden = False

    def __init__(
        self, start: tuple[float, float], end: tuple[float, float], speed_limit: float | None = 30.0
    ) -> None:
        self.start, along = np.array(start), np.subtract(end, start)
        self.length, self.speed_limit = float(np.hypot(*along)), speed_limit
        self.direction = along / self.length
        self.lateral = np.array([-self.direction[1], self.direction[0]])

    def position(self, s: float, d: float) -> Any:
        return self.start + s * self.direction + d * self.lateral

    def local_coordinates(self, position: Any) -> tuple[float, float]:
        away = position - self.start
        return float(away @ self.direction), float(away @ self.lateral)

    def heading_at(self, s: float) -> float:
        return float(np.arctan2(self.direction[1], self.direction[0]))

    def width_at(self, s: float) -> float:
        return 4.0


class FakeNetwork:
    """Lanes between nodes; a lane goes on in the first edge of its last node, with the same number."""

    def __init__(self, graph: dict[str, dict[str, list[FakeLane]]]) -> None:
        self.graph = graph

    def get_lane(self, index: Index) -> FakeLane:
        return self.graph[index[0]][index[1]][index[2]]

    def next_lane(self, index: Index, route: list[Index], position: Any) -> Index:
        _, node, i = index
        if node not in self.graph:
            return index
        after = next(iter(self.graph[node]))
        return node, after, min(i, len(self.graph[node][after]) - 1)


def fake_vehicle(x: float, y: float, heading: float = 0.0, speed: float = 20.0, **more: Any) -> Any:
    """A vehicle as highway-env has it."""
    own = {"LENGTH": 5.0, "WIDTH": 2.0, "solid": True, "action": {"steering": 0.0, "acceleration": 0.0}}
    return SimpleNamespace(position=np.array([x, y]), heading=heading, speed=speed, **(own | more))


def fake_env(graph: dict[str, dict[str, list[FakeLane]]], ego: Any, index: Index, *others: Any) -> Any:
    """An environment with an ego on a lane, at a frequency of 15 Hz."""
    ego.lane_index = index
    road = SimpleNamespace(network=FakeNetwork(graph), vehicles=[ego, *others], objects=[])
    action = SimpleNamespace(acceleration_range=(-8.0, 8.0), steering_range=(-0.5, 0.5), size=2)
    config = {"policy_frequency": 15, "simulation_frequency": 15}
    world = SimpleNamespace(vehicle=ego, road=road, action_type=action, config=config, steps=30)
    return SimpleNamespace(unwrapped=world)
