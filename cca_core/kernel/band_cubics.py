"""Cubics of the path through the nodes of a band."""

from typing import Annotated

from cca_core.kernel.box_gaps import norm
from cca_core.kernel.types import Grid, Int, Real, Reals

__all__ = ["join_cubics"]

Points = Annotated[Grid, "segments + 1", 2]


def join_cubics(
    segments: Int, nodes: Points, moments: Points, start: Real, breaks: Annotated[Reals, "segments + 1"],
    cubics: Annotated[Grid, "segments", 8],
) -> None:  # fmt: skip
    """Compute arc lengths, and a, b, c, d of x and then of y, from nodes and spline moments / 6."""
    s = 0.0
    breaks[0] = start
    x = nodes[0, 0]
    y = nodes[0, 1]
    moment_x = moments[0, 0]
    moment_y = moments[0, 1]
    for i in range(segments):
        next_x = nodes[i + 1, 0]
        next_y = nodes[i + 1, 1]
        dx = next_x - x
        dy = next_y - y
        length = norm(dx, dy)
        s += length
        breaks[i + 1] = s + start
        squared = length * length
        here = squared * moment_x
        moment_x = moments[i + 1, 0]
        then = squared * moment_x
        cubics[i, 0] = then - here
        cubics[i, 1] = 3.0 * here
        cubics[i, 2] = dx - (2.0 * here + then)
        cubics[i, 3] = x
        here = squared * moment_y
        moment_y = moments[i + 1, 1]
        then = squared * moment_y
        cubics[i, 4] = then - here
        cubics[i, 5] = 3.0 * here
        cubics[i, 6] = dy - (2.0 * here + then)
        cubics[i, 7] = y
        x = next_x
        y = next_y
