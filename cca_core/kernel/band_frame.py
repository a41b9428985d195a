"""The route in the frame of each node: spacing, tangents, curvature, and how the band begins and ends."""

import math

from cca_core.kernel.band_workspace import OK, TOO_LONG, UNEVEN_SPACING, BandWork, Equilibrium
from cca_core.kernel.box_gaps import norm
from cca_core.kernel.constants import TINY
from cca_core.kernel.equilibrium import respond_to_start
from cca_core.kernel.stiffness import set_stiffness
from cca_core.kernel.types import Int, Real

MIN_EVENNESS = 0.8  # shortest step over the mean one, and mean over longest [-]
MIN_SPACING = 1e-6  # [m]
MAX_SPACING = 1e6  # [m]


def measure_route(w: BandWork) -> Int:
    """Compute spacing, tangents and curvature of the route."""
    n = w.n
    x = w.route_x
    y = w.route_y
    total = 0.0
    shortest = math.inf
    longest = 0.0
    chord = w.chord
    here_x = x[0]
    here_y = y[0]
    for i in range(n - 1):
        next_x = x[i + 1]
        next_y = y[i + 1]
        step = norm(next_x - here_x, next_y - here_y)
        here_x = next_x
        here_y = next_y
        chord[i] = step
        total += step
        if step < shortest:
            shortest = step
        if step > longest:
            longest = step
    w.spacing = total / (n - 1)
    if not (shortest > MIN_EVENNESS * w.spacing and w.spacing > MIN_EVENNESS * longest):
        return UNEVEN_SPACING
    if not MIN_SPACING <= w.spacing <= MAX_SPACING:
        return UNEVEN_SPACING
    tangent_x = w.tangent_x
    tangent_y = w.tangent_y
    curvature = w.route_curvature
    here_x = x[0]
    here_y = y[0]
    last_x = here_x
    last_y = here_y
    last_chord = 0.0
    for i in range(n):
        next_x = x[i + 1] if i < n - 1 else here_x
        next_y = y[i + 1] if i < n - 1 else here_y
        dx = next_x - last_x
        dy = next_y - last_y
        length = norm(dx, dy)
        if not length > 0.0:  # turns back on the spot
            return UNEVEN_SPACING
        tangent_x[i] = dx / length
        tangent_y[i] = dy / length
        if i < n - 1:
            here_chord = chord[i]
            if i > 0:  # of the circle through three nodes
                cross = (here_x - last_x) * (next_y - here_y) - (here_y - last_y) * (next_x - here_x)
                curvature[i] = 2.0 * cross / (last_chord * here_chord * length)
            last_chord = here_chord
        last_x = here_x
        last_y = here_y
        here_x = next_x
        here_y = next_y
    curvature[0] = curvature[1]
    curvature[n - 1] = curvature[n - 2]
    return OK


def set_elasticity(w: BandWork, e: Equilibrium) -> None:
    """Compute the stiffness of the band for its spacing."""
    h = w.spacing
    squared = h * h
    rate = w.k_c / (squared * squared * h)
    bending = w.k_b / (squared * h)
    # contact stiffness of the curvature limit: 0.25 per k_c [1/m^2] and 10 per k_b [-]
    of_curvature = (0.25 * w.k_c + 10.0 * w.k_b) / (squared * h)
    set_stiffness(e, rate, bending, w.k_s / h, w.k_e * h, of_curvature)


def leave_route(w: BandWork, end_curvature: Real) -> Real:
    """Turn the first heading as the start asks; return the curvature of the band there."""
    # the chord between the first two nodes is rotated against the tangent at the first
    cosine = math.cos(-0.5 * w.spacing * end_curvature)
    sine = math.sin(-0.5 * w.spacing * end_curvature)
    tx = w.tangent_x[0] * cosine - w.tangent_y[0] * sine
    ty = w.tangent_x[0] * sine + w.tangent_y[0] * cosine
    w.tangent_x[0] = tx
    w.tangent_y[0] = ty
    slope = 0.5 * (w.start_1 - w.start_before) / w.spacing
    change = (w.start_1 - 2.0 * w.start_0 + w.start_before) / (w.spacing * w.spacing)
    along = 1.0 - end_curvature * w.start_0
    speed = max(norm(along, slope), TINY)
    w.heading_x0 = (tx * along - ty * slope) / speed
    w.heading_y0 = (tx * slope + ty * along) / speed
    turn = along * (change + end_curvature * along) + 2.0 * end_curvature * (slope * slope)
    return turn / (speed * speed * speed)


def set_ends(w: BandWork, e: Equilibrium) -> Int:
    """Compute headings and spline moments at both ends, and the response to the start alone."""
    last = w.n - 1
    first_curvature = 2.0 * w.route_curvature[1] - w.route_curvature[2]
    last_curvature = 2.0 * w.route_curvature[last - 1] - w.route_curvature[last - 2]
    w.heading_x0 = w.tangent_x[0]
    w.heading_y0 = w.tangent_y[0]
    w.heading_x1 = w.tangent_x[last]
    w.heading_y1 = w.tangent_y[last]
    if w.start_before != 0.0 or w.start_0 != 0.0 or w.start_1 != 0.0:
        if not respond_to_start(e, w.start_before, w.start_0, w.start_1, w.free):
            return TOO_LONG
        first_curvature = leave_route(w, first_curvature)
    else:
        for i in range(w.n):
            w.free[i] = 0.0
    w.moment_x0 = -first_curvature * w.heading_y0 / 6.0
    w.moment_y0 = first_curvature * w.heading_x0 / 6.0
    w.moment_x1 = -last_curvature * w.heading_y1 / 6.0
    w.moment_y1 = last_curvature * w.heading_x1 / 6.0
    return OK
