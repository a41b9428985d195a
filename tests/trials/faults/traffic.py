"""Cut-ins, lead vehicles, following, maneuvers."""

import math

from cca_core import Lane, Road
from tests.trials.boxes import box_distance, corners
from tests.trials.driving import CAR, Drive, World, along, at, cruise, curve, drive, pose_on, remote, straight
from tests.trials.faults.scenes import ADJACENT, FAR, OPPOSING, cutter, lead_at, min_gap, no_traffic, on_lane
from tests.trials.faults.table import Check, Table
from tests.trials.radio import Radio

TABLE = Table()


@TABLE.case(
    "cut-ins", "cut-in-10-slower", "one lane: a car 10 m/s slower cuts in 25 m ahead; braking avoids it"
)
def _():
    run = on_lane(15.0, cutter(5.0, 25.0, 3.5 / 3.0, 15.0), 9.0)
    return [*min_gap(run), ("actions", run.actions, "lacks", "EVADE_RIGHT")]


@TABLE.case("cut-ins", "cut-in-motorway", "two lanes, ego 30, a car at 20 cuts in 20 m ahead with 0.8 m/s")
def _():
    return min_gap(on_lane(30.0, cutter(20.0, 20.0, 0.8, 30.0, 0.5), 9.0, ADJACENT, evasion=FAR), 0.1)


@TABLE.case("cut-ins", "cut-in-in-town", "two lanes, ego 15, a car at 8 cuts in 9 m ahead with 0.8 m/s")
def _():
    return min_gap(on_lane(15.0, cutter(8.0, 9.0, 0.8, 15.0, 0.5), 9.0, ADJACENT, evasion=FAR), 0.1)


def truck_and_car(v: float, v_car: float, behind: float) -> Drive:
    """A truck of 18 m at 2 m/s, its rear 8 m ahead; an uncertain car alongside it on the adjacent lane."""
    lanes = Lane(d=0.0, width=3.0), Lane(d=3.0, width=3.0)

    def world(t, _):
        truck = remote("truck", 119.25 + 2.0 * t, 0.0, 2.0, length=18.0, width=2.5)
        return [truck, remote("car", 119.25 - behind + v_car * t, 2.9, v_car, sigma_across=0.5)]

    return on_lane(v, world, 8.0, lanes, 14.0)


@TABLE.case(
    "leaders", "leader-truck-car-beside", "a car alongside the truck ahead does not hide the truck's rear"
)
def _():
    return [("max a_x in 0.5 s", max(truck_and_car(7.0, 9.0, 3.25).column("a_x")[:25]), "<=", 0.1)]


@TABLE.case("leaders", "leader-truck-driven", "the same driven: ego at 7 behind a truck at 2, car at 6 m/s")
def _():
    return min_gap(truck_and_car(7.0, 6.0, 9.0))


@TABLE.case(
    "leaders", "long-bus-in-bend", "a bus of 20 m, stationary on the opposing lane of a curve of 40 m radius"
)
def _():
    path = curve(40.0, 60.0, math.pi)
    bus = at(path, "bus", 60.0 + 40.0 * math.pi / 3.0, 3.5, length=20.0, width=2.55, oncoming=True)
    run = drive(cruise(Road(path, OPPOSING), 12.0), pose_on(path, 5.0, 8.0), lambda t, _: [bus], 14.0)
    return min_gap(run, 0.3)


@TABLE.case(
    "leaders",
    "told-braking-and-silence",
    "an oncoming truck reports braking, sends nothing for 0.95 s, accelerates",
)
def _():
    radio, age, road = Radio(), 0.95, Road(straight(), OPPOSING, speed_limit=30.0)
    for n in range(6):
        back = 0.1 * (5 - n)
        x, a_x = 472.0 + 9.0 * back, -8.0 * (n == 5)
        truck = remote("0000000a", x, 3.5, 9.0, math.pi, a_x=a_x, length=10.0, width=2.5)
        lead = remote("0000000b", 160.0 - 15.0 * (0.05 + back), 0.0, 15.0)
        for vehicle, t in ((truck, 10.0 - age - back), (lead, 9.95 - back)):
            radio.tracker.update(radio.message(vehicle, t, vehicle.id, n, t), t + 0.02)
    command = cruise(road, 25.0, FAR).step(10.0, along(25.0), radio.tracker.vehicles(10.0, along(25.0)))
    gap, s = math.inf, 100.0
    while (
        command.decision.action.is_evading and s < command.reference.end
    ):  # as planned, at the truck's bounds
        (x, y), t = command.reference.position(s), (s - 100.0) / 25.0
        ego = corners(float(x), float(y), float(command.reference.heading(s)), CAR.length, CAR.width)
        x_truck = 472.0 - 9.0 * (t + age) - 1.5 * (t + age) ** 2
        gap, s = min(gap, box_distance(ego, corners(x_truck, 3.5, math.pi, 10.0, 2.5))), s + 1.0
    return [("min gap", gap, ">=", 0.5)]


