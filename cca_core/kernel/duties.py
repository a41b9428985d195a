"""Duties: which vehicles behind the ego keep their distance to it, and how far their drivers can."""

import math

from cca_core.kernel.rollout import ONCOMING, TIME_EPS
from cca_core.kernel.scene import TOLERANCE, Scene, is_outside
from cca_core.kernel.traffic import AGE, AHEAD, HALF_L, HALF_W, SIDE_SPEED, SURE_W, D
from cca_core.kernel.types import Flag, Int, Real

__all__ = [
    "find_duty",
    "has_duty",
    "is_behind",
    "is_established",
    "is_in_zone_lane",
    "keeps_zone",
    "merges_behind",
    "reacts",
    "worst_rear_gap",
    "zone_begin",
]

FAR = 1e3  # gap where there is no vehicle [m]


def find_duty(w: Scene, row: Int, p: Int, wait: Real) -> Int:
    """Find from when on vehicles behind the ego must keep their distance; return when it is in its lane."""
    back = 0
    for k in range(w.steps):
        if is_outside(w, p, w.offset_at[row, k], TOLERANCE):
            back = min(k + 1, w.steps - 1)
    w.rear = w.s[row, back] + w.offset - w.half_length
    w.duty_from = back
    for k in range(back, w.steps):
        if back > 0 and w.t[k] < w.t[back] + wait:
            w.duty_from = k + 2  # a touch before the first step after that time is seen in that step
    return back


def has_duty(w: Scene, j: Int, back: Int) -> Flag:
    """Whether a vehicle is behind the ego in its lane from `duty_from` on, for good."""
    if w.crosses[j] != 0 or not w.v_o[j, 0] >= ONCOMING:
        return False
    return w.s_o[j, back] + 0.5 * w.half_l[j] < w.rear


def merges_behind(w: Scene, row: Int, j: Int) -> Int:
    """First step at which a vehicle from the side is behind the ego in its way, and keeps its distance."""
    if w.crosses[j] != 0 or not w.v_o[j, 0] >= ONCOMING:
        return w.steps
    across = w.half_w[j] + w.half_width
    for k in range(w.steps):
        if abs(w.d_o[j, k] - w.offset_at[row, k]) < across:
            moves_in = abs(w.d_o[j, 0] - w.offset_at[row, k]) >= across
            behind = w.s_o[j, k] + w.half_l[j] < w.s[row, k] + w.offset - w.half_length
            return k if moves_in and behind else w.steps
    return w.steps


def is_behind(w: Scene, row: Int, p: Int, j: Int, back: Int) -> Flag:
    """Whether a vehicle that is nominally behind cannot be alongside: far enough, or in the ego's lane."""
    high = w.high_passed[j, back] if w.overtakes[p, j] != 0.0 else w.high[j, back]
    ahead = w.seen[j, AHEAD]
    front = w.seen[j, HALF_L] * math.sqrt(max(1.0 - ahead * ahead, 0.0))  # so far aside, if it is oblique
    in_lane = w.half_width + min(w.seen[j, SURE_W], 0.0) - front - TOLERANCE
    now = w.d_o[j, back] - w.offset_at[row, back]
    reported = now - w.seen[j, SIDE_SPEED] * w.seen[j, AGE]
    return high < w.rear or (abs(now) < in_lane and abs(reported) < in_lane)


def is_surely_in(w: Scene, j: Int, right: Real, left: Real) -> Flag:
    """Whether a body is at least in part in a lane, wherever it is within its bounds.

    Since its report it has moved sideways at most as reported.
    """
    now = w.seen[j, D]
    reported = now - w.seen[j, SIDE_SPEED] * w.seen[j, AGE]
    low = max(now, reported) - w.seen[j, SURE_W]
    high = min(now, reported) + w.seen[j, SURE_W]
    return low < left - w.entry_tolerance and high > right + w.entry_tolerance


def is_established(w: Scene, j: Int) -> Flag:
    """Whether a vehicle follows an ego outside its lane, in one of the lanes that the ego is in."""
    if w.established == 0 or w.crosses[j] != 0 or not w.v_o[j, 0] >= ONCOMING:
        return False
    if not w.high[j, 0] < w.s_0 + w.offset - w.half_length:
        return False  # it may be alongside
    if w.established == 1:
        return is_surely_in(w, j, w.lane_right if w.leaves else w.lane_left, w.edge_left)
    return is_surely_in(w, j, w.edge_right, w.lane_left if w.leaves else w.lane_right)


def zone_begin(w: Scene, since: Real) -> Int:
    """Index of the first time that is not before another."""
    begin = w.steps - 1
    for k in range(w.steps):
        if w.t[k] >= since - TIME_EPS:
            begin = min(begin, k)
    return begin


def is_in_zone_lane(w: Scene, j: Int) -> Flag:
    """Whether a vehicle is in the adjacent lane that the maneuver enters."""
    return w.adjacent[j] == 3 or w.adjacent[j] == w.zone_side


def keeps_zone(w: Scene, j: Int) -> Flag:
    """Whether a vehicle is for certain in the adjacent lane that the maneuver enters, not in the ego's."""
    half = 0.5 * (w.seen[j, HALF_W] + w.seen[j, SURE_W])  # of the body, where it is reported
    if w.zone_side == 1:
        outside = w.seen[j, D] - half > w.lane_left - w.entry_tolerance
        return outside and is_surely_in(w, j, w.lane_left, w.edge_left)
    outside = w.seen[j, D] + half < w.lane_right + w.entry_tolerance
    return outside and is_surely_in(w, j, w.edge_right, w.lane_right)


def rear_gap(w: Scene, row: Int, begin: Int, front: Real, speed: Real) -> Real:
    """Least gap behind the ego to a driver who reacts to it from a time on, given their front and speed."""
    gap = FAR
    position = front
    v = speed
    for k in range(begin, w.steps):
        gap = min(gap, w.s[row, k] + w.offset - w.half_length - position)
        has_reacted = w.t[k] - w.t[begin] >= w.rear_reaction - TIME_EPS
        if k + 1 == w.steps or (has_reacted and not v > w.v[row, k]):
            break
        h = w.t[k + 1] - w.t[k]
        then = max(v - w.rear_braking * h, 0.0) if has_reacted else v
        position = position + 0.5 * (v + then) * h
        v = then
    return gap


def reacts(w: Scene, row: Int, j: Int, begin: Int) -> Flag:
    """Whether a driver behind in the adjacent lane has the room to react to the ego from a time on."""
    if not w.rear_reaction > 0.0 or w.crosses[j] != 0 or not keeps_zone(w, j):
        return False
    front = w.s_o[j, begin] + w.half_l[j]
    if not w.v_o[j, begin] >= ONCOMING or not front < w.s[row, begin] + w.offset - w.half_length:
        return False
    return rear_gap(w, row, begin, front, w.v_o[j, begin]) > 0.0


def worst_rear_gap(w: Scene, row: Int, j: Int, begin: Int) -> Real:
    """Least gap behind the ego to a vehicle of the adjacent lane, in its worst case until it reacts."""
    speed = w.v_o[j, begin]
    if begin > 0:
        speed = (w.high[j, begin] - w.high[j, begin - 1]) / (w.t[begin] - w.t[begin - 1])
    return rear_gap(w, row, begin, w.high[j, begin], speed)
