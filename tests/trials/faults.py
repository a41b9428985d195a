"""Small cases in which the library once fell short, each with the right outcome.

Measures public results only: commands in a closed loop on `SingleTrackPlant`, tracks, paths, files read.
``python faults.py`` runs all cases (half a minute on one core), ``python faults.py ID...`` some (the name of a
group runs the group), ``python faults.py --list`` lists them. A line a case: id, HOLDS or FALLS SHORT, what was
measured, what is wanted; the counts at the end. Speeds are in m/s, distances in m, a_x and a_y in m/s^2.
"""

# fmt: off

import dataclasses
import json
import logging
import math
import tempfile
import warnings
import zipfile
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np

from cca_core import (
    EvasionSettings,
    InfeasibleError,
    InputError,
    Lane,
    LocalFrame,
    Planner,
    Road,
    VehicleState,
    fit_path,
)
from cca_core.path import clean_route, read_waypoints
from cca_core.sim import drive_commonroad, ima, load_log, read_bsm_log, read_commonroad, simulate
from cca_core.sim.study.store import StudyFile
from cca_core.v2x import Bsm, Tracker, TrackerSettings, decode_bsm, encode_bsm
from tests.trials.driving import (
    CAR,
    ROAD_HEIGHT,
    Radio,
    along,
    at,
    bend,
    box_distance,
    corners,
    cruise,
    drive,
    pose_on,
    remote,
    straight,
)
from tests.trials.table import Table, cpu, raised

TABLE = Table()
case = TABLE.case
FAR = EvasionSettings(awareness_range=math.inf)
TWO, ONCOMING = (Lane(d=0.0), Lane(d=3.5)), (Lane(d=0.0), Lane(d=3.5, direction=-1))
ICE = replace(CAR, mu=0.2)
FOLDER = tempfile.TemporaryDirectory()


def keeps_off(run, least: float = 0.5) -> list[tuple]:
    """Check that nobody was touched."""
    return [("least gap", run.least("gap"), ">=", least)]


def on_lane(v: float, world, duration: float, lanes=None, wanted: float | None = None, **more):
    """Ego at x = 100 of a straight road, which goes on at its speed unless `wanted` is another."""
    road = Road(straight(), lanes, speed_limit=36.0)
    planner = cruise(road, wanted or v, more.pop("evasion", None), more.get("car", CAR))
    return drive(planner, along(v, y=more.pop("y", 0.0)), world, duration, **more)


def by_radio(world, duration: float = 18.0, **settings):
    """Ego at 15 m/s on one lane, which knows others by their messages alone."""
    return on_lane(15.0, world, duration, radio=Radio(**settings))


def nobody(t, state):
    """An empty road."""
    return []


# routes that pass themselves


def out_and_back():
    """Route out along y = 0 and back along y = 3.5."""
    turn = [(620, -3), (640, -14), (660, -24), (685, -25), (703, -12), (708, 5), (700, 22), (680, 30), (655, 25)]
    out = [(float(x), 0.0) for x in range(0, 601, 10)]
    return fit_path([*out, *turn, (635, 13), (617, 5.5), *[(x, 3.5) for x, _ in out[::-1]]], tolerance=0.3)


def oval(laps: int):
    """Oval of two straights of 200 m and two half circles of 60 m radius, from (0, 0)."""
    half, lap = np.linspace(0.0, math.pi, 38)[:-1], [(float(x), 0.0) for x in range(0, 200, 5)]
    lap += [(200.0 + 60.0 * math.sin(a), 60.0 - 60.0 * math.cos(a)) for a in half]
    lap += [(200.0 - x, 120.0) for x, _ in lap[:40]]
    lap += [(-60.0 * math.sin(a), 60.0 + 60.0 * math.cos(a)) for a in half]
    return fit_path([*lap * laps, (0.0, 0.0)], tolerance=0.05)


case("routes", "route-out-and-back", "the way back is the oncoming lane: a parked van, an oncoming car",
     lambda: keeps_off(
    drive(cruise(Road(out_and_back(), ONCOMING), 15.0, FAR), along(15.0, 60.0), lambda t, _: [
        remote("van", 200.0, -0.5, length=6.0, width=2.0), remote("oncoming", 350.0 - 15.0 * t, 3.5, 15.0, math.pi)
    ], 18.0)
))
case("routes", "route-two-laps", "two laps of one road: a car stands on it in the first lap", lambda: keeps_off(
    drive(cruise(Road(oval(2)), 12.0), along(10.0, 5.0), lambda t, _: [remote("c", 150.0, 0.3)], 20.0)
))
case("routes", "route-ego-in-between", "the ego 1.8 m left of its lane is nearer to the way back", lambda: [
    ("status", cruise(Road(out_and_back()), 12.0).step(0.0, along(10.0, y=1.8), []).status.name, "==", "OK")
])

# ids and senders

