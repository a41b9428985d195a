"""Drivers who brake and swerve for the ego, after their reaction time."""

import random
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tests.trials.closed_loop.car import Car
    from tests.trials.closed_loop.episode import Episode

HARDEST = -6.0  # braking of a driver who reacts [m/s^2]
SHIFT = 0.5  # by which a driver makes room in the own lane [m]


def attentive(car: "Car", delay: float) -> None:
    """Let a driver follow the vehicle ahead with a delay, and make room for an ego that comes near."""
    lane, past = car.d, []

    @car.acts
    def _(c, sim):
        past.append((sim.t, sim.following(c)))
        while len(past) > 1 and past[1][0] <= sim.t - delay:
            past.pop(0)
        reach = 0.5 * (c.length + sim.car.length) + 0.5 * c.v
        is_near = abs(c.s - sim.s) < reach and 0.5 < abs(c.d - sim.d) < 3.0
        c.d_goal = lane + (SHIFT if c.d > sim.d else -SHIFT) * is_near
        return max(past[0][1], HARDEST)


def reacting(sim: "Episode", rng: random.Random) -> None:
    """A slow vehicle ahead; attentive drivers beside and behind the ego."""
    size = rng.choice([(4.5, 1.8), (18.0, 2.5)])
    sim.add(
        "slow", rng.uniform(40.0, 140.0), rng.uniform(-0.3, 0.3), sim.v_max * rng.uniform(0.3, 0.7), size=size
    )
    d, ahead = sim.adjacent_lane(1), -rng.uniform(12.0, 60.0)
    for _ in range(rng.randint(1, 3)):
        v = min(sim.limit, sim.v_max * rng.uniform(0.85, 1.25))
        attentive(sim.add("beside", ahead, d, v, reactive=False), rng.uniform(0.4, 1.2))
        ahead -= 8.0 + rng.uniform(1.0, 3.0) * v
    v = sim.v_0 * rng.uniform(0.8, 1.1)
    behind = sim.add("behind", -8.0 - rng.uniform(1.0, 2.0) * v, 0.0, v, reactive=False)
    attentive(behind, rng.uniform(0.4, 1.0))
