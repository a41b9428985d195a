"""Motion along candidate paths: rollouts, costs and gaps, as scalar loops for the compiled kernel."""

__all__ = ["conflict", "costs", "limit_path", "nominal", "roll", "worst"]

import math

from cca_core.planner._kinds import (
    Flag,
    Int,
    Motions,
    OnPaths,
    OnRoute,
    Overtakes,
    PerVehicle,
    Real,
    RunMarks,
    Runs,
    Stops,
    Terms,
    Times,
    VehicleMarks,
)

FAR = 1e3
STANDSTILL = 0.2
TOLERANCE = 0.05
ONCOMING = -0.5
RELEASE = 12.0
TIME_EPS = 1e-9


class Scene:
    # the route around the ego, one station a meter; stations are relative to the first
    n: Int
    x: OnRoute
    y: OnRoute
    psi: OnRoute
    kappa: OnRoute
    cap: OnRoute  # squared speed limit
    lane_right: Real
    lane_left: Real
    # candidate paths: lateral offset, squared speed limit, vehicles that are overtaken
    paths: Int
    d: OnPaths
    path_cap: OnPaths
    overtakes: Overtakes
    # times from now
    steps: Int
    t: Times
    # other vehicles: nominal motion and worst case; those that cross the route in the plane
    m: Int
    s_o: Motions
    v_o: Motions
    d_o: Motions
    s_follow: Motions  # where vehicles do not drive through each other
    v_follow: Motions
    half_l: PerVehicle
    half_w: PerVehicle
    low: Motions
    high: Motions
    right: Motions
    left: Motions
    crosses: VehicleMarks
    stands: VehicleMarks
    x_o: Motions
    y_o: Motions
    psi_o: Motions
    x_w: Motions
    y_w: Motions
    psi_w: Motions
    half_l_w: Motions
    half_w_w: Motions
    adjacent: VehicleMarks
    assumed: VehicleMarks  # at the end of the awareness range
    # points to stop at for vehicles that cross, in the order of their arrival
    stops: Int
    stop_s: Stops
    stop_until: Stops
    # the ego
    s_0: Real
    v_0: Real
    a_0: Real
    a_true: Real
    half_length: Real
    half_width: Real
    offset: Real
    # its limits
    a_max: Real
    b_comfort: Real
    b_max: Real
    b_soft: Real  # needed deceleration from which on following costs
    b_other: Real  # that others may brake with
    risk_until: Real
    grip: Real
    standstill_gap: Real
    time_gap: Real
    approach_rate: Real
    jerk: Real
    jerk_emergency: Real
    lag: Real
    blocking_gap: Real
    look: Real
    react: Real
    # motions of the ego
    rows: Int
    s: Runs
    v: Runs
    a: Runs
    offset_at: Runs
    limited_by: RunMarks
    terms: Terms
    # results of the last check
    least: Real
    gap: Real
    which: Int
    when: Int
    impact: Real
    s_enter: Real
    s_exit: Real
    t_enter: Real
    t_exit: Real
    zone_from: Real  # time at which the body enters an adjacent lane
    begin_from: Real  # and at which that maneuver begins
    zone_side: Int  # of that lane: 1 left, 2 right
    duty_from: Int
    rear: Real


def norm(x: Real, y: Real) -> Real:
    return math.sqrt(x * x + y * y)


def outside(x: Real, y: Real, length: Real, width: Real) -> Real:
    """Squared distance of a point from a box of these half extents around the origin."""
    dx = max(abs(x) - length, 0.0)
    dy = max(abs(y) - width, 0.0)
    return dx * dx + dy * dy


def nearest_corner(
    x: Real, y: Real, c: Real, s: Real, length: Real, width: Real, own_length: Real, own_width: Real
) -> Real:
    """Least squared distance of the corners of a turned box at x, y from the box around the origin."""
    ax = c * length - s * width
    ay = s * length + c * width
    bx = c * length + s * width
    by = s * length - c * width
    first = min(outside(x + ax, y + ay, own_length, own_width), outside(x - ax, y - ay, own_length, own_width))
    then = min(outside(x + bx, y + by, own_length, own_width), outside(x - bx, y - by, own_length, own_width))
    return min(first, then)