case("ids", "id-twice-in-list", "two records with one id: a car beside, a standing car ahead", lambda: keeps_off(
    on_lane(15.0, lambda t, _: [remote("0", 55.0 + 15.0 * t, 3.5, 15.0), remote("0", 190.0, 0.0)], 12.0)
))
case("ids", "id-of-two-senders", "two senders under one temporary id: one beside, one stands ahead", lambda: keeps_off(
    by_radio(lambda t, _: [remote("a", 60.0 + 15.0 * t, 3.5, 15.0), remote("b", 300.0, 0.0)],
             sender=lambda v, t: "00000000")
))
case("ids", "id-own-message", "the ego's own message is heard back, 20 ms late", lambda: [
    ("least speed", by_radio(nobody, 5.0, echo=True).least("v"), ">=", 14.0)
])
case("ids", "sender-27-m-long", "a road train of 27 m stands on the lane and tells its length", lambda: keeps_off(
    by_radio(lambda t, _: [remote("00000003", 300.0, 0.0, length=27.0, width=2.55)])
))
case("ids", "record-45-m-long", "a tram of 45 m stands on the lane", lambda: keeps_off(
    on_lane(20.0, lambda t, _: [remote("tram", 190.0, 0.0, length=45.0, width=2.6)], 10.0)
))
case("ids", "sender-without-heading", "a slow car ahead never tells its heading", lambda: keeps_off(
    by_radio(lambda t, _: [remote("00000001", 200.0 + 5.0 * t, 0.0, 5.0)], fields=lambda v, t: {"psi": None})
))
case("ids", "sender-on-a-bridge", "a car stands on a bridge 8 m above the route; messages tell the height", lambda: [
    ("least speed", by_radio(
        lambda t, _: [remote("00000001", 290.0, 0.0, 0.0, math.pi / 2)], 12.0,
        fields=lambda v, t: {"elevation": ROAD_HEIGHT + 8.0},
    ).least("v"), ">=", 14.0)
])


@case("ids", "id-new-after-silence", "the leader is silent for 3 s and comes back under another id")
def _():
    run = by_radio(lambda t, _: [remote("lead", 150.0 + 15.0 * t, 0.0, 15.0)], 40.0,
                   sender=lambda v, t: None if 5.0 <= t < 8.0 else f"{11 if t < 5.0 else 12:08x}")
    return [("least speed", run.least("v"), ">=", 3.0), ("speed at the end", run.last("v"), ">=", 13.0)]


@case("ids", "sender-without-gear", "a car backs out of a driveway and does not tell its gear")
def _():
    def world(t, _):
        moving = min(max(t - 4.0, 0.0), 6.0)
        return [remote("00000006", 240.0, 18.0 - 3.0 * moving, -3.0 * (0.0 < moving < 6.0), math.pi / 2)]

    return keeps_off(by_radio(world, fields=lambda v, t: {"transmission": None}))


@case("ids", "bsm-repeated-mark", "hard_braking told in a message with the second mark of the one before")
def _():
    tracker = Tracker(LocalFrame(40.0, -83.0))
    for count, mark, events in ((1, 23.8, ()), (2, 23.9, ()), (3, 23.9, ("hard_braking",))):
        tracker.update(encode_bsm(Bsm(
            msg_count=count, id="00c0ffee", sec_mark=mark, latitude_deg=40.0, longitude_deg=-83.0 + mark * 1.7e-4,
            speed=14.5, psi=0.0, a_x=0.0, length=4.5, width=1.8, events=frozenset(events),
        )), 23.75 + 0.1 * count)
    return [("events", sorted(tracker.vehicles(24.06)[0].events), "has", "hard_braking")]


# clock and time


def clock_off(by: float) -> list[tuple]:
    """A standing sender, and a receiver whose clock is off: no contact, or at least told to be blind."""
    run = by_radio(lambda t, _: [remote("00000003", 300.0, 0.0)], clock=by)
    return [("no contact or told", run.least("gap") >= 0.5 or run.blind, "==", True)]


def slowed(least: float, **how) -> list[tuple]:
    """An empty road at 20 m/s."""
    return [("least speed", on_lane(20.0, nobody, 8.0, **how).least("v"), ">=", least)]


case("time", "clock-0.3-s-behind", "the receiver's clock is 0.3 s behind the senders'", lambda: clock_off(-0.3))
case("time", "clock-18-s-ahead", "the receiver's clock is GPS time, the senders' UTC", lambda: clock_off(18.0))
case("time", "time-twice", "one time stamp comes twice",
     lambda: slowed(19.5, clock=lambda t: 1.98 if abs(t - 2.0) < 1e-6 else t))
case("time", "time-set-back", "the clock is set back by 5 s", lambda: slowed(18.0, clock=lambda t: t - 5.0 * (t > 2.0)))
case("time", "place-outlier", "the ego's place jumps 20 m aside for one cycle",
     lambda: slowed(19.5, sensed=lambda t, s: replace(s, y=s.y + 20.0) if abs(t - 2.0) < 1e-6 else s))

