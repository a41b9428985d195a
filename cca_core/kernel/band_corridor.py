"""Bounds of a band: road edges, and obstacles on the side on which they are passed."""

import math

from cca_core.kernel.band_boxes import node_of
from cca_core.kernel.band_workspace import BandWork
from cca_core.kernel.box_gaps import norm
from cca_core.kernel.types import Flag, Int

ALIGNED = 0.02  # sine of the angle below which a box counts as parallel
PARALLEL = 1e-9  # below it the sense of rotation is that of rounding errors
END_SLOPE = 0.5  # at which bounds fall beyond the ends of an obstacle, steeper than any band [-]
MIN_DROP = 1e-9  # of an overlap from node to node [m]


def measure_overlaps(w: BandWork) -> Flag:
    """Compute how far obstacles overlap the ego along the route; return whether all are parallel to it."""
    # the ego reaches from -reach to reach + lead
    reach = 0.5 * w.length
    clearance = w.clearance
    offset = w.box_offset
    route_x = w.route_x
    route_y = w.route_y
    tangent_x = w.tangent_x
    tangent_y = w.tangent_y
    overlap = w.overlap
    max_sine = 0.0
    for o in range(w.m):
        lead = w.lead_distance[o]
        changes = w.is_fixed[o] == 0
        ax = w.box_ahead_x[o, 0]
        ay = w.box_ahead_y[o, 0]
        box_x = w.box_x[o, 0]
        box_y = w.box_y[o, 0]
        half_length = w.half_length[o, 0] + clearance
        half_width = w.half_width[o, 0] + clearance
        for i in range(w.n):
            if changes:
                ax = w.box_ahead_x[o, i]
                ay = w.box_ahead_y[o, i]
                box_x = w.box_x[o, i]
                box_y = w.box_y[o, i]
                half_length = w.half_length[o, i] + clearance
                half_width = w.half_width[o, i] + clearance
            tx = tangent_x[i]
            ty = tangent_y[i]
            x = (box_x - route_x[i]) * tx + (box_y - route_y[i]) * ty - offset
            cosine = abs(ax * tx + ay * ty)
            sine = abs(ay * tx - ax * ty)
            if sine > max_sine:
                max_sine = sine
            beyond = x - lead if x - lead > -x else -x
            overlap[o, i] = half_length * cosine + half_width * sine + reach - beyond
    return max_sine < ALIGNED


def measure_range(w: BandWork, o: Int, i: Int, aligned: Flag) -> None:
    """Compute the lateral range of an obstacle along the ego, and where the ego passes it."""
    # The range is that of the upper and lower roof of the box over the stretch of the ego: a roof has its
    # ridge at a corner and falls to both sides.
    reach = 0.5 * w.length
    k = node_of(w, o, i)
    tx = w.tangent_x[i]
    ty = w.tangent_y[i]
    ax = w.box_ahead_x[o, k]
    ay = w.box_ahead_y[o, k]
    dx = w.box_x[o, k] - w.route_x[i]
    dy = w.box_y[o, k] - w.route_y[i]
    x = dx * tx + dy * ty - w.box_offset
    y = dy * tx - dx * ty
    turn_cos = ax * tx + ay * ty
    turn_sin = ay * tx - ax * ty
    cosine = abs(turn_cos)
    sine = abs(turn_sin)
    along = w.half_length[o, k] + w.clearance
    across = w.half_width[o, k] + w.clearance
    half_y = along * sine + across * cosine
    upper = half_y
    lower = half_y
    if not aligned and sine > PARALLEL:
        counter = turn_cos * turn_sin >= 0.0  # rotated counter-clockwise by less than a right angle
        ridge = along * cosine - across * sine if counter else across * sine - along * cosine
        along_edge = sine / max(cosine, ALIGNED)
        across_edge = cosine / max(sine, ALIGNED)
        rise = along_edge if counter else across_edge
        fall = across_edge if counter else along_edge
        before = -reach - x
        behind = reach + w.lead_distance[o] - x
        upper = half_y - max(ridge - behind, 0.0) * rise - max(before - ridge, 0.0) * fall
        lower = half_y - max(ridge + before, 0.0) * rise - max(-behind - ridge, 0.0) * fall
    w.passing_right[o, i] = y - max(lower, -half_y) - 0.5 * w.width
    w.passing_left[o, i] = y + max(upper, -half_y) + 0.5 * w.width


def set_passing(w: BandWork) -> None:
    """Compute the displacements at which the ego passes obstacles; infinite where one is not alongside."""
    # bounds at the nodes with an overlap alone would jump by a node when an end moves past one
    aligned = measure_overlaps(w)
    slope = END_SLOPE * norm(w.route_x[1] - w.route_x[0], w.route_y[1] - w.route_y[0])
    last = w.n - 1
    overlaps = w.overlap
    passing_right = w.passing_right
    passing_left = w.passing_left
    for o in range(w.m):
        overlap = overlaps[o, 0]
        after = overlap
        for i in range(w.n):
            before = overlap
            overlap = after
            if i < last:
                after = overlaps[o, i + 1]
            if before >= 0.0 or overlap >= 0.0 or after >= 0.0:
                measure_range(w, o, i, aligned)
                near = max(before, overlap, after)
                relief = slope * (min(overlap, 0.0) / min(overlap - near, -MIN_DROP))
                passing_right[o, i] += relief
                passing_left[o, i] -= relief
            else:
                passing_right[o, i] = math.inf
                passing_left[o, i] = -math.inf


def set_bounds(w: BandWork) -> Int:
    """Compute the bounds for the sides; return the node where they overlap most, or -1."""
    half = 0.5 * w.width
    lower = w.lower
    upper = w.upper
    right_edge = w.right_edge
    left_edge = w.left_edge
    passing_right = w.passing_right
    passing_left = w.passing_left
    for i in range(w.n):
        lower[i] = right_edge[i] + half
        upper[i] = left_edge[i] - half
    for o in range(w.m):
        if w.passes_left[o] != 0:
            for i in range(w.n):
                bound = passing_left[o, i]
                if bound > lower[i]:
                    lower[i] = bound
        else:
            for i in range(w.n):
                bound = passing_right[o, i]
                if bound < upper[i]:
                    upper[i] = bound
    worst = 0.0
    node = -1
    for i in range(w.n):
        if lower[i] - upper[i] > worst:
            worst = lower[i] - upper[i]
            node = i
    return node
