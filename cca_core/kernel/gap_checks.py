"""Gaps of the ego's motions to other vehicles, nominally and in the worst case."""

import math

from cca_core.kernel.box_gaps import norm, oriented_box_gap
from cca_core.kernel.duties import (
    FAR,
    find_duty,
    has_duty,
    is_behind,
    is_established,
    is_in_zone_lane,
    keeps_zone,
    merges_behind,
    reacts,
    worst_rear_gap,
    zone_begin,
)
from cca_core.kernel.rollout import ONCOMING
from cca_core.kernel.scene import TOLERANCE, Scene, at_station, is_outside, slope, station
from cca_core.kernel.traffic import BEND_W, BULGE
from cca_core.kernel.types import Flag, Int, Real

__all__ = ["check_nominal", "check_worst_case"]

STANDSTILL = 0.2  # speed below which the ego stands [m/s]
FAR_IN_PLANE = 15.0  # gap from which on a crossing vehicle is far [m]
NEAR = 12.0  # part of an interval beyond the body that matters [m]
ROUNDING = 1e-6  # of gaps, at most [m]


def pose(w: Scene, at: Real, d: Real, turn: Real) -> tuple[Real, Real, Real, Real]:
    """Center of the ego's body in the plane, cosine and sine of its heading."""
    route = at_station(w.n, w.psi, at)
    heading = route + math.atan2(turn, max(1.0 - w.kappa[station(w.n, at)] * d, 0.1))
    c = math.cos(heading)
    s = math.sin(heading)
    x = at_station(w.n, w.x, at) - d * math.sin(route) + w.offset * c
    y = at_station(w.n, w.y, at) + d * math.cos(route) + w.offset * s
    return x, y, c, s


def set_poses(w: Scene, row: Int, p: Int) -> None:
    """Place the ego's body at each step of a motion: on the route, and in the plane if vehicles cross."""
    for k in range(w.steps):
        at = w.s[row, k]
        turn = slope(w, p, at)
        kappa = w.kappa[station(w.n, at)]
        w.turn[k] = turn
        w.scale[k] = 1.0 / math.sqrt(1.0 + turn * turn)
        w.bends[k] = max(
            abs(kappa), abs(w.kappa[station(w.n, at - NEAR)]), abs(w.kappa[station(w.n, at + NEAR)])
        )
        w.wide[k] = w.half_width + 0.5 * abs(kappa) * w.half_length * w.half_length
        if w.crossing > 0:
            w.x_e[k], w.y_e[k], w.c_e[k], w.s_e[k] = pose(w, at, w.offset_at[row, k], turn)


def ego_gap(w: Scene, row: Int, k: Int, low: Real, high: Real, right: Real, left: Real, enough: Real) -> Real:
    """Gap of the ego's body to a rectangle in route coordinates; more than `enough` may be more."""
    at = w.s[row, k]
    middle = at + w.offset
    reach = w.half_length + w.half_width
    if not low <= middle + reach + NEAR:
        return low - middle - reach
    if not high >= middle - reach - NEAR:
        return middle - reach - high
    turn = w.turn[k]
    scale = w.scale[k]
    aside = 0.5 * (right + left) - w.offset_at[row, k] - w.offset * turn * scale
    across = abs(aside) - (w.half_length * abs(turn) + w.wide[k]) * scale - 0.5 * (left - right)
    if across > enough:
        return across
    begin = max(low, middle - reach - NEAR)
    end = max(min(high, middle + reach + NEAR), begin)
    ahead = 0.5 * (begin + end) - at - w.offset * scale
    return oriented_box_gap(
        ahead, aside, scale, turn * scale, 1.0, 0.0, w.half_length, w.wide[k],
        0.5 * (end - begin), 0.5 * (left - right),
    )  # fmt: skip


def plane_gap(w: Scene, k: Int, x: Real, y: Real, psi: Real, length: Real, width: Real) -> Real:
    """Gap of the ego's body in a motion to a box in the plane."""
    dx = x - w.x_e[k]
    dy = y - w.y_e[k]
    if not norm(dx, dy) < length + width + w.half_length + w.half_width + FAR_IN_PLANE:
        return FAR_IN_PLANE
    return oriented_box_gap(
        dx, dy, w.c_e[k], w.s_e[k], math.cos(psi), math.sin(psi), w.half_length, w.half_width, length, width
    )


def nominal_gap(w: Scene, row: Int, j: Int, k: Int, pet: Real, enough: Real) -> Real:
    """Gap to a vehicle; one that crosses covers where it is within a time."""
    if w.crosses[j] != 0:
        length = w.half_l[j] + pet * w.v_o[j, k]
        return plane_gap(w, k, w.x_o[j, k], w.y_o[j, k], w.psi_o[j, k], length, w.half_w[j])
    s = w.s_o[j, k]
    d = w.d_o[j, k]
    return ego_gap(w, row, k, s - w.half_l[j], s + w.half_l[j], d - w.half_w[j], d + w.half_w[j], enough)


