"""Routes that pass near themselves."""

import math

import numpy as np

from cca_core import Path, Road, fit_path
from tests.trials.driving import along, cruise, drive, remote
from tests.trials.faults.scenes import FAR, OPPOSING, min_gap
from tests.trials.faults.table import Table

TABLE = Table()


def out_and_back() -> Path:
    """Route out along y = 0 and back along y = 3.5."""
    turn = [
        (620, -3),
        (640, -14),
        (660, -24),
        (685, -25),
        (703, -12),
        (708, 5),
        (700, 22),
        (680, 30),
        (655, 25),
    ]
    out = [(float(x), 0.0) for x in range(0, 601, 10)]
    return fit_path([*out, *turn, (635, 13), (617, 5.5), *[(x, 3.5) for x, _ in out[::-1]]], tolerance=0.3)


def oval(laps: int) -> Path:
    """Oval of two straights of 200 m and two half circles of 60 m radius, from (0, 0)."""
    half, lap = np.linspace(0.0, math.pi, 38)[:-1], [(float(x), 0.0) for x in range(0, 200, 5)]
    lap += [(200.0 + 60.0 * math.sin(a), 60.0 - 60.0 * math.cos(a)) for a in half]
    lap += [(200.0 - x, 120.0) for x, _ in lap[:40]]
    lap += [(-60.0 * math.sin(a), 60.0 + 60.0 * math.cos(a)) for a in half]
    return fit_path([*lap * laps, (0.0, 0.0)], tolerance=0.05)


@TABLE.case(
    "routes", "route-out-and-back", "the return leg is the opposing lane: a parked van, an oncoming car"
)
def _():
    def world(t, _):
        van = remote("van", 200.0, -0.5, length=6.0, width=2.0)
        return [van, remote("oncoming", 350.0 - 15.0 * t, 3.5, 15.0, math.pi)]

    return min_gap(drive(cruise(Road(out_and_back(), OPPOSING), 15.0, FAR), along(15.0, 60.0), world, 18.0))


@TABLE.case("routes", "route-two-laps", "two laps of one road: a car is stationary on it in the first lap")
def _():
    planner = cruise(Road(oval(2)), 12.0)
    return min_gap(drive(planner, along(10.0, 5.0), lambda t, _: [remote("c", 150.0, 0.3)], 20.0))


@TABLE.case("routes", "route-ego-in-between", "the ego 1.8 m left of its lane is nearer to the return leg")
def _():
    command = cruise(Road(out_and_back()), 12.0).step(0.0, along(10.0, y=1.8), [])
    return [("status", command.status.name, "==", "OK")]
