"""Other vehicles of a scene over time: nominal motion, worst case, and order in the lane."""

import math

from cca_core.kernel.constants import STALE_AGE, STANDSTILL_SPEED
from cca_core.kernel.order import set_following_speed, set_order
from cca_core.kernel.reach import measured_motion, reach
from cca_core.kernel.scene import Scene, station
from cca_core.kernel.types import Flag, Int, Real

__all__ = ["locate_vehicles"]

GONE = 1e6  # station of a vehicle that is nominally not there [m]
NO_ACCELERATION = 0.5  # a smaller reported acceleration is noise [m/s^2]
SPEEDING = 0.5  # above the speed limit, that a vehicle may drive faster than now [m/s]
ABREAST = 1.5  # lateral distance below which stationary vehicles are in one queue [m]
ASSUMED_HALF_WIDTH = 0.9  # of a vehicle beyond the awareness range [m]

# columns of what is seen of a vehicle; stations as in the scene
S = 0
D = 1
SPEED = 2  # along the route, negative against it
HALF_L = 3  # extents with the uncertainty bound
HALF_W = 4
NOMINAL_L = 5  # extents at which it is compared nominally
NOMINAL_W = 6
RATE = 7  # reported, of the magnitude of the speed
NOMINAL_RATE = 8  # the same with the events of the vehicle
AGE = 9
AHEAD = 10  # cosine of the heading to the route
SIDE_SPEED = 11  # with which it may move sideways
SIDE_RANGE = 12  # and how far
CROSSES = 13
X = 14
Y = 15
PSI = 16
V_X = 17
A_X = 18
TURN_RATE = 19
BODY_L = 20  # half extents of a body that crosses
BODY_W = 21
BULGE = 22  # width that a bend of curvature 1 adds to the straight body; of a bend of the route [m^2]
BEND_W = 23  # part of the half extent across that the bend adds in which it is now
SURE_W = 24  # half extent across that is covered for certain; negative if nothing is
NOMINAL_D = 25  # offset if it has followed the road since it was measured
LEAVES = 26  # whether it is expected to move sideways


def travel(w: Scene, v: Real, a: Real, lasts: Real, t: Real) -> tuple[Real, Real]:
    """Nominal distance and speed without sign; a reported acceleration lasts for a bounded time."""
    if abs(a) < NO_ACCELERATION or (w.keeps and a > 0.0):
        return v * t, v
    until = min(w.braking_time, v / -a) if a < 0.0 else min(lasts, max(w.v_limit - v, 0.0) / a)
    changing = min(t, until)
    speed = v + a * changing
    return v * changing + 0.5 * a * (changing * changing) + speed * (t - changing), max(speed, 0.0)


def set_adjacent(w: Scene, j: Int, right: Real, left: Real) -> None:
    """Mark whether a body is in an adjacent lane, or moves there from beyond."""
    last = w.steps - 1
    in_left = left > w.lane_left + w.entry_tolerance and w.right[j, last] < w.edge_left - w.entry_tolerance
    in_right = right < w.lane_right - w.entry_tolerance and w.left[j, last] > w.edge_right + w.entry_tolerance
    w.adjacent[j] = (1 if in_left else 0) + (2 if in_right else 0)


def locate_along(w: Scene, j: Int) -> None:
    """Motion of a vehicle along the route."""
    v = w.seen[j, SPEED]
    speed = abs(v)
    side = w.seen[j, SIDE_SPEED]
    sign = math.copysign(1.0, v)
    for k in range(w.steps):
        distance, now = travel(w, speed, w.seen[j, NOMINAL_RATE], w.acceleration_time, w.t[k])
        w.s_o[j, k] = w.seen[j, S] + sign * distance
        w.v_o[j, k] = sign * now
        across = math.copysign(min(abs(side) * w.t[k], w.seen[j, SIDE_RANGE]), side)
        w.d_o[j, k] = w.seen[j, NOMINAL_D] + (across if w.seen[j, LEAVES] != 0.0 else 0.0)
        w.right[j, k] = w.seen[j, D] - w.seen[j, HALF_W] + min(across, 0.0)
        w.left[j, k] = w.seen[j, D] + w.seen[j, HALF_W] + max(across, 0.0)
    set_adjacent(w, j, w.seen[j, D] - w.seen[j, HALF_W], w.seen[j, D] + w.seen[j, HALF_W])


def lane_scale(w: Scene, j: Int, at: Real) -> Real:
    """Distance driven in the lane of a vehicle for each meter of the route: longer outside of a bend."""
    return max(1.0 - w.seen[j, D] * w.kappa[station(w.n, at)], 0.1)


