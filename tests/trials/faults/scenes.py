"""Roads, drives and checks that several groups of cases use."""

import math
from dataclasses import replace

from cca_core import EvasionSettings, Lane, Road
from tests.trials.driving import CAR, Drive, World, along, cruise, drive, remote, straight
from tests.trials.faults.table import Check
from tests.trials.radio import Radio

FAR = EvasionSettings(awareness_range=math.inf)
ADJACENT = Lane(d=0.0), Lane(d=3.5)
OPPOSING = Lane(d=0.0), Lane(d=3.5, direction=-1)
ICY_CAR = replace(CAR, mu=0.2)


def min_gap(run: Drive, limit: float = 0.5) -> list[Check]:
    """Check that the ego keeps a gap."""
    return [("min gap", run.minimum("gap"), ">=", limit)]


def on_lane(
    v: float, world: World, duration: float, lanes=None, cruise_speed: float | None = None, **more
) -> Drive:
    """Drive from x = 100 of a straight road, at `cruise_speed` or else on at the first speed."""
    road = Road(straight(), lanes, speed_limit=36.0)
    planner = cruise(road, cruise_speed or v, more.pop("evasion", None), more.get("car", CAR))
    return drive(planner, along(v, y=more.pop("y", 0.0)), world, duration, **more)


def by_radio(world: World, duration: float = 18.0, **settings) -> Drive:
    """Drive at 15 m/s on one lane; the ego knows other vehicles by their messages only."""
    return on_lane(15.0, world, duration, radio=Radio(**settings))


def no_traffic(t, state):
    """An empty road."""
    return []


def clock_off(offset: float) -> list[Check]:
    """A stationary sender, and a receiver whose clock is off: no collision, or at least reported as blind."""
    run = by_radio(lambda t, _: [remote("00000003", 300.0, 0.0)], clock=offset)
    return [("no collision or reported", run.minimum("gap") >= 0.5 or run.blind, "==", True)]


def lead_at(v: float, gap: float, **more) -> World:
    """A lead vehicle met at a gap."""
    return lambda t, _: [remote("lead", 104.5 + gap + v * t, 0.0, v, **more)]


def cutter(
    v: float, gap: float, v_lateral: float, v_ego: float, begins: float = 3.0, d_0: float = 3.5
) -> World:
    """A car cuts in from an adjacent lane, `gap` ahead of an ego that keeps its speed until then."""

    def world(t, _):
        d = max(abs(d_0) - v_lateral * max(t - begins, 0.0), 0.0)
        v_d = v_lateral if t > begins and d > 0.0 else 0.0
        side = math.copysign(1.0, d_0)
        x = 104.5 + v_ego * begins + gap + v * (t - begins)
        return [remote("cutter", x, side * d, math.hypot(v, v_d), -side * math.atan2(v_d, v))]

    return world