# cut-ins


def cutter(v: float, gap: float, sideways: float, v_ego: float, begins: float = 3.0, beside: float = 3.5):
    """A car on the lane to the left that comes over, `gap` ahead of an ego which keeps its speed until then."""

    def world(t, _):
        d = max(abs(beside) - sideways * max(t - begins, 0.0), 0.0)
        aside = sideways if t > begins and d > 0.0 else 0.0
        side = math.copysign(1.0, beside)
        x = 104.5 + v_ego * begins + gap + v * (t - begins)
        return [remote("cutter", x, side * d, math.hypot(v, aside), -side * math.atan2(aside, v))]

    return world


@case("cut-ins", "cut-in-10-slower", "one lane: a car 10 m/s slower comes over 25 m ahead; braking avoids it")
def _():
    run = on_lane(15.0, cutter(5.0, 25.0, 3.5 / 3.0, 15.0), 9.0)
    return [*keeps_off(run), ("actions", run.actions, "lacks", "EVADE_RIGHT")]


case("cut-ins", "cut-in-motorway", "two lanes, ego 30, other 20 comes over 20 m ahead with 0.8 m/s", lambda: keeps_off(
    on_lane(30.0, cutter(20.0, 20.0, 0.8, 30.0, 0.5), 9.0, TWO, evasion=FAR), 0.1
))
case("cut-ins", "cut-in-in-town", "two lanes, ego 15, other 8 comes over 9 m ahead with 0.8 m/s", lambda: keeps_off(
    on_lane(15.0, cutter(8.0, 9.0, 0.8, 15.0, 0.5), 9.0, TWO, evasion=FAR), 0.1
))

# leaders and long vehicles


def truck_and_car(v: float, v_car: float, behind: float):
    """A truck of 18 m at 2 m/s, its rear 8 m ahead; an uncertain car beside it on the next lane."""
    lanes = Lane(d=0.0, width=3.0), Lane(d=3.0, width=3.0)
    return on_lane(v, lambda t, _: [
        remote("truck", 119.25 + 2.0 * t, 0.0, 2.0, length=18.0, width=2.5),
        remote("car", 119.25 - behind + v_car * t, 2.9, v_car, sigma_across=0.5),
    ], 8.0, lanes, 14.0)


case("leaders", "leader-truck-car-beside", "a car beside the truck ahead does not hide the truck's rear", lambda: [
    ("largest a_x in 0.5 s", max(truck_and_car(7.0, 9.0, 3.25).column("a_x")[:25]), "<=", 0.1)
])
case("leaders", "leader-truck-driven", "the same driven: ego at 7 behind a truck at 2, car at 6 m/s",
     lambda: keeps_off(truck_and_car(7.0, 6.0, 9.0)))


@case("leaders", "long-bus-in-bend", "a bus of 20 m stands on the oncoming lane of a bend of 40 m radius")
def _():
    path = bend(40.0, 60.0, math.pi)
    bus = at(path, "bus", 60.0 + 40.0 * math.pi / 3.0, 3.5, length=20.0, width=2.55, oncoming=True)
    return keeps_off(drive(cruise(Road(path, ONCOMING), 12.0), pose_on(path, 5.0, 8.0), lambda t, _: [bus], 14.0), 0.3)


@case("leaders", "told-braking-and-silence", "an oncoming truck told braking, is silent for 0.95 s, and accelerates")
def _():
    radio, age, road = Radio(), 0.95, Road(straight(), ONCOMING, speed_limit=30.0)
    for n in range(6):
        back = 0.1 * (5 - n)
        truck = remote("0000000a", 472.0 + 9.0 * back, 3.5, 9.0, math.pi, a_x=-8.0 * (n == 5), length=10.0, width=2.5)
        lead = remote("0000000b", 160.0 - 15.0 * (0.05 + back), 0.0, 15.0)
        for vehicle, t in ((truck, 10.0 - age - back), (lead, 9.95 - back)):
            radio.tracker.update(radio.message(vehicle, t, vehicle.id, n, t), t + 0.02)
    command = cruise(road, 25.0, FAR).step(10.0, along(25.0), radio.tracker.vehicles(10.0, along(25.0)))
    least, s = math.inf, 100.0
    while command.decision.action.is_evading and s < command.reference.end:  # as planned, the truck at its bounds
        (x, y), t = command.reference.position(s), (s - 100.0) / 25.0
        ego = corners(float(x), float(y), float(command.reference.heading(s)), CAR.length, CAR.width)
        truck = 472.0 - 9.0 * (t + age) - 1.5 * (t + age) ** 2
        least, s = min(least, box_distance(ego, corners(truck, 3.5, math.pi, 10.0, 2.5))), s + 1.0
    return [("least gap", least, ">=", 0.5)]


# following comfort


