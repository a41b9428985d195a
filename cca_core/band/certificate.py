"""What a band keeps: the distance of the ego's swept box to obstacles and edges, and its curvature."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from cca_core._checks import Array, Complex, Index
from cca_core.band.corridor import Corridor
from cca_core.band.problem import BandProblem, spline_moments
from cca_core.geometry import gap_between
from cca_core.vehicle import VehicleParams

_ROUNDING = 2e-3  # by which cubics and headings between nodes may differ from those assumed [m]
_LOOSE = 4e-3  # what a bound may lie below the least gap at nodes [m]
_DECISIVE = 1e-2  # beyond the distance asked: gaps above that are not what holds a band [m]
_PARTS = 16  # of an interval that is looked into


@dataclass(frozen=True, slots=True, eq=False)
class Certificate:
    """What the ego's body swept along bands keeps.

    Parameters
    ----------
    gaps : ndarray, shape (m, bands, n)
        Least gap to each obstacle around each node [m]: a lower bound, exact within the bulge of the band
        between nodes where it is at its least.
    right_margin, left_margin : ndarray, shape (bands, n)
        How far the body stays off the right and the left edge [m], negative where it crosses it.
    curvature : ndarray, shape (bands, n)
        Curvature of the band [1/m], left positive.
    min_gap, min_edge_clearance : ndarray, shape (bands,)
        Least of the gaps to obstacles and of the distances from edges [m].
    curvature_ratio : ndarray, shape (bands,)
        Largest curvature as a multiple of its limit [-].
    sixth : ndarray of complex, shape (bands, n)
        A sixth of the second derivative of the C2 cubic through the nodes [1/m].
    """

    gaps: Array
    right_margin: Array
    left_margin: Array
    curvature: Array
    min_gap: Array
    min_edge_clearance: Array
    curvature_ratio: Array
    sixth: Complex

    def violation(self, task: BandProblem) -> Array:
        """Return how far bands are from what was asked [-], shape (bands,); a meter counts as 5 limits."""
        short = np.maximum(task.clearance - self.min_gap, -self.min_edge_clearance)
        excess: Array = 5.0 * np.maximum(short, 0.0) + np.maximum(self.curvature_ratio - 1.0, 0.0)
        return excess

    def update(self, bands: Index, some: "Certificate") -> None:
        """Put in what some of the bands keep after another solve."""
        self.gaps[:, bands] = some.gaps
        for name in (
            "right_margin",
            "left_margin",
            "curvature",
            "min_gap",
            "min_edge_clearance",
            "curvature_ratio",
            "sixth",
        ):
            getattr(self, name)[bands] = getattr(some, name)


def certify(task: BandProblem, u: Array) -> Certificate:
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
    The band is the C2 cubic through its nodes, and between them obstacles move in straight lines. The
    gap of convex bodies in straight relative motion without turning is a convex function of time: it lies
    above its secants drawn on from the intervals on both sides. What the curve bulges from its chord and what
    turning may take away is taken off that bound. Where it falls below the distance asked, or is loose and
    within 1 cm of it beside what stands, the interval is sampled closely.
    """
    nodes = task.route_nodes + 1j * task.tangents * u
    along, curvature, sixth = spline_moments(nodes, task.end_moments)
    gaps = _gaps(task, nodes, along, curvature)
    right, left = _edge_distances(task, u, along, curvature)
    edge = np.minimum(right, left).min(axis=1)
    bent = np.abs(curvature / task.curvature_limit).max(axis=1)
    min_gap = gaps.min(axis=(0, 2)) if len(gaps) else np.full(len(u), math.inf)
    return Certificate(gaps, right, left, curvature, min_gap, edge, bent, sixth)


def end_gaps(task: BandProblem) -> Array:
    """Measure what no bending changes: the gaps at the pinned ends.

    Parameters
    ----------
    task : Task
        Route, obstacles and the ego.

    Returns
    -------
    gaps : ndarray, shape (m, bands)
        Lesser of the gaps to each obstacle at the first and the last node [m].
    """
    ends = slice(None), slice(None), [0, -1]
    there = (task.route_nodes + 1j * task.tangents * task.free_displacement)[:, [0, -1]]
    gaps = _gap(there, task.end_headings, _at(task.corridor, ends), task.vehicle)
    least: Array = gaps.min(axis=2)
    return least