def gentle(world: World, limit: float = -3.0, lanes=None) -> list[Check]:
    """Check that an ego at 22 m/s keeps a gap and brakes gently."""
    run = on_lane(22.0, world, 9.0, lanes)
    return [*min_gap(run), ("min a_x", run.minimum("a_x"), ">=", limit)]


@TABLE.case("following", "follow-short-gap", "20 m behind a lead of the same 22 m/s")
def _():
    return gentle(lead_at(22.0, 20.0))


@TABLE.case("following", "follow-faster-leader", "20 m behind a lead that is faster")
def _():
    return gentle(lead_at(23.0, 20.0))


@TABLE.case("following", "follow-cut-in-as-fast", "a car of equal speed cuts in 20 m ahead")
def _():
    return gentle(cutter(22.0, 20.0, 1.2, 22.0, 2.0), -3.5, ADJACENT)


@TABLE.case(
    "following", "brakes-let-go", "a ghost vehicle appears for 0.6 s; the brakes are released afterwards"
)
def _():
    def reported(t, _):
        return [remote("ghost", 130.0 + 20.0 * t, 0.0)] if 2.0 <= t < 2.6 else []

    run = on_lane(20.0, no_traffic, 6.0, reported=reported)
    late = min(a_x for t, a_x in zip(run.column("t"), run.column("a_x"), strict=True) if t > 3.6)
    return [("min a_x after 1 s", late, ">=", -0.5), ("min speed", run.minimum("v"), ">=", 14.0)]


@TABLE.case(
    "maneuvers",
    "stop-behind-hidden",
    "a stationary car was occluded by the lead, which moves over; left is free",
)
def _():
    def world(t, _):
        d = min(max(t - 12.0, 0.0) / 3.0 * 3.5, 3.5)
        return [remote("stopped", 500.0, 0.0), remote("lead", 140.0 + 20.0 * t, d, 20.0)]

    run = on_lane(20.0, world, 50.0, ADJACENT)
    return [*min_gap(run), ("distance driven", run.last("s"), ">=", 520.0)]


def stop_and_go(
    t_free: float, t_go: float = 99.0, a_go: float = 0.0, limit: float = 4.0, lanes=ADJACENT
) -> list[Check]:
    """A lead brakes to a standstill and may drive off again; a car alongside is gone at `t_free`."""
    x, v, t_now = 128.5, 14.0, 0.0

    def world(t, state):
        nonlocal x, v, t_now
        while True:
            a = 0.0 if t_now < 2.0 else -7.0 * (v > 0.0) if t_now < t_go else a_go * (v < 14.0)
            if t_now > t - 1e-9:
                break
            was, v, t_now = v, max(v + 0.02 * a, 0.0), t_now + 0.02
            x += 0.01 * (v + was)
        alongside = [remote("beside", state.x, lanes[1].d, state.v_x)] if t < t_free else []
        return [remote("lead", x, 0.0, v, a_x=a), *alongside]

    run = on_lane(14.0, world, 14.0, lanes, 22.0, evasion=FAR)
    return [*min_gap(run, 0.9), ("max a_y", run.magnitude("a_y"), "<=", limit)]


@TABLE.case(
    "maneuvers",
    "swerve-at-low-speed",
    "a lead has stopped, left becomes free: lateral_acceleration_limit is kept at 6-9 m/s",
)
def _():
    return stop_and_go(3.5)


@TABLE.case("maneuvers", "passed-drives-off", "the overtaken vehicle drives off and reports it")
def _():
    return stop_and_go(3.8, 4.2, 2.6, 4.2)


@TABLE.case(
    "maneuvers", "told-acceleration-stays", "a slow lead reports a_x = 1 all the time and stays at 12 m/s"
)
def _():
    run = on_lane(12.0, lead_at(12.0, 25.5, a_x=1.0), 30.0, ADJACENT, 22.0)
    return [("actions", run.actions, "has", "EVADE_LEFT")]