def gentle(world, least: float = -3.0, lanes=None) -> list[tuple]:
    """An ego at 22 m/s keeps off and brakes gently."""
    run = on_lane(22.0, world, 9.0, lanes)
    return [*keeps_off(run), ("least a_x", run.least("a_x"), ">=", least)]


def ahead(v: float, gap: float, **more):
    """A leader met at a gap."""
    return lambda t, _: [remote("lead", 104.5 + gap + v * t, 0.0, v, **more)]


case("following", "follow-short-gap", "20 m behind a leader of the same 22 m/s", lambda: gentle(ahead(22.0, 20.0)))
case("following", "follow-faster-leader", "20 m behind a leader that draws away", lambda: gentle(ahead(23.0, 20.0)))
case("following", "follow-cut-in-as-fast", "a car of equal speed comes over 20 m ahead",
     lambda: gentle(cutter(22.0, 20.0, 1.2, 22.0, 2.0), -3.5, TWO))


@case("following", "brakes-let-go", "a body is seen for 0.6 s only; the brakes are let go when it is gone")
def _():
    def told(t, _):
        return [remote("ghost", 130.0 + 20.0 * t, 0.0)] if 2.0 <= t < 2.6 else []

    run = on_lane(20.0, nobody, 6.0, told=told)
    late = min(a_x for t, a_x in zip(run.column("t"), run.column("a_x"), strict=True) if t > 3.6)
    return [("least a_x after 1 s", late, ">=", -0.5), ("least speed", run.least("v"), ">=", 14.0)]


# stopping for ever, told accelerations, swerves at low speed


@case("maneuvers", "stop-behind-hidden", "a standing car was hidden by the leader, which moves over; left is free")
def _():
    run = on_lane(20.0, lambda t, _: [
        remote("stopped", 500.0, 0.0), remote("lead", 140.0 + 20.0 * t, min(max(t - 12.0, 0.0) / 3.0 * 3.5, 3.5), 20.0)
    ], 50.0, TWO)
    return [*keeps_off(run), ("way driven", run.last("s"), ">=", 520.0)]


def stop_and_go(t_free: float, t_go: float = 99.0, a_go: float = 0.0, most: float = 4.0, lanes=TWO) -> list[tuple]:
    """A leader brakes to a stand and may drive off again; a car beside is gone at `t_free`."""
    x, v, t_now = 128.5, 14.0, 0.0

    def world(t, state):
        nonlocal x, v, t_now
        while True:
            a = 0.0 if t_now < 2.0 else -7.0 * (v > 0.0) if t_now < t_go else a_go * (v < 14.0)
            if t_now > t - 1e-9:
                break
            was, v, t_now = v, max(v + 0.02 * a, 0.0), t_now + 0.02
            x += 0.01 * (v + was)
        beside = [remote("beside", state.x, lanes[1].d, state.v_x)] if t < t_free else []
        return [remote("lead", x, 0.0, v, a_x=a), *beside]

    run = on_lane(14.0, world, 14.0, lanes, 22.0, evasion=FAR)
    return [*keeps_off(run, 0.9), ("largest a_y", run.largest("a_y"), "<=", most)]


case("maneuvers", "swerve-at-low-speed", "a leader has stopped, left becomes free: lateral_acceleration_limit is kept at 6-9 m/s",
     lambda: stop_and_go(3.5))
case("maneuvers", "passed-drives-off", "the vehicle that is being passed drives off, and says so",
     lambda: stop_and_go(3.8, 4.2, 2.6, 4.2))
case("maneuvers", "told-acceleration-stays", "a slow leader tells a_x = 1 all the time and stays at 12 m/s", lambda: [
    ("actions", on_lane(12.0, ahead(12.0, 25.5, a_x=1.0), 30.0, TWO, 22.0).actions, "has", "EVADE_LEFT")
])

# ego off its lane, oncoming vehicles partly in it, friction

case("off-lane", "off-lane-standing-car", "the ego is 2.5 m left of its route, a car stands in front of it",
     lambda: keeps_off(
    on_lane(6.0, lambda t, _: [remote("car", 111.0, 2.5)], 8.0, TWO, y=2.5), 0.2
))
case("off-lane", "off-lane-slight", "the ego is 1.2 m left of its route, a car stands at 2 m left", lambda: keeps_off(
    on_lane(3.0, lambda t, _: [remote("car", 108.0, 2.025)], 8.0, TWO, 5.0, y=1.2), 0.2
))
case("off-lane", "oncoming-truck-over-line", "an oncoming truck 1 m over the line; there is room on the right",
     lambda: keeps_off(
    on_lane(15.0, lambda t, _: [remote("truck", 500.0 - 12.0 * t, 1.8, 12.0, math.pi, length=12.0, width=2.55)], 22.0,
            ONCOMING, evasion=FAR), 0.2
))
case("friction", "friction-bend", "mu = 0.2 told and true: a bend of 80 m radius", lambda: [("largest d", drive(
    cruise(Road(bend(80.0)), 20.0, car=ICE), pose_on(bend(80.0), 20.0, 15.0), nobody, 20.0, car=ICE
).largest("d"), "<=", 0.9)])
case("friction", "friction-standing-car", "mu = 0.2: a standing car known from 400 m away", lambda: keeps_off(
    on_lane(20.0, lambda t, _: [remote("car", 500.0, 0.0)], 40.0, car=ICE)
))

