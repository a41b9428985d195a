"""What a band keeps: the distance of the ego's swept box to obstacles and edges, and its curvature."""

import math
from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array, Complex, Index
from cca_core.band.corridor import Corridor
from cca_core.band.task import Task, frames
from cca_core.geometry import gap_between
from cca_core.vehicle import VehicleParams

_PARTS = 16  # of an interval that is looked into


@dataclass(frozen=True, slots=True, eq=False)
class Certificate:
    """What the ego's body swept along bands keeps.

    Parameters
    ----------
    gaps : ndarray, shape (m, bands, n)
        Least gap to each obstacle around each node [m]: a lower bound, exact within the bulge of the band
        between nodes where it is at its least.
    right, left : ndarray, shape (bands, n)
        How far the body stays off the right and the left edge [m], negative where it crosses it.
    curvature : ndarray, shape (bands, n)
        Curvature of the band [1/m], left positive.
    """

    gaps: Array
    right: Array
    left: Array
    curvature: Array

    @property
    def least_gap(self) -> Array:
        """Least gap of each band to any obstacle [m], shape (bands,)."""
        least: Array = self.gaps.min(axis=(0, 2), initial=math.inf)
        return least

    @property
    def least_edge(self) -> Array:
        """How far each band's body stays off the nearer edge at least [m], shape (bands,)."""
        least: Array = np.minimum(self.right.min(axis=1), self.left.min(axis=1))
        return least

    def update(self, bands: Index, some: "Certificate") -> None:
        """Put in what some of the bands keep after another solve."""
        self.gaps[:, bands] = some.gaps
        self.right[bands], self.left[bands], self.curvature[bands] = some.right, some.left, some.curvature


def certify(task: Task, u: Array) -> Certificate:
    """Sweep the ego's box along displaced bands.

    Parameters
    ----------
    task : Task
        Route, obstacles, edges, the ego and the distance asked; gaps above that are bounded only.
    u : ndarray, shape (bands, n)
        Displacement [m].

    Returns
    -------
    certificate : Certificate
        Gaps, distances and curvature, between nodes as at nodes.

    Notes
    -----
    Between nodes the band is the cubic Hermite curve through them and obstacles move in straight lines. The
    gap of convex bodies in straight relative motion without turning is a convex function of time: it lies
    above its secants drawn on from the intervals on both sides. What the curve bulges from its chord is
    taken off that bound, and where it falls below the distance asked, the interval is sampled closely.
    """
    nodes = task.base + 1j * task.tangents * u
    along, curvature = frames(nodes)
    return Certificate(
        _gaps(task, nodes, along, curvature), *_edge_distances(task, u, along, curvature), curvature
    )


def _gaps(task: Task, nodes: Complex, along: Complex, curvature: Array) -> Array:
    """Least gap (m, bands, n) to each obstacle between each node and the next."""
    o, vehicle, clearance = task.corridor, task.vehicle, task.clearance
    if not len(o.centre):
        return np.empty(o.centre.shape)
    middles = np.abs(o.centre - (nodes + vehicle.box_offset * along))
    # circles around the boxes bound their gap from below, circles inside them from above
    gaps = middles - (o.radius + 0.5 * math.hypot(vehicle.length, vehicle.width))
    most = (middles - o.half_width).min(axis=(0, 2)) - 0.5 * vehicle.width
    step = task.h
    near = gaps <= (np.maximum(clearance, most) + 2.0 * step)[:, None]
    pairs = np.nonzero(near)
    if not len(pairs[0]):
        return gaps
    sampled = _gap(nodes[pairs[1:]], along[pairs[1:]], _at(o, pairs), vehicle)
    bent = np.abs(curvature[pairs[1:]])
    bulge = 0.125 * step[pairs[1]] ** 2 * bent * (1.0 + 0.5 * vehicle.length * bent)
    least = sampled.copy()
    i = pairs[2]
    change = sampled[1:] - sampled[:-1]
    inner = np.flatnonzero(i[1:] - i[:-1] == 1)  # intervals with both ends sampled
    least[inner] = np.minimum(least[inner], sampled[inner + 1]) - np.maximum(bulge[inner], bulge[inner + 1])
    # secants drawn on from both sides meet below the samples where the gap may dip between them
    dips = 1 + np.flatnonzero((change[:-2] < 0.0) & (change[2:] > 0.0) & (i[3:] - i[:-3] == 3))
    if len(dips):
        before, after = change[dips - 1], change[dips + 1]
        lowest = before * (sampled[dips + 1] - after - sampled[dips]) / (before - after)
        least[dips] = np.minimum(least[dips], sampled[dips] + lowest - bulge[dips])
    look = inner[(least[inner] < clearance) & (np.minimum(sampled[inner], sampled[inner + 1]) >= clearance)]
    if len(look):
        least[look] = _between(nodes, along, o, vehicle, tuple(p[look] for p in pairs))
    gaps[pairs] = least
    return gaps


