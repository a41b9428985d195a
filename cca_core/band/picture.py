"""What a drawing of a band shows."""

from typing import TYPE_CHECKING

import numpy as np

from cca_core._checks import Array, Complex
from cca_core._svg import EDGE, EGO, FAILED, OTHER, ROUTE, Mark
from cca_core.geometry import boxes

if TYPE_CHECKING:
    from cca_core.band.band import Band


def band_marks(band: "Band") -> list[Mark]:
    """Collect what is drawn of a single band.

    Parameters
    ----------
    band : Band
        The band.

    Returns
    -------
    marks : list of Mark
        Route, edges and obstacles, each as the ego comes nearest to it, and the band as wide as the ego, in
        another color where it must not be driven.
    """
    problem, nodes = band.problem, band.nodes.view(np.complex128)[:, 0]
    route, left, corridor = problem.route_nodes[0], 1j * problem.tangents[0], problem.corridor
    half = 0.5 * problem.vehicle.width
    marks = [Mark(xy=_points(route), color=ROUTE, kind="dashes", width=1.0)]
    if corridor.has_edges:
        edges = route + left * (corridor.lower[0] - half), route + left * (corridor.upper[0] + half)
        marks += [Mark(xy=_points(edge), color=EDGE) for edge in edges]
    for i, center in enumerate(corridor.center[:, 0]):
        k = int(np.abs(center - nodes).argmin())
        size = 2.0 * corridor.half_length[i, 0, k], 2.0 * corridor.half_width[i, 0, k]
        box = boxes(center[k].real, center[k].imag, np.angle(corridor.ahead[i, 0, k]), *size)
        marks.append(Mark(xy=box.corners(), color=OTHER, kind="area"))
    color = EGO if band.ok else FAILED
    marks.append(Mark(xy=band.nodes, color=color, kind="swath", width=2.0 * half))
    return [*marks, *(Mark(xy=band.nodes, color=color, kind=kind) for kind in ("dots", "arrow"))]


def _points(z: Complex) -> Array:
    """Points x + iy as rows, shape (n, 2)."""
    return np.stack((z.real, z.imag), axis=-1)