# end of the route, honest reasons, minimal-risk stop


def unexplained(path, s: float, duration: float) -> list[tuple]:
    """Cycles that brake while the reason says that the lane ahead is free."""
    run = drive(cruise(Road(path), 20.0), pose_on(path, s, 20.0), nobody, duration)
    wrong = sum(a < -0.5 and "free" in why for a, why in zip(run.column("a_x"), run.column("reason"), strict=True))
    return [("unexplained cycles", wrong, "==", 0), ("last reason", run.last("reason"), "lacks", "ahead is free")]


case("reasons", "reason-end-of-route", "the ego stops at the end of its route and says why",
     lambda: unexplained(straight(400.0), 200.0, 20.0))
case("reasons", "reason-bend", "the ego slows down for a bend of 30 m radius and says why",
     lambda: unexplained(bend(30.0), 20.0, 9.4)[:1])


@case("reasons", "brake-that-accelerates", "crossing traffic has passed: no BRAKE with a_x above 0")
def _():
    log, wrong = simulate(ima(ego="v2v")), 0
    ends = [t for t, _, _ in log.decisions[1:]] + [math.inf]
    for (begin, action, _), end in zip(log.decisions, ends, strict=True):
        wrong += (action == "BRAKE") * int(((log.t >= begin) & (log.t < end) & (log.command[:, 1] > 0.1)).sum())
    return [("cycles", wrong, "==", 0)]


def state_lost(path, s_lost: float, world, most: float, lanes=TWO) -> list[tuple]:
    """No state any more from a place on: the ego comes to stand on the road."""
    lost = []

    def sensed(t, state):
        if lost or float(path.project((state.x, state.y))[0]) >= s_lost:
            lost.append(t)
        return None if lost else state

    run = drive(cruise(Road(path, lanes), 20.0), pose_on(path, 20.0, 20.0), world, 25.0, sensed=sensed)
    return [*keeps_off(run, 0.2), ("largest d", run.largest("d"), "<=", most), ("speed", run.last("v"), "<=", 0.1)]


case("minimal-risk", "state-lost-in-swerve", "no state in the middle of a swerve: stands on the road, not beside it",
     lambda: state_lost(straight(), 255.0, lambda t, _: [remote("parked", 320.0, 0.0)], 5.25 - 0.5 * CAR.width))
case("minimal-risk", "state-lost-before-bend", "no state just before a bend of 150 m radius: stands on its lane",
     lambda: state_lost(bend(150.0), 199.0, nobody, 0.9))

# path fitting


