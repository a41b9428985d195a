"""Certificate of a band: gaps of the ego's swept box to obstacles and edges, and curvature."""

import math

from cca_core.kernel.band_gaps import measure_gaps
from cca_core.kernel.band_spline import displace_nodes, fit_spline
from cca_core.kernel.band_workspace import BandWork
from cca_core.kernel.types import Flag, Int, Real


def measure_edges_at(w: BandWork, x: Real, ahead: Int) -> None:
    """Lower the margins to the distance of one cross section of the body from the edges there."""
    half = 0.5 * w.width
    ahead_x = w.ahead_x
    ahead_y = w.ahead_y
    tangent_x = w.tangent_x
    tangent_y = w.tangent_y
    right_margin = w.right_margin
    left_margin = w.left_margin
    bulge = 0.125 * (w.spacing * w.spacing)
    bent = 0.5 * (x * x)
    last = w.n - 1
    for i in range(w.n):
        turn_cos = ahead_x[i] * tangent_x[i] + ahead_y[i] * tangent_y[i]
        turn_sin = ahead_y[i] * tangent_x[i] - ahead_x[i] * tangent_y[i]
        reach = half * turn_cos + bulge * abs(w.curvature[i])
        middle = w.u[i] + x * turn_sin - bent * w.route_curvature[i]
        at = min(max(i + ahead, 0), last)  # edges continue beyond the ends
        right_margin[i] = min(right_margin[i], middle - reach - w.right_edge[at])
        left_margin[i] = min(left_margin[i], w.left_edge[at] - middle - reach)


def has_straight_edges(w: BandWork) -> Flag:
    """Return whether both edges keep their lateral offset."""
    for i in range(1, w.n):
        if w.right_edge[i] != w.right_edge[0] or w.left_edge[i] != w.left_edge[0]:
            return False
    return True


def measure_edges(w: BandWork) -> None:
    """Compute the distance of the body from both edges, over its length."""
    right_margin = w.right_margin
    left_margin = w.left_margin
    w.min_edge_clearance = math.inf
    for i in range(w.n):
        right_margin[i] = math.inf
        left_margin[i] = math.inf
    if not w.has_edges:
        return
    front = w.box_offset + 0.5 * w.length
    rear = w.box_offset - 0.5 * w.length
    h = w.spacing
    if has_straight_edges(w):
        measure_edges_at(w, front, 0)
        measure_edges_at(w, w.box_offset, 0)
        measure_edges_at(w, rear, 0)
    else:  # the edge at each node that the body reaches counts
        for k in range(-w.n, w.n + 1):
            if rear - h < k * h < front + h:
                measure_edges_at(w, min(max(k * h, rear), front), k)
    for i in range(w.n):
        margin = min(right_margin[i], left_margin[i])
        w.min_edge_clearance = min(w.min_edge_clearance, margin)
        if not margin > -math.inf:
            w.finite = False


def certify(w: BandWork) -> None:
    """Sweep the ego's box along the displaced band."""
    w.finite = True
    displace_nodes(w)
    fit_spline(w)
    u = w.u
    moment_x = w.moment_x
    moment_y = w.moment_y
    curvatures = w.curvature
    limits = w.curvature_limit
    sharpest = 0.0
    ratio = 0.0
    size = 0.0  # of all, as a sum keeps what is no number
    for i in range(w.n):
        curvature = abs(curvatures[i])
        if curvature > sharpest:
            sharpest = curvature
        here = curvature / limits[i]
        if here > ratio:
            ratio = here
        size += abs(u[i]) + abs(moment_x[i]) + abs(moment_y[i]) + curvature
    w.max_curvature = sharpest
    w.curvature_ratio = ratio
    if not size < math.inf:
        w.finite = False
    measure_gaps(w)
    measure_edges(w)


def shortfall_of(w: BandWork) -> Real:
    """Return the shortfall [m] of clearance or at an edge, negative if there is none."""
    return max(w.clearance - w.min_gap, -w.min_edge_clearance)


def is_satisfied(w: BandWork) -> Flag:
    """Return whether clearance, edges and curvature limit are kept."""
    return w.finite and shortfall_of(w) <= 0.0 and w.curvature_ratio <= 1.0


def violation_of(w: BandWork) -> Real:
    """Return the violation [-] of clearance and limits; a meter counts as 5."""
    if not w.finite:
        return math.inf
    return 5.0 * max(shortfall_of(w), 0.0) + max(w.curvature_ratio - 1.0, 0.0)
