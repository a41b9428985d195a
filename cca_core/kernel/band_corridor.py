"""Bounds of a band: road edges, and obstacles on the side on which they are passed."""

import math

from cca_core.kernel.band_workspace import BandWork
from cca_core.kernel.box_gaps import norm
from cca_core.kernel.types import Flag, Int

ALIGNED = 0.02  # sine of the angle below which a box counts as parallel
PARALLEL = 1e-9  # below it the sense of rotation is that of rounding errors
END_SLOPE = 0.5  # at which bounds fall beyond the ends of an obstacle, steeper than any band [-]
MIN_DROP = 1e-9  # of an overlap from node to node [m]


def set_heading(w: BandWork, o: Int, i: Int) -> None:
    """Compute unit heading and radius of an obstacle, and how far a corner has moved since the last node."""
    if i > 0 and w.box_psi[o, i] == w.box_psi[o, i - 1]:
        w.box_ahead_x[o, i] = w.box_ahead_x[o, i - 1]
        w.box_ahead_y[o, i] = w.box_ahead_y[o, i - 1]
    else:
        w.box_ahead_x[o, i] = math.cos(w.box_psi[o, i])
        w.box_ahead_y[o, i] = math.sin(w.box_psi[o, i])
    w.radius[o, i] = norm(w.half_length[o, i], w.half_width[o, i])
    w.max_radius[o] = max(w.max_radius[o], w.radius[o, i])
    if i > 0:
        step = norm(w.box_x[o, i] - w.box_x[o, i - 1], w.box_y[o, i] - w.box_y[o, i - 1])
        turn_x = w.box_ahead_x[o, i] - w.box_ahead_x[o, i - 1]
        turn = norm(turn_x, w.box_ahead_y[o, i] - w.box_ahead_y[o, i - 1])
        w.max_step[o] = max(w.max_step[o], step + turn * w.radius[o, i])


def set_headings(w: BandWork) -> None:
    """Compute headings, radii and steps of the obstacles."""
    x = w.box_x
    y = w.box_y
    psi = w.box_psi
    length = w.half_length
    width = w.half_width
    for o in range(w.m):
        w.max_step[o] = 0.0
        w.max_radius[o] = 0.0
        set_heading(w, o, 0)
        for i in range(1, w.n):
            k = i - 1
            if x[o, i] != x[o, k] or y[o, i] != y[o, k] or psi[o, i] != psi[o, k]:
                set_heading(w, o, i)
            elif length[o, i] != length[o, k] or width[o, i] != width[o, k]:
                set_heading(w, o, i)
            else:
                w.box_ahead_x[o, i] = w.box_ahead_x[o, k]
                w.box_ahead_y[o, i] = w.box_ahead_y[o, k]
                w.radius[o, i] = w.radius[o, k]


def measure_overlaps(w: BandWork) -> Flag:
    """Compute how far obstacles overlap the ego along the route; return whether all are parallel to it."""
    # the ego reaches from -reach to reach + lead
    reach = 0.5 * w.length
    clearance = w.clearance
    max_sine = 0.0
    for o in range(w.m):
        for i in range(w.n):
            tx = w.tangent_x[i]
            ty = w.tangent_y[i]
            ax = w.box_ahead_x[o, i]
            ay = w.box_ahead_y[o, i]
            x = (w.box_x[o, i] - w.route_x[i]) * tx + (w.box_y[o, i] - w.route_y[i]) * ty - w.box_offset
            cosine = abs(ax * tx + ay * ty)
            sine = abs(ay * tx - ax * ty)
            max_sine = max(max_sine, sine)
            half_x = (w.half_length[o, i] + clearance) * cosine + (w.half_width[o, i] + clearance) * sine
            w.overlap[o, i] = half_x + reach - max(-x, x - w.lead_distance[o])
    return max_sine < ALIGNED


def measure_range(w: BandWork, o: Int, i: Int, aligned: Flag) -> None:
    """Compute the lateral range of an obstacle along the ego, and where the ego passes it."""
    # The range is that of the upper and lower roof of the box over the stretch of the ego: a roof has its
    # ridge at a corner and falls to both sides.
    reach = 0.5 * w.length
    dx = w.box_x[o, i] - w.route_x[i]
    dy = w.box_y[o, i] - w.route_y[i]
    x = dx * w.tangent_x[i] + dy * w.tangent_y[i] - w.box_offset
    y = dy * w.tangent_x[i] - dx * w.tangent_y[i]
    turn_cos = w.box_ahead_x[o, i] * w.tangent_x[i] + w.box_ahead_y[o, i] * w.tangent_y[i]
    turn_sin = w.box_ahead_y[o, i] * w.tangent_x[i] - w.box_ahead_x[o, i] * w.tangent_y[i]
    cosine = abs(turn_cos)
    sine = abs(turn_sin)
    along = w.half_length[o, i] + w.clearance
    across = w.half_width[o, i] + w.clearance
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
    set_headings(w)
    aligned = measure_overlaps(w)
    slope = END_SLOPE * norm(w.route_x[1] - w.route_x[0], w.route_y[1] - w.route_y[0])
    last = w.n - 1
    for o in range(w.m):
        for i in range(w.n):
            overlap = w.overlap[o, i]
            before = w.overlap[o, i - 1] if i > 0 else overlap
            after = w.overlap[o, i + 1] if i < last else overlap
            if before >= 0.0 or overlap >= 0.0 or after >= 0.0:
                measure_range(w, o, i, aligned)
                near = max(before, overlap, after)
                relief = slope * (min(overlap, 0.0) / min(overlap - near, -MIN_DROP))
                w.passing_right[o, i] += relief
                w.passing_left[o, i] -= relief
            else:
                w.passing_right[o, i] = math.inf
                w.passing_left[o, i] = -math.inf


def set_bounds(w: BandWork) -> Int:
    """Compute the bounds for the sides; return the node where they overlap most, or -1."""
    half = 0.5 * w.width
    for i in range(w.n):
        w.lower[i] = w.right_edge[i] + half
        w.upper[i] = w.left_edge[i] - half
    for o in range(w.m):
        for i in range(w.n):
            if w.passes_left[o] != 0:
                w.lower[i] = max(w.lower[i], w.passing_left[o, i])
            else:
                w.upper[i] = min(w.upper[i], w.passing_right[o, i])
    worst = 0.0
    node = -1
    for i in range(w.n):
        if w.lower[i] - w.upper[i] > worst:
            worst = w.lower[i] - w.upper[i]
            node = i
    return node
