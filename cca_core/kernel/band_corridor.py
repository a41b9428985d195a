"""Bounds of a band: road edges, and obstacles on the side on which they are passed."""

import math

from cca_core.kernel.band_workspace import BandWork
from cca_core.kernel.box_gaps import norm
from cca_core.kernel.types import Flag, Int

ALIGNED = 0.02  # sine of the angle below which a box counts as parallel
END_SLOPE = 0.5  # at which bounds fall beyond the ends of an obstacle, steeper than any band [-]
MIN_DROP = 1e-9  # of an overlap from node to node [m]


def set_headings(w: BandWork) -> Flag:
    """Compute headings, radii and steps of the obstacles; return whether all are parallel to the route."""
    max_sine = 0.0
    for o in range(w.m):
        w.max_step[o] = 0.0
        for i in range(w.n):
            if i > 0 and w.box_psi[o, i] == w.box_psi[o, i - 1]:
                w.box_ahead_x[o, i] = w.box_ahead_x[o, i - 1]
                w.box_ahead_y[o, i] = w.box_ahead_y[o, i - 1]
            else:
                w.box_ahead_x[o, i] = math.cos(w.box_psi[o, i])
                w.box_ahead_y[o, i] = math.sin(w.box_psi[o, i])
            w.radius[o, i] = norm(w.half_length[o, i], w.half_width[o, i])
            sine = w.box_ahead_y[o, i] * w.tangent_x[i] - w.box_ahead_x[o, i] * w.tangent_y[i]
            max_sine = max(max_sine, abs(sine))
            if i > 0:
                step = norm(w.box_x[o, i] - w.box_x[o, i - 1], w.box_y[o, i] - w.box_y[o, i - 1])
                turn_x = w.box_ahead_x[o, i] - w.box_ahead_x[o, i - 1]
                turn = norm(turn_x, w.box_ahead_y[o, i] - w.box_ahead_y[o, i - 1])
                w.max_step[o] = max(w.max_step[o], step + turn * w.radius[o, i])
    return max_sine < ALIGNED


def measure_overlap(w: BandWork, o: Int, i: Int, aligned: Flag) -> None:
    """Compute how far an obstacle overlaps the ego along the route, and its lateral range there."""
    # Along the route the ego reaches from -reach to reach + lead. The range is that of the upper and lower
    # roof of the box over that stretch: a roof has its ridge at a corner and falls to both sides.
    reach = 0.5 * w.length
    lead = w.lead_distance[o]
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
    half_x = along * cosine + across * sine
    half_y = along * sine + across * cosine
    upper = half_y
    lower = half_y
    if not aligned:
        counter = turn_cos * turn_sin >= 0.0  # rotated counter-clockwise by less than a right angle
        ridge = along * cosine - across * sine if counter else across * sine - along * cosine
        along_edge = sine / max(cosine, ALIGNED)
        across_edge = cosine / max(sine, ALIGNED)
        rise = along_edge if counter else across_edge
        fall = across_edge if counter else along_edge
        before = -reach - x
        behind = reach + lead - x
        upper = half_y - max(ridge - behind, 0.0) * rise - max(before - ridge, 0.0) * fall
        lower = half_y - max(ridge + before, 0.0) * rise - max(-behind - ridge, 0.0) * fall
    w.overlap[o, i] = half_x + reach - max(-x, x - lead)
    w.passing_right[o, i] = y - max(lower, -half_y) - 0.5 * w.width
    w.passing_left[o, i] = y + max(upper, -half_y) + 0.5 * w.width


def set_passing(w: BandWork) -> None:
    """Compute the displacements at which the ego passes obstacles; infinite where one is not alongside."""
    # bounds at the nodes with an overlap alone would jump by a node when an end moves past one
    aligned = set_headings(w)
    slope = END_SLOPE * norm(w.route_x[1] - w.route_x[0], w.route_y[1] - w.route_y[0])
    for o in range(w.m):
        for i in range(w.n):
            measure_overlap(w, o, i, aligned)
        for i in range(w.n):
            overlap = w.overlap[o, i]
            if overlap >= 0.0:
                continue
            near = max(w.overlap[o, max(i - 1, 0)], w.overlap[o, min(i + 1, w.n - 1)])
            if near >= 0.0:
                relief = slope * (overlap / min(overlap - near, -MIN_DROP))
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
