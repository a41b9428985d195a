"""Result of a band: its status, the reason and the active constraint, from its certificate."""

import math

from cca_core.kernel.band_gaps import end_gap, gap_to
from cca_core.kernel.band_workspace import (
    ACTIVE_SET,
    BLOCKED_END,
    CLEARANCE,
    CURVATURE,
    CURVATURE_LIMIT,
    DISPLACEMENT,
    EDGE,
    EMPTY_INTERVAL,
    INFEASIBLE,
    LEFT_EDGE,
    NO_CONSTRAINT,
    NOT_CONVERGED,
    OK,
    RIGHT_EDGE,
    SATISFIED,
    BandWork,
)
from cca_core.kernel.types import Int, Real

ROUNDING = 1e-9  # violations up to here are rounding errors [m]


def nearest_obstacle(w: BandWork) -> Int:
    """Return the obstacle with the least gap, the first of equals."""
    gap = math.inf
    nearest = NO_CONSTRAINT
    for k in range(w.n_pairs):
        if w.bound[k] < gap:
            gap = w.bound[k]
            nearest = w.pair_obstacle[k]
    return nearest


def closest_edge(w: BandWork) -> Int:
    """Return the edge with the least margin, the right one of equals."""
    for i in range(w.n):
        if w.right_margin[i] == w.min_edge_clearance:
            return RIGHT_EDGE
    return LEFT_EDGE


def largest_displacement(w: BandWork) -> Real:
    """Return the largest displacement [m], without sign."""
    u = w.u
    largest = 0.0
    for i in range(w.n):
        if abs(u[i]) > largest:
            largest = abs(u[i])
    return largest


def report_curvature(w: BandWork) -> None:
    """Report the curvature that exceeds its limit by the largest factor."""
    ratio = -1.0
    for i in range(w.n):
        here = abs(w.curvature[i]) / w.curvature_limit[i]
        if here > ratio:
            ratio = here
            w.value = abs(w.curvature[i])
            w.limit = w.curvature_limit[i]


def fail(w: BandWork, reason: Int, active: Int) -> None:
    """Report that a band is infeasible."""
    w.status = INFEASIBLE
    w.reason = reason
    w.active = active


def report_stall(w: BandWork) -> None:
    """Report that the active set has not converged."""
    w.status = NOT_CONVERGED
    w.reason = ACTIVE_SET
    w.active = NO_CONSTRAINT


def compare(w: BandWork) -> None:
    """Compare the certificate with the limits; what is not a number satisfies none."""
    excess = w.min_gap - w.clearance
    nearest = nearest_obstacle(w)
    closest = closest_edge(w) if w.min_edge_clearance < excess else nearest
    displacement = largest_displacement(w)
    w.status = OK
    w.reason = SATISFIED
    w.active = closest
    w.other = NO_CONSTRAINT
    w.node = -1
    w.value = 0.0
    w.limit = 0.0
    if not excess >= -ROUNDING:
        fail(w, CLEARANCE, nearest)
    elif not w.min_edge_clearance >= -ROUNDING:
        fail(w, EDGE, closest)
    elif not displacement <= w.max_displacement:
        fail(w, DISPLACEMENT, nearest)
        w.value = displacement
    elif not w.curvature_ratio <= 1.0 + ROUNDING:
        fail(w, CURVATURE, CURVATURE_LIMIT)
        report_curvature(w)


def report_empty_interval(w: BandWork, node: Int) -> None:
    """Report the two constraints that leave no displacement at a node; of equals the last obstacle."""
    fail(w, EMPTY_INTERVAL, RIGHT_EDGE)
    w.node = node
    w.other = LEFT_EDGE
    low = w.right_edge[node] + 0.5 * w.width
    high = w.left_edge[node] - 0.5 * w.width
    for o in range(w.m):
        if w.passes_left[o] != 0 and w.passing_left[o, node] >= low:
            low = w.passing_left[o, node]
            w.active = o
        if w.passes_left[o] == 0 and w.passing_right[o, node] <= high:
            high = w.passing_right[o, node]
            w.other = o


def find_blocked_end(w: BandWork) -> Int:
    """Return the nearest obstacle that is too close to a pinned end, if a bound is violated there."""
    e = w.n - 1
    if w.lower[0] <= w.free[0] <= w.upper[0] and w.lower[e] <= w.free[e] <= w.upper[e]:
        return NO_CONSTRAINT
    gap = w.clearance - w.max_end_shortfall
    nearest = NO_CONSTRAINT
    for o in range(w.m):
        here = end_gap(w, o)
        if here < gap:
            gap = here
            nearest = o
    return nearest


def report_blocked_end(w: BandWork, o: Int) -> None:
    """Report the obstacle that is too close to a pinned end, with its gap."""
    fail(w, BLOCKED_END, o)
    w.value = gap_to(w, o)
