"""What bounds a band: edges of the road, and obstacles on the side on which they are passed."""

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
_ALIGNED = 0.02  # sine of a turn below which a box is as good as parallel
_OF_OBSTACLES = (
    "center", "ahead", "half_length", "half_width", "radius", "max_step", "alongside", "right", "left",
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Corridor:
    """Obstacles and edges in the frame of each node.

    Parameters
    ----------
    center, ahead : ndarray of complex, shape (m, bands, n)
        Middle of each obstacle's box x + iy when the ego is at each node [m] and its unit heading [-].
    half_length, half_width : ndarray, shape (m, bands, n)
        Half extents of the boxes [m].
    radius : ndarray, shape (m, bands, n)
        Of the circles around the boxes [m].
    max_step : ndarray, shape (m, bands)
        Farthest that a corner moves from node to node [m].
    alongside : ndarray of bool, shape (m, bands, n)
        Whether an obstacle is beside the ego there.
    right, left : ndarray, shape (m, bands, n)
        Displacement at which the ego passes an obstacle on its right and on its left at clearance [m].
    lower, upper : ndarray, shape (bands, n)
        Displacement at which the ego drives along the right and the left edge [m].
    has_edges : bool
        Whether there are edges at all.
    """

    center: Complex
    ahead: Complex
    half_length: Array
    half_width: Array
    radius: Array
    max_step: Array
    alongside: Mask
    right: Array
    left: Array
    lower: Array
    upper: Array
    has_edges: bool

    def select(self, bands: Index) -> "Corridor":
        """Return the same for some bands, each as often as it is named."""
        of_obstacles = {name: getattr(self, name)[:, bands] for name in _OF_OBSTACLES}
        return replace(self, **of_obstacles, lower=self.lower[bands], upper=self.upper[bands])

    def default_sides(self) -> tuple[Mask, Mask]:
        """Whether obstacles are in the way, and whether the route passes them on their left.

        Returns
        -------
        in_the_way, passes_left : ndarray of bool, shape (m, bands)
            An obstacle is in the way if the undisplaced ego would come closer to it than the clearance; if
            it is, left stands for no natural side.
        """
        on_right = np.logical_or.reduce(self.alongside & (self.left > 0.0), axis=-1)
        on_left = np.logical_or.reduce(self.alongside & (self.right < 0.0), axis=-1)
        both: Mask = on_right & on_left
        return both, both if both.all() else both | (self.mean_offset() < 0.0)

    def mean_offset(self) -> Array:
        """Mean lateral coordinate of each obstacle where it is abeam, up to a factor, shape (m, bands)."""
        middle: Array = np.where(self.alongside, self.left + self.right, 0.0).sum(axis=-1)
        return middle

    def bounds(self, passes_left: Mask) -> tuple[Array, Array]:
        """Bounds of the displacement.

        Parameters
        ----------
        passes_left : ndarray of bool, shape (m, bands)
            Whether the ego passes each obstacle on the obstacle's left.

        Returns
        -------
        lower, upper : ndarray, shape (bands, n)
            Least and largest displacement [m]; nothing lies between them where lower > upper.
        """
        lower, upper = self.lower.copy(), self.upper.copy()
        for abeam, sides, right, left in zip(self.alongside, passes_left, self.right, self.left, strict=True):
            beside = abeam & sides[:, None]
            lower = np.where(beside, np.maximum(lower, left), lower)
            upper = np.where(beside < abeam, np.minimum(upper, right), upper)
        return lower, upper


def make_corridor(
    base: Complex,
    tangents: Complex,
    obstacles: Sequence[Boxes],
    edges: tuple[ArrayLike, ArrayLike] | None,
    vehicle: VehicleParams,
    clearance: float,
    lead: ArrayLike,
    leading: tuple[int, ...],
) -> Corridor:
    """Check obstacles and edges and find what they leave free.

    Parameters
    ----------
    base, tangents : ndarray of complex, shape (bands, n)
        Nodes x + iy of the undeformed route [m] and unit tangents there [-].
    obstacles : sequence of Boxes
        Fields broadcast against (..., n).
    edges : pair of array_like, optional
        Right and left edge [m], left positive, which the ego's body does not cross.
    vehicle : VehicleParams
        The ego.
    clearance : float
        Distance to keep from obstacles [m].
    lead : array_like, shape (m,) or ()
        Distance before each obstacle from which on the ego is beside it [m].
    leading : tuple of int
        Leading axes of obstacles and edges, which are flattened to `bands`.

    Returns
    -------
    corridor : Corridor
        The same, node by node.

    Raises
    ------
    InputError
        If a shape does not fit, or a value is not finite or has the wrong sign.
    """
    shape = (*leading, base.shape[1])
    x, y, psi, half_length, half_width = _stacked(obstacles, shape)
    m = len(obstacles)
    run_up = check_any("lead_distance", lead)
    if run_up.shape not in ((), (m,)) or run_up.min(initial=0.0) < 0.0:
        raise InputError(f"lead_distance must have shape () or ({m},) and not be negative, was {lead!r}")
    center, ahead = x + 1j * y, np.cos(psi) + 1j * np.sin(psi)
    radius = np.hypot(half_length, half_width)
    moves = np.zeros(radius.shape[:2])
    if any(np.ndim(o.x) or np.ndim(o.y) or np.ndim(o.psi) for o in obstacles):
        turns = np.abs(ahead[..., 1:] - ahead[..., :-1]) * radius[..., 1:]
        moves = (np.abs(center[..., 1:] - center[..., :-1]) + turns).max(axis=-1)
    apart = (center - base) * tangents.conj()
    abeam, right, left = _span(
        apart - vehicle.box_offset, ahead * tangents.conj(), half_length + clearance, half_width + clearance,
        0.5 * vehicle.length, run_up[..., None, None],
    )  # fmt: skip
    keep = 0.5 * vehicle.width
    lower, upper = _edges(edges, shape)
    return Corridor(
        center, ahead, half_length, half_width, radius, moves,
        abeam, right - keep, left + keep,
        lower + keep, upper - keep, edges is not None,
    )  # fmt: skip


def _stacked(obstacles: Sequence[Boxes], shape: tuple[int, ...]) -> Array:
    """Position, heading and half extents of all obstacles, shape (5, m, bands, n)."""
    given: object = obstacles
    if not isinstance(given, (list, tuple)) or not all(isinstance(o, Boxes) for o in given):
        raise InputError(
            f"obstacles must be a list of Boxes, as made by cca_core.geometry.boxes, was {str(given)[:60]}"
        )
    fields = np.empty((5, len(obstacles), *shape))
    x, y, psi, length, width = fields
    for i, o in enumerate(obstacles):
        try:
            x[i], y[i], psi[i], length[i], width[i] = o.x, o.y, o.psi, o.length, o.width
        except (TypeError, ValueError):
            raise InputError(
                f"obstacles must have fields of real numbers, shape () or {shape}, obstacle {i} has not"
            ) from None
    if not np.isfinite(fields).all():
        raise InputError("obstacles must be finite")
    fields[3:] *= 0.5
    if fields[3:].min(initial=0.0) < 0.0:
        raise InputError("obstacles must have lengths and widths that are not negative")
    return fields.reshape(5, len(obstacles), math.prod(shape[:-1]), shape[-1])


def _span(
    center: Complex, turn: Complex, length: Array, width: Array, reach: float, lead: Array
) -> tuple[Mask, Array, Array]:
    """Where boxes are abeam of a stretch of the x axis from -reach to reach + lead, and what they cover.

    Centers and turns are relative to that stretch, extents are half ones. Covered is what the upper and the
    lower roof of the box reach over the stretch: a roof has its ridge at a corner and falls to both sides
    along the edges that meet there.
    """
    c, s = np.abs(turn.real), np.abs(turn.imag)
    x, y = center.real, center.imag
    half_x, half_y = length * c + width * s, length * s + width * c
    abeam: Mask = (x >= -half_x - reach) & (x <= half_x + reach + lead)
    if s.max(initial=0.0) < _ALIGNED:
        return abeam, y - half_y, y + half_y
    counter = turn.real * turn.imag >= 0.0  # turned counter-clockwise by less than a right angle
    ridge = np.where(counter, length * c - width * s, width * s - length * c)
    along_edge, across_edge = s / np.maximum(c, _ALIGNED), c / np.maximum(s, _ALIGNED)
    rise, fall = np.where(counter, along_edge, across_edge), np.where(counter, across_edge, along_edge)
    before, behind = -reach - x, reach + lead - x
    upper = half_y - np.maximum(ridge - behind, 0.0) * rise - np.maximum(before - ridge, 0.0) * fall
    lower = half_y - np.maximum(ridge + before, 0.0) * rise - np.maximum(-behind - ridge, 0.0) * fall
    return abeam, y - np.maximum(lower, -half_y), y + np.maximum(upper, -half_y)


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
        except (TypeError, ValueError):
            raise InputError(
                f"corridor must have edges of real numbers, one or one per node {shape}, "
                f"had shape {np.shape(edge)}"
            ) from None
        if np.isnan(full[-1]).any():
            raise InputError("corridor must not be NaN")
    if (full[0] > full[1]).any():
        raise InputError("corridor must be the right edge and then the left one: left is positive")
    return full[0].reshape(-1, shape[-1]), full[1].reshape(-1, shape[-1])
