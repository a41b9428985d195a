"""Bounds of a band: road edges, and obstacles on the side on which they are passed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, Complex, Index, Mask, check_any
from cca_core.errors import InputError
from cca_core.geometry import Boxes
from cca_core.vehicle import VehicleParams

Side = Literal["left", "right"]
"""Side on which the ego passes an obstacle."""

_ALIGNED = 0.02  # sine of the angle below which a box counts as parallel
_END_SLOPE = 0.5  # at which bounds fall beyond the ends of an obstacle, steeper than any band [-]
_OF_OBSTACLES = (
    "center", "ahead", "half_length", "half_width", "radius", "max_step", "alongside", "right", "left",
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Corridor:
    """Obstacles and edges in the frame of each node."""

    center: Complex  # middle of each obstacle's box x + iy when the ego is at each node [m], (m, bands, n)
    ahead: Complex  # its unit heading [-]
    half_length: Array  # half extents of the boxes [m], (m, bands, n)
    half_width: Array
    radius: Array  # of the circles around the boxes [m], (m, bands, n)
    max_step: Array  # longest way of a corner from node to node [m], (m, bands)
    alongside: Mask  # whether an obstacle is alongside the ego at this node or a neighbor, (m, bands, n)
    right: (
        Array  # displacement at which the ego passes on an obstacle's right at clearance [m], (m, bands, n)
    )
    left: Array
    lower: Array  # displacement at which the ego drives along the right edge [m], (bands, n)
    upper: Array
    has_edges: bool

    def select(self, bands: Index) -> "Corridor":
        """Return the corridor of some bands; an index may occur more than once."""
        of_obstacles = {name: getattr(self, name)[:, bands] for name in _OF_OBSTACLES}
        return replace(self, **of_obstacles, lower=self.lower[bands], upper=self.upper[bands])

    def default_sides(self) -> tuple[Mask, Mask]:
        """Return whether obstacles block the route, and whether it passes them on their left (m, bands)."""
        on_right = np.logical_or.reduce(self.alongside & (self.left > 0.0), axis=-1)
        on_left = np.logical_or.reduce(self.alongside & (self.right < 0.0), axis=-1)
        both: Mask = on_right & on_left
        return both, both if both.all() else both | (self.mean_offset() < 0.0)

    def mean_offset(self) -> Array:
        """Return each obstacle's lateral offset where it is alongside, up to a factor, shape (m, bands)."""
        middle: Array = np.where(self.alongside, self.left + self.right, 0.0).sum(axis=-1)
        return middle

    def bounds(self, passes_left: Mask) -> tuple[Array, Array]:
        """Return the bounds of the displacement [m], shape (bands, n), for sides of shape (m, bands)."""
        lower, upper = self.lower.copy(), self.upper.copy()
        for alongside, sides, right, left in zip(
            self.alongside, passes_left, self.right, self.left, strict=True
        ):
            above = alongside & sides[:, None]
            lower = np.where(above, np.maximum(lower, left), lower)
            upper = np.where(above < alongside, np.minimum(upper, right), upper)
        return lower, upper


def make_corridor(
    route: Complex,
    tangents: Complex,
    obstacles: Sequence[Boxes],
    edges: tuple[ArrayLike, ArrayLike] | None,
    vehicle: VehicleParams,
    clearance: float,
    lead_distance: ArrayLike,
    batch_shape: tuple[int, ...],
) -> Corridor:
    """Check obstacles and edges and find the displacement that they leave free."""
    shape = (*batch_shape, route.shape[1])
    x, y, psi, half_length, half_width = _stacked(obstacles, shape)
    m = len(obstacles)
    lead = check_any("lead_distance", lead_distance)
    if lead.shape not in ((), (m,)) or lead.min(initial=0.0) < 0.0:
        raise InputError(
            f"lead_distance must have shape () or ({m},) and not be negative, was {lead_distance!r}"
        )
    center, ahead = x + 1j * y, np.cos(psi) + 1j * np.sin(psi)
    radius = np.hypot(half_length, half_width)
    max_step = np.zeros(radius.shape[:2])
    if any(np.ndim(o.x) or np.ndim(o.y) or np.ndim(o.psi) for o in obstacles):
        turns = np.abs(ahead[..., 1:] - ahead[..., :-1]) * radius[..., 1:]
        max_step = (np.abs(center[..., 1:] - center[..., :-1]) + turns).max(axis=-1)
    relative = (center - route) * tangents.conj()
    overlap, right, left = _span(
        relative - vehicle.box_offset, ahead * tangents.conj(),
        half_length + clearance, half_width + clearance,
        0.5 * vehicle.length, lead[..., None, None],
    )  # fmt: skip
    alongside, outside = _with_neighbors(overlap)
    relief = _END_SLOPE * np.abs(route[:, 1:2] - route[:, :1]) * outside
    right, left = right + relief, left - relief
    half = 0.5 * vehicle.width
    lower, upper = _edges(edges, shape)
    return Corridor(
        center, ahead, half_length, half_width, radius, max_step,
        alongside, right - half, left + half,
        lower + half, upper - half, edges is not None,
    )  # fmt: skip


