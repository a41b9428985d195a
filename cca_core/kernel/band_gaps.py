"""Gaps of the ego's swept box to obstacles, between nodes too: lower bounds, tight where they limit."""

import math

from cca_core.kernel.band_boxes import node_of
from cca_core.kernel.band_workspace import BandWork
from cca_core.kernel.box_gaps import norm, oriented_box_gap
from cca_core.kernel.constants import TINY
from cca_core.kernel.types import Flag, Int, Real, floor_within

CURVE_ERROR = 2e-3  # by which cubics and headings between nodes may differ from those assumed [m]
LOOSE = 4e-3  # a bound this far below the least gap at nodes is refined [m]
DECISIVE = 1e-2  # gaps this far above the clearance do not limit a band [m]
PARTS = 16  # of an interval that is sampled closely
TURN_ERROR = 0.125  # of a corner's way by turns: two parts of it, as its sense may change [-]
LEVER = 0.6  # of the length, at which a corner moves if the body turns [-]


def gap_at(w: BandWork, o: Int, i: Int) -> Real:
    """Return the gap to an obstacle with the ego at a node."""
    k = node_of(w, o, i)
    return oriented_box_gap(
        w.box_x[o, k] - w.center_x[i], w.box_y[o, k] - w.center_y[i], w.ahead_x[i], w.ahead_y[i],
        w.box_ahead_x[o, k], w.box_ahead_y[o, k],
        0.5 * w.length, 0.5 * w.width, w.half_length[o, k], w.half_width[o, k],
    )  # fmt: skip


def sample_between(w: BandWork, o: Int, i: Int, first: Real, last: Real) -> None:
    """Compute the gap to an obstacle at equal parts from a node to the next, whose gaps are given."""
    j = i + 1
    x = w.x[i]
    y = w.y[i]
    cx = w.x[j] - x
    cy = w.y[j] - y
    chord = norm(cx, cy)
    ax = w.ahead_x[i] * chord - cx
    ay = w.ahead_y[i] * chord - cy
    bx = cx - w.ahead_x[j] * chord
    by = cy - w.ahead_y[j] * chord
    changes = w.is_fixed[o] == 0
    at = node_of(w, o, i)
    box_x = w.box_x[o, at]
    box_y = w.box_y[o, at]
    heading_x = w.box_ahead_x[o, at]
    heading_y = w.box_ahead_y[o, at]
    box_length = w.half_length[o, at]
    box_width = w.half_width[o, at]
    length = 0.5 * w.length
    width = 0.5 * w.width
    offset = w.box_offset
    parts = w.parts
    parts[0] = first
    parts[PARTS] = last
    for k in range(1, PARTS):
        f = k / 16.0
        e = 1.0 - f
        tx = cx + e * (1.0 - 3.0 * f) * ax + f * (2.0 - 3.0 * f) * bx
        ty = cy + e * (1.0 - 3.0 * f) * ay + f * (2.0 - 3.0 * f) * by
        speed = max(norm(tx, ty), TINY)
        tx /= speed
        ty /= speed
        if changes:
            hx = w.box_ahead_x[o, i] + f * (w.box_ahead_x[o, j] - w.box_ahead_x[o, i])
            hy = w.box_ahead_y[o, i] + f * (w.box_ahead_y[o, j] - w.box_ahead_y[o, i])
            heading = max(norm(hx, hy), TINY)
            heading_x = hx / heading
            heading_y = hy / heading
            box_x = w.box_x[o, i] + f * (w.box_x[o, j] - w.box_x[o, i])
            box_y = w.box_y[o, i] + f * (w.box_y[o, j] - w.box_y[o, i])
            box_length = w.half_length[o, i] + f * (w.half_length[o, j] - w.half_length[o, i])
            box_width = w.half_width[o, i] + f * (w.half_width[o, j] - w.half_width[o, i])
        dx = box_x - (x + f * cx + f * e * (e * ax + f * bx)) - offset * tx
        dy = box_y - (y + f * cy + f * e * (e * ay + f * by)) - offset * ty
        parts[k] = oriented_box_gap(
            dx, dy, tx, ty, heading_x, heading_y, length, width, box_length, box_width
        )


def turn_between(w: BandWork, o: Int, i: Int) -> Real:
    """Return by how much the box of an obstacle turns from a node to the next [rad]."""
    if w.is_fixed[o] != 0:
        return 0.0
    j = min(i + 1, w.n - 1)
    return norm(w.box_ahead_x[o, j] - w.box_ahead_x[o, i], w.box_ahead_y[o, j] - w.box_ahead_y[o, i])


