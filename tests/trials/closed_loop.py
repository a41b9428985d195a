"""Random traffic around one ego, independent of the library's own simulation.

Measures contacts, by family of traffic, and the CPU time of a cycle. Roads, cars, the ego's plant (kinematic or
dynamic) and the contact check are this file's own; the library gives path, road and planner alone. Others are
told perfectly, noisily, late, with gaps or under changing ids. Run
``python closed_loop.py --seeds 0:200 [--family cut_in] [--json FILE]``. Equal seeds give equal drives; the family
of a seed is that of its number unless one is named. A contact is "standing" if the ego stood and was run into,
"avoidable" if the same drive with full braking from the first observation of that vehicle has no contact ("in 1 s":
even if it brakes only 1 s before), and "other" else.
"""

# fmt: off

import argparse
import json
import math
import os
import random
import time
from collections import Counter, defaultdict

os.environ.update({name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")})

import numpy as np

from cca_core import (
    EvasionSettings,
    Lane,
    Planner,
    RemoteVehicle,
    Road,
    VehicleParams,
    VehicleState,
    fit_path,
)
from tests.trials.driving import box_distance, corners

G = 9.81
STEP = 0.02  # of the traffic [s]
BRAKE = -7.0  # of the drive that classifies [m/s^2]
LAYOUTS = {  # other lanes: side in lane widths, direction, whether a shoulder 2 m wide is on the right
    "1": ((), False), "1s": ((), True), "2o": (((1, -1),), False), "2os": (((1, -1),), True),
    "2s": (((1, 1),), False), "2o_r": (((-1, 1),), False), "3s": (((1, 1), (-1, 1)), False),
    "4": (((1, 1), (2, -1), (-1, 1)), False),
}


class Geometry:
    """Straight or winding road, sampled every half meter."""

    ds, length = 0.5, 2000.0

    def __init__(self, rng: random.Random) -> None:
        n = int(self.length / self.ds) + 1
        self.kappa, self.radius = np.zeros(n), math.inf
        if rng.random() < 0.5:
            self.radius = math.exp(rng.uniform(math.log(80.0), math.log(500.0)))
            i, sign = 0, rng.choice([-1, 1])
            while i < n:
                radius = self.radius * rng.uniform(1.0, 1.6)
                arc, line = rng.uniform(0.5, 1.3) * radius, rng.uniform(0.0, 150.0)
                j = i + int(line / self.ds)
                i = j + int(arc / self.ds)
                self.kappa[j:i] = sign / radius
                sign = -sign if rng.random() < 0.8 else sign
            window = int(30.0 / self.ds)
            self.kappa = np.convolve(self.kappa, np.ones(window) / window, mode="same")
        self.psi = np.concatenate(([0.0], np.cumsum(0.5 * (self.kappa[1:] + self.kappa[:-1])) * self.ds))
        middle = 0.5 * (self.psi[1:] + self.psi[:-1])
        self.x = np.concatenate(([0.0], np.cumsum(np.cos(middle)) * self.ds))
        self.y = np.concatenate(([0.0], np.cumsum(np.sin(middle)) * self.ds))

    def at(self, s: float, d: float) -> tuple[float, float, float, float]:
        """Position, heading and curvature at place (s, d)."""
        u = s / self.ds
        i = min(max(int(u), 0), len(self.x) - 2)
        f = u - i
        psi = self.psi[i] + min(max(f, 0.0), 1.0) * (self.psi[i + 1] - self.psi[i])
        x = self.x[i] + f * (self.x[i + 1] - self.x[i]) - d * math.sin(psi)
        y = self.y[i] + f * (self.y[i + 1] - self.y[i]) + d * math.cos(psi)
        return float(x), float(y), float(psi), float(self.kappa[i])

    def place(self, x: float, y: float, s: float) -> tuple[float, float]:
        """Place (s, d) of a point, searched from s on."""
        for _ in range(6):
            x_0, y_0, psi, kappa = self.at(s, 0.0)
            along = (x - x_0) * math.cos(psi) + (y - y_0) * math.sin(psi)
            d = (y - y_0) * math.cos(psi) - (x - x_0) * math.sin(psi)
            s += along / max(1.0 - kappa * d, 0.3)
            if abs(along) < 1e-4:
                break
        return s, d


class Plant:
    """Single track on saturating tires, or kinematic; below 4 m/s always kinematic."""

    def __init__(self, car: VehicleParams, x: float, y: float, psi: float, v: float, r: float, kinematic: bool) -> None:
        self.car, self.kinematic = car, kinematic
        self.x, self.y, self.psi, self.v, self.v_y, self.r, self.delta, self.a = x, y, psi, v, 0.0, r, 0.0, 0.0

    def state(self) -> VehicleState:
        """As the planner takes it."""
        return VehicleState(
            x=self.x, y=self.y, psi=self.psi, v_x=self.v, v_y=self.v_y, r=self.r, delta=self.delta, a_x=self.a
        )

    def step(self, delta: float, a_x: float, dt: float) -> None:
        """Drive on."""
        n = max(1, math.ceil(dt / 0.005 - 1e-9))
        h, p = dt / n, self.car
        grip = p.mu * G
        for _ in range(n):
            rate = (max(-p.delta_max, min(p.delta_max, delta)) - self.delta) / max(p.steering_lag, 1e-3)
            self.delta += max(-p.delta_rate_max, min(p.delta_rate_max, rate)) * h
            self.a += (a_x - self.a) * min(1.0, h / 0.05)
            a = max(-grip, min(self.a, grip))
            v, v_y, r, psi = self.v, self.v_y, self.r, self.psi
            if v <= 0.0 and a < 0.0:
                a = v = 0.0
            if self.kinematic or v < 4.0:
                slip = math.atan(p.l_r / p.wheelbase * math.tan(self.delta))
                turn = v * math.cos(slip) * math.tan(self.delta) / p.wheelbase
                turn = math.copysign(grip / v, turn) if abs(v * turn) > grip else turn
                r += (turn - r) * min(1.0, h / 0.05)
                v_y += (v * math.tan(slip) - v_y) * min(1.0, h / 0.05)
            else:
                left = math.sqrt(max(1.0 - (a / grip) ** 2, 0.01)) * grip * p.m / p.wheelbase
                front, rear = left * p.l_r, left * p.l_f
                f_f = front * math.tanh(p.C_f * (self.delta - math.atan2(v_y + p.l_f * r, v)) / front)
                f_r = rear * math.tanh(-p.C_r * math.atan2(v_y - p.l_r * r, v) / rear)
                v_y += ((f_f * math.cos(self.delta) + f_r) / p.m - v * r) * h
                r += (p.l_f * f_f * math.cos(self.delta) - p.l_r * f_r) / p.I_z * h
            self.x += (v * math.cos(psi) - v_y * math.sin(psi)) * h
            self.y += (v * math.sin(psi) + v_y * math.cos(psi)) * h
            self.psi, self.v, self.v_y, self.r = psi + r * h, max(v + a * h, 0.0), v_y, r


class Car:
    """Another road user, on the road at (s, d) or, crossing, on a line of its own (`free`: x, y, psi)."""

    def __init__(self, name, s, d, v, dirn=1, size=(4.5, 1.8), reactive=True, free=None) -> None:
        self.id, self.s, self.d, self.v, self.dir, self.wished, self.reactive = name, s, d, v, dirn, v, reactive
        self.length, self.width = size
        self.free, self.a, self.sideways, self.goal, self.lateral, self.r = free, 0.0, 0.0, d, 1.2, 0.0
        self.memo: dict = {}
        self.acts = self.seen = None
        self.visible = lambda sim: True

    def does(self, acts) -> None:
        """Decorate the function that gives its acceleration; None leaves it to the driver model."""
        self.acts = acts

    def pose(self, road: Geometry) -> tuple[float, float, float]:
        """Position and heading of the body."""
        if self.free:
            return self.free
        x, y, psi, _ = road.at(self.s, self.d)
        psi += 0.0 if self.dir > 0 else math.pi
        return x, y, psi + (self.dir * math.atan2(self.sideways, max(self.v, 1.0)) if self.v > 0.3 else 0.0)

    def step(self, sim: "Episode", dt: float) -> None:
        """Drive on as the family says, or else behind whoever is ahead."""
        a = self.acts(self, sim) if self.acts else None
        if a is None:
            a = sim.following(self) if self.reactive else self.wished - self.v
        self.a = 0.0 if self.v <= 0.0 and a < 0.0 else max(-8.0, min(3.0, a))
        v = max(self.v + self.a * dt, 0.0)
        way = 0.5 * (self.v + v) * dt
        if self.free:
            x, y, psi = self.free
            self.free = x + way * math.cos(psi), y + way * math.sin(psi), psi
        else:
            kappa = sim.road.at(self.s, 0.0)[3]
            self.s += self.dir * way / max(1.0 - self.d * kappa, 0.3)
            aside = (self.goal - self.d) / max(0.6, dt)
            self.sideways = max(-self.lateral, min(self.lateral, aside)) if self.v >= 0.3 else 0.0
            self.d += self.sideways * dt
            self.r = kappa * self.v * self.dir
        self.v = v


class Episode:
    """One drive."""

    def __init__(self, seed: int, name: str) -> None:
        rng = self.rng = random.Random(seed)
        self.seed, self.family, self.road, self.t, self.cars = seed, name, Geometry(rng), 0.0, []
        self.limit = rng.choice([14.0, 20.0, 25.0, 30.0, 36.0])
        w = self.lane = rng.choice([2.75, 3.0, 3.25, 3.5, 3.75])
        layout = rng.choice(["1", "1s", "2o", "2o", "2o", "2s", "2s", "3s", "2o_r", "4", "2os"])
        if name in ("oncoming_overtaker", "slow_with_oncoming"):
            layout = rng.choice(["2o", "2os", "4"])
        if name in ("cut_in", "stop_beside", "slow_with_beside"):
            layout = rng.choice(["2s", "3s", "4"])
        others, shoulder = LAYOUTS[layout]
        self.lanes = [Lane(d=0.0, width=w), *(Lane(d=side * w, width=w, direction=way) for side, way in others)]
        self.lanes += [Lane(d=-0.5 * w - 1.0, width=2.0)] if shoulder else []
        path = fit_path(np.column_stack((self.road.x, self.road.y))[::10], tolerance=0.02)
        self.car = rng.choice([VehicleParams.bmw_320i(), VehicleParams.ford_escort(), VehicleParams.vw_vanagon()])
        cruise = self.limit * rng.uniform(0.75, 1.0)
        self.v_max = min(cruise, math.sqrt(2.5 * self.road.radius) * 1.05)
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
        self.plant = Plant(self.car, x, y, psi + turned, v, kappa * v, rng.choice([True, False, False]))
        self.telling = rng.choice(["perfect", "perfect", "noisy", "delayed", "flicker", "idchange", "understated"])
        self.jitter = rng.choice([False] * 4 + [True])
        self.range = rng.choice([150.0, 300.0, 400.0])
        FAMILIES[name](self, rng)
        self._background(rng)
        road = Road(path, self.lanes, speed_limit=self.limit)
        self.planner = Planner(self.car, road, cruise_speed=cruise, evasion=EvasionSettings(awareness_range=self.range))
        self.duration, self.told, self.bias = rng.uniform(20.0, 26.0), {}, {}

    def add(self, name: str, ahead: float, d: float, v: float, **more) -> Car:
        """Put a car onto the road, `ahead` of the ego."""
        car = Car(f"{name}{len(self.cars)}", self.s + ahead, d, v, **more)
        self.cars.append(car)
        return car

    def lane_of(self, direction: int) -> float:
        """A lane beside, of a direction."""
        found = [lane.d for lane in self.lanes if lane.direction == direction and lane.d != 0.0 and lane.width > 2.5]
        return found[0] if direction < 0 else self.rng.choice(found)

    def speed(self, low: float, high: float) -> float:
        """Speed at which a car may come along here."""
        return min(self.limit, math.sqrt(2.5 * self.road.radius)) * self.rng.uniform(low, high)

    def _background(self, rng: random.Random) -> None:
        wanted, lanes = rng.randint(0, 8), [lane for lane in self.lanes if lane.width >= 2.5]
        for _ in range(60):
            lane, ahead, v = rng.choice(lanes), rng.uniform(-120.0, 450.0), self.speed(0.6, 1.0)
            free = all(
                abs(c.s - self.s - ahead) >= 12.0 + 1.2 * max(c.v, v) or abs(c.d - lane.d) >= 2.5
                for c in self.cars if not c.free
            )
            if wanted and free and abs(ahead) >= (60.0 if lane.d == 0.0 else 15.0):
                size = rng.choice([(4.5, 1.8), (4.5, 1.8), (18.0, 2.5), (2.0, 0.8), (12.0, 2.5)])
                size = size[0], min(size[1], self.lane - 0.3)
                self.add("bg", ahead, lane.d + rng.uniform(-0.2, 0.2), v, dirn=lane.direction, size=size)
                wanted -= 1

    def following(self, car: Car) -> float:
        """Acceleration of the intelligent driver model behind whoever is ahead."""
        gap, v_ahead, ego = math.inf, 0.0, (self.s, self.d, self.car.length, self.car.width, self.plant.v)
        for s, d, length, width, v in [ego, *((c.s, c.d, c.length, c.width, c.v * c.dir) for c in self.cars
                                              if c is not car and not c.free)]:
            ahead = (s - car.s) * car.dir
            if ahead > 0.0 and abs(d - car.d) < 0.5 * (width + car.width) + 0.2:
                ahead -= 0.5 * (length + car.length)
                if ahead < gap:
                    gap, v_ahead = ahead, v * car.dir
        v, wished = car.v, max(car.wished, 0.1)
        a = 1.5 * (1.0 - (v / wished) ** 4) if v < car.wished else -min(1.0, v - car.wished)
        if gap < 1e3:
            want = 2.0 + max(0.0, v + v * (v - v_ahead) / (2.0 * math.sqrt(1.5 * 2.5)))
            a = min(a, 1.5 * (1.0 - (v / wished) ** 4 - (want / max(gap, 0.1)) ** 2))
        return a

    def report(self) -> list[RemoteVehicle]:
        """What the ego is told of the others."""
        rng, how, out = self.rng, self.telling, []
        for car in self.cars:
            x, y, psi = car.pose(self.road)
            if math.hypot(x - self.plant.x, y - self.plant.y) > self.range or not car.visible(self):
                continue
            name, age, sigma, v, a, r = car.id, 0.0, 0.0, car.v, car.a, car.r
            told = self.told.get(name)
            if how == "flicker":
                if told is None or self.t > told[1]:
                    on = told is None or not told[0]
                    told = self.told[name] = on, self.t + (rng.uniform(0.2, 2.0) if on else rng.uniform(0.05, 0.6))
                if not told[0]:
                    continue
            elif how == "idchange":
                if told is None or self.t > told[1]:
                    told = self.told[name] = rng.randrange(10**9), self.t + rng.uniform(0.3, 2.0)
                name = f"{name}~{told[0]}"
            elif how == "delayed":
                if told is None or self.t - told[0] > told[1]:
                    told = self.told[name] = self.t, rng.choice([0.1, 0.1, 0.3, 0.5, 0.8]), (x, y, psi, v, a, r)
                age, (x, y, psi, v, a, r) = self.t - told[0], told[2]
                x, y = x + v * age * math.cos(psi + 0.5 * r * age), y + v * age * math.sin(psi + 0.5 * r * age)
                psi += r * age
            if how in ("noisy", "delayed", "understated"):
                sigma, true = (0.1, 0.5) if how == "understated" else (0.3, 0.3)
                old = self.bias.get(car.id) or (rng.gauss(0.0, true), rng.gauss(0.0, true), self.t)
                keep = math.exp((old[2] - self.t) / 8.0)
                off = [keep * e + math.sqrt(max(0.0, 1.0 - keep * keep)) * rng.gauss(0.0, true) for e in old[:2]]
                self.bias[car.id] = *off, self.t
                ahead, left = (max(-2.0 * true, min(2.0 * true, e)) for e in off)
                x += ahead * math.cos(psi) - left * math.sin(psi)
                y += ahead * math.sin(psi) + left * math.cos(psi)
            car.seen = self.t if car.seen is None else car.seen
            out.append(RemoteVehicle(
                id=name, x=x, y=y, psi=psi, v_x=v, a_x=a, r=r, length=car.length, width=car.width, age=age,
                sigma_along=sigma, sigma_across=sigma,
            ))
        return out

    def touched(self) -> Car | None:
        """Who is touched now."""
        c, s = math.cos(self.plant.psi), math.sin(self.plant.psi)
        x, y = self.plant.x + self.car.box_offset * c, self.plant.y + self.car.box_offset * s
        for car in self.cars:
            x_c, y_c, psi = car.pose(self.road)
            if math.hypot(x_c - x, y_c - y) < 0.5 * math.hypot(car.length, car.width) + 2.6:
                ego = corners(x, y, self.plant.psi, self.car.length, self.car.width)
                if box_distance(ego, corners(x_c, y_c, psi, car.length, car.width)) <= 0.0:
                    return car
        return None

    def braking(self) -> tuple[float, float]:
        """Full braking along the road, of the drive that classifies."""
        look, car, state = max(4.0, 0.8 * self.plant.v), self.car, self.plant
        x, y, _, _ = self.road.at(self.s + look, 0.0)
        angle = math.remainder(math.atan2(y - state.y, x - state.x) - state.psi, 2.0 * math.pi)
        delta = math.atan2(2.0 * car.wheelbase * math.sin(angle), math.hypot(x - state.x, y - state.y))
        return delta * (1.0 + car.understeer_gradient * state.v**2 / car.wheelbase), BRAKE

    def run(self, brake_from: float = math.inf) -> dict:
        """Drive; from `brake_from` on the ego only brakes."""
        cycles, actions, stood, command = [], set(), 0.0, None
        result = {"seed": self.seed, "family": self.family, "contact": None}
        while self.t < self.duration and self.s < self.road.length - 300.0 and stood < 4.0:
            others, state = self.report(), self.plant.state()
            if self.t < brake_from:
                begun = time.thread_time()
                command = self.planner.step(self.t, state, others)
                cycles.append(time.thread_time() - begun)
                delta, a_x = command.delta, command.a_x
                actions.add(command.decision.action.name)
                if not math.isfinite(delta + a_x) or "internal error" in command.decision.reason:
                    result["error"] = command.decision.reason
                    break
            else:
                delta, a_x = self.braking()
            dt = STEP
            if self.jitter:
                dt = self.rng.uniform(0.005, 0.2) if self.rng.random() > 0.003 else 1.0
            n = max(1, math.ceil(dt / STEP - 1e-9))
            hit = None
            for _ in range(n):
                for car in self.cars:
                    car.step(self, dt / n)
                self.plant.step(delta, a_x, dt / n)
                self.t += dt / n
                self.s, self.d = self.road.place(self.plant.x, self.plant.y, self.s)
                hit = self.touched()
                if hit:
                    break
            if hit:
                result["contact"] = {
                    "t": round(self.t, 2), "with": hit.id, "v": round(self.plant.v, 2), "v_other": round(hit.v, 2),
                    "d": round(self.d, 2), "d_other": round(hit.d, 2), "seen": hit.seen,
                }
                if command:
                    decision = command.decision
                    result["contact"] |= {"action": decision.action.name, "reason": decision.reason}
                    result["contact"]["status"] = command.status.name
                break
            stood = stood + dt if self.plant.v < 0.02 and self.t > 8.0 else 0.0
        return result | {"t": round(self.t, 2), "actions": sorted(actions), "cycles": cycles}


def classify(contact: dict, seed: int, name: str) -> str:
    """Say whether the ego stood, could have braked in time, or neither."""
    if contact["v"] < 0.3:
        return "standing"
    for kind, begin in (("in 1 s", contact["t"] - 1.0), ("avoidable", contact["seen"])):
        if contact["seen"] is not None and Episode(seed, name).run(max(begin, contact["seen"]))["contact"] is None:
            return kind
    return "other"


def empty(sim, rng):
    """Background traffic only."""


def slow(sim, rng):
    """A slow vehicle ahead."""
    size = rng.choice([(4.5, 1.8), (18.0, 2.5), (2.0, 0.8), (1.8, 0.6)])
    sim.add("slow", rng.uniform(40.0, 200.0), rng.uniform(-0.4, 0.4), sim.v_max * rng.uniform(0.1, 0.7), size=size)


def slow_with_oncoming(sim, rng):
    """A slow vehicle, and oncoming traffic."""
    slow(sim, rng)
    for i in range(rng.randint(1, 3)):
        sim.add("oncoming", rng.uniform(120.0, 400.0) + 200.0 * i, sim.lane_of(-1), sim.speed(0.7, 1.0), dirn=-1)


def slow_with_beside(sim, rng):
    """A slow vehicle, and faster ones from behind on the lane beside."""
    slow(sim, rng)
    d = sim.lane_of(1)
    for i in range(rng.randint(1, 3)):
        v = min(sim.limit, sim.v_max * rng.uniform(0.9, 1.2))
        car = sim.add("beside", -rng.uniform(10.0, 60.0) - 40.0 * i, d, v)
        begin, a, end = rng.uniform(1.0, 8.0), rng.choice([-8.0, 3.0, 2.0, -4.0]), rng.uniform(1.0, 5.0)
        if rng.random() < 0.4:
            car.acts = lambda c, sim, b=begin, a=a, e=end: (
                min(a, sim.following(c) if a > 0 else 0.0) if b < sim.t < b + e and c.v < sim.limit else None
            )


def stopping_distance(sim, braking: float, more: float) -> float:
    """Way to a stop."""
    return sim.v_max**2 / (2.0 * braking) + more


def stopped(sim, rng):
    """A standing vehicle on the lane."""
    size = rng.choice([(4.5, 1.8), (18.0, 2.5), (2.0, 0.8)])
    ahead = stopping_distance(sim, 6.0, 8.0) + rng.uniform(5.0, 150.0)
    sim.add("stopped", ahead, rng.uniform(-0.8, 0.8), 0.0, size=size, reactive=False)


def partly(sim, rng):
    """A standing vehicle partly on the lane."""
    ahead = stopping_distance(sim, 6.0, 8.0) + rng.uniform(5.0, 150.0)
    sim.add("partly", ahead, rng.choice([-1, 1]) * rng.uniform(0.8, 2.6), 0.0, reactive=False)


def hidden(sim, rng):
    """A standing vehicle that is told late."""
    need = stopping_distance(sim, 6.5, 5.0)
    car = sim.add("hidden", need + rng.uniform(40.0, 150.0), rng.uniform(-1.2, 1.2), 0.0, reactive=False)
    near = need + rng.uniform(3.0, 30.0)

    def visible(sim):
        car.memo["seen"] = car.memo.get("seen", False) or car.s - sim.s < near
        return car.memo["seen"]

    car.visible = visible


def cut_in(sim, rng):
    """A car from the lane beside comes over in front, and may brake then."""
    car = sim.add("cutin", rng.uniform(0.0, 60.0), sim.lane_of(1), sim.v_max * rng.uniform(0.5, 1.0), reactive=False)
    near, after, lateral = rng.uniform(4.0, 30.0), rng.choice([0.0, 0.0, -3.0, -8.0, -1.0]), rng.uniform(0.8, 2.0)

    @car.does
    def _(c, sim):
        ahead = c.s - sim.s - 0.5 * (c.length + sim.car.length)
        if "on" not in c.memo and sim.t > 1.0 and 1.0 < ahead < near and c.v < sim.plant.v + 2.0:
            c.memo["on"], c.goal, c.lateral = sim.t, 0.0, lateral
        return after if after and sim.t > c.memo.get("on", math.inf) + 2.5 else None


def cut_out(sim, rng):
    """The leader moves over in front of a standing vehicle, often hidden until then."""
    far = sim.add("revealed", rng.uniform(150.0, 320.0), rng.uniform(-0.5, 0.5), 0.0, reactive=False)
    car = sim.add("cutout", 8.0 + 1.2 * sim.v_max, 0.0, sim.v_max * rng.uniform(0.8, 1.0), reactive=False)
    ahead, side = rng.uniform(1.2, 3.0), rng.choice([lane.d for lane in sim.lanes if lane.d != 0.0] or [-3.0])

    @car.does
    def _(c, sim):
        if far.s - c.s < 10.0 + ahead * c.v:
            c.goal, c.lateral = side, 2.0

    def visible(sim):
        far.memo["seen"] = far.memo.get("seen", False) or abs(car.d) > 1.2 or car.s > far.s
        return far.memo["seen"]

    if rng.random() < 0.7:
        far.visible = visible


def hard_braking(sim, rng):
    """The leader brakes with 8 m/s^2, and may drive off again."""
    ahead, size = 8.0 + rng.uniform(0.8, 2.5) * sim.v_max, (rng.choice([4.5, 18.0]), rng.choice([1.8, 2.5]))
    car = sim.add("hard", ahead, rng.uniform(-0.3, 0.3), sim.v_max * rng.uniform(0.8, 1.0), size=size, reactive=False)
    begin, to, again = rng.uniform(1.0, 8.0), rng.choice([0.0, 0.0, 5.0]), rng.random() < 0.5

    @car.does
    def _(c, sim):
        if sim.t > begin and "done" not in c.memo and c.v > to:
            return -8.0
        if sim.t > begin:
            c.memo.setdefault("done", sim.t)
        off = again and sim.t > c.memo.get("done", math.inf) + 2.0 and c.v < c.wished
        return 2.0 if off else 0.0 if "done" in c.memo else None


def oncoming_overtaker(sim, rng):
    """An oncoming car overtakes on the ego's lane and returns late or never."""
    d, v, ahead = sim.lane_of(-1), sim.speed(0.6, 0.9), rng.uniform(250.0, 500.0)
    sim.add("slow_oncoming", ahead, d, 0.7 * v, dirn=-1, reactive=False)
    car = sim.add("overtaker", ahead + rng.uniform(8.0, 30.0), d, v, dirn=-1, reactive=False)
    back, never = rng.uniform(1.0, 5.0), rng.random() < 0.2

    @car.does
    def _(c, sim):
        late = (c.s - sim.s) / max(c.v + sim.plant.v, 1.0) < back and not never
        if sim.t >= 0.5:
            c.goal, c.lateral = (d, 3.0) if late else (0.0, 2.0)
        return 0.0


def wrong_way(sim, rng):
    """Somebody comes along the ego's lane the wrong way."""
    sim.add("wrong", rng.uniform(150.0, 400.0), rng.uniform(-0.5, 0.5), sim.speed(0.2, 0.8), dirn=-1,
            reactive=rng.random() < 0.5)


def crosses(sim, name, ahead, angle, distance, v, size, acts):
    """A road user on a straight line across the road."""
    x, y, psi, _ = sim.road.at(sim.s + ahead, 0.0)
    psi += angle
    free = x - distance * math.cos(psi), y - distance * math.sin(psi), psi
    sim.add(name, ahead, 0.0, v, size=size, reactive=False, free=free).acts = acts


def crossing(sim, rng):
    """One or two vehicles cross."""
    for _ in range(rng.randint(1, 2)):
        ahead, v = rng.uniform(80.0, 220.0), rng.uniform(3.0, 16.0)
        angle = rng.choice([-1, 1]) * math.radians(rng.uniform(50.0, 130.0))
        arrives = max(ahead / max(sim.v_max, 3.0) + rng.uniform(-2.5, 2.5), 0.5)
        mode, begin = rng.choice(["steady", "steady", "brake", "hurry", "stop"]), rng.uniform(1.0, max(1.5, arrives))
        a, low, high = {"steady": (0, 0, 0), "brake": (-2, 2, 99), "hurry": (2, 0, 18), "stop": (-5, 0, 99)}[mode]
        crosses(sim, "crossing", ahead, angle, v * arrives, v, (rng.choice([4.5, 4.5, 12.0, 2.0]), 1.8),
                lambda c, sim, a=a, lo=low, hi=high, b=begin: a if sim.t > b and lo <= c.v < hi else 0.0)


def pedestrian(sim, rng):
    """People step onto the road; some stop on it."""
    for i in range(rng.randint(1, 3)):
        ahead, v, near = rng.uniform(60.0, 200.0) + 20.0 * i, rng.uniform(0.8, 1.8), rng.uniform(2.0, 6.0)
        distance, stops = rng.uniform(3.0, 8.0), rng.random() < 0.25

        def acts(c, sim, s=sim.s + ahead, v=v, near=near, distance=distance, stops=stops):
            if (s - sim.s) / max(sim.plant.v, 1.0) < near:
                c.memo.setdefault("on", sim.t)
            if "on" not in c.memo:
                return 0.0
            return -3.0 if stops and sim.t - c.memo["on"] > distance / v else 1.5 * (c.v < v)

        crosses(sim, "pedestrian", ahead, rng.choice([-1, 1]) * math.radians(rng.uniform(70.0, 110.0)), distance, 0.0,
                (0.5, 0.5), acts)


def merge(sim, rng):
    """A slower car comes in from the right edge."""
    ahead, v = rng.uniform(5.0, 80.0), sim.v_max * rng.uniform(0.2, 0.9)
    car = sim.add("merge", ahead, -0.5 * sim.lane - 2.0, v, reactive=False)
    begin, lateral, polite = rng.uniform(1.0, 6.0), rng.uniform(0.5, 1.8), rng.random() < 0.5

    @car.does
    def _(c, sim):
        ahead = c.s - sim.s - 0.5 * (c.length + sim.car.length)
        if sim.t > begin and (not polite or ahead > 3.0 or ahead < -15.0):
            c.goal, c.lateral = 0.0, lateral
        return 1.5 if c.goal == 0.0 and c.v < sim.v_max else 0.0


def passed_speeds_up(sim, rng):
    """The vehicle that is being passed speeds up."""
    ahead, d = rng.uniform(50.0, 150.0), rng.uniform(-0.2, 0.2)
    car = sim.add("passed", ahead, d, sim.v_max * rng.uniform(0.3, 0.6), reactive=False)
    a, top = rng.uniform(1.0, 3.0), min(sim.limit, 1.1 * sim.v_max)

    @car.does
    def _(c, sim):
        c.memo["on"] = c.memo.get("on", False) or (abs(sim.d) > 1.0 and c.s - sim.s < 25.0)
        return min(a, sim.following(c)) if c.memo["on"] and c.v < top else 0.0


def tailgater(sim, rng):
    """Somebody close behind reacts after half a second."""
    car, past = sim.add("tail", -5.0 - rng.uniform(0.4, 1.0) * sim.v_0, 0.0, sim.v_0, reactive=False), []

    @car.does
    def _(c, sim):
        past.append((sim.t, sim.plant.v, sim.plant.a))
        while len(past) > 1 and past[0][0] < sim.t - 0.5:
            past.pop(0)
        behind = sim.s - c.s - 0.5 * (c.length + sim.car.length)
        if abs(sim.d - c.d) > 1.6:
            return sim.following(c)
        return past[0][2] + (past[0][1] - c.v) + 0.3 * (behind - 0.5 * c.v - 1.0)
    rng.choice([slow, stopped, hard_braking, cut_out])(sim, rng)


def stop_beside(sim, rng):
    """Somebody stays beside the ego, who meets a slow or standing vehicle."""
    car = sim.add("beside", rng.uniform(-12.0, 12.0), sim.lane_of(1), sim.v_0, reactive=False)
    car.acts = lambda c, sim: max(-6.0, min(3.0, sim.plant.v - c.v - 0.2 * (c.s - sim.s)))
    rng.choice([slow, stopped])(sim, rng)


def platoon(sim, rng):
    """Several vehicles in a row, the first of which may stop."""
    v, ahead = sim.v_max * rng.uniform(0.3, 0.95), rng.uniform(40.0, 120.0)
    stops, begin = rng.random() < 0.5, rng.uniform(2.0, 8.0)
    for _ in range(rng.randint(3, 5)):
        car = sim.add("platoon", ahead, rng.uniform(-0.2, 0.2), v, size=(rng.choice([4.5, 4.5, 16.0]), 2.0))
        ahead += 18.0 + 0.7 * v
    if stops:
        car.acts = lambda c, sim: -7.0 if sim.t > begin else None


def mixed(sim, rng):
    """Two families at once."""
    for one in rng.sample([slow, partly, hard_braking, crossing, pedestrian, merge, platoon, wrong_way], 2):
        one(sim, rng)


FAMILIES = {function.__name__: function for function in (
    empty, slow, slow_with_oncoming, slow_with_beside, stopped, partly, hidden, cut_in, cut_out, hard_braking,
    oncoming_overtaker, wrong_way, crossing, pedestrian, merge, passed_speeds_up, tailgater, stop_beside, platoon,
    mixed,
)}


def main() -> None:
    """Drive the seeds that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", default="0:40", help="first:last, the last not included")
    parser.add_argument("--family", choices=FAMILIES, help="all seeds of one family")
    parser.add_argument("--json", help="file for a line of JSON for each drive")
    arguments = parser.parse_args()
    first, last = map(int, arguments.seeds.split(":"))
    names, table, cycles = list(FAMILIES), defaultdict(Counter), []
    for seed in range(first, last):
        name = arguments.family or names[seed % len(names)]
        result = Episode(seed, name).run()
        cycles += result.pop("cycles")
        table[name]["drives"] += 1
        table[name]["errors"] += "error" in result
        if result["contact"]:
            result["kind"] = classify(result["contact"], seed, name)
            table[name][result["kind"]] += 1
            table[name]["avoidable"] += result["kind"] == "in 1 s"
            c = result["contact"]
            print(f"seed {seed} {name}: {result['kind']}, t {c['t']}, with {c['with']}, v {c['v']}, "
                  f"{c.get('action')}: {c.get('reason', '')[:60]}")
        if arguments.json:
            with open(arguments.json, "a", encoding="utf-8") as out:
                out.write(json.dumps(result) + "\n")
    columns = ("drives", "errors", "standing", "avoidable", "in 1 s", "other")
    print(f"\n{'family':20}" + "".join(f"{c:>11}" for c in columns))
    total = Counter()
    for name in sorted(table):
        total.update(table[name])
        print(f"{name:20}" + "".join(f"{table[name][c]:11}" for c in columns))
    print(f"{'all':20}" + "".join(f"{total[c]:11}" for c in columns))
    ms = 1e3 * np.percentile(cycles, [50, 99, 100])
    print(f"CPU time of a cycle [ms]: median {ms[0]:.2f}, 99 % {ms[1]:.1f}, worst {ms[2]:.0f} ({len(cycles)} cycles)")


if __name__ == "__main__":
    main()
