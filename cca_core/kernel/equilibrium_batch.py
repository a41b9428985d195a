"""Equilibria of a batch of bands between given bounds."""

from typing import Annotated

from cca_core.kernel.band_workspace import Equilibrium
from cca_core.kernel.equilibrium import find_equilibrium
from cca_core.kernel.stiffness import set_stiffness
from cca_core.kernel.types import Flag, Grid, Int, Ints

__all__ = ["find_equilibria"]

Rows = Annotated[Grid, "bands", "n"]


def find_equilibria(
    e: Equilibrium, bands: Int, n: Int, bounded: Flag, stiffness: Annotated[Grid, "bands", 5], lower: Rows,
    upper: Rows, lower_difference: Rows, upper_difference: Rows, u: Rows, solves: Annotated[Ints, "bands"],
    converged: Annotated[Ints, "bands"],
) -> None:  # fmt: skip
    """Find the displacement of each band; `stiffness` is that of rate, bending, tension and both contacts."""
    e.n = n
    for b in range(bands):
        set_stiffness(e, stiffness[b, 0], stiffness[b, 1], stiffness[b, 2], stiffness[b, 3], stiffness[b, 4])
        e.bounded = bounded
        e.solves = 0
        for i in range(n):
            e.lower[i] = lower[b, i]
            e.upper[i] = upper[b, i]
            e.lower_difference[i] = lower_difference[b, i]
            e.upper_difference[i] = upper_difference[b, i]
        done = find_equilibrium(e, False)
        for i in range(n):
            u[b, i] = e.u[i]
        solves[b] = e.solves
        converged[b] = 1 if done else 0
