"""One drive: the ego, its planner and the traffic around it."""

import math
import random
import time
from typing import Any

import numpy as np

from cca_core import EvasionSettings, Lane, Planner, Road, VehicleParams, fit_path
from tests.trials.boxes import box_distance, corners
from tests.trials.closed_loop.car import Car
from tests.trials.closed_loop.families import FAMILIES, MORE_FAMILIES
from tests.trials.closed_loop.geometry import Geometry
from tests.trials.closed_loop.plant import Plant
from tests.trials.closed_loop.reports import KINDS, Reports

STEP = 0.02  # of the traffic [s]
FULL_BRAKING = -7.0  # of the drive that classifies a collision [m/s^2]
LAYOUTS = {  # other lanes: side in lane widths, direction; whether a shoulder 2 m wide is on the right
    "1": ((), False),
    "1s": ((), True),
    "2o": (((1, -1),), False),
    "2os": (((1, -1),), True),
    "2s": (((1, 1),), False),
    "2o_r": (((-1, 1),), False),
    "3s": (((1, 1), (-1, 1)), False),
    "4": (((1, 1), (2, -1), (-1, 1)), False),
}
FREQUENCY = "1", "1s", "2o", "2o", "2o", "2s", "2s", "3s", "2o_r", "4", "2os"
NEEDS_OPPOSING = "oncoming_overtaker", "slow_with_oncoming"
NEEDS_ADJACENT = "cut_in", "stop_alongside", "slow_with_adjacent", "reacting"
SIZES = (4.5, 1.8), (4.5, 1.8), (18.0, 2.5), (2.0, 0.8), (12.0, 2.5)