def min_between(w: BandWork, o: Int, i: Int, first: Real, last: Real) -> Real:
    """Return a lower bound of the gap to an obstacle from a node to the next, whose gaps are given."""
    gap = w.parts
    sample_between(w, o, i, first, last)
    bound = gap[0]
    for k in range(1, PARTS + 1):
        if gap[k] < bound:
            bound = gap[k]
    if w.max_step[o] > 0.0:
        bent = w.spacing * max(abs(w.curvature[i]), abs(w.curvature[i + 1]))
        swing = w.radius[o, i] * turn_between(w, o, i) + LEVER * w.length * bent
        bound -= TURN_ERROR * swing
    # in the first and in the last part the gap lies above the next part's secant
    bound = min(bound, gap[1] - max(gap[2] - gap[1], 0.0))
    bound = min(bound, gap[PARTS - 1] + min(gap[PARTS - 1] - gap[PARTS - 2], 0.0))
    before = gap[1] - gap[0]
    here = gap[2] - gap[1]
    for k in range(1, PARTS - 1):
        after = gap[k + 2] - gap[k + 1]
        if before < 0.0 and after > 0.0:
            bound = min(bound, gap[k] + before * (here - after) / (before - after))
        before = here
        here = after
    return bound


def max_change(w: BandWork) -> Real:
    """Return by how much a gap to a stationary obstacle changes at most from node to node."""
    return w.spacing * (1.0 + LEVER * w.length * w.max_curvature)


def set_centers(w: BandWork) -> Real:
    """Compute the center of the ego's box at each node; return the longest way from node to node."""
    center_x = w.center_x
    center_y = w.center_y
    offset = w.box_offset
    longest = 0.0
    last_x = 0.0
    last_y = 0.0
    node_x = w.x
    node_y = w.y
    ahead_x = w.ahead_x
    ahead_y = w.ahead_y
    for i in range(w.n):
        x = node_x[i] + offset * ahead_x[i]
        y = node_y[i] + offset * ahead_y[i]
        center_x[i] = x
        center_y[i] = y
        if i > 0:
            dx = x - last_x
            dy = y - last_y
            squared = dx * dx + dy * dy
            if squared > longest:
                longest = squared
        last_x = x
        last_y = y
    return math.sqrt(longest)


def find_near(w: BandWork) -> None:
    """Find the obstacles and nodes that may be near each other, as pairs; skip nodes that are too far."""
    # circles around the boxes bound their gap from below, circles inside them from above
    half = 0.5 * norm(w.length, w.width)
    upper = math.inf
    step = set_centers(w)
    change = max_change(w)
    center_x = w.center_x
    center_y = w.center_y
    clearance = w.clearance
    half_width = 0.5 * w.width
    w.n_pairs = 0
    for o in range(w.m):
        moves = w.max_step[o] + change
        travel = max(w.max_step[o] + step, TINY)
        next_node = 0
        changes = w.is_fixed[o] == 0
        x = w.box_x[o, 0]
        y = w.box_y[o, 0]
        radius = w.radius[o, 0]
        box_width = w.half_width[o, 0]
        for i in range(w.n):
            if i < next_node:
                continue
            if changes:
                x = w.box_x[o, i]
                y = w.box_y[o, i]
                radius = w.radius[o, i]
                box_width = w.half_width[o, i]
            distance = norm(x - center_x[i], y - center_y[i])
            gap = distance - (radius + half)
            upper = min(upper, distance - box_width)
            near = max(clearance, upper - half_width) + 2.0 * moves
            if gap > near:
                excess = distance - (w.max_radius[o] + half) - near
                next_node = i + floor_within(excess / travel, 1, w.n)
            else:
                w.pair_obstacle[w.n_pairs] = o
                w.pair_node[w.n_pairs] = i
                w.bound[w.n_pairs] = gap
                w.n_pairs += 1
    w.near = max(w.clearance, upper - 0.5 * w.width)


def sample_near(w: BandWork) -> None:
    """Sample the gaps of the pairs; drop those that have turned out to be far, as others are nearer."""
    change = max_change(w)
    count = 0
    for k in range(w.n_pairs):
        o = w.pair_obstacle[k]
        i = w.pair_node[k]
        moves = w.max_step[o] + change
        if w.bound[k] > w.near + 2.0 * moves:
            continue
        w.pair_obstacle[count] = o
        w.pair_node[count] = i
        w.sampled[count] = gap_at(w, o, i)
        turn = w.spacing * abs(w.curvature[i])
        w.bulge[count] = 0.125 * w.spacing * turn + 0.5 * moves * (turn + turn_between(w, o, i))
        count += 1
    w.n_pairs = count


def is_straight(w: BandWork) -> Flag:
    """Return whether the band is straight at the sampled nodes, and every obstacle stationary."""
    for o in range(w.m):
        if w.max_step[o] != 0.0:
            return False
    for k in range(w.n_pairs):
        if w.curvature[w.pair_node[k]] != 0.0:
            return False
    return True