def _at(corridor: Corridor, pairs: tuple[Index, ...]) -> tuple[Complex, Complex, Array, Array]:
    o = corridor
    return o.centre[pairs], o.ahead[pairs], o.half_length[pairs], o.half_width[pairs]


def _gap(
    position: Complex, ahead: Complex, obstacle: tuple[Complex, Complex, Array, Array], vehicle: VehicleParams
) -> Array:
    centre, heading, half_length, half_width = obstacle
    return gap_between(
        centre - position - vehicle.box_offset * ahead, ahead, heading,
        0.5 * vehicle.length, 0.5 * vehicle.width, half_length, half_width,
    )  # fmt: skip


def _between(
    nodes: Complex, along: Complex, corridor: Corridor, vehicle: VehicleParams, pairs: tuple[Index, ...]
) -> Array:
    """Least gap between a node and the next, ends included, for pairs (obstacle, band, node)."""
    f = np.linspace(0.0, 1.0, _PARTS + 1)[:, None]
    o, band, i = pairs
    p, q = nodes[band, i], nodes[band, i + 1]
    chord = q - p
    a, b = along[band, i] * np.abs(chord) - chord, chord - along[band, i + 1] * np.abs(chord)
    position = p + f * chord + f * (1.0 - f) * ((1.0 - f) * a + f * b)
    ahead = chord + (1.0 - f) * (1.0 - 3.0 * f) * a + f * (2.0 - 3.0 * f) * b
    centre, heading, half_length, half_width = _at(corridor, pairs)
    later = _at(corridor, (o, band, i + 1))
    heading = heading + f * (later[1] - heading)
    obstacle = (
        centre + f * (later[0] - centre), heading / np.abs(heading),
        half_length + f * (later[2] - half_length), half_width + f * (later[3] - half_width),
    )  # fmt: skip
    least: Array = _gap(position, ahead / np.abs(ahead), obstacle, vehicle).min(axis=0)
    return least


def _edge_distances(task: Task, u: Array, along: Complex, curvature: Array) -> tuple[Array, Array]:
    """Distance (bands, n) of the body from the right and the left edge, over its length."""
    corridor, vehicle = task.corridor, task.vehicle
    if not corridor.edged:
        free = np.full(u.shape, math.inf)
        return free, free.copy()
    half = 0.5 * vehicle.width
    turn = along * task.tangents.conj()
    bend = 0.5 * task.curvature
    least, most = np.full(u.shape, math.inf), np.full(u.shape, -math.inf)
    front, rear = vehicle.box_offset + 0.5 * vehicle.length, vehicle.box_offset - 0.5 * vehicle.length
    for x in (front, vehicle.box_offset, rear):
        middle = u + x * turn.imag - bend * (x * x)
        least, most = np.minimum(least, middle), np.maximum(most, middle)
    beside = half * turn.real + 0.125 * np.abs(curvature) * task.h[:, None] ** 2
    reach = math.ceil(max(front, -rear) / task.h.min())
    right = _worst(corridor.lower - half, reach, np.maximum)
    left = _worst(corridor.upper + half, reach, np.minimum)
    return least - beside - right, left - most - beside


def _worst(edge: Array, reach: int, pick: np.ufunc) -> Array:
    """Nearest place of an edge within a number of nodes before and behind."""
    if (edge == edge[:, :1]).all():
        return edge
    wide = np.pad(edge, ((0, 0), (reach, reach)), mode="edge")
    n = edge.shape[1]
    worst: Array = pick.reduce([wide[:, k : k + n] for k in range(2 * reach + 1)], axis=0)
    return worst
