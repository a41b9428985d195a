"""Equilibrium of a band against one-sided bounds, by a semi-smooth Newton iteration on the active set.

The energy is ``1/2 u K u`` and ``1/2 contact`` times the squared violations of the bounds: convex and
piecewise quadratic. A step that reproduces its active set is the minimum.
"""

from cca_core.kernel.band_workspace import Equilibrium, Nodes
from cca_core.kernel.stiffness import apply_stiffness, factorize, row_diagonal, second_difference, substitute
from cca_core.kernel.types import Flag, Int, Real

FULL_STEPS = 10  # the active set converges in 3 to 6
DAMPED_STEPS = 50
SECANTS = 12  # of a line search
FLAT_SLOPE = 1e-3  # of the slope at its start: an exact root is not needed
STIFF_ROW = 1e5  # stiffness of a row over that of a contact from which on digits are lost
CORRECTIONS = 3  # rounds of iterative refinement where digits are lost
MAX_CORRECTION = 1e-5  # the mean of the last one of a response to the start [m]
END_STEP = 0.05  # by which an end node is bounded less than its neighbor if the band does not touch it [m]


def side_of(value: Real, low: Real, high: Real) -> Int:
    """Return the bound that a value violates: -1 the lower one, 1 the upper one, 0 none."""
    if value < low:
        return -1
    if value > high:
        return 1
    return 0


def touches_end(before: Real, here: Real, after: Real) -> Flag:
    """Return whether the band touches a node of a bound: not an end that is bounded less than the next."""
    rises_on = after - here > END_STEP and before <= 0.0
    falls_off = here - before < -END_STEP and after <= 0.0
    return not (rises_on or falls_off)


def guess_active_set(e: Equilibrium) -> None:
    """Take the bounds that zero violates: a stiff band touches a straight one at its first and last node."""
    n = e.n
    active = e.active
    violation = e.step
    lower = e.lower
    upper = e.upper
    for i in range(2, n - 2):
        low = lower[i]
        high = upper[i]
        active[i] = side_of(0.0, low, high) if low > 0.0 or high < 0.0 else 0
        violation[i] = (0.0 if low < 0.0 else low) + (0.0 if high > 0.0 else high)
    if e.bounded:
        for i in range(1, n - 1):
            e.sharp[i] = side_of(0.0, e.lower_difference[i], e.upper_difference[i])
    if e.rate == 0.0 and e.bending == 0.0 and not e.bounded:  # a string touches all of a bound
        return
    for i in range(3, n - 3):
        if active[i] != 0:
            sign = -active[i] * 1.0
            if not touches_end(sign * violation[i - 1], sign * violation[i], sign * violation[i + 1]):
                active[i] = 0
    before = active[2]
    for i in range(3, n - 3):
        here = active[i]
        if here != 0 and before == here and active[i + 1] == here:
            active[i] = 0
        before = here


def update_active_set(e: Equilibrium, u: Nodes) -> Flag:
    """Take the bounds that a displacement violates; return whether they are those before."""
    same = True
    active = e.active
    lower = e.lower
    upper = e.upper
    for i in range(2, e.n - 2):
        now = 0
        if u[i] < lower[i]:
            now = -1
        elif u[i] > upper[i]:
            now = 1
        if now != active[i]:
            same = False
            active[i] = now
    if e.bounded:
        for i in range(1, e.n - 1):
            now = side_of(second_difference(u, i), e.lower_difference[i], e.upper_difference[i])
            if now != e.sharp[i]:
                same = False
            e.sharp[i] = now
    return same


def hold_active_set(e: Equilibrium) -> None:
    """Compute the forces of the bounds that are held."""
    n = e.n
    force = e.force
    for i in range(n):
        force[i] = 0.0
    for i in range(2, n - 2):
        if e.active[i] != 0:
            force[i] = e.contact * (e.lower[i] if e.active[i] < 0 else e.upper[i])
    if e.bounded:
        for i in range(1, n - 1):
            if e.sharp[i] != 0:
                bound = e.lower_difference[i] if e.sharp[i] < 0 else e.upper_difference[i]
                push = e.curvature_contact * bound
                force[i - 1] += push
                force[i] -= 2.0 * push
                force[i + 1] += push


def refine(e: Equilibrium) -> None:
    """Regain digits of a solution: solve for the forces that it leaves."""
    n = e.n
    rest = e.residual
    target = e.target
    step = e.step
    apply_stiffness(e, target, rest)
    for i in range(2, n - 2):
        held = e.contact * target[i] if e.active[i] != 0 else 0.0
        rest[i] = e.force[i] - held - rest[i]
    if e.bounded:
        for i in range(1, n - 1):
            if e.sharp[i] != 0:
                push = e.curvature_contact * second_difference(target, i)
                rest[i - 1] -= push
                rest[i] += 2.0 * push
                rest[i + 1] -= push
    substitute(e, rest, step)
    for i in range(2, n - 2):
        target[i] += step[i]


def solve_held(e: Equilibrium) -> Flag:
    """Solve to `target` with the active set held; return whether that is the active set there."""
    hold_active_set(e)
    e.solves += 1
    if not factorize(e):
        e.definite = False  # for want of digits
    substitute(e, e.force, e.target)
    if row_diagonal(e) > STIFF_ROW * e.contact:
        for _ in range(CORRECTIONS):
            refine(e)
    return update_active_set(e, e.target)


