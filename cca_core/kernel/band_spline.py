"""The C2 cubic through the displaced nodes: unit tangents, curvature, and moments divided by 6."""

from cca_core.kernel.band_workspace import BandWork
from cca_core.kernel.box_gaps import norm
from cca_core.kernel.circles import TINY


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
    for i in range(1, n - 1):
        mx[i] = w.ahead_x[i] - w.ahead_x[i - 1]
        my[i] = w.ahead_y[i] - w.ahead_y[i - 1]
        diagonal[i] = 2.0 * (h[i] + h[i - 1])
    mx[1] -= h[0] * mx[0]
    my[1] -= h[0] * my[0]
    mx[n - 2] -= h[n - 2] * mx[n - 1]
    my[n - 2] -= h[n - 2] * my[n - 1]
    for i in range(2, n - 1):
        factor = h[i - 1] / diagonal[i - 1]
        diagonal[i] -= factor * h[i - 1]
        mx[i] -= factor * mx[i - 1]
        my[i] -= factor * my[i - 1]
    mx[n - 2] /= diagonal[n - 2]
    my[n - 2] /= diagonal[n - 2]
    for i in range(n - 3, 0, -1):
        mx[i] = (mx[i] - h[i] * mx[i + 1]) / diagonal[i]
        my[i] = (my[i] - h[i] * my[i + 1]) / diagonal[i]


def fit_spline(w: BandWork) -> None:
    """Fit the curve through the displaced nodes."""
    n = w.n
    h = w.chord
    ax = w.ahead_x
    ay = w.ahead_y
    mx = w.moment_x
    my = w.moment_y
    for i in range(n - 1):
        dx = w.x[i + 1] - w.x[i]
        dy = w.y[i + 1] - w.y[i]
        h[i] = max(norm(dx, dy), TINY)
        ax[i] = dx / h[i]
        ay[i] = dy / h[i]
    solve_moments(w)
    # the last tangent first: it needs the last slope
    ax[n - 1] = ax[n - 2] + h[n - 2] * (2.0 * mx[n - 1] + mx[n - 2])
    ay[n - 1] = ay[n - 2] + h[n - 2] * (2.0 * my[n - 1] + my[n - 2])
    for i in range(n - 1):
        ax[i] -= h[i] * (2.0 * mx[i] + mx[i + 1])
        ay[i] -= h[i] * (2.0 * my[i] + my[i + 1])
    for i in range(n):
        speed = max(norm(ax[i], ay[i]), TINY)
        ax[i] /= speed
        ay[i] /= speed
        w.curvature[i] = 6.0 * (ax[i] * my[i] - ay[i] * mx[i]) / (speed * speed)
