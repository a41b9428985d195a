"""Families of traffic: each adds the vehicles that make its situation to an episode."""

import math
import random
from typing import TYPE_CHECKING

from tests.trials.closed_loop.crossings import crossing, pedestrian
from tests.trials.closed_loop.reacting import reacting

if TYPE_CHECKING:
    from tests.trials.closed_loop.episode import Episode


def empty(sim: "Episode", rng: random.Random) -> None:
    """Background traffic only."""


def slow(sim: "Episode", rng: random.Random) -> None:
    """A slow vehicle ahead."""
    size = rng.choice([(4.5, 1.8), (18.0, 2.5), (2.0, 0.8), (1.8, 0.6)])
    sim.add(
        "slow", rng.uniform(40.0, 200.0), rng.uniform(-0.4, 0.4), sim.v_max * rng.uniform(0.1, 0.7), size=size
    )


def slow_with_oncoming(sim: "Episode", rng: random.Random) -> None:
    """A slow vehicle, and oncoming traffic."""
    slow(sim, rng)
    for i in range(rng.randint(1, 3)):
        sim.add(
            "oncoming",
            rng.uniform(120.0, 400.0) + 200.0 * i,
            sim.adjacent_lane(-1),
            sim.speed(0.7, 1.0),
            direction=-1,
        )


def slow_with_adjacent(sim: "Episode", rng: random.Random) -> None:
    """A slow vehicle, and faster ones from behind on the adjacent lane."""
    slow(sim, rng)
    d = sim.adjacent_lane(1)
    for i in range(rng.randint(1, 3)):
        v = min(sim.limit, sim.v_max * rng.uniform(0.9, 1.2))
        car = sim.add("beside", -rng.uniform(10.0, 60.0) - 40.0 * i, d, v)
        begin, a, end = rng.uniform(1.0, 8.0), rng.choice([-8.0, 3.0, 2.0, -4.0]), rng.uniform(1.0, 5.0)
        if rng.random() < 0.4:
            car.action = lambda c, sim, b=begin, a=a, e=end: (
                min(a, sim.following(c) if a > 0 else 0.0) if b < sim.t < b + e and c.v < sim.limit else None
            )


def stopping_distance(sim: "Episode", braking: float, more: float) -> float:
    """Distance to a stop from the ego's speed, and `more` [m]."""
    return sim.v_max**2 / (2.0 * braking) + more


def stopped(sim: "Episode", rng: random.Random) -> None:
    """A stationary vehicle on the lane."""
    size = rng.choice([(4.5, 1.8), (18.0, 2.5), (2.0, 0.8)])
    ahead = stopping_distance(sim, 6.0, 8.0) + rng.uniform(5.0, 150.0)
    sim.add("stopped", ahead, rng.uniform(-0.8, 0.8), 0.0, size=size, reactive=False)


def partly(sim: "Episode", rng: random.Random) -> None:
    """A stationary vehicle partly on the lane."""
    ahead = stopping_distance(sim, 6.0, 8.0) + rng.uniform(5.0, 150.0)
    sim.add("partly", ahead, rng.choice([-1, 1]) * rng.uniform(0.8, 2.6), 0.0, reactive=False)


def hidden(sim: "Episode", rng: random.Random) -> None:
    """A stationary vehicle that is reported late."""
    need = stopping_distance(sim, 6.5, 5.0)
    car = sim.add("hidden", need + rng.uniform(40.0, 150.0), rng.uniform(-1.2, 1.2), 0.0, reactive=False)
    near = need + rng.uniform(3.0, 30.0)

    def visible(sim):
        car.memory["visible"] = car.memory.get("visible", False) or car.s - sim.s < near
        return car.memory["visible"]

    car.is_visible = visible


