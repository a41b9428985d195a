"""Certificate of a band: gaps of the ego's swept box to obstacles and edges, and curvature."""

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from cca_core._checks import Array, Complex, Index
from cca_core.band.corridor import Corridor
from cca_core.band.problem import BandProblem, spline_moments
from cca_core.geometry import gap_between
from cca_core.vehicle import VehicleParams

_CURVE_ERROR = 2e-3  # by which cubics and headings between nodes may differ from those assumed [m]
_LOOSE = 4e-3  # a bound this far below the least gap at nodes is refined [m]
_DECISIVE = 1e-2  # gaps this far above the clearance do not limit a band [m]


@dataclass(frozen=True, slots=True, eq=False)
class Certificate:
    """Gaps, margins and curvature of the ego's body swept along bands."""

    gaps: Array  # least gap around each node [m], (m, bands, n): a lower bound, tight where it limits a band
    right_margin: Array  # distance of the body from the right edge [m], negative beyond it, (bands, n)
    left_margin: Array
    curvature: Array  # [1/m], left positive, (bands, n)
    min_gap: Array  # least of all gaps [m], (bands,)
    min_edge_clearance: Array
    curvature_ratio: Array  # largest curvature as a multiple of its limit [-], (bands,)
    moment_over_6: Complex  # spline moments, divided by 6 [1/m], (bands, n)

    def violation(self, problem: BandProblem) -> Array:
        """Return the violation of clearance and limits [-], shape (bands,); a meter counts as 5."""
        shortfall = np.maximum(problem.clearance - self.min_gap, -self.min_edge_clearance)
        violation: Array = 5.0 * np.maximum(shortfall, 0.0) + np.maximum(self.curvature_ratio - 1.0, 0.0)
        return violation

    def update(self, bands: Index, some: "Certificate") -> None:
        """Replace the values of some bands after another solve."""
        self.gaps[:, bands] = some.gaps
        for field in fields(self)[1:]:
            getattr(self, field.name)[bands] = getattr(some, field.name)


def certify(problem: BandProblem, u: Array) -> Certificate:
    """Sweep the ego's box along displaced bands."""
    # The gap of convex bodies in straight relative motion without rotation is a convex function of time: it
    # lies above the secants of the intervals on both sides. The bulge of the cubic from its chord and the
    # effect of rotation are subtracted from that bound. An interval is sampled closely where the bound falls
    # below the clearance, or is loose and within 1 cm of it next to a stationary obstacle.
    nodes = problem.route_nodes + 1j * problem.tangents * u
    along, curvature, moment_over_6 = spline_moments(nodes, problem.end_moments)
    gaps = _gaps(problem, nodes, along, curvature)
    right, left = _edge_distances(problem, u, along, curvature)
    edge = np.minimum(right, left).min(axis=1)
    ratio = np.abs(curvature / problem.curvature_limit).max(axis=1)
    min_gap = gaps.min(axis=(0, 2)) if len(gaps) else np.full(len(u), math.inf)
    return Certificate(gaps, right, left, curvature, min_gap, edge, ratio, moment_over_6)


def end_gaps(problem: BandProblem) -> Array:
    """Return the lesser gap [m] to each obstacle at the pinned ends, shape (m, bands)."""
    ends = slice(None), slice(None), [0, -1]
    nodes = (problem.route_nodes + 1j * problem.tangents * problem.free_displacement)[:, [0, -1]]
    gaps = _gap(nodes, problem.end_headings, _at(problem.corridor, ends), problem.vehicle)
    lesser: Array = gaps.min(axis=2)
    return lesser


