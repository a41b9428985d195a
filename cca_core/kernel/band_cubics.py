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
    for i in range(segments):
        length = norm(nodes[i + 1, 0] - nodes[i, 0], nodes[i + 1, 1] - nodes[i, 1])
        s += length
        breaks[i + 1] = s + start
        for k in range(2):
            here = length * length * moments[i, k]
            then = length * length * moments[i + 1, k]
            cubics[i, 4 * k] = then - here
            cubics[i, 4 * k + 1] = 3.0 * here
            cubics[i, 4 * k + 2] = nodes[i + 1, k] - nodes[i, k] - (2.0 * here + then)
            cubics[i, 4 * k + 3] = nodes[i, k]