def reach_along(w: Scene, j: Int, passed: Flag) -> None:
    """Worst case along the route of a vehicle that is overtaken, or of one that is not.

    Speeds and accelerations are those in its lane, stations follow from the distance driven there.
    """
    scale = lane_scale(w, j, w.seen[j, S])
    v = w.seen[j, SPEED] * scale
    rate = w.seen[j, RATE] * scale
    nominal = w.seen[j, NOMINAL_RATE]
    braking = max(w.b_other, -rate)
    age = w.seen[j, AGE]
    slowest, so_far, stops = measured_motion(v, age, rate, braking)
    # one that stands by dead reckoning may have braked harder since its report
    stood = min(0.5 * slowest * min(stops, STALE_AGE) - so_far, 0.0) / scale
    if passed and rate > 0.0:
        rate = 0.0  # a driver who is overtaken does not accelerate any more
        nominal = min(nominal, 0.0)
    acceleration = max(w.a_passed if passed else w.a_other, rate)
    rear = w.seen[j, S] - w.seen[j, HALF_L]
    front = w.seen[j, S] + w.seen[j, HALF_L]
    measured, counted, _ = measured_motion(v, age, rate, braking)
    fastest = max(w.v_limit, max(abs(v), measured) + SPEEDING)  # it may not have braked since its report
    sum_low = 0.0
    sum_high = 0.0
    low_0 = 0.0
    high_0 = 0.0
    low_last = 0.0
    high_last = 0.0
    for k in range(w.steps):
        low = 0.0
        high = 0.0
        if w.keeps:
            distance, _ = travel(w, abs(w.seen[j, SPEED]), nominal, w.acceleration_time, w.t[k])
            low = math.copysign(1.0, v) * distance
            high = low
        else:
            low, _ = reach(v, w.t[k], age, braking, acceleration, slowest, so_far, stops)
            _, high = reach(v, w.t[k], age, braking, acceleration, measured, counted, stops)
            if k == 0:
                low_0 = low / scale
                high_0 = high / scale
            else:
                farthest = fastest * (w.t[k] - w.t[k - 1])
                at_low = w.seen[j, S] + low_0 + sum_low
                at_high = w.seen[j, S] + high_0 + sum_high
                sum_low += max(low - low_last, -farthest) / lane_scale(w, j, at_low)
                sum_high += min(high - high_last, farthest) / lane_scale(w, j, at_high)
            low_last = low
            high_last = high
            low = low_0 + sum_low
            high = high_0 + sum_high
            if abs(v) < STANDSTILL_SPEED:  # what stands does not reverse, nor has it since its report
                if w.seen[j, AHEAD] > 0.0:
                    low = max(low, stood)
                else:
                    high = min(high, -stood)
        if passed:
            if v >= 0.0:  # a reported acceleration is believed for a while
                distance, _ = travel(
                    w, w.seen[j, SPEED], w.seen[j, NOMINAL_RATE], w.acceleration_time, w.t[k]
                )
                high = max(high, distance)
            w.low_passed[j, k] = rear + low
            w.high_passed[j, k] = front + high
        else:
            w.low[j, k] = rear + low
            w.high[j, k] = front + high


def on_arc(w: Scene, j: Int, s: Real, turn: Real) -> tuple[Real, Real, Real]:
    """Position and heading of a vehicle after an arc."""
    half = 0.5 * turn
    chord = s * (math.sin(half) / half) if abs(half) > 1e-12 else s
    heading = w.seen[j, PSI] + half
    x = w.seen[j, X] + chord * math.cos(heading)
    return x, w.seen[j, Y] + chord * math.sin(heading), w.seen[j, PSI] + turn


def farthest_braking(v: Real, rate: Real, lasts: Real, acceleration: Real, t: Real) -> Real:
    """Largest distance of a vehicle that goes on braking for a while, and then accelerates."""
    braking = min(min(lasts, t), v / -rate)
    speed = v + rate * braking
    then = t - braking
    return v * braking + 0.5 * rate * braking * braking + speed * then + 0.5 * acceleration * then * then


def locate_crossing(w: Scene, j: Int) -> None:
    """Motion of a vehicle in the plane: on its circle nominally, and where it can be within a time."""
    v = w.seen[j, V_X]
    speed = abs(v)
    sign = math.copysign(1.0, v)
    rate = sign * w.seen[j, A_X]
    kappa = w.seen[j, TURN_RATE] / v if speed > STANDSTILL_SPEED else 0.0
    braking = 0.0 if w.keeps else max(w.b_crossing, -rate)
    acceleration = 0.0 if w.keeps else max(w.a_crossing, rate)
    age = w.seen[j, AGE]
    measured, counted, still = measured_motion(speed, age, 0.0, braking)
    for k in range(w.steps):
        w.s_o[j, k] = w.seen[j, S]
        distance, w.v_o[j, k] = travel(w, speed, rate, w.crossing_time, w.t[k])
        w.d_o[j, k] = w.seen[j, D]
        s = sign * distance
        w.x_o[j, k], w.y_o[j, k], w.psi_o[j, k] = on_arc(w, j, s, kappa * s)
        before = max(w.t[k] - w.min_pet, 0.0)
        after = w.t[k] + w.min_pet
        low, _ = reach(speed, before, age, braking, acceleration, measured, counted, still)
        _, high = reach(speed, after, age, braking, acceleration, measured, counted, still)
        if rate < -NO_ACCELERATION and age < w.yield_time:
            high = min(high, farthest_braking(speed, rate, w.yield_time - age, acceleration, after))
        middle = 0.5 * (low + high)
        extent = 0.5 * (high - low)
        turn = min(max(kappa * middle * sign, -0.5 * math.pi), 0.5 * math.pi)
        w.x_w[j, k], w.y_w[j, k], w.psi_w[j, k] = on_arc(w, j, sign * middle, turn)
        w.half_l_w[j, k] = w.seen[j, BODY_L] + extent
        w.half_w_w[j, k] = w.seen[j, BODY_W] + min(0.25 * abs(kappa) * extent * extent, extent)
    w.adjacent[j] = 0


