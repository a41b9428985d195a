"""Arguments that bound a band: obstacles, and road edges."""

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, is_finite
from cca_core.errors import InputError
from cca_core.geometry import Boxes

Side = Literal["left", "right"]
"""Side on which the ego passes an obstacle."""


def stack_boxes(obstacles: Sequence[Boxes], shape: tuple[int, ...]) -> Array:
    """Return position, heading and extents of all obstacles, shape (5, m, bands, n).

    Their numbers are checked by the kernel, which reads them anyway; `refuse_boxes` says what is wrong.
    """
    boxes: object = obstacles
    if not isinstance(boxes, (list, tuple)) or not all(isinstance(o, Boxes) for o in boxes):
        raise InputError(
            f"obstacles must be a list of Boxes, as made by cca_core.geometry.boxes, was {str(boxes)[:60]}"
        )
    m = len(obstacles)
    fields = np.empty((5, m, *shape))
    for i, o in enumerate(obstacles):
        one = fields[:, i]
        try:
            one[0], one[1], one[2], one[3], one[4] = o.x, o.y, o.psi, o.length, o.width
        except (TypeError, ValueError, OverflowError):
            raise InputError(
                f"obstacles must have fields of real numbers with shape () or {shape}, was obstacle {i}"
            ) from None
    return fields.reshape(5, m, math.prod(shape[:-1]), shape[-1])


def refuse_boxes(boxes: Array) -> None:
    """Raise for obstacles that no vehicle can be."""
    if not is_finite(boxes):
        raise InputError("obstacles must be finite")
    raise InputError("obstacles must have lengths and widths that are not negative")


def check_edges(edges: tuple[ArrayLike, ArrayLike], shape: tuple[int, ...]) -> Array:
    """Return the right and left edge at each node [m], shape (2, bands, n)."""
    pair: object = edges
    if not isinstance(pair, (tuple, list)) or len(pair) != 2:
        raise InputError("corridor must be a pair of edges, right and left")
    full = np.empty((2, *shape))
    for row, edge in zip(full, pair, strict=True):
        try:
            row[...] = edge
        except (TypeError, ValueError, OverflowError):
            raise InputError(
                f"corridor must have edges of real numbers, one or one per node {shape}, "
                f"had shape {np.shape(edge)}"
            ) from None
    if np.isnan(full).any():
        raise InputError("corridor must not be NaN")
    if (full[0] > full[1]).any():
        raise InputError("corridor must be the right edge and then the left one: left is positive")
    return full.reshape(2, -1, shape[-1])