class Ears(logging.Handler):
    """Listens to the library's warnings, whichever way they come."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.heard = False

    def emit(self, record: logging.LogRecord) -> None:
        """Take in a line of the log."""
        self.heard = True

    def listen(self, function):
        """Call a function; return its result and whether it warned."""
        logger = logging.getLogger("cca_core")
        logger.addHandler(self)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            result = function()
        logger.removeHandler(self)
        return result, self.heard or bool(caught)


def drivable(points, least: float, **settings) -> list[tuple]:
    """The path has no radius below `least`, or is refused, or somebody warns."""

    def made():
        path = fit_path(clean_route(points).parts[0], **settings)
        Planner(CAR, Road(path, speed_limit=25.0), cruise_speed=20.0)
        return path

    try:
        path, warned = Ears().listen(made)
    except InfeasibleError:
        return [("drivable or told", True, "==", True)]
    radius = 1.0 / max(float(np.abs(path.curvature(np.arange(path.start, path.end, 0.1))).max()), 1e-9)
    return [("least radius", radius, ">=", 0.0), ("drivable or told", radius >= least or warned, "==", True)]


def winding(n: int, spacing: float, radius: float, seed: int, noise: float) -> np.ndarray:
    """Noisy waypoints of a road that winds with a least radius."""
    s = spacing * np.arange(n)
    psi = np.cumsum(np.sin(2.0 * math.pi * s / 700.0)) * spacing / radius
    xy = np.column_stack((np.cumsum(np.cos(psi)), np.cumsum(np.sin(psi)))) * spacing
    return xy + np.random.default_rng(seed).normal(0.0, noise, xy.shape)


def u_turn(length: float, width: float, most: float, limit: float) -> list[tuple]:
    """Out and back: the path passes near all waypoints, or is refused."""
    x = np.arange(0.0, length + 1.0, 10.0)
    points = np.vstack((np.column_stack((x, 0.0 * x)), np.column_stack((x[::-1], 0.0 * x + width))))
    try:
        sampled = fit_path(points, tolerance=1.0, curvature_limit=limit).sample(0.2)
    except InfeasibleError:
        return [("refused", True, "==", True)]
    return [("farthest waypoint", max(float(np.hypot(*(sampled - p).T).min()) for p in points), "<=", most)]


STANDING = np.array([
    (0, 0), (-6.7, 0.8), (-6.1, 3.8), (-9, 4.7), (-0.6, -0.8), (8.8, -3.8), (12.9, -7.2), (16, -9.3), (19.6, -11),
    (23.8, -11.4), (28.8, -10.2), (34.3, -8.5),
])
case("path", "u-turn-with-limit", "a U-turn 4 m wide with curvature_limit: no chord from first to last point",
     lambda: u_turn(300.0, 4.0, 12.0, 0.15))
case("path", "noisy-gps-default", "receiver noise of 1 m at the default tolerance: half the true radius, or told",
     lambda: drivable(winding(300, 8.0, 111.0, 1, 1.0), 55.0))
case("path", "standing-receiver", "the receiver stands at the start: drivable, or told",
     lambda: drivable(STANDING, 4.0, tolerance=1.0))


@case("path", "tolerance-monotone", "what can be fitted within 0.5 m can be fitted within more")
def _():
    points, tried = [(0, 0), (-0.1533, -1.1736), (100.65, -14.3058), (429.9056, -162.1269)], (0.5, 1.0, 2.0, 5.0, 20.0)
    wrong = [most for most in tried if raised(lambda most=most: fit_path(points, tolerance=most))]
    return [("tolerances that fail", wrong, "==", [])]


def told_too_far(points, tolerance: float) -> list[tuple]:
    """`Path.project` without `near` gives the nearest point."""
    path = fit_path(points, tolerance=tolerance)
    true = float(np.hypot(*path.position(np.arange(path.start, path.end, 0.001)).T).min())
    return [("distance told beyond the true one", abs(float(path.project((0.0, 0.0))[1])) - true, "<=", 0.01)]


case("path", "project-nearest", "project without near gives the nearest point of a tight path", lambda: told_too_far(
    [(-3.33, 5.51), (-4.38, 6.9), (-3.22, 4.23), (0, 0), (-0.39, 1.49), (-1.6, 1.06)], 0.5
))

# files


def file(name: str, content: str) -> FilePath:
    """Write a file into a folder that is removed at the end."""
    path = FilePath(FOLDER.name) / name
    path.write_text(content, encoding="utf-8")
    return path


POINTS = '<trkpt lat="48.000" lon="11.0"/><trkpt lat="48.001" lon="11.0"/>'


@case("files", "gpx-segments", "two track segments 215 m apart: the reader tells of the break")
def _():
    rows = ["".join(f'<trkpt lat="{b + 1e-4 * i}" lon="11.0"/>' for i in range(20)) for b in (48.0, 48.0038)]
    name = file("two.gpx", "<gpx><trk>" + "".join(f"<trkseg>{r}</trkseg>" for r in rows) + "</trk></gpx>")
    points, told = Ears().listen(lambda: read_waypoints(name))
    for extra in {f.name for f in dataclasses.fields(points)} - {"lat", "lon", "duplicates"}:
        value = np.asarray(getattr(points, extra), dtype=object)  # two segments, or the row where the second begins
        told = told or 20 in value.ravel().tolist() or (value.ndim > 0 and len(value) == 2)
    return [("told", told, "==", True)]


@case("files", "gpx-doctype", "a GPX file with a document type declaration is refused")
def _():
    name = file("doctype.gpx", f'<!DOCTYPE g [<!ENTITY x "41.5">]><gpx><trkpt lat="&x;" lon="1"/>{POINTS}</gpx>')
    return [("raises", raised(lambda: read_waypoints(name)), "==", "InputError")]


def seconds(text: str) -> float:
    """CPU time of reading a GPX file [s]; to refuse it counts as well."""
    name = file("long.gpx", text)
    return cpu(lambda: raised(lambda: read_waypoints(name), InputError))


@case("files", "gpx-long-attribute", "an attribute of 8 MB takes less than 1 s, and not the square of its length")
def _():
    short, long = (seconds(f'<gpx name="{"a" * n}">{POINTS}</gpx>') for n in (2_000_000, 8_000_000))
    return [("seconds", long, "<=", 1.0), ("growth", long / max(short, 0.02), "<=", 8.0)]


case("files", "gpx-deep", "1 500 000 nested elements are refused, or read in less than 1 s", lambda: [
    ("seconds", seconds("<gpx>" + "<a>" * 1_500_000 + POINTS + "</a>" * 1_500_000 + "</gpx>"), "<=", 1.0)
])
case("files", "csv-empty-row", "a row without a fix is left out, the others are read", lambda: [
    ("points", len(read_waypoints(file("a.csv", "lat,lon\n48.000,11\n,\n48.001,11\n48.002,11\n")).lat), "==", 3)
])


def only_input_error(*calls) -> list[tuple]:
    """No call raises anything but InputError."""
    return [("other errors", sorted({name for call in calls if (name := raised(call, InputError))}), "==", [])]


@case("files", "log-bad-files", "load_log: an array, odd or deep contents, a header that claims 7 TB")
def _():
    folder = FilePath(FOLDER.name)
    names = [folder / "a.npy", *(folder / f"{i}.npz" for i in range(5))]
    np.save(names[0], np.zeros(3))
    for name, meta in zip(names[1:], (b"[1, 2]", b"1", b'{"version": 1}', b"[" * 100_000), strict=False):
        np.savez(name, meta=np.frombuffer(meta, dtype=np.uint8))
    with zipfile.ZipFile(names[-1], "w") as archive, archive.open("t.npy", "w") as member:
        np.lib.format.write_array_header_1_0(member, {"descr": "<f8", "fortran_order": False, "shape": (10**12,)})
    return only_input_error(*(lambda n=n: load_log(n) for n in names))


case("files", "frames-bad-files", "read_bsm_log: commas alone, huge numbers, deep nesting, a long field",
     lambda: only_input_error(*(lambda n=n, t=t: read_bsm_log(file(n, t)) for n, t in (
         ("a.txt", ",\n"), ("b.txt", "00\n,,,\n"), ("c.json", '[{"hex":"00","t":' + "1" * 400 + "}]"),
         ("d.json", '[{"hex":"00","t":' + "1" * 5000 + "}]"), ("e.json", "[" * 100_000),
         ("f.csv", "t,hex\n1," + "0" * 200_000 + "\n"),
     ))))


@case("files", "study-bad-files", "StudyFile: a row nested 100 000 deep; numbers of runs that are none")
def _():
    head = json.dumps({"study": "x"})
    rows = ["[" * 100_000, '{"index": "0"}', '{"index": NaN}', '{"index": -1}']
    names = [file(f"study{i}.jsonl", f"{head}\n{row}\n") for i, row in enumerate(rows)]
    taken = sum(not raised(lambda n=n: StudyFile(n, "x")) for n in names[1:])
    return [*only_input_error(*(lambda n=n: StudyFile(n, "x") for n in names)), ("odd rows taken", taken, "==", 0)]


case("files", "numbers-too-large", "10**400 in settings and states raises InputError", lambda: only_input_error(
    lambda: replace(CAR, m=10**400), lambda: VehicleState(x=10**400, y=0.0, psi=0.0, v_x=0.0), lambda: Lane(d=10**400),
    lambda: LocalFrame(10**400, 0.0), lambda: EvasionSettings(clearance=10**400),
    lambda: TrackerSettings(approach_horizon=10**400), lambda: Planner(CAR, straight(), cruise_speed=10**400),
))

# messages in wrappers

FRAME = encode_bsm(Bsm(msg_count=5, id="00c0ffee", sec_mark=1.0, latitude_deg=40.0, longitude_deg=-83.0, speed=13.9))


def wrapped(kind: str, frame: bytes = FRAME, psid: int = 0x20) -> bytes:
    """A message in IEEE 1609.2 unsecured or signed data, or in a WSMP packet (IEEE 1609.3, version 3)."""
    unsecured = bytes((3, 0x80, len(frame))) + frame
    if kind == "signed":  # SHA-256, payload, PSID and generation time, digest of the certificate, signature
        return (bytes((3, 0x81, 0, 0x40)) + unsecured + bytes((0x40, 1, psid)) + bytes(8)
                + b"\x80" + bytes(8) + b"\x80\x80" + bytes(64))
    return unsecured if kind == "unsecured" else bytes((3, 0, psid, len(unsecured))) + unsecured


def found(data: bytes) -> list[tuple]:
    """The message in a wrapper is found."""
    return [("id", decode_bsm(data).id, "==", "00c0ffee")]


case("wrappers", "bsm-unsecured", "IEEE 1609.2 unsecured data around the message", lambda: found(wrapped("unsecured")))
case("wrappers", "bsm-signed", "IEEE 1609.2 signed data around the message", lambda: found(wrapped("signed")))
case("wrappers", "bsm-wsmp", "a WSMP packet with unsecured data around the message", lambda: found(wrapped("wsmp")))

# CommonRoad


def moment(tag: str, step: int, x: float, y: float = 0.0, v: float = 15.0) -> str:
    """State of a recorded vehicle."""
    return (f"<{tag}><position><point><x>{x}</x><y>{y}</y></point></position><orientation><exact>0.0</exact>"
            f"</orientation><time><exact>{step}</exact></time><velocity><exact>{v}</exact></velocity></{tag}>")


def recorded(name: int, x: float, y: float = 0.0, v: float = 15.0) -> FilePath:
    """Scenario of one straight lane, a goal 140 m ahead of the ego (id 900), and one car at constant speed."""
    bounds = "".join(
        f"<{tag}>" + "".join(f"<point><x>{a}</x><y>{b}</y></point>" for a in (0, 100, 200)) + f"</{tag}>"
        for tag, b in (("leftBound", 1.75), ("rightBound", -1.75))
    )
    goal = ("<goalState><position><rectangle><length>10</length><width>3.5</width><orientation>0</orientation><center>"
            "<x>150</x><y>0</y></center></rectangle></position><time><intervalStart>0</intervalStart><intervalEnd>150"
            "</intervalEnd></time></goalState>")
    states = "".join(moment("state", k, x + 0.1 * v * k, y, v) for k in range(1, 60))
    return file("scenario.xml", (
        '<commonRoad commonRoadVersion="2020a" timeStepSize="0.1" benchmarkID="ZAM_Test-1">'
        f'<lanelet id="1">{bounds}</lanelet><dynamicObstacle id="{name}"><type>car</type><shape><rectangle><length>4.5'
        f"</length><width>1.8</width></rectangle></shape>{moment('initialState', 0, x, y, v)}<trajectory>{states}"
        f'</trajectory></dynamicObstacle><planningProblem id="900">{moment("initialState", 0, 10.0)}{goal}'
        "</planningProblem></commonRoad>"
    ))


def collides(name: int) -> list[tuple]:
    """The ego's own recording is among the obstacles."""
    run = drive_commonroad(read_commonroad(recorded(name, 10.0)))
    return [("collided with", run.summary()["collided_with"], "==", [])]


