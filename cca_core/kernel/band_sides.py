"""Side assignment: by a rule, or the sides whose band has the least energy."""

import math

from cca_core.kernel.band_certificate import shortfall_of
from cca_core.kernel.band_corridor import set_bounds
from cca_core.kernel.band_relaxation import relax_with_sides
from cca_core.kernel.band_tightening import set_relative_bounds
from cca_core.kernel.band_workspace import (
    BLOCKING_LEFT,
    CHEAPEST_SIDES,
    GIVEN_SIDES,
    OK,
    BandWork,
    Equilibrium,
)
from cca_core.kernel.equilibrium import find_equilibrium
from cca_core.kernel.stiffness import apply_stiffness
from cca_core.kernel.types import Flag, Int, Real

RIGHT_COST = 1e-6  # by which each obstacle passed on the right raises the cost: of two equals, left


def set_default_sides(w: BandWork) -> Flag:
    """Find the obstacles that block the route, and the side of the others; return whether any blocks."""
    any_blocks = False
    for o in range(w.m):
        on_right = False
        on_left = False
        offset = 0.0  # of the obstacle where it is alongside, up to a factor
        for i in range(w.n):
            if w.passing_right[o, i] < math.inf:
                offset += w.passing_left[o, i] + w.passing_right[o, i]
                on_right = on_right or w.passing_left[o, i] > 0.0
                on_left = on_left or w.passing_right[o, i] < 0.0
        blocks = on_right and on_left
        any_blocks = any_blocks or blocks
        w.blocking[o] = 1 if blocks else 0
        w.passes_left[o] = 1 if blocks or offset < 0.0 else 0
    return any_blocks


def set_blocking_sides(w: BandWork, left: Flag) -> None:
    """Pass the blocking obstacles on one side."""
    set_default_sides(w)
    for o in range(w.m):
        if w.blocking[o] != 0:
            w.passes_left[o] = 1 if left else 0


def measure_freedom(w: BandWork, o: Int) -> None:
    """Find the sides that the edges leave at an obstacle, and its distance from the route."""
    half = 0.5 * w.width
    no_left = False
    no_right = False
    distance = math.inf
    for i in range(w.n):
        if w.passing_right[o, i] < math.inf:
            no_left = no_left or w.passing_left[o, i] > w.left_edge[i] - half
            no_right = no_right or w.passing_right[o, i] < w.right_edge[i] + half
            distance = min(distance, max(w.passing_right[o, i], -w.passing_left[o, i]))
    w.distance[o] = distance
    w.is_free[o] = 0 if no_left or no_right else 1
    if no_left and not no_right:
        w.passes_left[o] = 0
    elif no_right and not no_left:
        w.passes_left[o] = 1


def count_assignments(w: BandWork) -> Int:
    """Choose the nearest obstacles whose sides are tried; return the number of assignments.

    The sides of the others are in `default_side`.
    """
    for o in range(w.m):
        measure_freedom(w, o)
        w.default_side[o] = w.passes_left[o]
    count = 1
    for o in range(w.m):
        w.rank[o] = 0
        for other in range(w.m):
            nearer = w.distance[other] < w.distance[o]
            if w.distance[other] == w.distance[o]:
                nearer = other < o
            if w.is_free[other] != 0 and nearer:
                w.rank[o] += 1
    for o in range(w.m):
        if w.is_free[o] != 0 and w.rank[o] >= w.max_free_sides:
            w.is_free[o] = 0
        if w.is_free[o] != 0:
            count += count
    return count


def assign_sides(w: BandWork, code: Int) -> Int:
    """Take the sides of an assignment, 0 for all on the left; return how many are passed on the right."""
    rest = code
    right = 0
    for o in range(w.m - 1, -1, -1):
        w.passes_left[o] = w.default_side[o]
        if w.is_free[o] != 0:
            half = rest // 2
            w.passes_left[o] = 1 - (rest - 2 * half)
            rest = half
        right += 1 - w.passes_left[o]
    return right


def is_former(w: BandWork) -> Flag:
    """Return whether the sides are those of the previous band."""
    if not w.has_former:
        return False
    for o in range(w.m):
        if w.passes_left[o] != w.former[o]:
            return False
    return True


def energy_of(e: Equilibrium) -> Real:
    """Return the energy of the equilibrium, in its units."""
    energy = 0.0
    apply_stiffness(e, e.u, e.residual)
    for i in range(2, e.n - 2):
        violation = max(e.u[i] - e.upper[i], 0.0) - max(e.lower[i] - e.u[i], 0.0)
        energy += e.u[i] * e.residual[i] + e.contact * (violation * violation)
    return 0.5 * energy


def cost_of(w: BandWork, e: Equilibrium, right: Int) -> Real:
    """Return the cost of the sides between their bounds."""
    set_relative_bounds(w, e)
    e.bounded = False
    find_equilibrium(e, False)
    energy = energy_of(e)
    cost = energy * (1.0 + RIGHT_COST * right)
    return cost * w.side_change_fraction if is_former(w) else cost


def rank_assignments(w: BandWork, e: Equilibrium, count: Int) -> Int:
    """Find the cheapest assignments whose bounds leave a displacement; return how many are kept."""
    kept = 0
    for code in range(count):
        right = assign_sides(w, code)
        empty = set_bounds(w)
        if empty >= 0:
            continue
        cost = cost_of(w, e, right)
        at = kept
        for k in range(kept - 1, -1, -1):
            if not cost < w.costs[k]:
                break
            at = k
        if at >= w.n_certified:
            continue
        kept = min(kept + 1, w.n_certified)
        for k in range(kept - 1, at, -1):
            w.codes[k] = w.codes[k - 1]
            w.costs[k] = w.costs[k - 1]
        w.codes[at] = code
        w.costs[at] = cost
    return kept


def violation_of_limits(w: BandWork) -> Real:
    """Return the violation [-] of clearance and of the least curvature limit; a meter counts as 5."""
    limit = math.inf
    for i in range(w.n):
        limit = min(limit, w.curvature_limit[i])
    excess = max(w.max_curvature / limit - 1.0, 0.0)
    return 5.0 * max(shortfall_of(w), 0.0) + excess if w.finite else math.inf


def relax_cheapest(w: BandWork, e: Equilibrium, kept: Int) -> None:
    """Relax the cheapest assignments until one is feasible; otherwise the one of least violation."""
    best = 0
    violation = math.inf
    for k in range(kept):
        assign_sides(w, w.codes[k])
        relax_with_sides(w, e)
        if w.status == OK:
            return
        here = violation_of_limits(w)
        if here < violation:
            violation = here
            best = k
    if best < kept - 1:
        assign_sides(w, w.codes[best])
        relax_with_sides(w, e)


def relax_with_rule(w: BandWork, e: Equilibrium, rule: Int) -> None:
    """Relax a prepared band with the sides of a rule."""
    if rule == CHEAPEST_SIDES and set_default_sides(w):
        count = count_assignments(w)
        kept = rank_assignments(w, e, count) if count > 1 else 0
        if kept > 0:
            relax_cheapest(w, e, kept)
            return
        for o in range(w.m):
            w.passes_left[o] = w.default_side[o]
        if count > 1:
            set_default_sides(w)
    elif rule != GIVEN_SIDES and rule != CHEAPEST_SIDES:
        set_blocking_sides(w, rule == BLOCKING_LEFT)
    relax_with_sides(w, e)