def box_distance(
    dx: Real, dy: Real, ax: Real, ay: Real, bx: Real, by: Real, length_a: Real, width_a: Real, length_b: Real,
    width_b: Real,
) -> Real:  # fmt: skip
    """Signed distance of boxes with headings a and b and half extents; b's center is off by dx, dy."""
    turn_c = bx * ax + by * ay
    turn_s = by * ax - bx * ay
    c = abs(turn_c)
    s = abs(turn_s)
    x_b = dx * ax + dy * ay  # seen from a
    y_b = dy * ax - dx * ay
    x_a = -(dx * bx + dy * by)  # seen from b
    y_a = -(dy * bx - dx * by)
    along_a = abs(x_b) - length_a - (length_b * c + width_b * s)
    across_a = abs(y_b) - width_a - (length_b * s + width_b * c)
    along_b = abs(x_a) - length_b - (length_a * c + width_a * s)
    across_b = abs(y_a) - width_b - (length_a * s + width_a * c)
    separation = max(max(along_a, across_a), max(along_b, across_b))
    if separation <= 0.0 or separation > 20.0:
        return separation
    of_b = nearest_corner(x_b, y_b, turn_c, turn_s, length_b, width_b, length_a, width_a)
    of_a = nearest_corner(x_a, y_a, turn_c, -turn_s, length_a, width_a, length_b, width_b)
    return math.sqrt(min(of_b, of_a))


def station(n: Int, at: Real) -> Int:
    """Index of the station before a position on the route."""
    return math.floor(min(max(at, 0.0), n - 1.001))


def on_route(n: Int, row: OnRoute, at: Real) -> Real:
    """Value at a position, linear between stations."""
    i = station(n, at)
    f = min(max(at - i, 0.0), 1.0)
    return row[i] + f * (row[i + 1] - row[i])


def lateral(w: Scene, p: Int, at: Real) -> Real:
    """Lateral offset of a path."""
    i = station(w.n, at)
    f = min(max(at - i, 0.0), 1.0)
    return w.d[p, i] + f * (w.d[p, i + 1] - w.d[p, i])


def slope(w: Scene, p: Int, at: Real) -> Real:
    """Slope of the lateral offset of a path."""
    return 0.5 * (lateral(w, p, at + 1.0) - lateral(w, p, at - 1.0))


def bend(w: Scene, p: Int, at: Real) -> Real:
    """Curvature that a path adds to the route's."""
    return lateral(w, p, at + 1.0) - 2.0 * lateral(w, p, at) + lateral(w, p, at - 1.0)


def squared_speed(w: Scene, p: Int, at: Real) -> Real:
    """Squared speed limit of route and path."""
    i = station(w.n, at)
    f = min(max(at - i, 0.0), 1.0)
    own = w.path_cap[p, i] + f * (w.path_cap[p, i + 1] - w.path_cap[p, i])
    return min(own, w.cap[i] + f * (w.cap[i + 1] - w.cap[i]))


def limit_path(w: Scene, p: Int, a_y: Real) -> None:
    """Squared speed at which the curvature of a path needs a lateral acceleration, led down to in comfort."""
    for i in range(w.n):
        w.path_cap[p, i] = 1e4
    for i in range(1, w.n - 1):
        added = w.d[p, i + 1] - 2.0 * w.d[p, i] + w.d[p, i - 1]
        if abs(added) > 1e-5:
            w.path_cap[p, i] = min(a_y / max(abs(added + w.kappa[i]), 1e-6), 1e4)
    for k in range(1, w.n):
        at = w.n - 1 - k
        w.path_cap[p, at] = min(w.path_cap[p, at], w.path_cap[p, at + 1] + 2.0 * w.b_comfort)


