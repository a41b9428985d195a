"""Order of the vehicles in a lane: drivers brake behind each other, and no vehicle drives through another."""

import math

from cca_core.kernel.constants import STANDSTILL_SPEED
from cca_core.kernel.scene import Scene
from cca_core.kernel.types import Int, Real

__all__ = ["set_following_speed", "set_order"]

EAGER = 1.5  # drivers brake harder than needed, but no harder than the one ahead [-]
OVERLAP = 0.2  # of bodies across the road that still pass each other [m]


def keep_behind(w: Scene, j: Int, k: Int, sign: Real) -> None:
    """Keep the nominal motion of a vehicle behind another one of its lane and direction, a meter apart."""
    space = w.half_l[j] + w.half_l[k]
    apart = w.half_w[j] + w.half_w[k] - OVERLAP
    begin = sign * w.s_o[j, 0]
    if not sign * w.s_o[k, 0] - begin > space or abs(w.d_o[j, 0] - w.d_o[k, 0]) >= apart:
        return
    space += 1.0
    drive_on = sign * w.v_o[j, 0] >= 0.0 and sign * w.v_o[k, 0] >= 0.0
    if drive_on and sign * w.s_follow[j, w.steps - 1] <= sign * w.s_follow[k, 0] - space:
        return  # it never comes near
    last = w.steps - 1
    # its driver brakes in comfort, or at once: harder than needed, at most as the one ahead
    start = w.t[last]
    needed = 0.0
    for i in range(1, w.steps):
        lack = sign * (w.s_follow[j, i] - w.s_follow[k, i]) + space
        if lack > 0.0 and not abs(w.d_o[j, i] - w.d_o[k, i]) >= apart:
            start = min(start, w.t[i] - math.sqrt(2.0 * lack / w.b_comfort))
            needed = max(needed, 2.0 * lack / (w.t[i] * w.t[i]))
    start = max(start, 0.0)
    braking = max(w.b_comfort, needed)
    farthest = begin
    for i in range(w.steps):
        late = max(w.t[i] - start, 0.0)
        s = sign * w.s_follow[j, i]
        at = s - 0.5 * braking * (late * late)
        if needed > 0.0:
            alike = s + sign * (w.s_follow[k, i] - w.s_follow[k, 0] - w.v_o[k, 0] * w.t[i])
            at = min(at, max(alike, s - 0.5 * EAGER * needed * (w.t[i] * w.t[i])))
        if not abs(w.d_o[j, i] - w.d_o[k, i]) >= apart:
            at = min(at, sign * w.s_follow[k, i] - space)
        farthest = max(farthest, at)
        w.s_follow[j, i] = sign * farthest


def set_order(w: Scene, sign: Real) -> None:
    """Keep the vehicles of one direction behind each other, the first one first."""
    count = 0
    for j in range(w.m):
        if w.crosses[j] != 0 or w.assumed[j] != 0 or not sign * w.v_o[j, 0] > -STANDSTILL_SPEED:
            continue
        at = count
        for _ in range(count):
            if not sign * w.s_o[w.order[at - 1], 0] < sign * w.s_o[j, 0]:
                break
            w.order[at] = w.order[at - 1]
            at -= 1
        w.order[at] = j
        count += 1
    for i in range(count):
        for k in range(i):
            keep_behind(w, w.order[i], w.order[k], sign)


def set_following_speed(w: Scene, j: Int) -> None:
    """Speed of a vehicle that stays behind others; second order for unequal steps."""
    last = w.steps - 1
    w.v_follow[j, 0] = (w.s_follow[j, 1] - w.s_follow[j, 0]) / (w.t[1] - w.t[0])
    w.v_follow[j, last] = (w.s_follow[j, last] - w.s_follow[j, last - 1]) / (w.t[last] - w.t[last - 1])
    for i in range(1, last):
        h = w.t[i] - w.t[i - 1]
        g = w.t[i + 1] - w.t[i]
        before = (w.s_follow[j, i] - w.s_follow[j, i - 1]) / h
        after = (w.s_follow[j, i + 1] - w.s_follow[j, i]) / g
        w.v_follow[j, i] = (g * before + h * after) / (h + g)
    w.stands[j] = 1 if abs(w.v_follow[j, last]) < STANDSTILL_SPEED else 0
