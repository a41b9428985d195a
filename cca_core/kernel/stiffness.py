"""Stiffness of a band between pinned ends: internal forces, factors of its matrix, solutions."""

from cca_core.kernel.band_workspace import Equilibrium, Nodes
from cca_core.kernel.types import Flag, Int, Real


def set_stiffness(
    e: Equilibrium, rate: Real, bending: Real, tension: Real, contact: Real, of_curvature: Real
) -> None:
    """Take stiffnesses in units of the outermost coefficient, in which row sums keep their digits."""
    unit = rate
    if unit == 0.0:
        unit = bending if bending != 0.0 else tension
    if not unit > 0.0:  # the digits of all are lost
        unit = 1.0
    e.rate = rate / unit
    e.bending = bending / unit
    e.tension = tension / unit
    e.contact = contact / unit
    e.curvature_contact = of_curvature / unit


def row_diagonal(e: Equilibrium) -> Real:
    """Return the diagonal of the stiffness matrix without contacts."""
    return 20.0 * e.rate + 6.0 * e.bending + 2.0 * e.tension


def second_difference(u: Nodes, i: Int) -> Real:
    """Return the second difference of an inner node."""
    return u[i - 1] - 2.0 * u[i] + u[i + 1]


def apply_stiffness(e: Equilibrium, u: Nodes, to: Nodes) -> None:
    """Compute the internal forces at the nodes that are not pinned."""
    # differences of neighbors keep the digits that a sum with the stencil loses
    n = e.n
    bend = e.difference
    moment = e.moment
    bend[0] = 0.0
    bend[n - 1] = 0.0
    for i in range(1, n - 1):
        bend[i] = (u[i + 1] - u[i]) - (u[i] - u[i - 1])
    for i in range(1, n - 1):
        moment[i] = e.bending * bend[i] - e.rate * ((bend[i + 1] - bend[i]) - (bend[i] - bend[i - 1]))
    shear = e.tension * (u[2] - u[1]) - (moment[2] - moment[1])
    for i in range(2, n - 2):
        next_shear = e.tension * (u[i + 1] - u[i]) - (moment[i + 1] - moment[i])
        to[i] = shear - next_shear
        shear = next_shear


def factorize(e: Equilibrium) -> Flag:
    """Compute LDL' of the stiffness matrix with the active set held; return whether it is definite."""
    n = e.n
    l1 = e.factor_1
    l2 = e.factor_2
    l3 = e.factor_3
    inverse = e.inverse
    active = e.active
    sharp = e.sharp
    row_0 = row_diagonal(e)
    row_1 = -15.0 * e.rate - 4.0 * e.bending - e.tension
    row_2 = 6.0 * e.rate + e.bending
    row_3 = -e.rate
    contact = e.contact
    definite = True
    # of the last three rows; before the first one all are zero
    inverse_1 = 0.0
    inverse_2 = 0.0
    inverse_3 = 0.0
    l1_1 = 0.0
    l1_2 = 0.0
    l2_1 = 0.0
    for i in range(2, n - 2):
        d = row_0 if active[i] == 0 else row_0 + contact
        c1 = row_1
        c2 = row_2
        if e.bounded:
            before = e.curvature_contact if sharp[i - 1] != 0 else 0.0
            here = e.curvature_contact if sharp[i] != 0 else 0.0
            after = e.curvature_contact if sharp[i + 1] != 0 else 0.0
            d += 4.0 * here + before + after
            c1 -= 2.0 * (before + here)
            c2 += before
        l3_0 = row_3 * inverse_3
        d -= row_3 * l3_0
        c2 -= row_3 * l1_2
        c1 -= row_3 * l2_1
        l2_0 = c2 * inverse_2
        d -= c2 * l2_0
        c1 -= c2 * l1_1
        l1_0 = c1 * inverse_1
        d -= c1 * l1_0
        if not d > 0.0:
            definite = False
            d = 1.0
        l3[i] = l3_0
        l2[i] = l2_0
        l1[i] = l1_0
        inverse_3 = inverse_2
        inverse_2 = inverse_1
        inverse_1 = 1.0 / d
        inverse[i] = inverse_1
        l1_2 = l1_1
        l1_1 = l1_0
        l2_1 = l2_0
    # beyond the last free node they meet zeros, which must not be times what is left from before
    for i in range(n - 2, n):
        l2[i] = 0.0
        l3[i] = 0.0
    return definite


def substitute(e: Equilibrium, force: Nodes, to: Nodes) -> None:
    """Solve with the factors; the pinned ends of the result stay as they are, 0."""
    n = e.n
    l1 = e.factor_1
    l2 = e.factor_2
    l3 = e.factor_3
    inverse = e.inverse
    one = 0.0  # of the last rows; beyond the free nodes all are zero
    two = 0.0
    three = 0.0
    for i in range(2, n - 2):
        here = force[i] - l1[i] * one - l2[i] * two - l3[i] * three
        to[i] = here
        three = two
        two = one
        one = here
    one *= inverse[n - 3]
    two = 0.0
    three = 0.0
    to[n - 3] = one
    for i in range(n - 4, 1, -1):
        here = to[i] * inverse[i] - l1[i + 1] * one - l2[i + 2] * two - l3[i + 3] * three
        to[i] = here
        three = two
        two = one
        one = here