def _stacked(obstacles: Sequence[Boxes], shape: tuple[int, ...]) -> Array:
    """Position, heading and half extents of all obstacles, shape (5, m, bands, n)."""
    boxes: object = obstacles
    if not isinstance(boxes, (list, tuple)) or not all(isinstance(o, Boxes) for o in boxes):
        raise InputError(
            f"obstacles must be a list of Boxes, as made by cca_core.geometry.boxes, was {str(boxes)[:60]}"
        )
    fields = np.empty((5, len(obstacles), *shape))
    x, y, psi, length, width = fields
    for i, o in enumerate(obstacles):
        try:
            x[i], y[i], psi[i], length[i], width[i] = o.x, o.y, o.psi, o.length, o.width
        except (TypeError, ValueError, OverflowError):
            raise InputError(
                f"obstacles must have fields of real numbers with shape () or {shape}, was obstacle {i}"
            ) from None
    if not np.isfinite(fields).all():
        raise InputError("obstacles must be finite")
    fields[3:] *= 0.5
    if fields[3:].min(initial=0.0) < 0.0:
        raise InputError("obstacles must have lengths and widths that are not negative")
    return fields.reshape(5, len(obstacles), math.prod(shape[:-1]), shape[-1])


def _span(
    center: Complex, turn: Complex, length: Array, width: Array, reach: float, lead: Array
) -> tuple[Array, Array, Array]:
    """Return how far boxes overlap the x axis from -reach to reach + lead [m], and their y range there."""
    # Centers and turns are relative to that stretch, extents are half ones. The range is that of the upper
    # and lower roof of the box over the stretch: a roof has its ridge at a corner and falls to both sides.
    c, s = np.abs(turn.real), np.abs(turn.imag)
    x, y = center.real, center.imag
    half_x, half_y = length * c + width * s, length * s + width * c
    overlap: Array = half_x + reach - np.maximum(-x, x - lead)
    if s.max(initial=0.0) < _ALIGNED:
        return overlap, y - half_y, y + half_y
    counter = turn.real * turn.imag >= 0.0  # rotated counter-clockwise by less than a right angle
    ridge = np.where(counter, length * c - width * s, width * s - length * c)
    along_edge, across_edge = s / np.maximum(c, _ALIGNED), c / np.maximum(s, _ALIGNED)
    rise, fall = np.where(counter, along_edge, across_edge), np.where(counter, across_edge, along_edge)
    before, behind = -reach - x, reach + lead - x
    upper = half_y - np.maximum(ridge - behind, 0.0) * rise - np.maximum(before - ridge, 0.0) * fall
    lower = half_y - np.maximum(ridge + before, 0.0) * rise - np.maximum(-behind - ridge, 0.0) * fall
    return overlap, y - np.maximum(lower, -half_y), y + np.maximum(upper, -half_y)


def _with_neighbors(overlap: Array) -> tuple[Mask, Array]:
    """Return the nodes with an overlap or next to one, and by which fraction of a step they lie outside."""
    # bounds at the nodes with an overlap alone would jump by a node when an end moves past one
    near = overlap.copy()
    np.maximum(near[..., 1:], overlap[..., :-1], out=near[..., 1:])
    np.maximum(near[..., :-1], overlap[..., 1:], out=near[..., :-1])
    alongside = near >= 0.0
    return alongside, alongside * (np.minimum(overlap, 0.0) / np.minimum(overlap - near, -1e-9))


def _edges(edges: tuple[ArrayLike, ArrayLike] | None, shape: tuple[int, ...]) -> tuple[Array, Array]:
    """Right and left edge at each node [m], infinite where there is none."""
    if edges is None:
        flat = math.prod(shape[:-1]), shape[-1]
        return np.full(flat, -math.inf), np.full(flat, math.inf)
    pair: object = edges
    if not isinstance(pair, (tuple, list)) or len(pair) != 2:
        raise InputError("corridor must be a pair of edges, right and left")
    full = []
    for edge in pair:
        try:
            full.append(np.array(np.broadcast_to(np.asarray(edge, dtype=np.float64), shape)))
        except (TypeError, ValueError, OverflowError):
            raise InputError(
                f"corridor must have edges of real numbers, one or one per node {shape}, "
                f"had shape {np.shape(edge)}"
            ) from None
        if np.isnan(full[-1]).any():
            raise InputError("corridor must not be NaN")
    if (full[0] > full[1]).any():
        raise InputError("corridor must be the right edge and then the left one: left is positive")
    return full[0].reshape(-1, shape[-1]), full[1].reshape(-1, shape[-1])