case("commonroad", "commonroad-own-recording", "the ego's own recording is among the obstacles", lambda: collides(8))
case("commonroad", "commonroad-own-id", "the same, under the id of the planning problem", lambda: collides(900))

# what holds already and is to stay so


def stopping(t, state):
    """A leader at 22 m/s, 30 m ahead, that brakes with 7 m/s^2 from 1 s on."""
    braked = min(max(t - 1.0, 0.0), 22.0 / 7.0)
    x = 134.5 + 22.0 * min(t, 1.0 + braked) - 3.5 * braked**2
    return [remote("lead", x, 0.0, 22.0 - 7.0 * braked, a_x=-7.0 * (0.0 < braked < 22.0 / 7.0))]


case("controls", "control-brakes-hard", "the leader at 22 m/s, 30 m ahead, brakes with 7 m/s^2 to a stand",
     lambda: keeps_off(on_lane(22.0, stopping, 10.0)))
case("controls", "control-one-way-van", "a parked van and an oncoming car on a road that does not come back",
     lambda: keeps_off(
    on_lane(15.0, lambda t, _: [
        remote("van", 240.0, -0.5, length=6.0, width=2.0), remote("oncoming", 390.0 - 15.0 * t, 3.5, 15.0, math.pi)
    ], 18.0, ONCOMING, evasion=FAR)
))
case("controls", "control-sender-26-m", "a road train of 26 m by messages", lambda: keeps_off(
    by_radio(lambda t, _: [remote("00000003", 300.0, 0.0, length=26.0, width=2.55)])
))
case("controls", "control-clock-0.9-s", "the receiver's clock is 0.9 s ahead, within the window",
     lambda: clock_off(0.9))
