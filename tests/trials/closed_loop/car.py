"""Other vehicles and pedestrians."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from tests.trials.closed_loop.geometry import Geometry

if TYPE_CHECKING:
    from tests.trials.closed_loop.episode import Episode

Pose = tuple[float, float, float]
Action = Callable[["Car", "Episode"], float | None]


class Car:
    """Road user at (s, d) of the road, or crossing it on a line of its own (`free_pose`: x, y, psi)."""

    def __init__(
        self,
        name: str,
        s: float,
        d: float,
        v: float,
        direction: int = 1,
        size: tuple[float, float] = (4.5, 1.8),
        reactive: bool = True,
        free_pose: Pose | None = None,
    ) -> None:
        self.id, self.s, self.d, self.v, self.direction, self.reactive = name, s, d, v, direction, reactive
        self.length, self.width = size
        self.desired_speed, self.free_pose = v, free_pose
        self.a, self.v_d, self.d_goal, self.max_v_d, self.r = 0.0, 0.0, d, 1.2, 0.0
        self.memory: dict[str, Any] = {}  # of its action
        self.action: Action | None = None
        self.first_report: float | None = None
        self.is_visible: Callable[[Episode], bool] = lambda sim: True

    def acts(self, action: Action) -> None:
        """Decorate the function that returns the car's acceleration; None leaves it to the driver model."""
        self.action = action

    def pose(self, road: Geometry) -> Pose:
        """Position and heading of the body."""
        if self.free_pose:
            return self.free_pose
        x, y, psi, _ = road.at(self.s, self.d)
        psi += 0.0 if self.direction > 0 else math.pi
        drift = self.direction * math.atan2(self.v_d, max(self.v, 1.0)) if self.v > 0.3 else 0.0
        return x, y, psi + drift

    def step(self, sim: "Episode", dt: float) -> None:
        """Advance by the action, or else by the driver model."""
        a = self.action(self, sim) if self.action else None
        if a is None:
            a = sim.following(self) if self.reactive else self.desired_speed - self.v
        self.a = 0.0 if self.v <= 0.0 and a < 0.0 else max(-8.0, min(3.0, a))
        v = max(self.v + self.a * dt, 0.0)
        distance = 0.5 * (self.v + v) * dt
        if self.free_pose:
            x, y, psi = self.free_pose
            self.free_pose = x + distance * math.cos(psi), y + distance * math.sin(psi), psi
        else:
            kappa = sim.road.at(self.s, 0.0)[3]
            self.s += self.direction * distance / max(1.0 - self.d * kappa, 0.3)
            v_d = (self.d_goal - self.d) / max(0.6, dt)
            self.v_d = max(-self.max_v_d, min(self.max_v_d, v_d)) if self.v >= 0.3 else 0.0
            self.d += self.v_d * dt
            self.r = kappa * self.v * self.direction
        self.v = v
