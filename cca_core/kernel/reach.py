"""Where other vehicles may be: distances, reachable and occupied intervals, danger zones, occupancy boxes."""

import math
from typing import Annotated

from cca_core.kernel.box_gaps import norm
from cca_core.kernel.constants import STALE_AGE, STANDSTILL_SPEED
from cca_core.kernel.curve import SMALLEST_SPEED, Curve, curvature_of, curve_point
from cca_core.kernel.types import Grid, Int, Real, Reals

__all__ = [
    "danger_zones",
    "distances_driven",
    "occupancy_boxes",
    "occupied_intervals",
    "reachable_intervals",
    "vehicle_boxes",
]

Row = Annotated[Reals, "n"]
Times = Annotated[Reals, "times"]
Motions = Annotated[Grid, "vehicles", 8]
VehicleTimes = Annotated[Grid, "vehicles", "times"]
Zones = Annotated[Grid, "vehicles", 2]
PerVehicle = Annotated[Reals, "vehicles"]
Boxes = Annotated[Grid, "n", 5]
VehicleBoxes = Annotated[Grid, "vehicles * times", 5]

BELIEVED_BRAKING = -1.0  # harder braking lasts until standstill [m/s^2]
SMALLEST = 1e-300  # no denormal deceleration overflows a division [m/s^2]
WINDOW = 15.0  # bodies farther away do not matter, with both half lengths [m]

# columns of the motion of a vehicle
REAR = 0  # smallest station of its body now [m]
FRONT = 1
SPEED = 2  # along the road [m/s]
AGE = 3  # [s]
RATE = 4  # reported rate of change of the magnitude of the speed [m/s^2]
BRAKING = 5  # assumed maximum deceleration [m/s^2]
ACCELERATION = 6
A_X = 7  # reported acceleration, of a vehicle that keeps its motion [m/s^2]


def distance_driven(v: Real, a_x: Real, t: Real) -> Real:
    """Distance driven in a time; braking lasts until standstill, any other acceleration ends now."""
    if a_x >= BELIEVED_BRAKING or v <= 0.0:
        return v * t
    braking = min(max(t, 0.0), v / -a_x)
    return v * (braking + min(t, 0.0)) + 0.5 * a_x * braking * braking


def measured_motion(v: Real, age: Real, rate: Real, braking: Real) -> tuple[Real, Real, Real]:
    """Speed when it was measured, distance that dead reckoning has counted since, time until standstill."""
    speed = abs(v)
    known = min(age, STALE_AGE)
    measured = max(speed - rate * known, 0.0)
    stops = measured / max(braking, SMALLEST) if braking > 0.0 else math.inf
    return measured, speed * age - 0.5 * rate * known * known, stops


def reach(
    v: Real, t: Real, age: Real, braking: Real, acceleration: Real, measured: Real, counted: Real, stops: Real
) -> tuple[Real, Real]:
    """Smallest and largest displacement along the road within assumed limits."""
    shortest = abs(v) * t  # as if forwards; the speed was constant before now
    longest = shortest
    if t >= 0.0:
        since = t + age
        slows = min(since, stops)
        shortest = measured * slows - 0.5 * braking * slows * slows - counted
        longest = measured * since + 0.5 * acceleration * since * since - counted
    creeping = STANDSTILL_SPEED if acceleration > 0.0 else 0.0
    # one that stands by dead reckoning may not have braked
    low = -longest if v < creeping or v == 0.0 else shortest
    return low, longest if v > -creeping or v == 0.0 else -shortest


def distances_driven(n: Int, t: Row, v: Real, a_x: Real, distance: Row) -> None:
    """Distance driven at many times."""
    for i in range(n):
        distance[i] = distance_driven(v, a_x, t[i])


def reachable_intervals(
    n: Int, v: Row, t: Row, age: Row, rate: Row, braking: Real, acceleration: Real, low: Row, high: Row
) -> None:
    """Displacements that vehicles can reach, one time for each."""
    for i in range(n):
        measured, counted, stops = measured_motion(v[i], age[i], rate[i], braking)
        low[i], high[i] = reach(v[i], t[i], age[i], braking, acceleration, measured, counted, stops)


