"""The C2 cubic through the displaced nodes: unit tangents, curvature, and moments divided by 6."""

import math

from cca_core.kernel.band_workspace import BandWork
from cca_core.kernel.box_gaps import norm
from cca_core.kernel.constants import TINY


def displace_nodes(w: BandWork) -> None:
    """Displace the nodes of the route to their left."""
    for i in range(w.n):
        w.x[i] = w.route_x[i] - w.tangent_y[i] * w.u[i]
        w.y[i] = w.route_y[i] + w.tangent_x[i] * w.u[i]


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
    factor = h[0]  # of the row before, whose moment is x, y
    x = mx[0]
    y = my[0]
    last = 0.0
    for i in range(1, n - 1):
        x = w.ahead_x[i] - w.ahead_x[i - 1] - factor * x
        y = w.ahead_y[i] - w.ahead_y[i - 1] - factor * y
        last = 2.0 * (h[i] + h[i - 1]) - (factor * h[i - 1] if i > 1 else 0.0)
        mx[i] = x
        my[i] = y
        diagonal[i] = last
        factor = h[i] / last
    x = mx[n - 1]
    y = my[n - 1]
    for i in range(n - 2, 0, -1):
        x = (mx[i] - h[i] * x) / diagonal[i]
        y = (my[i] - h[i] * y) / diagonal[i]
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
    for i in range(n - 1):
        dx = x[i + 1] - x[i]
        dy = y[i + 1] - y[i]
        chord = max(norm(dx, dy), TINY)
        h[i] = chord
        ax[i] = dx / chord
        ay[i] = dy / chord
    solve_moments(w)
    # the last tangent first: it needs the last slope
    ax[n - 1] = ax[n - 2] + h[n - 2] * (2.0 * mx[n - 1] + mx[n - 2])
    ay[n - 1] = ay[n - 2] + h[n - 2] * (2.0 * my[n - 1] + my[n - 2])
    for i in range(n - 1):
        ax[i] -= h[i] * (2.0 * mx[i] + mx[i + 1])
        ay[i] -= h[i] * (2.0 * my[i] + my[i + 1])
    for i in range(n):
        tx = ax[i]
        ty = ay[i]
        speed = max(math.sqrt(tx * tx + ty * ty), TINY)  # about 1
        tx /= speed
        ty /= speed
        ax[i] = tx
        ay[i] = ty
        w.curvature[i] = 6.0 * (tx * my[i] - ty * mx[i]) / (speed * speed)