def approach(w: Scene, v: Real, gap: Real, v_lead: Real, final_gap: Real, stops: Flag) -> Real:
    """Acceleration that follows at the time gap; it brakes harder than in comfort only as far as needed."""
    space = max(gap - w.standstill_gap, 0.01)
    lead = max(v_lead, 0.0)
    need = 0.0
    if v_lead < ONCOMING:
        need = (0.5 * v - v_lead) * v / space
    elif v > lead:
        need = (v - lead) * (v - lead) / (2.0 * space)
    if stops:
        need = max(need, v * v / (2.0 * max(final_gap - w.standstill_gap, 0.01)))
    surplus = gap - w.standstill_gap - w.time_gap * lead
    linear = w.b_comfort / (w.approach_rate * w.approach_rate)
    shed = w.approach_rate * surplus
    rate = w.approach_rate
    if surplus > linear:
        shed = math.sqrt(2.0 * w.b_comfort * (surplus - 0.5 * linear))
        rate = w.b_comfort / shed
    a = rate * min(lead - v, 0.0) + 2.0 * w.approach_rate * (lead + shed - v)
    a = max(a, -w.b_comfort)
    if need > w.b_comfort:
        a = min(a, -min(1.1 * need, w.b_max))
    return a


def needed(w: Scene, v: Real, gap: Real, v_lead: Real) -> Real:
    """Deceleration that is needed after the reaction time if a lead vehicle brakes as hard as is assumed."""
    space = gap - v * w.react
    lead = max(v_lead, 0.0)
    if w.b_other <= 0.0:
        closing = max(v - lead, 0.0)
        return closing * closing / (2.0 * max(space, 0.1))
    return v * v / (2.0 * max(space + lead * lead / (2.0 * w.b_other), 0.1))


def in_path(w: Scene, p: Int, j: Int, k: Int, then: Int) -> Flag:
    """Whether a vehicle is in the way of a path now or a little later."""
    here = lateral(w, p, w.s_follow[j, k])
    low = min(w.d_o[j, k], w.d_o[j, then]) - here
    high = max(w.d_o[j, k], w.d_o[j, then]) - here
    reach = w.half_w[j] + w.half_width + w.blocking_gap
    return low < reach and high > -reach


def roll(
    w: Scene, row: Int, p: Int, follows: Flag, passes: Flag, yields: Int, braking: Real, tail: Real, kept: Flag
) -> None:
    """Drive a path: cruise, follow, yield to the first vehicles that cross, brake; `tail` brakes after `react`."""
    position = w.s_0
    speed = w.v_0
    command = w.a_0
    true = w.a_true
    later = 0
    w.limited_by[row] = -1
    w.terms[row, 8] = 0.0
    for k in range(w.steps):
        risk = 0.0
        w.s[row, k] = position
        w.v[row, k] = speed
        w.offset_at[row, k] = lateral(w, p, position)
        h = w.t[k + 1] - w.t[k] if k + 1 < w.steps else w.t[k] - w.t[k - 1]
        horizon = 2.0 + speed
        here = math.sqrt(max(squared_speed(w, p, position), 0.0))
        cruise = min(max(here - speed, -w.b_comfort), w.a_max)
        there = (squared_speed(w, p, position + horizon) - speed * speed) / (2.0 * horizon)
        want = min(cruise, max(there, -w.b_max))
        limit = -1
        if want < w.a_max - 0.01 and want < -0.05:
            limit = -2
        front = position + w.offset + w.half_length
        if follows:
            for _ in range(w.steps):  # as far as vehicles are looked for before they are in the path
                if later + 1 >= w.steps or w.t[later] >= w.t[k] + w.look:
                    break
                later += 1
            for j in range(w.m):
                if w.crosses[j] != 0 or w.overtakes[p, j] != 0.0:
                    continue
                if w.s_follow[j, k] + 0.5 * w.half_l[j] <= position + w.offset:
                    continue
                if passes and abs(lateral(w, p, w.s_follow[j, k])) > TOLERANCE:
                    continue  # it will have left when the ego comes
                if not in_path(w, p, j, k, later):
                    continue
                gap = w.s_follow[j, k] - w.half_l[j] - front
                final = w.s_follow[j, w.steps - 1] - w.half_l[j] - front
                if w.t[k] < w.risk_until and tail <= 0.0:
                    excess = min(needed(w, speed, gap, w.v_follow[j, k]), 3.0 * w.b_max) / w.b_soft - 1.0
                    risk = max(risk, max(excess, 0.0) * max(excess, 0.0))
                a = approach(w, speed, gap, w.v_follow[j, k], final, w.stands[j] != 0)
                if a < want:
                    want = a
                    limit = j
        w.terms[row, 8] += risk * h
        for j in range(yields):
            if w.t[k] < w.stop_until[j] and w.stop_s[j] - position > -2.0:
                gap = w.stop_s[j] - position + w.standstill_gap
                a = approach(w, speed, gap, 0.0, gap, True)
                if a < want:
                    want = a
                    limit = -10 - j
        if k <= 2:
            w.limited_by[row] = limit
        if kept:
            want = min(w.a[row, k], min(cruise, max(there, -w.b_max)) if there < 0.0 else w.a_max)
        want = min(want, -braking) if braking > 0.0 else want
        if tail > 0.0 and w.t[k] >= w.react - TIME_EPS:
            want = -tail
        side = (w.kappa[station(w.n, position)] + bend(w, p, position)) * speed * speed
        most = math.sqrt(max(w.grip * w.grip - side * side, 0.25))
        want = min(max(want, -most), most)
        if not kept:
            hard = want < -2.0 * w.b_comfort or tail > 0.0
            low = command - (w.jerk_emergency if hard else w.jerk) * h
            high = command + w.jerk * h
            if command < 0.0:
                high = max(high, min(command + RELEASE * h, 0.5))
            want = min(max(want, low), high)
        command = want
        w.a[row, k] = command
        z = h / w.lag  # of the brakes and the engine
        true = true + (command - true) * (1.0 - 1.0 / (1.0 + z + 0.5 * z * z + z * z * z / 6.0))
        now = max(speed + true * h, 0.0)
        if now <= 0.0 and true < 0.0:
            true = 0.0
            command = max(command, -w.b_comfort)
        position = position + 0.5 * (speed + now) * h
        speed = now


