"""Bands of a batch one after the other: from the caller's arrays into the workspace, and back."""

import math
from typing import Annotated

from cca_core.kernel.band_boxes import load_boxes
from cca_core.kernel.band_certificate import certify
from cca_core.kernel.band_corridor import set_bounds
from cca_core.kernel.band_relaxation import prepare_band
from cca_core.kernel.band_result import compare, report_stall
from cca_core.kernel.band_sides import relax_with_rule
from cca_core.kernel.band_workspace import CODES, OK, REALS, BandBatch, BandWork, Equilibrium
from cca_core.kernel.types import Int, Ints, Reals

__all__ = ["measure_band", "relax_bands"]

Found = Annotated[Reals, "bands * columns"]
Codes = Annotated[Ints, "6 * bands"]


def load_band(q: BandBatch, b: Int, w: BandWork) -> None:
    """Copy the problem of a band into the workspace."""
    w.n = q.n
    w.m = q.m
    w.has_edges = q.has_edges
    w.has_former = q.has_former
    w.start_before = q.start[b, 0]
    w.start_0 = q.start[b, 1]
    w.start_1 = q.start[b, 2]
    right_edge = w.right_edge
    left_edge = w.left_edge
    route_x = w.route_x
    route_y = w.route_y
    limit = w.curvature_limit
    for i in range(w.n):
        route_x[i] = q.nodes[b, 2 * i]
        route_y[i] = q.nodes[b, 2 * i + 1]
        right_edge[i] = -math.inf
        left_edge[i] = math.inf
        limit[i] = q.curvature_limit[b, i]
    if q.has_edges:
        for i in range(w.n):
            right_edge[i] = q.right_edge[b, i]
            left_edge[i] = q.left_edge[b, i]
    w.has_valid_boxes = True
    for o in range(w.m):
        w.lead_distance[o] = q.lead_distance[o]
        w.passes_left[o] = q.passes_left[o * q.bands + b]
        w.former[o] = q.former[o * q.bands + b] if q.has_former else 0
        load_boxes(q, b, w, o)


def store_band(q: BandBatch, b: Int, w: BandWork, columns: Int, found: Found, codes: Codes) -> None:
    """Copy what is found for a band into its rows of the result."""
    n = w.n
    row = b * columns
    found[row] = w.min_gap
    found[row + 1] = w.min_edge_clearance
    found[row + 2] = w.max_curvature
    found[row + 3] = w.spacing
    found[row + 4] = w.value
    found[row + 5] = w.limit
    points = row + REALS
    moments = points + 2 * n
    displacement = moments + 2 * n
    lower = displacement + n
    upper = lower + n
    x = w.x
    y = w.y
    moment_x = w.moment_x
    moment_y = w.moment_y
    u = w.u
    low = w.lower
    high = w.upper
    for i in range(n):
        found[points + 2 * i] = x[i]
        found[points + 2 * i + 1] = y[i]
        found[moments + 2 * i] = moment_x[i]
        found[moments + 2 * i + 1] = moment_y[i]
        found[displacement + i] = u[i]
        found[lower + i] = low[i]
        found[upper + i] = high[i]
    for o in range(w.m):
        q.passes_left[o * q.bands + b] = w.passes_left[o]
    codes[CODES * b + 1] = w.reason
    codes[CODES * b + 2] = w.active
    codes[CODES * b + 3] = w.other
    codes[CODES * b + 4] = w.node
    codes[CODES * b + 5] = w.solves


def relax_bands(
    q: BandBatch, w: BandWork, e: Equilibrium, bands: Int, columns: Int, found: Found, codes: Codes
) -> None:
    """Relax the bands of a batch; their status is in the first column of `codes`."""
    for b in range(bands):
        load_band(q, b, w)
        status = prepare_band(w, e)
        if status == OK:
            relax_with_rule(w, e, q.side_rule)
            store_band(q, b, w, columns, found, codes)
        codes[CODES * b] = w.status


def measure_band(
    q: BandBatch, w: BandWork, e: Equilibrium, n: Int, u: Annotated[Reals, "n"], columns: Int,
    found: Annotated[Reals, "columns"], codes: Annotated[Ints, 6],
) -> Int:  # fmt: skip
    """Certify a displacement of the first band of a batch; return a status.

    Its frame, its bounds for the given sides, and its certificate are left in the workspace.
    """
    load_band(q, 0, w)
    status = prepare_band(w, e)
    w.solves = 0
    if status == OK:
        set_bounds(w)
        for i in range(n):
            w.u[i] = u[i]
        certify(w)
        compare(w)
        if not w.finite:
            report_stall(w)
        store_band(q, 0, w, columns, found, codes)
    codes[0] = w.status
    return status