def bound_between(w: BandWork) -> None:
    """Bound the gaps between sampled nodes from below, by the samples around."""
    # The gap of convex bodies in straight relative motion without rotation is a convex function of time: it
    # lies above the secants of the intervals on both sides. The bulge of the cubic from its chord and the
    # effect of rotation are subtracted from that bound.
    sampled = w.sampled
    bulge = w.bulge
    bound = w.bound
    count = w.n_pairs
    error = 0.0 if is_straight(w) else CURVE_ERROR
    for k in range(count):
        bulge[k] += error
        bound[k] = sampled[k]
    for k in range(count - 1):
        if w.pair_node[k + 1] - w.pair_node[k] == 1:
            bound[k] = min(sampled[k], sampled[k + 1]) - max(bulge[k], bulge[k + 1])
    # extended secants of both sides meet below the samples where the gap may dip between them
    for k in range(1, count - 2):
        before = sampled[k] - sampled[k - 1]
        after = sampled[k + 2] - sampled[k + 1]
        if before < 0.0 and after > 0.0 and w.pair_node[k + 2] - w.pair_node[k - 1] == 3:
            dip = sampled[k] + before * (sampled[k + 1] - sampled[k] - after) / (before - after)
            # the secants suppose that the curvature at all four nodes makes no difference
            allowance = max(bulge[k - 1], bulge[k], bulge[k + 1], bulge[k + 2])
            bound[k] = min(bound[k], dip - allowance)
    change = max_change(w)
    for k in range(count - 1):
        i = w.pair_node[k]
        if w.pair_node[k + 1] - i == 1 and (i == 0 or i == w.n - 2):
            bound[k] -= 0.5 * (w.max_step[w.pair_obstacle[k]] + change)


def refine_between(w: BandWork) -> None:
    """Sample closely where a bound is below the clearance, or loose where the gap at the nodes is."""
    sampled = w.sampled
    bound = w.bound
    count = w.n_pairs
    min_sample = math.inf
    for k in range(count):
        min_sample = min(min_sample, sampled[k])
    for k in range(count - 1):
        o = w.pair_obstacle[k]
        i = w.pair_node[k]
        if w.pair_node[k + 1] - i != 1:
            continue
        min_at_nodes = min(sampled[k], sampled[k + 1])
        decisive = w.clearance
        if min_at_nodes < w.clearance:  # the shortfall between nodes moves bounds; only motion adds to it
            if not w.max_step[o] > 0.0:
                continue
            decisive = min_at_nodes - LOOSE
        elif w.max_step[o] == 0.0:
            decisive = max(decisive, min(min_sample - LOOSE, w.clearance + DECISIVE))
        if bound[k] < decisive:
            bound[k] = min_between(w, o, i, sampled[k], sampled[k + 1])


def measure_gaps(w: BandWork) -> None:
    """Bound the gaps of the pairs from each node to the next, and find the least of all."""
    find_near(w)
    sample_near(w)
    bound_between(w)
    refine_between(w)
    w.min_gap = math.inf
    for k in range(w.n_pairs):
        w.min_gap = min(w.min_gap, w.bound[k])
        if not w.bound[k] > -math.inf:
            w.finite = False


def gap_to(w: BandWork, o: Int) -> Real:
    """Return the least gap to an obstacle; infinite if it is far."""
    gap = math.inf
    for k in range(w.n_pairs):
        if w.pair_obstacle[k] == o:
            gap = min(gap, w.bound[k])
    return gap


def end_gap(w: BandWork, o: Int) -> Real:
    """Return the lesser of the gaps to an obstacle at the pinned ends, which no deformation changes."""
    e = w.n - 1
    x = w.route_x[0] - w.tangent_y[0] * w.free[0] + w.box_offset * w.heading_x0
    y = w.route_y[0] + w.tangent_x[0] * w.free[0] + w.box_offset * w.heading_y0
    first = oriented_box_gap(
        w.box_x[o, 0] - x, w.box_y[o, 0] - y, w.heading_x0, w.heading_y0,
        w.box_ahead_x[o, 0], w.box_ahead_y[o, 0],
        0.5 * w.length, 0.5 * w.width, w.half_length[o, 0], w.half_width[o, 0],
    )  # fmt: skip
    k = node_of(w, o, e)
    x = w.route_x[e] - w.tangent_y[e] * w.free[e] + w.box_offset * w.heading_x1
    y = w.route_y[e] + w.tangent_x[e] * w.free[e] + w.box_offset * w.heading_y1
    last = oriented_box_gap(
        w.box_x[o, k] - x, w.box_y[o, k] - y, w.heading_x1, w.heading_y1,
        w.box_ahead_x[o, k], w.box_ahead_y[o, k],
        0.5 * w.length, 0.5 * w.width, w.half_length[o, k], w.half_width[o, k],
    )  # fmt: skip
    return min(first, last)