def costs(w: Scene, row: Int, p: Int, until: Real) -> None:
    """Integrals over a time of what a motion costs, and its peak lateral acceleration."""
    for c in range(8):
        w.terms[row, c] = 0.0
    last = 0
    for k in range(w.steps - 1):
        if w.t[k] >= until:
            break
        last = k + 1
        h = w.t[k + 1] - w.t[k]
        v = w.v[row, k]
        a = w.a[row, k]
        at = w.s[row, k]
        added = bend(w, p, at) * v * v
        whole = added + w.kappa[station(w.n, at)] * v * v
        d = w.offset_at[row, k]
        w.terms[row, 0] += (a * a if a < 0.0 else 0.3 * a * a) * h
        w.terms[row, 1] += added * added * h
        if abs(added) > 0.05:
            w.terms[row, 2] = max(w.terms[row, 2], abs(whole))
        if d + w.half_width > w.lane_left or d - w.half_width < w.lane_right:
            w.terms[row, 3] += h
        jerk = (w.a[row, k + 1] - a) / h
        w.terms[row, 4] += jerk * jerk * h
    w.terms[row, 5] = w.s[row, last]
    w.terms[row, 6] = w.v[row, last]
    w.terms[row, 7] = w.offset_at[row, w.steps - 1]


def find_duty(w: Scene, row: Int, wait: Real) -> None:
    """From when on vehicles behind the ego must keep their distance, and where the ego's rear is then."""
    back = 0
    for k in range(w.steps):
        d = w.offset_at[row, k]
        if d + w.half_width - TOLERANCE > w.lane_left or d - w.half_width + TOLERANCE < w.lane_right:
            back = min(k + 1, w.steps - 1)
    w.rear = w.s[row, back] + w.offset - w.half_length
    w.duty_from = back
    for k in range(back, w.steps):
        if back > 0 and w.t[k] < w.t[back] + wait:
            w.duty_from = k


def has_duty(w: Scene, j: Int, k: Int, back: Int) -> Flag:
    """Whether a vehicle is behind the ego in its lane, for good."""
    if w.crosses[j] != 0 or k < w.duty_from or w.v_o[j, 0] < ONCOMING:
        return False
    return w.s_o[j, back] + 0.5 * w.half_l[j] < w.rear