def cut_in(sim: "Episode", rng: random.Random) -> None:
    """A car cuts in from the adjacent lane, and may brake then."""
    car = sim.add(
        "cutin",
        rng.uniform(0.0, 60.0),
        sim.adjacent_lane(1),
        sim.v_max * rng.uniform(0.5, 1.0),
        reactive=False,
    )
    near, after, lateral = (
        rng.uniform(4.0, 30.0),
        rng.choice([0.0, 0.0, -3.0, -8.0, -1.0]),
        rng.uniform(0.8, 2.0),
    )

    @car.acts
    def _(c, sim):
        ahead = c.s - sim.s - 0.5 * (c.length + sim.car.length)
        if "on" not in c.memory and sim.t > 1.0 and 1.0 < ahead < near and c.v < sim.plant.v + 2.0:
            c.memory["on"], c.d_goal, c.max_v_d = sim.t, 0.0, lateral
        return after if after and sim.t > c.memory.get("on", math.inf) + 2.5 else None


def cut_out(sim: "Episode", rng: random.Random) -> None:
    """The lead changes its lane before a stationary vehicle, often occluded until then."""
    far = sim.add("revealed", rng.uniform(150.0, 320.0), rng.uniform(-0.5, 0.5), 0.0, reactive=False)
    car = sim.add("cutout", 8.0 + 1.2 * sim.v_max, 0.0, sim.v_max * rng.uniform(0.8, 1.0), reactive=False)
    ahead, side = rng.uniform(1.2, 3.0), rng.choice([lane.d for lane in sim.lanes if lane.d != 0.0] or [-3.0])

    @car.acts
    def _(c, sim):
        if far.s - c.s < 10.0 + ahead * c.v:
            c.d_goal, c.max_v_d = side, 2.0

    def visible(sim):
        far.memory["visible"] = far.memory.get("visible", False) or abs(car.d) > 1.2 or car.s > far.s
        return far.memory["visible"]

    if rng.random() < 0.7:
        far.is_visible = visible


def hard_braking(sim: "Episode", rng: random.Random) -> None:
    """The lead brakes with 8 m/s^2, and may drive off again."""
    ahead, size = 8.0 + rng.uniform(0.8, 2.5) * sim.v_max, (rng.choice([4.5, 18.0]), rng.choice([1.8, 2.5]))
    car = sim.add(
        "hard", ahead, rng.uniform(-0.3, 0.3), sim.v_max * rng.uniform(0.8, 1.0), size=size, reactive=False
    )
    begin, to, again = rng.uniform(1.0, 8.0), rng.choice([0.0, 0.0, 5.0]), rng.random() < 0.5

    @car.acts
    def _(c, sim):
        if sim.t > begin and "done" not in c.memory and c.v > to:
            return -8.0
        if sim.t > begin:
            c.memory.setdefault("done", sim.t)
        off = again and sim.t > c.memory.get("done", math.inf) + 2.0 and c.v < c.desired_speed
        return 2.0 if off else 0.0 if "done" in c.memory else None


def oncoming_overtaker(sim: "Episode", rng: random.Random) -> None:
    """An oncoming car overtakes on the ego's lane and returns late or never."""
    d, v, ahead = sim.adjacent_lane(-1), sim.speed(0.6, 0.9), rng.uniform(250.0, 500.0)
    sim.add("slow_oncoming", ahead, d, 0.7 * v, direction=-1, reactive=False)
    car = sim.add("overtaker", ahead + rng.uniform(8.0, 30.0), d, v, direction=-1, reactive=False)
    back, never = rng.uniform(1.0, 5.0), rng.random() < 0.2

    @car.acts
    def _(c, sim):
        late = (c.s - sim.s) / max(c.v + sim.plant.v, 1.0) < back and not never
        if sim.t >= 0.5:
            c.d_goal, c.max_v_d = (d, 3.0) if late else (0.0, 2.0)
        return 0.0


def wrong_direction(sim: "Episode", rng: random.Random) -> None:
    """A vehicle drives against the direction of the ego's lane."""
    sim.add(
        "wrong",
        rng.uniform(150.0, 400.0),
        rng.uniform(-0.5, 0.5),
        sim.speed(0.2, 0.8),
        direction=-1,
        reactive=rng.random() < 0.5,
    )


