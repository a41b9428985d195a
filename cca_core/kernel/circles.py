"""Circles through three points."""

from cca_core.kernel.box_gaps import norm
from cca_core.kernel.types import Real

TINY = 1e-12  # least length that is divided by [m]


def circle_curvature(x0: Real, y0: Real, x1: Real, y1: Real, x2: Real, y2: Real) -> Real:
    """Return the signed curvature [1/m] of the circle through three points."""
    ax = x1 - x0
    ay = y1 - y0
    bx = x2 - x1
    by = y2 - y1
    return 2.0 * (ax * by - ay * bx) / (norm(ax, ay) * norm(bx, by) * norm(x2 - x0, y2 - y0))