def ego_gap(w: Scene, row: Int, p: Int, k: Int, low: Real, high: Real, right: Real, left: Real) -> Real:
    """Gap of the ego's body to a rectangle in route coordinates."""
    at = w.s[row, k]
    middle = at + w.offset
    reach = w.half_length + w.half_width
    if low > middle + reach + 12.0:
        return low - middle - reach
    if high < middle - reach - 12.0:
        return middle - reach - high
    begin = max(low, middle - reach - 12.0)
    end = max(min(high, middle + reach + 12.0), begin)
    turn = slope(w, p, at)
    scale = 1.0 / math.sqrt(1.0 + turn * turn)
    width = w.half_width + 0.5 * abs(w.kappa[station(w.n, at)]) * w.half_length * w.half_length
    return box_distance(
        0.5 * (begin + end) - at - w.offset * scale, 0.5 * (right + left) - w.offset_at[row, k] - w.offset * turn * scale,
        scale, turn * scale, 1.0, 0.0, w.half_length, width, 0.5 * (end - begin), 0.5 * (left - right),
    )  # fmt: skip


def body_gap(
    w: Scene, p: Int, at: Real, d: Real, x: Real, y: Real, psi: Real, length: Real, width: Real
) -> Real:
    """Gap of the ego's body at a position of a path to a box in the plane."""
    route = on_route(w.n, w.psi, at)
    kappa = w.kappa[station(w.n, at)]
    heading = route + math.atan2(slope(w, p, at), max(1.0 - kappa * d, 0.1))
    c = math.cos(heading)
    s = math.sin(heading)
    x_ego = on_route(w.n, w.x, at) - d * math.sin(route) + w.offset * c
    y_ego = on_route(w.n, w.y, at) + d * math.cos(route) + w.offset * s
    if norm(x - x_ego, y - y_ego) > length + width + w.half_length + w.half_width + 15.0:
        return 15.0
    return box_distance(
        x - x_ego, y - y_ego, c, s, math.cos(psi), math.sin(psi), w.half_length, w.half_width, length, width
    )


def plane_gap(
    w: Scene, row: Int, p: Int, k: Int, x: Real, y: Real, psi: Real, length: Real, width: Real
) -> Real:
    """Gap of the ego's body in a motion to a box in the plane."""
    return body_gap(w, p, w.s[row, k], w.offset_at[row, k], x, y, psi, length, width)


def conflict(w: Scene, p: Int, j: Int, reach: Int, until: Real, margin: Real) -> Flag:
    """Find the stations of a path that a crossing vehicle passes over, and when."""
    w.s_enter = -1.0
    w.s_exit = -1.0
    w.t_enter = -1.0
    w.t_exit = -1.0
    for i in range(reach):
        at = w.s_0 + i
        d = lateral(w, p, at)
        x = on_route(w.n, w.x, at)
        y = on_route(w.n, w.y, at)
        reach_j = w.half_l[j] + w.half_w[j] + w.half_length + w.half_width + abs(w.offset) + abs(d) + margin
        for k in range(w.steps):
            if w.t[k] > until:
                break
            if norm(w.x_o[j, k] - x, w.y_o[j, k] - y) > reach_j:
                continue
            gap = body_gap(w, p, at, d, w.x_o[j, k], w.y_o[j, k], w.psi_o[j, k], w.half_l[j], w.half_w[j])
            if gap < margin:
                if w.s_enter < 0.0:
                    w.s_enter = at
                w.s_exit = at
                if w.t_enter < 0.0 or w.t[k] < w.t_enter:
                    w.t_enter = w.t[k]
                w.t_exit = max(w.t_exit, w.t[k])
    return w.s_enter >= 0.0


def nominal_gap(w: Scene, row: Int, p: Int, j: Int, k: Int, pet: Real) -> Real:
    """Gap to a vehicle; one that crosses covers where it is within a time."""
    if w.crosses[j] != 0:
        length = w.half_l[j] + pet * w.v_o[j, k]
        return plane_gap(w, row, p, k, w.x_o[j, k], w.y_o[j, k], w.psi_o[j, k], length, w.half_w[j])
    s = w.s_o[j, k]
    d = w.d_o[j, k]
    return ego_gap(w, row, p, k, s - w.half_l[j], s + w.half_l[j], d - w.half_w[j], d + w.half_w[j])


