"""Angles, oriented boxes and the distance between them."""

import math
from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, as_array, explained
from cca_core._repr import short_repr
from cca_core.kernel import bind
from cca_core.kernel.box_gaps import box_gaps

__all__ = ["Boxes", "box_gap", "boxes", "wrap_angle"]

_box_gaps = bind(box_gaps)
# signs along and across of the corners, counter-clockwise from the front left
_CORNERS = np.array([[1.0, -1.0, -1.0, 1.0], [1.0, 1.0, -1.0, -1.0]])


@overload
def wrap_angle(angle: float) -> float: ...
@overload
def wrap_angle(angle: Array) -> Array: ...
def wrap_angle(angle: float | Array) -> float | Array:
    """Wrap an angle to [-pi, pi).

    Parameters
    ----------
    angle : float or ndarray
        Angle [rad], counter-clockwise positive.

    Returns
    -------
    wrapped : float or ndarray
        The same direction in [-pi, pi) [rad].

    Raises
    ------
    InputError
        If the angle is a plain number that is not finite.

    Examples
    --------
    >>> round(wrap_angle(3.5), 4)
    -2.7832
    """
    if isinstance(angle, np.ndarray):
        wrapped = (angle + np.pi) % (2.0 * np.pi) - np.pi
        return np.where(wrapped >= np.pi, -np.pi, wrapped)
    try:
        rest = math.remainder(angle, 2.0 * math.pi)
    except (TypeError, ValueError, OverflowError) as error:
        raise explained(error, {"angle": angle}) from None
    return -math.pi if rest >= math.pi else rest


@overload
def quintic_step(z: float, height: float = 1.0) -> float: ...
@overload
def quintic_step(z: Array, height: float = 1.0) -> Array: ...
def quintic_step(z: float | Array, height: float = 1.0) -> float | Array:
    """Step from 0 at z = 0 to `height` at z = 1 whose slope and curvature are zero at both ends."""
    return height * z**3 * (10.0 - 15.0 * z + 6.0 * z * z)


def arc_length(points: Array) -> Array:
    """Length (n,) of the polyline through points (n, 2) up to each of them."""
    return np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))


QUINTIC_PEAK = 5.7735
"""Largest second derivative of the quintic step [-]."""


@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """Oriented rectangles; the fields broadcast against each other.

    Parameters
    ----------
    x, y : ndarray, shape (...)
        Center of the box [m].
    psi : ndarray, shape (...)
        Heading of its long axis [rad], counter-clockwise from +x.
    length, width : ndarray, shape (...)
        Full extents along and across the heading [m].
    """

    x: Array
    y: Array
    psi: Array
    length: Array
    width: Array

    __repr__ = short_repr

    def corners(self) -> Array:
        """Corners, counter-clockwise from the front left.

        Returns
        -------
        corners : ndarray, shape (..., 4, 2)
            Positions [m].
        """
        fields = (self.x, self.y, self.psi, self.length, self.width)
        x, y, psi, length, width = (np.asarray(f)[..., None] for f in np.broadcast_arrays(*fields))
        along, across = 0.5 * length * _CORNERS[0], 0.5 * width * _CORNERS[1]
        cos, sin = np.cos(psi), np.sin(psi)
        x, y = x + cos * along - sin * across, y + sin * along + cos * across
        return np.stack((x, y), axis=-1)


def boxes(x: ArrayLike, y: ArrayLike, psi: ArrayLike, length: ArrayLike, width: ArrayLike) -> Boxes:
    """Make `Boxes` from array-like values.

    Parameters
    ----------
    x, y : array_like, shape (...)
        Center of the box [m].
    psi : array_like, shape (...)
        Heading [rad], counter-clockwise from +x.
    length, width : array_like, shape (...)
        Full extents along and across the heading [m].

    Returns
    -------
    boxes : Boxes
        The same values as float64 arrays.

    Raises
    ------
    InputError
        If a value is no array of real numbers.
    """
    named = {"x": x, "y": y, "psi": psi, "length": length, "width": width}
    return Boxes(*(as_array(name, value) for name, value in named.items()))


def box_gap(a: Boxes, b: Boxes) -> Array:
    """Signed distance between oriented boxes.

    Parameters
    ----------
    a, b : Boxes
        Boxes that broadcast against each other.

    Returns
    -------
    gap : ndarray, shape (...)
        Distance of the closest points [m]. For boxes that overlap it is negative: the least displacement
        along an axis of either box that separates them. It is NaN for a box that is not finite.

    Notes
    -----
    The closest points of two separate convex polygons include a corner of one of them, so the eight
    distances from corner to box suffice. The four separating axes decide on overlap.

    Examples
    --------
    >>> float(box_gap(boxes(0, 0, 0, 4, 2), boxes(7, 0, 0, 4, 2)))
    3.0
    """
    first, second = _rows(a), _rows(b)
    shape = np.broadcast_shapes(first.shape, second.shape)
    one, other = (
        np.ascontiguousarray(np.broadcast_to(rows, shape)).reshape(-1, 5) for rows in (first, second)
    )
    gap = np.empty(shape[:-1])
    _box_gaps(len(one), len(one), one, other, gap.reshape(-1))
    return gap


def _rows(boxes: Boxes) -> Array:
    """Boxes as the kernel takes them, shape (..., 5)."""
    fields = (boxes.x, boxes.y, boxes.psi, boxes.length, boxes.width)
    rows = np.empty((*np.broadcast_shapes(*map(np.shape, fields)), 5))
    for i, field in enumerate(fields):
        rows[..., i] = field
    return rows