class Episode:
    """Traffic of a family and a seed; the order of its random draws is part of the trial."""

    def __init__(self, seed: int, family: str) -> None:
        rng = self.rng = random.Random(seed)
        self.seed, self.family, self.road, self.t = seed, family, Geometry(rng), 0.0
        self.cars: list[Car] = []
        self.limit = rng.choice([14.0, 20.0, 25.0, 30.0, 36.0])
        self.lane_width = rng.choice([2.75, 3.0, 3.25, 3.5, 3.75])
        self.lanes = self._make_lanes()
        path = fit_path(np.column_stack((self.road.x, self.road.y))[::10], tolerance=0.02)
        self.car = rng.choice(
            [VehicleParams.bmw_320i(), VehicleParams.ford_escort(), VehicleParams.vw_vanagon()]
        )
        cruise_speed = self.limit * rng.uniform(0.75, 1.0)
        self.v_max = min(cruise_speed, math.sqrt(2.5 * self.road.radius) * 1.05)
        self.plant = self._make_plant()
        kind, self.jitter = rng.choice(KINDS), rng.choice([False] * 4 + [True])
        awareness_range = rng.choice([150.0, 300.0, 400.0])
        self.reports = Reports(rng, kind, awareness_range)
        (FAMILIES | MORE_FAMILIES)[family](self, rng)
        self._add_background()
        road = Road(path, self.lanes, speed_limit=self.limit)
        evasion = EvasionSettings(awareness_range=awareness_range)
        self.planner = Planner(self.car, road, cruise_speed=cruise_speed, evasion=evasion)
        self.duration = rng.uniform(20.0, 26.0)

    def _make_lanes(self) -> list[Lane]:
        """Lanes of a random layout that the family can use."""
        w, layout = self.lane_width, self.rng.choice(FREQUENCY)
        if self.family in NEEDS_OPPOSING:
            layout = self.rng.choice(["2o", "2os", "4"])
        if self.family in NEEDS_ADJACENT:
            layout = self.rng.choice(["2s", "3s", "4"])
        others, has_shoulder = LAYOUTS[layout]
        lanes = [Lane(d=0.0, width=w), *(Lane(d=side * w, width=w, direction=sign) for side, sign in others)]
        return lanes + ([Lane(d=-0.5 * w - 1.0, width=2.0)] if has_shoulder else [])

    def _make_plant(self) -> Plant:
        """The ego at its start: on its lane, off it, turned, too fast or at standstill."""
        rng = self.rng
        start = rng.choice(["normal"] * 7 + ["zero", "offlane", "heading", "fast"])
        v, d, turned = self.v_max * rng.uniform(0.8, 1.0), 0.0, 0.0
        if start == "zero":
            v = 0.0
        elif start == "offlane":
            d, turned = rng.uniform(-2.5, 2.5), rng.uniform(-0.05, 0.05)
        elif start == "heading":
            turned = rng.uniform(-0.25, 0.25)
        elif start == "fast":
            v = min(40.0, math.sqrt(6.0 * self.road.radius))
        self.s, self.d, self.v_0 = 250.0, d, v
        x, y, psi, kappa = self.road.at(self.s, d)
        return Plant(self.car, x, y, psi + turned, v, kappa * v, rng.choice([True, False, False]))

    def add(self, name: str, ahead: float, d: float, v: float, **more: Any) -> Car:
        """Put a car onto the road, `ahead` of the ego."""
        car = Car(f"{name}{len(self.cars)}", self.s + ahead, d, v, **more)
        self.cars.append(car)
        return car

    def adjacent_lane(self, direction: int) -> float:
        """Lateral offset of another lane of a direction."""
        found = [
            lane.d
            for lane in self.lanes
            if lane.direction == direction and lane.d != 0.0 and lane.width > 2.5
        ]
        return found[0] if direction < 0 else self.rng.choice(found)

    def speed(self, low: float, high: float) -> float:
        """Random speed of a car on this road."""
        return min(self.limit, math.sqrt(2.5 * self.road.radius)) * self.rng.uniform(low, high)

    def _add_background(self) -> None:
        """Add up to eight cars with sufficient distance to all others."""
        rng = self.rng
        wanted, lanes = rng.randint(0, 8), [lane for lane in self.lanes if lane.width >= 2.5]
        for _ in range(60):
            lane, ahead, v = rng.choice(lanes), rng.uniform(-120.0, 450.0), self.speed(0.6, 1.0)
            free = all(
                abs(c.s - self.s - ahead) >= 12.0 + 1.2 * max(c.v, v) or abs(c.d - lane.d) >= 2.5
                for c in self.cars
                if not c.free_pose
            )
            if wanted and free and abs(ahead) >= (60.0 if lane.d == 0.0 else 15.0):
                length, width = rng.choice(SIZES)
                size, d = (length, min(width, self.lane_width - 0.3)), lane.d + rng.uniform(-0.2, 0.2)
                self.add("bg", ahead, d, v, direction=lane.direction, size=size)
                wanted -= 1

    def following(self, car: Car) -> float:
        """Acceleration of the intelligent driver model behind the next vehicle ahead."""
        gap, v_lead = self._lead_of(car)
        v, desired = car.v, max(car.desired_speed, 0.1)
        a = 1.5 * (1.0 - (v / desired) ** 4) if v < car.desired_speed else -min(1.0, v - car.desired_speed)
        if gap < 1e3:
            want = 2.0 + max(0.0, v + v * (v - v_lead) / (2.0 * math.sqrt(1.5 * 2.5)))
            a = min(a, 1.5 * (1.0 - (v / desired) ** 4 - (want / max(gap, 0.1)) ** 2))
        return a

    def _lead_of(self, car: Car) -> tuple[float, float]:
        """Gap to the next vehicle ahead, and its speed along the car's direction."""
        gap, v_lead = math.inf, 0.0
        vehicles = [(self.s, self.d, self.car.length, self.car.width, self.plant.v)]
        vehicles += [
            (c.s, c.d, c.length, c.width, c.v * c.direction)
            for c in self.cars
            if c is not car and not c.free_pose
        ]
        for s, d, length, width, v in vehicles:
            ahead = (s - car.s) * car.direction
            if ahead > 0.0 and abs(d - car.d) < 0.5 * (width + car.width) + 0.2:
                ahead -= 0.5 * (length + car.length)
                if ahead < gap:
                    gap, v_lead = ahead, v * car.direction
        return gap, v_lead

    def collided_with(self) -> Car | None:
        """The car that the ego overlaps now."""
        c, s = math.cos(self.plant.psi), math.sin(self.plant.psi)
        x, y = self.plant.x + self.car.box_offset * c, self.plant.y + self.car.box_offset * s
        for car in self.cars:
            x_c, y_c, psi = car.pose(self.road)
            if math.hypot(x_c - x, y_c - y) < 0.5 * math.hypot(car.length, car.width) + 2.6:
                ego = corners(x, y, self.plant.psi, self.car.length, self.car.width)
                if box_distance(ego, corners(x_c, y_c, psi, car.length, car.width)) <= 0.0:
                    return car
        return None

    def full_braking(self) -> tuple[float, float]:
        """Steering along the road and full braking, of the drive that classifies a collision."""
        preview, car, state = max(4.0, 0.8 * self.plant.v), self.car, self.plant
        x, y, _, _ = self.road.at(self.s + preview, 0.0)
        angle = math.remainder(math.atan2(y - state.y, x - state.x) - state.psi, 2.0 * math.pi)
        delta = math.atan2(2.0 * car.wheelbase * math.sin(angle), math.hypot(x - state.x, y - state.y))
        return delta * (1.0 + car.understeer_gradient * state.v**2 / car.wheelbase), FULL_BRAKING

    def advance(self, delta: float, a_x: float, dt: float) -> Car | None:
        """Move everything by `dt` or until the ego collides; return the car that it collides with."""
        n = max(1, math.ceil(dt / STEP - 1e-9))
        for _ in range(n):
            for car in self.cars:
                car.step(self, dt / n)
            self.plant.step(delta, a_x, dt / n)
            self.t += dt / n
            self.s, self.d = self.road.to_frenet(self.plant.x, self.plant.y, self.s)
            other = self.collided_with()
            if other:
                return other
        return None

    def run(self, brake_from: float = math.inf) -> dict[str, Any]:
        """Drive to the end or a collision; from `brake_from` on the ego only brakes."""
        cycles, actions, stopped, command = [], set(), 0.0, None
        result: dict[str, Any] = {"seed": self.seed, "family": self.family, "collision": None}
        while self.t < self.duration and self.s < self.road.length - 300.0 and stopped < 4.0:
            remotes, state = self.reports.records(self), self.plant.state()
            if self.t < brake_from:
                begun = time.thread_time()
                command = self.planner.step(self.t, state, remotes)
                cycles.append(time.thread_time() - begun)
                delta, a_x = command.delta, command.a_x
                actions.add(command.decision.action.name)
                if not math.isfinite(delta + a_x) or "internal error" in command.decision.reason:
                    result["error"] = command.decision.reason
                    break
            else:
                delta, a_x = self.full_braking()
            dt = STEP
            if self.jitter:
                dt = self.rng.uniform(0.005, 0.2) if self.rng.random() > 0.003 else 1.0
            other = self.advance(delta, a_x, dt)
            if other:
                result["collision"] = self._describe(other)
                if command:
                    decision = command.decision
                    result["collision"] |= {"action": decision.action.name, "reason": decision.reason}
                    result["collision"]["status"] = command.status.name
                break
            stopped = stopped + dt if self.plant.v < 0.02 and self.t > 8.0 else 0.0
        return result | {"t": round(self.t, 2), "actions": sorted(actions), "cycles": cycles}

    def _describe(self, other: Car) -> dict[str, Any]:
        """Facts of a collision that has just happened."""
        v, d = round(self.plant.v, 2), round(self.d, 2)
        facts = {"t": round(self.t, 2), "with": other.id, "v": v, "v_other": round(other.v, 2), "d": d}
        return facts | {"d_other": round(other.d, 2), "first_report": other.first_report}