def merge(sim: "Episode", rng: random.Random) -> None:
    """A slower car enters from the right edge."""
    ahead, v = rng.uniform(5.0, 80.0), sim.v_max * rng.uniform(0.2, 0.9)
    car = sim.add("merge", ahead, -0.5 * sim.lane_width - 2.0, v, reactive=False)
    begin, lateral, polite = rng.uniform(1.0, 6.0), rng.uniform(0.5, 1.8), rng.random() < 0.5

    @car.acts
    def _(c, sim):
        ahead = c.s - sim.s - 0.5 * (c.length + sim.car.length)
        if sim.t > begin and (not polite or ahead > 3.0 or ahead < -15.0):
            c.d_goal, c.max_v_d = 0.0, lateral
        return 1.5 if c.d_goal == 0.0 and c.v < sim.v_max else 0.0


def passed_speeds_up(sim: "Episode", rng: random.Random) -> None:
    """The overtaken vehicle accelerates."""
    ahead, d = rng.uniform(50.0, 150.0), rng.uniform(-0.2, 0.2)
    car = sim.add("passed", ahead, d, sim.v_max * rng.uniform(0.3, 0.6), reactive=False)
    a, top = rng.uniform(1.0, 3.0), min(sim.limit, 1.1 * sim.v_max)

    @car.acts
    def _(c, sim):
        c.memory["on"] = c.memory.get("on", False) or (abs(sim.d) > 1.0 and c.s - sim.s < 25.0)
        return min(a, sim.following(c)) if c.memory["on"] and c.v < top else 0.0


def tailgater(sim: "Episode", rng: random.Random) -> None:
    """A vehicle close behind reacts after half a second."""
    car, past = sim.add("tail", -5.0 - rng.uniform(0.4, 1.0) * sim.v_0, 0.0, sim.v_0, reactive=False), []

    @car.acts
    def _(c, sim):
        past.append((sim.t, sim.plant.v, sim.plant.a))
        while len(past) > 1 and past[0][0] < sim.t - 0.5:
            past.pop(0)
        behind = sim.s - c.s - 0.5 * (c.length + sim.car.length)
        if abs(sim.d - c.d) > 1.6:
            return sim.following(c)
        return past[0][2] + (past[0][1] - c.v) + 0.3 * (behind - 0.5 * c.v - 1.0)

    rng.choice([slow, stopped, hard_braking, cut_out])(sim, rng)


def stop_alongside(sim: "Episode", rng: random.Random) -> None:
    """A vehicle stays alongside the ego, which meets a slow or stationary vehicle."""
    car = sim.add("beside", rng.uniform(-12.0, 12.0), sim.adjacent_lane(1), sim.v_0, reactive=False)
    car.action = lambda c, sim: max(-6.0, min(3.0, sim.plant.v - c.v - 0.2 * (c.s - sim.s)))
    rng.choice([slow, stopped])(sim, rng)


def platoon(sim: "Episode", rng: random.Random) -> None:
    """Several vehicles in a row, the first of which may stop."""
    v, ahead = sim.v_max * rng.uniform(0.3, 0.95), rng.uniform(40.0, 120.0)
    stops, begin = rng.random() < 0.5, rng.uniform(2.0, 8.0)
    for _ in range(rng.randint(3, 5)):
        car = sim.add("platoon", ahead, rng.uniform(-0.2, 0.2), v, size=(rng.choice([4.5, 4.5, 16.0]), 2.0))
        ahead += 18.0 + 0.7 * v
    if stops:
        car.action = lambda c, sim: -7.0 if sim.t > begin else None


def mixed(sim: "Episode", rng: random.Random) -> None:
    """Two families at once."""
    for one in rng.sample(
        [slow, partly, hard_braking, crossing, pedestrian, merge, platoon, wrong_direction], 2
    ):
        one(sim, rng)


FAMILIES = {
    function.__name__: function
    for function in (
        empty,
        slow,
        slow_with_oncoming,
        slow_with_adjacent,
        stopped,
        partly,
        hidden,
        cut_in,
        cut_out,
        hard_braking,
        oncoming_overtaker,
        wrong_direction,
        crossing,
        pedestrian,
        merge,
        passed_speeds_up,
        tailgater,
        stop_alongside,
        platoon,
        mixed,
    )
}

MORE_FAMILIES = {"reacting": reacting}
"""Families that are driven only if they are named."""
