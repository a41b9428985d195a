"""Controls, which hold already and must not break; commands and the time of a cycle."""

import math

import numpy as np

from cca_core import Road
from tests.trials.driving import along, at, cruise, curve, drive, pose_on, remote, straight
from tests.trials.faults.scenes import ADJACENT, FAR, OPPOSING, by_radio, clock_off, min_gap, on_lane
from tests.trials.faults.table import Check, Table, cpu

TABLE = Table()


@TABLE.case(
    "controls", "control-brakes-hard", "the lead at 22 m/s, 30 m ahead, brakes with 7 m/s^2 to a standstill"
)
def _():
    def world(t, _):
        braked = min(max(t - 1.0, 0.0), 22.0 / 7.0)
        x = 134.5 + 22.0 * min(t, 1.0 + braked) - 3.5 * braked**2
        return [remote("lead", x, 0.0, 22.0 - 7.0 * braked, a_x=-7.0 * (0.0 < braked < 22.0 / 7.0))]

    return min_gap(on_lane(22.0, world, 10.0))


@TABLE.case(
    "controls", "control-one-way-van", "a parked van and an oncoming car on a road that does not return"
)
def _():
    def world(t, _):
        van = remote("van", 240.0, -0.5, length=6.0, width=2.0)
        return [van, remote("oncoming", 390.0 - 15.0 * t, 3.5, 15.0, math.pi)]

    return min_gap(on_lane(15.0, world, 18.0, OPPOSING, evasion=FAR))


@TABLE.case("controls", "control-sender-26-m", "a road train of 26 m by messages")
def _():
    return min_gap(by_radio(lambda t, _: [remote("00000003", 300.0, 0.0, length=26.0, width=2.55)]))


@TABLE.case("controls", "control-clock-0.9-s", "the receiver's clock is 0.9 s ahead, within the window")
def _():
    return clock_off(0.9)


@TABLE.case("controls", "control-passes", "a stationary car, never occluded, is passed on the free left lane")
def _():
    run = on_lane(20.0, lambda t, _: [remote("c", 300.0, 0.0)], 20.0, ADJACENT)
    return [("distance driven", run.last("s"), ">=", 320.0)]


@TABLE.case(
    "commands",
    "cruise-speed-set-later",
    "planner.cruise_speed set to 10 after construction acts, or is refused",
)
def _():
    planner = cruise(Road(straight()), 20.0)

    def world(t, _):
        if 1.0 < t < 1.03:
            planner.cruise_speed = 10.0
        return []

    try:
        return [("speed", drive(planner, along(20.0), world, 12.0).last("v"), "<=", 10.5)]
    except AttributeError:
        return [("refused", True, "==", True)]


def slowest(radius: float, seed: int, scenes: int = 150) -> list[Check]:
    """Worst CPU time of a first step among random scenes on a curve: a lead and two oncoming vehicles."""
    rng, worst, path = np.random.default_rng(seed), 0.0, curve(radius, 200.0, 3.0)
    for _ in range(scenes):
        v, s = rng.uniform(8.0, 28.0), rng.uniform(200.0, 400.0)
        s_lead = s + rng.uniform(1.5, 3.5) * v
        remotes = [at(path, "lead", s_lead, rng.uniform(-0.5, 0.5), v * rng.uniform(0.2, 0.7))]
        for name in ("a", "b"):
            s_oncoming = s + rng.uniform(150.0, 500.0)
            remotes.append(at(path, name, s_oncoming, 3.5, rng.uniform(10.0, 25.0), oncoming=True))
        planner, state = cruise(Road(path, OPPOSING, speed_limit=30.0), 28.0, FAR), pose_on(path, s, v)
        worst = max(worst, cpu(lambda p=planner, s=state, r=remotes: p.step(0.0, s, r)))
    return [("milliseconds", 1e3 * worst, "<=", 20.0)]


@TABLE.case("commands", "cycle-time", "worst CPU time of a first step among 150 scenes on a curve")
def _():
    return slowest(300.0, 7)
