"""Families of traffic that crosses the road."""

import math
import random
from typing import TYPE_CHECKING

from tests.trials.closed_loop.car import Action

if TYPE_CHECKING:
    from tests.trials.closed_loop.episode import Episode


def add_crossing(
    sim: "Episode",
    name: str,
    ahead: float,
    angle: float,
    distance: float,
    v: float,
    size: tuple[float, float],
    action: Action,
) -> None:
    """A road user on a straight line across the road."""
    x, y, psi, _ = sim.road.at(sim.s + ahead, 0.0)
    psi += angle
    free_pose = x - distance * math.cos(psi), y - distance * math.sin(psi), psi
    sim.add(name, ahead, 0.0, v, size=size, reactive=False, free_pose=free_pose).action = action


def crossing(sim: "Episode", rng: random.Random) -> None:
    """One or two vehicles cross."""
    for _ in range(rng.randint(1, 2)):
        ahead, v = rng.uniform(80.0, 220.0), rng.uniform(3.0, 16.0)
        angle = rng.choice([-1, 1]) * math.radians(rng.uniform(50.0, 130.0))
        arrives = max(ahead / max(sim.v_max, 3.0) + rng.uniform(-2.5, 2.5), 0.5)
        mode, begin = (
            rng.choice(["steady", "steady", "brake", "hurry", "stop"]),
            rng.uniform(1.0, max(1.5, arrives)),
        )
        a, low, high = {"steady": (0, 0, 0), "brake": (-2, 2, 99), "hurry": (2, 0, 18), "stop": (-5, 0, 99)}[
            mode
        ]
        add_crossing(
            sim,
            "crossing",
            ahead,
            angle,
            v * arrives,
            v,
            (rng.choice([4.5, 4.5, 12.0, 2.0]), 1.8),
            lambda c, sim, a=a, lo=low, hi=high, b=begin: a if sim.t > b and lo <= c.v < hi else 0.0,
        )


def pedestrian(sim: "Episode", rng: random.Random) -> None:
    """People step onto the road; some stop on it."""
    for i in range(rng.randint(1, 3)):
        ahead, v, near = rng.uniform(60.0, 200.0) + 20.0 * i, rng.uniform(0.8, 1.8), rng.uniform(2.0, 6.0)
        distance, stops = rng.uniform(3.0, 8.0), rng.random() < 0.25

        def action(c, sim, s=sim.s + ahead, v=v, near=near, distance=distance, stops=stops):
            if (s - sim.s) / max(sim.plant.v, 1.0) < near:
                c.memory.setdefault("on", sim.t)
            if "on" not in c.memory:
                return 0.0
            return -3.0 if stops and sim.t - c.memory["on"] > distance / v else 1.5 * (c.v < v)

        add_crossing(
            sim,
            "pedestrian",
            ahead,
            rng.choice([-1, 1]) * math.radians(rng.uniform(70.0, 110.0)),
            distance,
            0.0,
            (0.5, 0.5),
            action,
        )