case("controls", "control-passes", "a standing car that nobody hid is passed on the free lane to the left", lambda: [
    ("way driven", on_lane(20.0, lambda t, _: [remote("c", 300.0, 0.0)], 20.0, TWO).last("s"), ">=", 320.0)
])

# commands and time of a cycle


@case("commands", "cruise-speed-set-later", "planner.cruise_speed set to 10 after construction acts, or is refused")
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


def slowest(radius: float, seed: int, scenes: int = 150) -> list[tuple]:
    """Worst CPU time of a first step among random scenes on a bend: leader and two oncoming."""
    rng, worst, path = np.random.default_rng(seed), 0.0, bend(radius, 200.0, 3.0)
    for _ in range(scenes):
        v, s = rng.uniform(8.0, 28.0), rng.uniform(200.0, 400.0)
        others = [at(path, "lead", s + rng.uniform(1.5, 3.5) * v, rng.uniform(-0.5, 0.5), v * rng.uniform(0.2, 0.7))]
        for name in ("a", "b"):
            others.append(at(path, name, s + rng.uniform(150.0, 500.0), 3.5, rng.uniform(10.0, 25.0), oncoming=True))
        planner, state = cruise(Road(path, ONCOMING, speed_limit=30.0), 28.0, FAR), pose_on(path, s, v)
        worst = max(worst, cpu(lambda p=planner, s=state, o=others: p.step(0.0, s, o)))
    return [("milliseconds", 1e3 * worst, "<=", 20.0)]


case("commands", "cycle-time", "worst CPU time of a first step among 150 scenes on a bend", lambda: slowest(300.0, 7))

if __name__ == "__main__":
    TABLE.main(__doc__.splitlines()[0])
