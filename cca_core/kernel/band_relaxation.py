"""Relaxation of a band with given sides, and of a band whose sides follow a rule."""

import math

from cca_core.kernel.band_certificate import certify
from cca_core.kernel.band_corridor import set_bounds, set_passing
from cca_core.kernel.band_frame import measure_route, set_elasticity, set_ends
from cca_core.kernel.band_result import (
    compare,
    find_blocked_end,
    report_blocked_end,
    report_empty_interval,
    report_stall,
)
from cca_core.kernel.band_tightening import solve_and_certify, tighten
from cca_core.kernel.band_workspace import INVALID_BOXES, NO_CONSTRAINT, OK, BandWork, Equilibrium
from cca_core.kernel.types import Int


def prepare_band(w: BandWork, e: Equilibrium) -> Int:
    """Put a band problem into the frame of each node; return a status."""
    e.n = w.n
    e.solves = 0
    w.status = measure_route(w) if w.has_valid_boxes else INVALID_BOXES
    if w.status != OK:
        return w.status
    set_elasticity(w, e)
    w.status = set_ends(w, e)
    if w.status == OK:
        set_passing(w)
    return w.status


def relax_with_sides(w: BandWork, e: Equilibrium) -> None:
    """Relax a prepared band with given sides."""
    e.solves = 0
    e.bounded = False
    empty = set_bounds(w)
    blocked = find_blocked_end(w)
    solvable = empty < 0 and blocked == NO_CONSTRAINT
    if not solvable:
        for i in range(w.n):
            w.lower[i] = -math.inf
            w.upper[i] = math.inf
    converged = solve_and_certify(w, e, False)
    if solvable:
        converged = tighten(w, e, converged)
    finite = w.finite
    if not finite:  # no result holds what is no number
        for i in range(w.n):
            w.u[i] = w.free[i]
        certify(w)
    compare(w)
    if empty >= 0:
        report_empty_interval(w, empty)
    if blocked != NO_CONSTRAINT:
        report_blocked_end(w, blocked)
    if not (converged and finite):
        report_stall(w)
    w.solves = e.solves