def nominal(w: Scene, row: Int, p: Int, touch: Real, clearance: Real, wait: Real, pet: Real) -> None:
    """Least gap to the nominal motion of others beyond what is asked, and the first overlap."""
    find_duty(w, row, wait)
    w.least = FAR
    w.gap = FAR
    w.which = -1
    w.when = w.steps
    w.impact = 0.0
    hit = w.steps
    back = 0
    for k in range(w.steps):
        d = w.offset_at[row, k]
        if d + w.half_width - TOLERANCE > w.lane_left or d - w.half_width + TOLERANCE < w.lane_right:
            back = min(k + 1, w.steps - 1)
    for j in range(w.m):
        asked = clearance if w.overtakes[p, j] != 0.0 else touch
        for k in range(w.steps):
            if has_duty(w, j, k, back):
                continue
            gap = nominal_gap(w, row, p, j, k, pet)
            if k == 0:
                asked = min(asked, max(gap - 0.02, 0.0))
            w.gap = min(w.gap, gap)
            if gap - asked < w.least:
                w.least = gap - asked
                w.which = j
                w.when = k
            if gap < 0.0 and k < hit:
                hit = k
                w.which = j
                w.when = k
                route = on_route(w.n, w.psi, w.s[row, k])
                psi = w.psi_o[j, k] if w.crosses[j] != 0 else route
                dx = w.v[row, k] * math.cos(route) - w.v_o[j, k] * math.cos(psi)
                dy = w.v[row, k] * math.sin(route) - w.v_o[j, k] * math.sin(psi)
                w.impact = norm(dx, dy)
    if hit < w.steps:
        w.when = hit


def worst_gap(w: Scene, row: Int, p: Int, j: Int, k: Int) -> Real:
    if w.crosses[j] != 0:
        return plane_gap(
            w, row, p, k, w.x_w[j, k], w.y_w[j, k], w.psi_w[j, k], w.half_l_w[j, k], w.half_w_w[j, k]
        )
    return ego_gap(w, row, p, k, w.low[j, k], w.high[j, k], w.right[j, k], w.left[j, k])


def worst(
    w: Scene, row: Int, p: Int, touch: Real, clearance: Real, wait: Real, x_safety: Real, which: Int
) -> Flag:
    """Whether vehicles within the declared bounds cannot touch the ego.

    `which`: 0 all vehicles; 1 without the overtaken ones; 2 the overtaken ones only. With `x_safety` the ego
    keeps that distance along the road to vehicles of the adjacent lane until it has returned: from when it enters
    that lane, or from when the maneuver begins if the vehicle comes nearer.
    """
    find_duty(w, row, wait)
    w.least = FAR
    w.which = -1
    w.when = w.steps
    back = 0
    for k in range(w.steps):
        d = w.offset_at[row, k]
        if d + w.half_width - TOLERANCE > w.lane_left or d - w.half_width + TOLERANCE < w.lane_right:
            back = min(k + 1, w.steps - 1)
    for j in range(w.m):
        passed = w.overtakes[p, j] != 0.0
        if (which == 1 and passed) or (which == 2 and not passed):
            continue
        if w.assumed[j] != 0 and x_safety <= 0.0:
            continue
        asked = clearance if passed else touch
        for k in range(w.steps):
            if has_duty(w, j, k, back):
                continue
            d = w.offset_at[row, k]
            out = d + w.half_width > w.lane_left or d - w.half_width < w.lane_right
            nears = w.v_o[j, 0] < ONCOMING or w.v_o[j, 0] > w.v_0 or w.assumed[j] != 0
            since = w.begin_from if nears else w.zone_from
            zone = x_safety > 0.0 and k <= back and w.t[k] >= since - TIME_EPS
            if zone and not passed and (w.adjacent[j] == 3 or w.adjacent[j] == w.zone_side):
                middle = w.s[row, k] + w.offset  # eq 11: along the road, wherever the ego is across it
                ahead = w.low[j, k] - x_safety - (middle + w.half_length)
                behind = middle - w.half_length - (w.high[j, k] + x_safety)
                if max(ahead, behind) < w.least:
                    w.least = max(ahead, behind)
                    w.which = j
                    w.when = k
                continue
            if w.assumed[j] != 0:
                continue
            if w.v[row, k] < STANDSTILL and w.crosses[j] == 0 and not out and k > 0:
                continue  # what stands in its lane touches nothing
            gap = worst_gap(w, row, p, j, k)
            if k == 0:
                asked = min(asked, max(gap - 0.02, -0.01))
            if gap - asked < w.least:
                w.least = gap - asked
                w.which = j
                w.when = k
    return w.least >= 0.0