def occupied_intervals(
    vehicles: Int, times: Int, motion: Motions, t: Times, rear: VehicleTimes, front: VehicleTimes
) -> None:
    """Stations that the bodies of vehicles may cover at common times."""
    for k in range(vehicles):
        begin = motion[k, REAR]
        end = motion[k, FRONT]
        v = motion[k, SPEED]
        age = motion[k, AGE]
        b = motion[k, BRAKING]
        a = motion[k, ACCELERATION]
        keeps = b == 0.0 and a == 0.0
        measured, counted, stops = measured_motion(v, age, motion[k, RATE], b)
        for i in range(times):
            if keeps:
                low = math.copysign(1.0, v) * distance_driven(abs(v), motion[k, A_X], t[i])
                rear[k, i] = begin + low
                front[k, i] = end + low
            else:
                first, last = reach(v, t[i], age, b, a, measured, counted, stops)
                rear[k, i] = begin + first
                front[k, i] = end + last


def danger_zones(vehicles: Int, times: Int, motion: Motions, t: Times, travel: Times, zone: Zones) -> None:
    """Intervals of the road in which vehicles of the adjacent lane block a maneuver, relative to the ego."""
    for k in range(vehicles):
        v = motion[k, SPEED]
        age = motion[k, AGE]
        b = motion[k, BRAKING]
        a = motion[k, ACCELERATION]
        measured, counted, stops = measured_motion(v, age, motion[k, RATE], b)
        low = math.inf
        high = -math.inf
        for i in range(times):
            first, last = reach(v, t[i], age, b, a, measured, counted, stops)
            if first - travel[i] <= last - travel[i]:
                low = min(low, first - travel[i])
                high = max(high, last - travel[i])
            else:  # not a number: all of the road is blocked
                low = -math.inf
                high = math.inf
        zone[k, 0] = motion[k, REAR] + low
        zone[k, 1] = motion[k, FRONT] + high


def occupancy_box(
    curve: Curve, s: Real, rear: Real, front: Real, d: Real, half_width: Real
) -> tuple[Real, Real, Real, Real, Real]:
    """Box that covers an occupied interval near a station: x, y, heading, length and width."""
    first = min(max(rear, s - WINDOW), front)
    last = max(min(front, s + WINDOW), rear)
    length = abs(last - first)
    x, y, dx, dy, ddx, ddy = curve_point(curve, 0.5 * (first + last))
    speed = max(norm(dx, dy), SMALLEST_SPEED)
    # wider by the deviation of the road from a straight line
    width = 2.0 * half_width + 0.25 * abs(curvature_of(dx, dy, ddx, ddy)) * length * length
    return x - d * dy / speed, y + d * dx / speed, math.atan2(dy, dx), length, width


def occupancy_boxes(
    curve: Curve, n: Int, s: Row, rear: Row, front: Row, d: Row, half_width: Row, boxes: Boxes
) -> None:
    """Boxes that cover occupied intervals near given stations."""
    for i in range(n):
        boxes[i, 0], boxes[i, 1], boxes[i, 2], boxes[i, 3], boxes[i, 4] = occupancy_box(
            curve, s[i], rear[i], front[i], d[i], half_width[i]
        )


def vehicle_boxes(
    curve: Curve, vehicles: Int, times: Int, s: Times, rear: VehicleTimes, front: VehicleTimes, d: PerVehicle,
    half_width: PerVehicle, boxes: VehicleBoxes,
) -> None:  # fmt: skip
    """Boxes of vehicles at common times, one vehicle after another, near the stations of the ego then."""
    for k in range(vehicles):
        for i in range(times):
            at = k * times + i
            boxes[at, 0], boxes[at, 1], boxes[at, 2], boxes[at, 3], boxes[at, 4] = occupancy_box(
                curve, s[i], rear[k, i], front[k, i], d[k], half_width[k]
            )
