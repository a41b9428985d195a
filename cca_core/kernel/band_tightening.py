"""Constraint tightening: solve, certify, move the bounds by the shortfall, solve again."""

import math

from cca_core.kernel.band_certificate import certify, is_satisfied, shortfall_of, violation_of
from cca_core.kernel.band_workspace import BandWork, Equilibrium, Nodes
from cca_core.kernel.equilibrium import find_equilibrium
from cca_core.kernel.stiffness import second_difference
from cca_core.kernel.types import Flag, Int, Real

MAX_FRACTION = 0.8  # of a shortfall that the last move left, for which the next one makes up


def measure_shortfalls(w: BandWork) -> None:
    """Compute the shortfall of clearance and at the edges on both sides of each node, to `low` and `high`."""
    for i in range(w.n):
        w.low[i] = -w.right_margin[i]
        w.high[i] = -w.left_margin[i]
    for k in range(w.n_pairs):
        i = w.pair_node[k]
        shortfall = w.clearance - w.bound[k]
        if w.passes_left[w.pair_obstacle[k]] != 0:
            w.low[i] = max(w.low[i], shortfall)
        else:
            w.high[i] = max(w.high[i], shortfall)


def tighten_positions(w: BandWork, gain: Real) -> Flag:
    """Move the bounds by the shortfalls, to `low` and `high`; return whether they leave a displacement."""
    measure_shortfalls(w)
    fits = True
    for i in range(w.n):
        short_low = w.low[i]
        short_up = w.high[i]
        w.low[i] = w.lower[i]
        w.high[i] = w.upper[i]
        if short_low > 0.0:
            w.low[i] = max(w.lower[i], w.u[i]) + (gain * short_low + w.clearance_margin)
        if short_up > 0.0:
            w.high[i] = min(w.upper[i], w.u[i]) - (gain * short_up + w.clearance_margin)
        if not w.low[i] <= w.high[i]:
            fits = False
    return fits


def bend_at(w: BandWork, u: Nodes, i: Int) -> Real:
    """Return the second difference of a displacement at any node; the band continues beyond its ends."""
    if i == 0:
        return w.start_before - 2.0 * u[0] + u[1]
    if i == w.n - 1:
        return u[i - 1] - 2.0 * u[i]
    return second_difference(u, i)


def release_curvature(w: BandWork, e: Equilibrium) -> None:
    """Begin without bounds of the second difference."""
    for i in range(w.n):
        w.lower_difference[i] = -math.inf
        w.upper_difference[i] = math.inf
        e.lower_difference[i] = -math.inf
        e.upper_difference[i] = math.inf
        e.sharp[i] = 0


def tighten_curvature(w: BandWork, e: Equilibrium) -> None:
    """Move the bounds of the second difference by the excess curvature."""
    squared = w.spacing * w.spacing
    for i in range(w.n):
        if w.curvature_limit[i] == math.inf:
            continue
        curvature = w.curvature[i] * squared
        aim = (1.0 - w.curvature_margin) * (w.curvature_limit[i] * squared)
        bend = bend_at(w, w.u, i)
        of_route = curvature - bend
        excess = max(abs(curvature) - aim, 0.0)
        low = max(w.lower_difference[i], -aim - of_route)
        high = min(w.upper_difference[i], aim - of_route)
        if excess > 0.0 and curvature < 0.0:
            low = max(low, bend) + excess
        if excess > 0.0 and curvature > 0.0:
            high = min(high, bend) - excess
        middle = 0.5 * (low + high)
        w.lower_difference[i] = min(low, middle)
        w.upper_difference[i] = max(high, middle)
        free = bend_at(w, w.free, i)
        e.lower_difference[i] = w.lower_difference[i] - free
        e.upper_difference[i] = w.upper_difference[i] - free


def set_relative_bounds(w: BandWork, e: Equilibrium) -> None:
    """Take the bounds relative to the response to the start, from which the equilibrium counts."""
    lower = w.lower
    upper = w.upper
    relative_lower = e.lower
    relative_upper = e.upper
    free = w.free
    for i in range(w.n):
        relative_lower[i] = lower[i] - free[i]
        relative_upper[i] = upper[i] - free[i]


def solve_and_certify(w: BandWork, e: Equilibrium, warm: Flag) -> Flag:
    """Solve between the bounds and certify; with `warm`, begin at the displacement so far."""
    set_relative_bounds(w, e)
    u = w.u
    free = w.free
    relative = e.u
    for i in range(w.n):
        relative[i] = u[i] - free[i] if warm else 0.0
    converged = find_equilibrium(e, warm)
    for i in range(w.n):
        u[i] = free[i] + relative[i]
    certify(w)
    return converged


def solve_tighter(w: BandWork, e: Equilibrium) -> Flag:
    """Take the bounds of the next round and solve, from where the last one ended."""
    for i in range(w.n):
        w.lower[i] = w.low[i]
        w.upper[i] = w.high[i]
    if w.curvature_ratio > 1.0 and not e.bounded:
        e.bounded = True
        release_curvature(w, e)
    if e.bounded:
        tighten_curvature(w, e)
    return solve_and_certify(w, e, True)


def gain_of(shortfall: Real, last_shortfall: Real) -> Real:
    """Return the factor of a move; contact yields by a fraction of it, which is extrapolated to zero."""
    if shortfall <= 0.0:
        return 1.0
    if not shortfall < MAX_FRACTION * last_shortfall:
        return 1.0 / (1.0 - MAX_FRACTION)
    return 1.0 / (1.0 - shortfall / last_shortfall)


def keep_displacement(w: BandWork) -> None:
    """Keep the displacement as the best so far."""
    for i in range(w.n):
        w.best_u[i] = w.u[i]


def tighten(w: BandWork, e: Equilibrium, first: Flag) -> Flag:
    """Move bounds until the certificate holds or there is no progress; keep the best.

    Return whether the active set of the last round has converged; `first` is that of the first one.
    """
    best = math.inf
    last_shortfall = math.inf
    stalls = 0
    converged = first
    keep_displacement(w)
    for _ in range(w.max_tightenings):
        if is_satisfied(w):
            break
        violation = violation_of(w)
        stalls = 0 if violation < w.min_progress * best else stalls + 1
        if violation < best:
            best = violation
            keep_displacement(w)
        if stalls >= w.max_stalls or e.solves >= w.max_solves:
            break
        shortfall = shortfall_of(w)
        gain = gain_of(shortfall, last_shortfall)
        last_shortfall = max(shortfall, w.clearance_margin)
        if not tighten_positions(w, gain):
            break
        converged = solve_tighter(w, e)
        if not converged:
            break
    if not violation_of(w) <= best:  # the last rounds were worse
        for i in range(w.n):
            w.u[i] = w.best_u[i]
        certify(w)
    return converged