def impact_speed(w: Scene, row: Int, j: Int, k: Int) -> Real:
    """Relative speed of the ego and a vehicle at a time; 0 if both drive the same way and draw apart."""
    v = w.v[row, k]
    v_o = w.v_o[j, k]
    ahead = w.s_o[j, k] - w.s[row, k] - w.offset
    if w.crosses[j] == 0 and v_o >= 0.0 and (v_o - v) * ahead > 0.0:
        return 0.0
    route = at_station(w.n, w.psi, w.s[row, k])
    psi = w.psi_o[j, k] if w.crosses[j] != 0 else route
    return norm(v * math.cos(route) - v_o * math.cos(psi), v * math.sin(route) - v_o * math.sin(psi))


def check_nominal(
    w: Scene, row: Int, p: Int, touch: Real, met: Real, clearance: Real, wait: Real, pet: Real
) -> None:
    """Least gap to the nominal motion of others beyond what is asked, and the first overlap.

    Asked are `clearance` of vehicles that are passed; of others `touch`, and `met` where the ego is outside
    its lane.
    """
    back = find_duty(w, row, p, wait)
    set_poses(w, row, p)
    begin = 0 if w.established != 0 else zone_begin(w, w.zone_from)
    steps = w.steps
    margin = FAR
    closest = FAR
    which = -1
    when = steps
    hit = steps
    w.impact = 0.0
    for j in range(w.m):
        if is_established(w, j):
            continue  # as in the ego's lane, its driver keeps the distance
        passed = w.overtakes[p, j] != 0.0
        inside = clearance if passed else touch
        outside = clearance if passed else met
        keeps_off = reacts(w, row, j, begin)
        until = w.duty_from if has_duty(w, j, back) else steps
        until = min(until, merges_behind(w, row, j))
        for k in range(min(until, steps)):
            if keeps_off and begin <= k and k <= back:
                continue
            asked = outside if is_outside(w, p, w.offset_at[row, k], TOLERANCE) else inside
            # a gap that neither lowers a minimum nor is an overlap need not be exact
            enough = max(closest, asked + margin, 0.0) + ROUNDING if k > 0 else math.inf
            gap = nominal_gap(w, row, j, k, pet, enough)
            if k == 0:  # no more than there is now
                inside = min(inside, max(gap - 0.02, 0.0))
                outside = min(outside, max(gap - 0.02, 0.0))
                asked = min(asked, max(gap - 0.02, 0.0))
            closest = min(closest, gap)
            if not gap - asked >= margin:
                margin = gap - asked
                which = j
                when = k
            if gap < 0.0 and (k < hit or w.impact == 0.0):
                impact = impact_speed(w, row, j, k)
                if impact > 0.0 or hit == steps:  # bodies that draw apart count if nothing else does
                    hit = k
                    which = j
                    w.impact = impact
    w.min_margin = margin
    w.gap = closest
    w.which = which
    w.when = hit if hit < steps else when


def worst_gap(w: Scene, row: Int, p: Int, j: Int, k: Int, enough: Real) -> Real:
    """Gap to where a vehicle may be in the worst case; more than `enough` may be more."""
    if w.crosses[j] != 0:
        return plane_gap(w, k, w.x_w[j, k], w.y_w[j, k], w.psi_w[j, k], w.half_l_w[j, k], w.half_w_w[j, k])
    passed = w.overtakes[p, j] != 0.0
    low = w.low_passed[j, k] if passed else w.low[j, k]
    high = w.high_passed[j, k] if passed else w.high[j, k]
    # wider where the road bends, beyond the bend in which it is now
    bulge = max(w.seen[j, BULGE] * w.bends[k] - w.seen[j, BEND_W], 0.0)
    return ego_gap(
        w, row, k, low - w.margin, high + w.margin, w.right[j, k] - bulge, w.left[j, k] + bulge, enough
    )


def swept_gap(w: Scene, row: Int, p: Int, j: Int, k: Int) -> Real:
    """Least gap from one step to the next to where a vehicle along the route may be in the worst case."""
    passed = w.overtakes[p, j] != 0.0
    low = w.low_passed[j, k] if passed else w.low[j, k]
    high = w.high_passed[j, k] if passed else w.high[j, k]
    low_then = w.low_passed[j, k + 1] if passed else w.low[j, k + 1]
    high_then = w.high_passed[j, k + 1] if passed else w.high[j, k + 1]
    along = w.s[row, k + 1] - w.s[row, k]
    across = w.offset_at[row, k + 1] - w.offset_at[row, k]
    right = min(w.right[j, k], w.right[j, k + 1] - across)
    left = max(w.left[j, k], w.left[j, k + 1] - across)
    return ego_gap(w, row, k, min(low, low_then - along), max(high, high_then - along), right, left, math.inf)


