"""Motions of the ego along candidate paths: cruise, follow, yield and brake; and what they cost."""

import math

from cca_core.kernel.scene import TOLERANCE, Scene, bend, is_outside, lateral, squared_speed, station
from cca_core.kernel.types import Flag, Int, Real

__all__ = ["limit_path_speed", "roll_out", "sum_costs"]

ONCOMING = -0.5  # speed below which a vehicle drives against the ego [m/s]
CALM = 0.5  # by which a plan that is kept may brake less than one made anew [m/s^2]
RELEASE = 12.0  # rate at which brakes are released [m/s^3]
TIME_EPS = 1e-9
LIMITED_STEP = 2  # the last of the steps that say what limits a motion
ROUNDING = 1e-9  # [m]
NO_LIMIT = -1
ROUTE_LIMIT = -2
FIRST_STOP = -10  # and below: stop points of crossing vehicles


def limit_path_speed(w: Scene, p: Int, a_y: Real) -> None:
    """Squared speed at which the curvature of a path needs a lateral acceleration, led down to in comfort."""
    w.path_low[p] = w.d[p, 0]
    w.path_high[p] = w.d[p, 0]
    for i in range(w.n):
        w.path_cap[p, i] = 1e4
        w.path_low[p] = min(w.path_low[p], w.d[p, i])
        w.path_high[p] = max(w.path_high[p], w.d[p, i])
    for i in range(1, w.n - 1):
        added = w.d[p, i + 1] - 2.0 * w.d[p, i] + w.d[p, i - 1]
        if abs(added) > 1e-5:
            w.path_cap[p, i] = min(a_y / max(abs(added + w.kappa[i]), 1e-6), 1e4)
    for k in range(1, w.n):
        at = w.n - 1 - k
        w.path_cap[p, at] = min(w.path_cap[p, at], w.path_cap[p, at + 1] + 2.0 * w.b_comfort)


def follow_at_gap(
    w: Scene, v: Real, gap: Real, v_lead: Real, final_gap: Real, stops: Flag, spare: Real, to_pass: Real
) -> Real:
    """Acceleration that follows at the time gap, and keeps the distance `to_pass` more behind what stops.

    It brakes harder than in comfort only as far as needed: a little harder for that distance, and when the
    ego creeps not for the last of the standstill gap, at most `spare`.
    """
    end = max(min(spare, w.creep_time * v), 0.01)
    space = max(gap - w.standstill_gap, end)
    lead = max(v_lead, 0.0)
    need = 0.0
    if v_lead < ONCOMING:
        need = (0.5 * v - v_lead) * v / space
    elif v > lead:
        need = (v - lead) * (v - lead) / (2.0 * space)
    if stops:
        left = max(final_gap - w.standstill_gap, end)
        need = max(need, v * v / (2.0 * left))
        if to_pass > 0.0:
            need = max(need, min(v * v / (2.0 * max(left - to_pass, 0.5 * left)), w.b_firm))
    surplus = gap - to_pass - w.standstill_gap - w.time_gap * lead
    linear = w.b_comfort / (w.approach_rate * w.approach_rate)
    shed = max(w.approach_rate * surplus, -w.opening_speed)
    rate = w.approach_rate
    if surplus > linear:
        shed = math.sqrt(2.0 * w.b_comfort * (surplus - 0.5 * linear))
        rate = w.b_comfort / shed
    a = rate * min(lead - v, 0.0) + 2.0 * w.approach_rate * (lead + shed - v)
    a = max(a, -w.b_comfort)
    if need > w.b_comfort:
        a = min(a, -min(1.1 * need, w.b_max))
    return a


def needed_braking(w: Scene, v: Real, gap: Real, v_lead: Real) -> Real:
    """Deceleration that is needed after the reaction time if a lead vehicle brakes as hard as is assumed."""
    space = gap - v * w.react
    lead = max(v_lead, 0.0)
    if w.b_other <= 0.0:
        closing = max(v - lead, 0.0)
        return closing * closing / (2.0 * max(space, 0.1))
    return v * v / (2.0 * max(space + lead * lead / (2.0 * w.b_other), 0.1))


def wait_at_point(w: Scene, v: Real, left: Real, wait: Real) -> Real:
    """Acceleration that reaches a point no sooner than after a time: an even deceleration, or a stop."""
    early = v * wait - left
    if not early > 0.0:
        return w.a_max
    even = 2.0 * early / (wait * wait)
    if left > 0.0 and even * wait <= v:
        return -min(even, w.b_max)
    gap = left + w.standstill_gap
    return follow_at_gap(w, v, gap, 0.0, gap, True, 0.0, 0.0)


def in_path(w: Scene, p: Int, j: Int, k: Int, then: Int) -> Flag:
    """Whether a vehicle is in the way of a path now or a little later."""
    here = lateral(w, p, w.s_follow[j, k])
    low = min(w.d_o[j, k], w.d_o[j, then]) - here
    high = max(w.d_o[j, k], w.d_o[j, then]) - here
    reach = w.half_w[j] + w.half_width
    if w.v_o[j, 0] >= ONCOMING:  # next to what drives against it there is no one to follow
        reach += w.blocking_gap
    return low < reach and high > -reach


def find_leads(w: Scene, p: Int) -> Int:
    """List the vehicles that may be in front of the ego in a path at some time; return their number."""
    count = 0
    for j in range(w.m):
        if w.crosses[j] != 0 or w.overtakes[p, j] != 0.0:
            continue
        reach = w.half_w[j] + w.half_width + w.blocking_gap + ROUNDING
        if w.d_low[j] - w.path_high[p] >= reach or w.path_low[p] - w.d_high[j] >= reach:
            continue
        farthest = max(w.s_follow[j, 0], w.s_follow[j, w.steps - 1]) + 0.5 * w.half_l[j]
        if farthest > w.s_0 + w.offset:
            w.leads[count] = j
            count += 1
    return count