def _gaps(problem: BandProblem, nodes: Complex, along: Complex, curvature: Array) -> Array:
    """Return the least gap (m, bands, n) to each obstacle between each node and the next."""
    o, vehicle, clearance = problem.corridor, problem.vehicle, problem.clearance
    if not len(o.center):
        return np.empty(o.center.shape)
    middles = np.abs(o.center - (nodes + vehicle.box_offset * along))
    # circles around the boxes bound their gap from below, circles inside them from above
    gaps = middles - (o.radius + 0.5 * math.hypot(vehicle.length, vehicle.width))
    upper = (middles - o.half_width).min(axis=(0, 2)) - 0.5 * vehicle.width
    # no gap changes by more from node to node
    moves = o.max_step + problem.h * (1.0 + 0.6 * vehicle.length * np.abs(curvature).max(axis=1))
    near = gaps <= (np.maximum(clearance, upper) + 2.0 * moves)[..., None]
    pairs = near.nonzero()
    i = pairs[2]
    if not len(i):
        return gaps
    sampled = _gap(nodes[pairs[1:]], along[pairs[1:]], _at(o, pairs), vehicle)
    kappa = np.abs(curvature[pairs[1:]])
    bulge = problem.h[pairs[1]] * kappa * (0.125 * problem.h[pairs[1]] + 0.5 * moves[pairs[:2]])
    if o.max_step.any() or kappa.any():
        bulge += _CURVE_ERROR
    lower = sampled.copy()
    inner = (i[1:] - i[:-1] == 1).nonzero()[0]  # intervals with both ends sampled
    lower[inner] = np.minimum(lower[inner], sampled[inner + 1]) - np.maximum(bulge[inner], bulge[inner + 1])
    # extended secants of both sides meet below the samples where the gap may dip between them
    change = sampled[1:] - sampled[:-1]
    dips = 1 + ((change[:-2] < 0.0) & (change[2:] > 0.0) & (i[3:] - i[:-3] == 3)).nonzero()[0]
    if len(dips):
        before, after = change[dips - 1], change[dips + 1]
        crossing = sampled[dips] + before * (change[dips] - after) / (before - after)
        lower[dips] = np.minimum(lower[dips], crossing - bulge[dips])
    last = gaps.shape[2] - 1
    if i.min() == 0 or i.max() == last:
        ends = inner[(i[inner] == 0) | (i[inner] == last - 1)]
        lower[ends] -= 0.5 * moves[pairs[0][ends], pairs[1][ends]]
    look = inner[lower[inner] < clearance + _DECISIVE]
    if len(look):
        floor = np.full(len(nodes), math.inf)
        np.minimum.at(floor, pairs[1], sampled)
        low = np.minimum(sampled[look], sampled[look + 1])
        loose = (lower[look] < floor[pairs[1][look]] - _LOOSE) & (
            o.max_step[pairs[0][look], pairs[1][look]] == 0.0
        )
        look = look[(low >= clearance) & ((lower[look] < clearance) | loose)]
    if len(look):
        lower[look] = _between(nodes, along, o, vehicle, tuple(p[look] for p in pairs))
    gaps[pairs] = lower
    return gaps


def _at(corridor: Corridor, pairs: tuple[Any, ...]) -> tuple[Complex, Complex, Array, Array]:
    """Return the boxes of obstacles at given indices."""
    o = corridor
    return o.center[pairs], o.ahead[pairs], o.half_length[pairs], o.half_width[pairs]


def _gap(
    position: Complex, ahead: Complex, obstacle: tuple[Complex, Complex, Array, Array], vehicle: VehicleParams
) -> Array:
    """Return the gap [m] between the ego's box and obstacle boxes; negative where they overlap."""
    center, heading, half_length, half_width = obstacle
    return gap_between(
        center - position - vehicle.box_offset * ahead, ahead, heading,
        0.5 * vehicle.length, 0.5 * vehicle.width, half_length, half_width,
    )  # fmt: skip


def _between(
    nodes: Complex, along: Complex, corridor: Corridor, vehicle: VehicleParams, pairs: tuple[Index, ...]
) -> Array:
    """Return the least gap between a node and the next, ends included, for pairs (obstacle, band, node)."""
    f = np.linspace(0.0, 1.0, 17)[:, None]
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
    # next to a stationary obstacle the gap lies, in the first and last part, above the next part's secant
    secant = np.minimum(gaps[1] - np.maximum(change[1], 0.0), gaps[-2] + np.minimum(change[-2], 0.0))
    at_ends = np.where(corridor.max_step[o, band] > 0.0, at_ends, np.minimum(secant, gaps.min(axis=0)))
    lower: Array = np.minimum(np.where(falls & rises, dips, math.inf).min(axis=0), at_ends)
    return lower


def _edge_distances(problem: BandProblem, u: Array, along: Complex, curvature: Array) -> tuple[Array, Array]:
    """Return the distance (bands, n) of the body from the right and the left edge, over its length [m]."""
    corridor, vehicle = problem.corridor, problem.vehicle
    if not corridor.has_edges:
        free = np.full(u.shape, math.inf)
        return free, free.copy()
    half, n = 0.5 * vehicle.width, u.shape[1]
    turn = along * problem.tangents.conj()
    sag = 0.5 * problem.curvature
    reach = half * turn.real + 0.125 * np.abs(curvature) * problem.h[:, None] ** 2
    front, rear = vehicle.front, vehicle.rear
    step = float(problem.h.min())
    right_edge, left_edge = corridor.lower - half, corridor.upper + half
    if (right_edge == right_edge[:, :1]).all() and (left_edge == left_edge[:, :1]).all():
        offsets = [(front, 0), (vehicle.box_offset, 0), (rear, 0)]
    else:  # the edge at each node that the body reaches counts
        reached = range(math.floor(rear / step), math.ceil(front / step) + 1)
        offsets = [(min(max(k * step, rear), front), k) for k in reached]
    n_beyond = max(abs(k) for _, k in offsets)
    beyond = np.clip(np.arange(-n_beyond, n + n_beyond), 0, n - 1)  # edges continue beyond the ends
    right_edge, left_edge = right_edge.take(beyond, axis=1), left_edge.take(beyond, axis=1)
    right, left = np.full(u.shape, math.inf), np.full(u.shape, math.inf)
    for x, k in offsets:
        middle, nodes = u + x * turn.imag - sag * (x * x), slice(n_beyond + k, n_beyond + k + n)
        right = np.minimum(right, middle - reach - right_edge[:, nodes])
        left = np.minimum(left, left_edge[:, nodes] - middle - reach)
    return right, left
