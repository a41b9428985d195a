"""What bands are asked to do, checked and in the frame of each node."""

from dataclasses import dataclass, replace

import numpy as np

from cca_core._checks import Array, Complex, Index
from cca_core.band.corridor import Corridor
from cca_core.band.stiffness import BandStiffness
from cca_core.vehicle import VehicleParams


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Task:
    """What bands were asked to do, checked; `bands` of them side by side.

    Parameters
    ----------
    base, tangents : ndarray of complex, shape (bands, n)
        Nodes x + iy of the undeformed route [m] and unit tangents there [-].
    curvature : ndarray, shape (bands, n)
        Curvature of the route [1/m], left positive.
    h : ndarray, shape (bands,)
        Distance between nodes [m].
    corridor : Corridor
        Obstacles and edges.
    vehicle : VehicleParams
        The ego.
    clearance : float
        Distance asked [m].
    curvature_limit : ndarray, shape (bands, n)
        Largest curvature allowed [1/m].
    stiffness : BandStiffness
        Elasticity.
    """

    base: Complex
    tangents: Complex
    curvature: Array
    h: Array
    corridor: Corridor
    vehicle: VehicleParams
    clearance: float
    curvature_limit: Array
    stiffness: BandStiffness

    def select(self, bands: Index) -> "Task":
        """Return the same for some bands, each as often as it is named."""
        return replace(
            self,
            base=self.base[bands],
            tangents=self.tangents[bands],
            curvature=self.curvature[bands],
            h=self.h[bands],
            corridor=self.corridor.select(bands),
            curvature_limit=self.curvature_limit[bands],
        )


def frames(nodes: Complex) -> tuple[Complex, Array]:
    """Return unit tangents [-] and signed curvature [1/m] at nodes x + iy.

    Tangents are central differences, one-sided at the ends; curvature is that of the C2 cubic through the
    nodes to second order.
    """
    steps = nodes[:, 1:] - nodes[:, :-1]
    along = np.empty_like(nodes)
    both = along[:, 1:-1] = steps[:, 1:] + steps[:, :-1]
    along[:, 0], along[:, -1] = steps[:, 0], steps[:, -1]
    length, chord = np.abs(steps), np.abs(along)
    along /= chord
    curvature = np.empty(nodes.shape)
    cross = (both * steps[:, 1:].conj()).imag
    curvature[:, 1:-1] = -2.0 * cross / (length[:, 1:] * length[:, :-1] * chord[:, 1:-1])
    curvature[:, 0], curvature[:, -1] = curvature[:, 1], curvature[:, -2]
    # the C2 cubic through the nodes has (k[i-1] + 4 k[i] + k[i+1]) / 6 on average, so it bends more at kinks
    curvature[:, 1:-1] -= (curvature[:, 2:] - 2.0 * curvature[:, 1:-1] + curvature[:, :-2]) / 6.0
    return along, curvature