def worst_impact(w: Scene, row: Int, j: Int, k: Int) -> Real:
    """Speed at which the ego and a vehicle of the worst case close at a time."""
    v = w.v[row, k]
    if w.crosses[j] != 0:
        return v
    i = max(k, 1)
    h = w.t[i] - w.t[i - 1]
    if w.s_o[j, 0] > w.s_0 + w.offset:
        return max(v - (w.low[j, i] - w.low[j, i - 1]) / h, 0.0)
    return max((w.high[j, i] - w.high[j, i - 1]) / h - v, 0.0)


def check_worst_case(
    w: Scene, row: Int, p: Int, touch: Real, clearance: Real, wait: Real, x_safety: Real, which: Int
) -> Flag:
    """Whether vehicles within the declared bounds cannot touch the ego.

    `which`: 0 all vehicles; 1 those of the adjacent lane on `zone_side`; 2 all others. With `x_safety` the
    ego keeps that distance along the road to vehicles of the adjacent lane until it has returned: from when
    it enters that lane, or from when the maneuver begins if the vehicle comes nearer. `impact` is the closing
    speed at the first overlap.
    """
    back = find_duty(w, row, p, wait)
    set_poses(w, row, p)
    steps = w.steps
    margin = FAR
    decides = -1
    when = steps
    hit = steps
    w.impact = 0.0
    maneuver_begin = zone_begin(w, w.begin_from)
    lane_begin = zone_begin(w, w.zone_from)
    for j in range(w.m):
        passed = w.overtakes[p, j] != 0.0
        nears = w.v_o[j, 0] < ONCOMING or w.v_o[j, 0] > w.v_0 or w.assumed[j] != 0
        begin = maneuver_begin if nears else lane_begin
        same = w.v_o[j, 0] >= ONCOMING and w.assumed[j] == 0
        ahead = same and w.s_o[j, begin] > w.s[row, begin] + w.offset
        adjacent = not passed and is_in_zone_lane(w, j)
        in_zone_lane = adjacent and (which == 1 or not ahead)
        if (which == 1 and not in_zone_lane) or (which == 2 and in_zone_lane):
            continue
        if w.assumed[j] != 0 and not x_safety > 0.0:
            continue
        if is_established(w, j):
            continue
        asked = clearance if passed else touch
        until = steps
        if has_duty(w, j, back) and is_behind(w, row, p, j, back):
            until = w.duty_from
        if which == 1:
            until = min(until, back + 1)
        for k in range(min(until, steps)):
            zone = x_safety > 0.0 and k <= back and k >= begin
            if zone and in_zone_lane:
                middle = w.s[row, k] + w.offset  # eq 11: along the road, wherever the ego is across it
                rear = w.s_o[j, k] - w.half_l[j] if ahead else w.low[j, k]
                zone_gap = max(
                    rear - x_safety - (middle + w.half_length),
                    middle - w.half_length - (w.high[j, k] + x_safety),
                )
                reacts_behind = same and not ahead and w.rear_reaction > 0.0
                if reacts_behind:  # it keeps its distance from then on
                    zone_gap = worst_rear_gap(w, row, j, k) - x_safety if k == begin else FAR
                if not zone_gap >= margin:
                    margin = zone_gap
                    decides = j
                    when = k
                if which == 1 or not reacts_behind or keeps_zone(w, j):
                    continue
            if w.assumed[j] != 0:
                continue
            if k > 0 and not w.v[row, k - 1] >= STANDSTILL and w.crosses[j] == 0:
                if not is_outside(w, p, w.offset_at[row, k], 0.0):
                    continue  # what stands in its lane touches nothing
            # a gap that neither lowers the margin nor is an overlap need not be exact
            enough = max(asked + margin, 0.0) + ROUNDING if k > 0 else math.inf
            gap = worst_gap(w, row, p, j, k, enough)
            if k == 0:
                asked = min(asked, max(gap - 0.02, 0.0))
            if asked < touch and k + 1 < steps and w.crosses[j] == 0:  # too little for contacts between steps
                gap = min(gap, swept_gap(w, row, p, j, k))
            if gap < 0.0 and k < hit:
                hit = k
                w.impact = worst_impact(w, row, j, k)
            if not gap - asked >= margin:
                margin = gap - asked
                decides = j
                when = k
    w.min_margin = margin
    w.which = decides
    w.when = when
    return margin >= 0.0
