"""Obstacles of a band: which vehicles the ego meets, when it is alongside them, and their boxes."""

import math
from typing import Annotated

from cca_core.kernel.curve import Curve
from cca_core.kernel.reach import occupancy_box
from cca_core.kernel.scene import Scene
from cca_core.kernel.traffic import HALF_L, HALF_W, SPEED, D, S
from cca_core.kernel.types import Flag, Grid, Int, Ints, Real, Reals

__all__ = ["find_meetings", "find_obstacles", "find_span"]

Row = Annotated[Reals, "n"]
Rows = Annotated[Ints, "vehicles"]
Boxes = Annotated[Grid, "vehicles * n", 5]

ON_ROUTE = -1  # on the route now, but not met
AWAY = -2
SPARE = 0.5  # gap along the road within which a vehicle is met [m]
NEAR = 2.0  # and within which it is an obstacle [m]


def find_meetings(w: Scene, row: Int, rear: Real) -> None:
    """Find the step at which a motion along the route meets each vehicle ahead of `rear`."""
    for j in range(w.m):
        w.met[j] = AWAY
        if w.crosses[j] != 0 or w.assumed[j] != 0 or not w.s_o[j, 0] + w.half_l[j] > rear:
            continue
        across = w.half_w[j] + w.half_width + w.blocking_gap
        along = w.half_l[j] + w.half_length + SPARE
        if abs(w.d_o[j, 0]) < across:
            w.met[j] = ON_ROUTE
        for k in range(w.steps):
            if abs(w.d_o[j, k]) < across and abs(w.s_o[j, k] - (w.s[row, k] + w.offset)) < along:
                w.met[j] = k
                break


def overlap(w: Scene, row: Int, j: Int, k: Int, reach: Real, lead: Real) -> Real:
    """Length by which the ego is alongside a vehicle at a step, negative if it is not."""
    center = w.s[row, k] + w.offset
    return min(w.high_passed[j, k] - center + reach, center + reach - w.low_passed[j, k] + lead)


def span(w: Scene, row: Int, j: Int, reach: Real, lead: Real) -> tuple[Real, Real, Real]:
    """Stations between which the ego is alongside a vehicle, and its speed at the first."""
    first = -1
    last = -1
    for k in range(w.steps):
        if overlap(w, row, j, k, reach, lead) >= 0.0:
            last = k
            if first < 0:
                first = k
    if first < 0:
        return math.inf, math.inf, 0.0
    begin = w.s[row, first]
    v = w.v[row, first]
    if first > 0:
        depth = overlap(w, row, j, first, reach, lead)
        f = depth / (depth - overlap(w, row, j, first - 1, reach, lead))
        begin -= (w.s[row, first] - w.s[row, first - 1]) * f
        v -= (w.v[row, first] - w.v[row, first - 1]) * f
    if last == w.steps - 1:
        return begin, math.inf, v
    depth = overlap(w, row, j, last, reach, lead)
    f = depth / (depth - overlap(w, row, j, last + 1, reach, lead))
    return begin, w.s[row, last] + (w.s[row, last + 1] - w.s[row, last]) * f, v


def find_span(w: Scene, row: Int, j: Int, clearance: Real, ttc: Real) -> tuple[Real, Real, Real]:
    """Stations between which the ego is alongside a vehicle in its worst case, and the lead before that."""
    reach = w.half_length + clearance
    begin, end, v = span(w, row, j, reach, 0.0)
    lead = ttc * max(v - w.seen[j, SPEED], 0.0) if begin < math.inf else 0.0
    begin, end, v = span(w, row, j, reach, lead)
    return begin, end, lead


def step_at(w: Scene, t: Real, k: Int) -> Int:
    """Step before a time, from an earlier one on."""
    step = k
    for _ in range(w.steps):
        if step + 2 >= w.steps or not w.t[step + 1] <= t:
            break
        step += 1
    return step


def is_obstacle(w: Scene, base: Real, n: Int, s: Row, t: Row, j: Int, rear: Real) -> Flag:
    """Whether a vehicle is in the ego lane near where the ego is at some station."""
    if w.crosses[j] != 0 or w.assumed[j] != 0 or not w.seen[j, S] + w.seen[j, HALF_L] >= rear:
        return False
    d = w.seen[j, D]
    if not (d - w.seen[j, HALF_W] <= w.lane_left and d + w.seen[j, HALF_W] >= w.lane_right):
        return False  # eq 11 decides about the adjacent lane
    k = 0
    for i in range(n):
        k = step_at(w, t[i], k)
        f = min(max((t[i] - w.t[k]) / (w.t[k + 1] - w.t[k]), 0.0), 1.0)
        at = base + w.s_o[j, k] + f * (w.s_o[j, k + 1] - w.s_o[j, k])
        if abs(at - s[i]) <= w.half_l[j] + 2.0 * w.half_length + NEAR:
            return True
    return False


def find_obstacles(
    w: Scene, curve: Curve, base: Real, n: Int, s: Row, t: Row, rear: Real, group: Int, vehicles: Int,
    rows: Rows, boxes: Boxes,
) -> Int:  # fmt: skip
    """Boxes of a group in its worst case, and nominally of the others near the stations; their number."""
    count = group
    for j in range(w.m):
        grouped = False
        for i in range(group):
            grouped = grouped or rows[i] == j
        if not grouped and count < vehicles and is_obstacle(w, base, n, s, t, j, rear):
            rows[count] = j
            count += 1
    for c in range(count):
        j = rows[c]
        k = 0
        for i in range(n):
            k = step_at(w, t[i], k)
            f = min(max((t[i] - w.t[k]) / (w.t[k + 1] - w.t[k]), 0.0), 1.0)
            at = w.s_o[j, k] + f * (w.s_o[j, k + 1] - w.s_o[j, k])
            low = at - w.half_l[j]
            high = at + w.half_l[j]
            if c < group:
                low = w.low_passed[j, k] + f * (w.low_passed[j, k + 1] - w.low_passed[j, k])
                high = w.high_passed[j, k] + f * (w.high_passed[j, k + 1] - w.high_passed[j, k])
            d = w.d_o[j, k] + f * (w.d_o[j, k + 1] - w.d_o[j, k])
            box = c * n + i
            boxes[box, 0], boxes[box, 1], boxes[box, 2], boxes[box, 3], boxes[box, 4] = occupancy_box(
                curve, s[i], base + low, base + high, d, w.half_w[j]
            )
    return count