def slope_along(e: Equilibrium, fraction: Real, at_start: Real, change: Real) -> Real:
    """Return the slope of the energy along `step` from `u`; elastic forces change linearly."""
    u = e.u
    step = e.step
    slope = at_start + fraction * change
    for i in range(2, e.n - 2):
        moved = u[i] + fraction * step[i]
        if moved < e.lower[i]:
            slope -= e.contact * step[i] * (e.lower[i] - moved)
        elif moved > e.upper[i]:
            slope += e.contact * step[i] * (moved - e.upper[i])
    if e.bounded:
        for i in range(1, e.n - 1):
            bend = second_difference(step, i)
            bent = second_difference(u, i) + fraction * bend
            if bent < e.lower_difference[i]:
                slope -= e.curvature_contact * bend * (e.lower_difference[i] - bent)
            elif bent > e.upper_difference[i]:
                slope += e.curvature_contact * bend * (bent - e.upper_difference[i])
    return slope


def line_search(e: Equilibrium) -> Real:
    """Return the fraction of `step` with the least energy: the root of its slope, by the Illinois method."""
    step = e.step
    at_start = 0.0
    change = 0.0
    apply_stiffness(e, e.u, e.residual)
    for i in range(2, e.n - 2):
        at_start += step[i] * e.residual[i]
    apply_stiffness(e, step, e.residual)
    for i in range(2, e.n - 2):
        change += step[i] * e.residual[i]
    a = 0.0
    b = 1.0
    at_a = slope_along(e, a, at_start, change)
    at_b = slope_along(e, b, at_start, change)
    if at_b <= 0.0 or at_a >= 0.0:
        return 1.0
    flat = -FLAT_SLOPE * at_a
    for _ in range(SECANTS):
        fraction = (a * at_b - b * at_a) / (at_b - at_a)
        value = slope_along(e, fraction, at_start, change)
        if abs(value) < flat or b - a < 1e-6:
            return fraction
        if value < 0.0:
            a = fraction
            at_a = value
            at_b = 0.5 * at_b
        else:
            b = fraction
            at_b = value
            at_a = 0.5 * at_a
    return a


def clear_ends(e: Equilibrium) -> None:
    """Set what is solved for to zero at the pinned nodes."""
    for k in range(4):
        i = k if k < 2 else e.n - k + 1
        e.u[i] = 0.0
        e.target[i] = 0.0
        e.step[i] = 0.0
        e.residual[i] = 0.0
        e.active[i] = 0
    e.sharp[0] = 0
    e.sharp[e.n - 1] = 0


def find_equilibrium(e: Equilibrium, warm: Flag) -> Flag:
    """Find the displacement `u` of least energy; return whether the active set has converged.

    With `warm`, `u` and its active set are the initial guess. It takes at most 60 solves. If full steps do
    not converge, a line search damps the next ones: the energy falls with every step.
    """
    n = e.n
    u = e.u
    e.definite = True
    clear_ends(e)
    if warm:
        update_active_set(e, u)
    else:
        guess_active_set(e)
        for i in range(n):
            u[i] = 0.0
    for _ in range(FULL_STEPS):
        if solve_held(e):
            for i in range(2, n - 2):
                u[i] = e.target[i]
            return e.definite
    for _ in range(DAMPED_STEPS):
        update_active_set(e, u)
        converged = solve_held(e)
        for i in range(2, n - 2):
            e.step[i] = e.target[i] - u[i]
        fraction = 1.0 if converged else line_search(e)
        for i in range(2, n - 2):
            u[i] = e.target[i] if converged else u[i] + fraction * e.step[i]
        if converged:
            return e.definite
    return False


def respond_to_start(e: Equilibrium, before: Real, start_0: Real, start_1: Real, to: Nodes) -> Flag:
    """Compute the displacement without contacts from its first three nodes; return whether digits suffice."""
    n = e.n
    force = e.force
    row_1 = -15.0 * e.rate - 4.0 * e.bending - e.tension
    row_2 = 6.0 * e.rate + e.bending
    row_3 = -e.rate
    clear_ends(e)
    e.bounded = False
    for i in range(n):
        force[i] = 0.0
        to[i] = 0.0
        e.active[i] = 0
    force[2] = -(row_1 * start_1 + row_2 * start_0 + row_3 * before)
    if n > 5:
        force[3] = -(row_2 * start_1 + row_3 * start_0)
    if n > 6:
        force[4] = -(row_3 * start_1)
    if not factorize(e):
        return False
    substitute(e, force, to)
    change = 0.0
    for _ in range(CORRECTIONS):
        apply_stiffness(e, to, e.residual)
        for i in range(2, n - 2):
            e.residual[i] = force[i] - e.residual[i]
        substitute(e, e.residual, e.target)
        change = 0.0
        for i in range(2, n - 2):
            to[i] += e.target[i]
            change += abs(e.target[i])  # a sum, as it keeps what is no number
    to[0] = start_0
    to[1] = start_1
    return change <= MAX_CORRECTION * n
