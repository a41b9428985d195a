"""An ego off its lane, low friction, reasons of braking, loss of the ego's state."""

import math

import numpy as np

from cca_core import Path, Road
from cca_core.sim import ima, simulate
from tests.trials.driving import CAR, World, cruise, curve, drive, pose_on, remote, straight
from tests.trials.faults.scenes import ADJACENT, FAR, ICY_CAR, OPPOSING, min_gap, no_traffic, on_lane
from tests.trials.faults.table import Check, Table

TABLE = Table()
NO_CAUSE = "keeping lane", "speeding up"  # of braking, in a reason


@TABLE.case(
    "off-lane", "off-lane-standing-car", "the ego is 2.5 m left of its route, a stationary car in front of it"
)
def _():
    return min_gap(on_lane(6.0, lambda t, _: [remote("car", 111.0, 2.5)], 8.0, ADJACENT, y=2.5), 0.2)


@TABLE.case("off-lane", "off-lane-slight", "the ego is 1.2 m left of its route, a stationary car at 2 m left")
def _():
    return min_gap(on_lane(3.0, lambda t, _: [remote("car", 108.0, 2.025)], 8.0, ADJACENT, 5.0, y=1.2), 0.2)


@TABLE.case(
    "off-lane", "oncoming-truck-over-line", "an oncoming truck 1 m over the line; there is space on the right"
)
def _():
    def world(t, _):
        return [remote("truck", 500.0 - 12.0 * t, 1.8, 12.0, math.pi, length=12.0, width=2.55)]

    return min_gap(on_lane(15.0, world, 22.0, OPPOSING, evasion=FAR), 0.2)


@TABLE.case("friction", "friction-bend", "mu = 0.2, reported and true: a curve of 80 m radius")
def _():
    planner = cruise(Road(curve(80.0)), 20.0, car=ICY_CAR)
    run = drive(planner, pose_on(curve(80.0), 20.0, 15.0), no_traffic, 20.0, car=ICY_CAR)
    return [("max d", run.magnitude("d"), "<=", 0.9)]


@TABLE.case("friction", "friction-standing-car", "mu = 0.2: a stationary car known from 400 m away")
def _():
    return min_gap(on_lane(20.0, lambda t, _: [remote("car", 500.0, 0.0)], 40.0, car=ICY_CAR))


def unexplained(path: Path, s: float, duration: float) -> list[Check]:
    """Count the cycles that brake whose reason does not tell of braking."""
    run = drive(cruise(Road(path), 20.0), pose_on(path, s, 20.0), no_traffic, duration)
    pairs = zip(run.column("a_x"), run.column("reason"), strict=True)
    wrong = sum(a < -0.5 and any(words in reason for words in NO_CAUSE) for a, reason in pairs)
    last = [("last reason", run.last("reason"), "lacks", words) for words in NO_CAUSE]
    return [("unexplained cycles", wrong, "==", 0), *last]


@TABLE.case("reasons", "reason-end-of-route", "the ego stops at the end of its route and gives that reason")
def _():
    return unexplained(straight(400.0), 200.0, 20.0)


@TABLE.case("reasons", "reason-bend", "the ego slows down for a curve of 30 m radius and gives that reason")
def _():
    return unexplained(curve(30.0), 20.0, 9.4)[:1]


@TABLE.case("reasons", "brake-that-accelerates", "crossing traffic has passed: no BRAKE with a_x above 0")
def _():
    log, wrong = simulate(ima(ego_type="v2v")), 0
    ends = [t for t, _, _ in log.decisions[1:]] + [math.inf]
    for (begin, action, _), end in zip(log.decisions, ends, strict=True):
        accelerating = (log.t >= begin) & (log.t < end) & (log.command[:, 1] > 0.1)
        wrong += (action == "BRAKE") * int(np.count_nonzero(accelerating))
    return [("cycles", wrong, "==", 0)]


def state_lost(path: Path, s_lost: float, world: World, limit: float) -> list[Check]:
    """Check that an ego without a state from a station on stops on the road."""
    lost = []

    def sensed(t, state):
        if lost or float(path.project((state.x, state.y))[0]) >= s_lost:
            lost.append(t)
        return None if lost else state

    run = drive(cruise(Road(path, ADJACENT), 20.0), pose_on(path, 20.0, 20.0), world, 25.0, sensed=sensed)
    return [
        *min_gap(run, 0.2),
        ("max d", run.magnitude("d"), "<=", limit),
        ("speed", run.last("v"), "<=", 0.1),
    ]


@TABLE.case(
    "minimal-risk", "state-lost-in-swerve", "no state in the middle of a maneuver: the ego stops on the road"
)
def _():
    return state_lost(straight(), 255.0, lambda t, _: [remote("parked", 320.0, 0.0)], 5.25 - 0.5 * CAR.width)


@TABLE.case(
    "minimal-risk",
    "state-lost-before-bend",
    "no state just before a curve of 150 m radius: stops on its lane",
)
def _():
    return state_lost(curve(150.0), 199.0, no_traffic, 0.9)
