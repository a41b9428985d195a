"""The C2 cubic through the displaced nodes: unit tangents, curvature, and moments divided by 6."""

import math

from cca_core.kernel.band_workspace import BandWork
from cca_core.kernel.box_gaps import norm
from cca_core.kernel.constants import TINY


def displace_nodes(w: BandWork) -> None:
    """Displace the nodes of the route to their left."""
    x = w.x
    y = w.y
    u = w.u
    route_x = w.route_x
    route_y = w.route_y
    tangent_x = w.tangent_x
    tangent_y = w.tangent_y
    for i in range(w.n):
        d = u[i]
        x[i] = route_x[i] - tangent_y[i] * d
        y[i] = route_y[i] + tangent_x[i] * d


def solve_moments(w: BandWork) -> None:
    """Solve the tridiagonal system of the moments, whose ends are known, with slopes in `ahead`."""
    n = w.n
    h = w.chord
    mx = w.moment_x
    my = w.moment_y
    diagonal = w.diagonal
    mx[0] = w.moment_x0
    my[0] = w.moment_y0
    mx[n - 1] = w.moment_x1
    my[n - 1] = w.moment_y1
    ahead_x = w.ahead_x
    ahead_y = w.ahead_y
    # of the row before, whose moment is x, y
    last_x = ahead_x[0]
    last_y = ahead_y[0]
    last_h = h[0]
    factor = last_h
    x = mx[0]
    y = my[0]
    for i in range(1, n - 1):
        here_x = ahead_x[i]
        here_y = ahead_y[i]
        here_h = h[i]
        x = here_x - last_x - factor * x
        y = here_y - last_y - factor * y
        pivot = 2.0 * (here_h + last_h) - (factor * last_h if i > 1 else 0.0)
        mx[i] = x
        my[i] = y
        diagonal[i] = pivot
        factor = here_h / pivot
        last_x = here_x
        last_y = here_y
        last_h = here_h
    x = mx[n - 1]
    y = my[n - 1]
    for i in range(n - 2, 0, -1):
        here_h = h[i]
        pivot = diagonal[i]
        x = (mx[i] - here_h * x) / pivot
        y = (my[i] - here_h * y) / pivot
        mx[i] = x
        my[i] = y


def fit_spline(w: BandWork) -> None:
    """Fit the curve through the displaced nodes."""
    n = w.n
    h = w.chord
    ax = w.ahead_x
    ay = w.ahead_y
    mx = w.moment_x
    my = w.moment_y
    x = w.x
    y = w.y
    here_x = x[0]
    here_y = y[0]
    for i in range(n - 1):
        next_x = x[i + 1]
        next_y = y[i + 1]
        dx = next_x - here_x
        dy = next_y - here_y
        here_x = next_x
        here_y = next_y
        chord = max(norm(dx, dy), TINY)
        h[i] = chord
        ax[i] = dx / chord
        ay[i] = dy / chord
    solve_moments(w)
    # the last tangent first: it needs the last slope
    ax[n - 1] = ax[n - 2] + h[n - 2] * (2.0 * mx[n - 1] + mx[n - 2])
    ay[n - 1] = ay[n - 2] + h[n - 2] * (2.0 * my[n - 1] + my[n - 2])
    curvature = w.curvature
    here_x = mx[0]
    here_y = my[0]
    for i in range(n):
        moment_x = here_x
        moment_y = here_y
        tx = ax[i]
        ty = ay[i]
        if i < n - 1:
            chord = h[i]
            here_x = mx[i + 1]
            here_y = my[i + 1]
            tx -= chord * (2.0 * moment_x + here_x)
            ty -= chord * (2.0 * moment_y + here_y)
        speed = max(math.sqrt(tx * tx + ty * ty), TINY)  # about 1
        tx /= speed
        ty /= speed
        ax[i] = tx
        ay[i] = ty
        curvature[i] = 6.0 * (tx * moment_y - ty * moment_x) / (speed * speed)