def _gaps(task: BandProblem, nodes: Complex, along: Complex, curvature: Array) -> Array:
    """Least gap (m, bands, n) to each obstacle between each node and the next."""
    o, vehicle, clearance = task.corridor, task.vehicle, task.clearance
    if not len(o.center):
        return np.empty(o.center.shape)
    middles = np.abs(o.center - (nodes + vehicle.box_offset * along))
    # circles around the boxes bound their gap from below, circles inside them from above
    gaps = middles - (o.radius + 0.5 * math.hypot(vehicle.length, vehicle.width))
    most = (middles - o.half_width).min(axis=(0, 2)) - 0.5 * vehicle.width
    # no gap changes by more from node to node
    moves = o.max_step + task.h * (1.0 + 0.6 * vehicle.length * np.abs(curvature).max(axis=1))
    near = gaps <= (np.maximum(clearance, most) + 2.0 * moves)[..., None]
    pairs = near.nonzero()
    i = pairs[2]
    if not len(i):
        return gaps
    sampled = _gap(nodes[pairs[1:]], along[pairs[1:]], _at(o, pairs), vehicle)
    bent = np.abs(curvature[pairs[1:]])
    bulge = task.h[pairs[1]] * bent * (0.125 * task.h[pairs[1]] + 0.5 * moves[pairs[:2]])
    if o.max_step.any() or bent.any():
        bulge += _ROUNDING
    least = sampled.copy()
    inner = (i[1:] - i[:-1] == 1).nonzero()[0]  # intervals with both ends sampled
    least[inner] = np.minimum(least[inner], sampled[inner + 1]) - np.maximum(bulge[inner], bulge[inner + 1])
    # secants drawn on from both sides meet below the samples where the gap may dip between them
    change = sampled[1:] - sampled[:-1]
    dips = 1 + ((change[:-2] < 0.0) & (change[2:] > 0.0) & (i[3:] - i[:-3] == 3)).nonzero()[0]
    if len(dips):
        before, after = change[dips - 1], change[dips + 1]
        bound = sampled[dips] + before * (change[dips] - after) / (before - after)
        least[dips] = np.minimum(least[dips], bound - bulge[dips])
    last = gaps.shape[2] - 1
    if i.min() == 0 or i.max() == last:
        ends = inner[(i[inner] == 0) | (i[inner] == last - 1)]
        least[ends] -= 0.5 * moves[pairs[0][ends], pairs[1][ends]]
    look = inner[least[inner] < clearance + _DECISIVE]
    if len(look):
        floor = np.full(len(nodes), math.inf)
        np.minimum.at(floor, pairs[1], sampled)
        low = np.minimum(sampled[look], sampled[look + 1])
        loose = (least[look] < floor[pairs[1][look]] - _LOOSE) & (
            o.max_step[pairs[0][look], pairs[1][look]] == 0.0
        )
        look = look[(low >= clearance) & ((least[look] < clearance) | loose)]
    if len(look):
        least[look] = _between(nodes, along, o, vehicle, tuple(p[look] for p in pairs))
    gaps[pairs] = least
    return gaps


def _at(corridor: Corridor, pairs: tuple[Any, ...]) -> tuple[Complex, Complex, Array, Array]:
    o = corridor
    return o.center[pairs], o.ahead[pairs], o.half_length[pairs], o.half_width[pairs]


def _gap(
    position: Complex, ahead: Complex, obstacle: tuple[Complex, Complex, Array, Array], vehicle: VehicleParams
) -> Array:
    center, heading, half_length, half_width = obstacle
    return gap_between(
        center - position - vehicle.box_offset * ahead, ahead, heading,
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
    center, heading, half_length, half_width = _at(corridor, pairs)
    later = _at(corridor, (o, band, i + 1))
    heading = heading + f * (later[1] - heading)
    obstacle = (
        center + f * (later[0] - center), heading / np.abs(heading),
        half_length + f * (later[2] - half_length), half_width + f * (later[3] - half_width),
    )  # fmt: skip
    gaps = _gap(position, ahead / np.abs(ahead), obstacle, vehicle)
    change = np.diff(gaps, axis=0)
    falls, rises = change[:-2] < 0.0, change[2:] > 0.0
    slope = np.where(falls & rises, change[2:] - change[:-2], math.inf)
    dips = gaps[1:-2] + change[:-2] * (change[1:-1] - change[2:]) / slope
    at_ends = gaps.min(axis=0) - 0.5 * np.abs(change[[0, -1]]).max(axis=0)
    # past what stands the gap lies, in the first and the last part, above the secant of the part beside
    beside = np.minimum(gaps[1] - np.maximum(change[1], 0.0), gaps[-2] + np.minimum(change[-2], 0.0))
    at_ends = np.where(corridor.max_step[o, band] > 0.0, at_ends, np.minimum(beside, gaps.min(axis=0)))
    least: Array = np.minimum(np.where(falls & rises, dips, math.inf).min(axis=0), at_ends)
    return least


def _edge_distances(task: BandProblem, u: Array, along: Complex, curvature: Array) -> tuple[Array, Array]:
    """Distance (bands, n) of the body from the right and the left edge, over its length."""
    corridor, vehicle = task.corridor, task.vehicle
    if not corridor.has_edges:
        free = np.full(u.shape, math.inf)
        return free, free.copy()
    half, n = 0.5 * vehicle.width, u.shape[1]
    turn = along * task.tangents.conj()
    bend = 0.5 * task.curvature
    beside = half * turn.real + 0.125 * np.abs(curvature) * task.h[:, None] ** 2
    front, rear = vehicle.front, vehicle.rear
    step = float(task.h.min())
    right_edge, left_edge = corridor.lower - half, corridor.upper + half
    if (right_edge == right_edge[:, :1]).all() and (left_edge == left_edge[:, :1]).all():
        places = [(front, 0), (vehicle.box_offset, 0), (rear, 0)]
    else:  # beside each node that the body reaches, its edge counts
        nodes = range(math.floor(rear / step), math.ceil(front / step) + 1)
        places = [(min(max(k * step, rear), front), k) for k in nodes]
    most = max(abs(k) for _, k in places)
    beyond = np.clip(np.arange(-most, n + most), 0, n - 1)  # edges go on beyond the ends
    right_edge, left_edge = right_edge.take(beyond, axis=1), left_edge.take(beyond, axis=1)
    right, left = np.full(u.shape, math.inf), np.full(u.shape, math.inf)
    for x, k in places:
        middle, there = u + x * turn.imag - bend * (x * x), slice(most + k, most + k + n)
        right = np.minimum(right, middle - beside - right_edge[:, there])
        left = np.minimum(left, left_edge[:, there] - middle - beside)
    return right, left