def roll_out(
    w: Scene,
    row: Int,
    p: Int,
    follows: Flag,
    passes: Flag,
    yields: Int,
    braking: Real,
    tail: Real,
    kept: Flag,
) -> None:
    """Drive a path: cruise, follow, yield to the first crossing vehicles, brake; `tail` after `react`."""
    position = w.s_0
    speed = w.v_0
    command = w.a_0
    actual = w.a_true
    later = 0
    leads = find_leads(w, p) if follows else 0
    w.limited_by[row] = NO_LIMIT
    w.terms[row, 8] = 0.0
    for k in range(w.steps):
        risk = 0.0
        ends = tail > 0.0 and w.t[k] >= w.react - TIME_EPS  # when nothing but its braking counts
        w.s[row, k] = position
        w.v[row, k] = speed
        w.offset_at[row, k] = lateral(w, p, position)
        h = w.t[k + 1] - w.t[k] if k + 1 < w.steps else w.t[k] - w.t[k - 1]
        horizon = 2.0 + speed
        here = math.sqrt(max(squared_speed(w, p, position), 0.0))
        cruise = min(max(here - speed, -w.b_comfort), w.a_max)
        there = (squared_speed(w, p, position + horizon) - speed * speed) / (2.0 * horizon)
        want = min(cruise, max(there, -w.b_max))
        limit = NO_LIMIT
        if want < w.a_max - 0.01 and want < -0.05:
            limit = ROUTE_LIMIT
        front = position + w.offset + w.half_length
        if follows and (not ends or k <= LIMITED_STEP):
            for _ in range(w.steps):  # as far as vehicles are looked for before they are in the path
                if later + 1 >= w.steps or not w.t[later] < w.t[k] + w.look:
                    break
                later += 1
            for i in range(leads):
                j = w.leads[i]
                if not w.s_follow[j, k] + 0.5 * w.half_l[j] > position + w.offset:
                    continue
                if passes and not abs(lateral(w, p, w.s_follow[j, k])) <= TOLERANCE:
                    continue  # it will have left when the ego comes
                if not in_path(w, p, j, k, later):
                    continue
                now = w.s_follow[j, 0] - w.half_l[j] - (w.s_0 + w.offset + w.half_length)
                gap = w.s_follow[j, k] - w.half_l[j] - front
                to_pass = min(w.passing_distance[j], max(now - w.standstill_gap, 0.0))  # to pass it later
                stops = w.stands[j] != 0
                if passes and not abs(lateral(w, p, w.s_follow[j, w.steps - 1])) <= TOLERANCE:
                    stops = False  # where it comes to rest it is passed
                if w.t[k] < w.risk_until and tail <= 0.0:
                    excess = (
                        min(needed_braking(w, speed, gap, w.v_follow[j, k]), 3.0 * w.b_max) / w.b_soft - 1.0
                    )
                    risk = max(risk, max(excess, 0.0) * max(excess, 0.0))
                final = gap + (w.s_follow[j, w.steps - 1] - w.s_follow[j, k])
                spare = 0.5 * w.standstill_gap
                a = follow_at_gap(w, speed, gap, w.v_follow[j, k], final, stops, spare, to_pass)
                if a < want:
                    want = a
                    limit = j
        w.terms[row, 8] += risk * h
        for j in range(yields):
            left = w.stop_s[j] - position
            wait = w.stop_until[j] - w.t[k]
            if wait > 0.0 and left > -2.0:
                a = wait_at_point(w, speed, left, wait)
                if a < want:
                    want = a
                    limit = FIRST_STOP - j
        if k <= LIMITED_STEP:
            w.limited_by[row] = limit
        free = False  # of limits of its change: what is kept was within them
        if kept:
            law = want + CALM
            want = min(w.a[row, k], min(cruise, max(there, -w.b_max)) if there < 0.0 else w.a_max)
            free = want <= law
            want = min(want, law)
        want = min(want, -braking) if braking > 0.0 else want
        if ends:
            want = -tail
        side = (w.kappa[station(w.n, position)] + bend(w, p, position)) * speed * speed
        available = math.sqrt(max(w.grip * w.grip - side * side, 0.25))
        want = min(max(want, -available), available)
        if not free or ends:
            hard = want < -2.0 * w.b_comfort or ends
            low = command - (w.jerk_emergency if hard else w.jerk) * h
            high = command + w.jerk * h
            if command < 0.0:
                high = max(high, min(command + RELEASE * h, 0.5))
            want = min(max(want, low), high)
        command = want
        w.a[row, k] = command
        z = h / w.lag  # of the brakes and the engine
        actual = actual + (command - actual) * (1.0 - 1.0 / (1.0 + z + 0.5 * z * z + z * z * z / 6.0))
        then = max(speed + actual * h, 0.0)
        if then <= 0.0 and actual < 0.0:
            actual = 0.0
            command = max(command, -w.b_comfort)
        position = position + 0.5 * (speed + then) * h
        speed = then


def sum_costs(w: Scene, row: Int, p: Int, until: Real) -> None:
    """Integrals over a time of what a motion costs, and its peak lateral acceleration."""
    for c in range(8):
        w.terms[row, c] = 0.0
    last = 0
    for k in range(w.steps - 1):
        if not w.t[k] < until:
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
        if is_outside(w, p, d, 0.0):
            w.terms[row, 3] += h
        jerk = (w.a[row, k + 1] - a) / h
        w.terms[row, 4] += jerk * jerk * h
    w.terms[row, 5] = w.s[row, last]
    w.terms[row, 6] = w.v[row, last]
    w.terms[row, 7] = w.offset_at[row, w.steps - 1]