def locate_assumed(w: Scene, j: Int) -> None:
    """Motion of a vehicle that is assumed at the end of the awareness range."""
    for k in range(w.steps):
        at = w.seen[j, S] + w.seen[j, SPEED] * w.t[k]
        w.s_o[j, k] = GONE
        w.v_o[j, k] = 0.0
        w.d_o[j, k] = 0.0
        w.low[j, k] = at
        w.high[j, k] = at
        w.low_passed[j, k] = at
        w.high_passed[j, k] = at
        w.right[j, k] = w.seen[j, D] - ASSUMED_HALF_WIDTH
        w.left[j, k] = w.seen[j, D] + ASSUMED_HALF_WIDTH
    set_adjacent(w, j, w.seen[j, D] - ASSUMED_HALF_WIDTH, w.seen[j, D] + ASSUMED_HALF_WIDTH)


def is_in(w: Scene, j: Int, right: Real, left: Real) -> Flag:
    """Whether a body is at least in part in a lane."""
    return w.seen[j, D] - w.seen[j, HALF_W] <= left and w.seen[j, D] + w.seen[j, HALF_W] >= right


def is_clear(w: Scene, j: Int, n: Int, right: Real, left: Real) -> Flag:
    """Whether no stationary vehicle is in a lane next to a vehicle or a little ahead."""
    rear = w.seen[j, S] - w.seen[j, HALF_L]
    end = w.seen[j, S] + w.seen[j, HALF_L] + w.queue_gap
    for i in range(n):
        stands = abs(w.seen[i, SPEED]) <= STANDSTILL_SPEED
        near = w.seen[i, S] - w.seen[i, HALF_L] < end and w.seen[i, S] + w.seen[i, HALF_L] > rear
        if i != j and stands and near and is_in(w, i, right, left):
            return False
    return True


def distance_to_pass(w: Scene, j: Int, n: Int) -> Real:
    """Distance kept behind a single vehicle that comes to rest next to a clear lane, for a later maneuver."""
    if w.stands[j] == 0 or w.crosses[j] != 0:
        return 0.0
    if not is_in(w, j, w.lane_right, w.lane_left):
        return 0.0
    for i in range(n):
        gap = w.seen[i, S] - w.seen[i, HALF_L] - (w.seen[j, S] + w.seen[j, HALF_L])
        if i != j and 0.0 < gap < w.queue_gap and abs(w.seen[i, D] - w.seen[j, D]) < ABREAST:
            return 0.0  # a queue drives on
    for i in range(w.max_lanes):
        if is_clear(w, j, n, w.other_lanes[i, 0], w.other_lanes[i, 1]):
            return w.passing_gap
    return 0.0


def locate_vehicles(w: Scene, seen: Int) -> None:
    """Predict the vehicles in `seen`, the first of which are real, the others assumed."""
    w.crossing = 0
    for j in range(w.m):
        w.half_l[j] = w.seen[j, NOMINAL_L]
        w.half_w[j] = w.seen[j, NOMINAL_W]
        w.crosses[j] = 1 if j < seen and w.seen[j, CROSSES] != 0.0 else 0
        w.assumed[j] = 1 if j >= seen else 0
        w.passing_distance[j] = 0.0
        if j >= seen:
            locate_assumed(w, j)
        elif w.crosses[j] != 0:
            w.crossing += 1
            locate_crossing(w, j)
        else:
            locate_along(w, j)
            reach_along(w, j, False)
            reach_along(w, j, True)
    for j in range(w.m):
        for i in range(w.steps):
            w.s_follow[j, i] = w.s_o[j, i]
    set_order(w, 1.0)
    set_order(w, -1.0)
    for j in range(w.m):
        set_following_speed(w, j)
        if w.v_o[j, 0] < 0.0:  # oncoming vehicles keep their order in the nominal motion too
            for i in range(w.steps):
                w.s_o[j, i] = w.s_follow[j, i]
                w.v_o[j, i] = w.v_follow[j, i] if i > 0 else w.v_o[j, 0]
        w.d_low[j] = w.d_o[j, 0]
        w.d_high[j] = w.d_o[j, 0]
        for i in range(1, w.steps):
            w.d_low[j] = min(w.d_low[j], w.d_o[j, i])
            w.d_high[j] = max(w.d_high[j], w.d_o[j, i])
    for j in range(seen):
        w.passing_distance[j] = distance_to_pass(w, j, seen)
