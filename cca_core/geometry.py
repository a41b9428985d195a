"""Angles, oriented boxes and the distance between them."""

import math
from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array

__all__ = ["Boxes", "box_gap", "boxes", "wrap_angle"]


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

    Examples
    --------
    >>> round(wrap_angle(3.5), 4)
    -2.7832
    """
    if isinstance(angle, np.ndarray):
        wrapped = (angle + np.pi) % (2.0 * np.pi) - np.pi
        return np.where(wrapped >= np.pi, -np.pi, wrapped)
    rest = math.remainder(angle, 2.0 * math.pi)
    return -math.pi if rest >= math.pi else rest


@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """Oriented rectangles, one or many; the fields broadcast against each other.

    Parameters
    ----------
    x, y : ndarray, shape (...)
        Centre of the box [m].
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

    def corners(self) -> Array:
        """Corners, counter-clockwise from the front left.

        Returns
        -------
        corners : ndarray, shape (..., 4, 2)
            Positions [m].
        """
        fields = (self.x, self.y, self.psi, self.length, self.width)
        x, y, psi, length, width = (np.asarray(f)[..., None] for f in np.broadcast_arrays(*fields))
        along, across = 0.5 * length * _ALONG, 0.5 * width * _ACROSS
        cos, sin = np.cos(psi), np.sin(psi)
        x, y = x + cos * along - sin * across, y + sin * along + cos * across
        return np.stack((x, y), axis=-1)


_ALONG = np.array([1.0, -1.0, -1.0, 1.0])
_ACROSS = np.array([1.0, 1.0, -1.0, -1.0])


def boxes(x: ArrayLike, y: ArrayLike, psi: ArrayLike, length: ArrayLike, width: ArrayLike) -> Boxes:
    """Make `Boxes` from anything array-like.

    Parameters
    ----------
    x, y : array_like, shape (...)
        Centre of the box [m].
    psi : array_like, shape (...)
        Heading [rad], counter-clockwise from +x.
    length, width : array_like, shape (...)
        Full extents along and across the heading [m].

    Returns
    -------
    boxes : Boxes
        The same values as float64 arrays.
    """
    return Boxes(*(np.asarray(value, dtype=np.float64) for value in (x, y, psi, length, width)))


def box_gap(a: Boxes, b: Boxes) -> Array:
    """Signed distance between oriented boxes.

    Parameters
    ----------
    a, b : Boxes
        Boxes that broadcast against each other.

    Returns
    -------
    gap : ndarray, shape (...)
        Distance of the closest points [m] where the boxes are apart; where they overlap, minus the
        shortest way to push them apart along an axis of either box [m].

    Notes
    -----
    Two convex polygons that are apart have their closest points at a corner of one of them, so the eight
    corner-to-box distances suffice. Overlap is decided by the four separating axes.

    Examples
    --------
    >>> float(box_gap(boxes(0, 0, 0, 4, 2), boxes(7, 0, 0, 4, 2)))
    3.0
    """
    dx, dy = b.x - a.x, b.y - a.y
    cos_a, sin_a, cos_b, sin_b = np.cos(a.psi), np.sin(a.psi), np.cos(b.psi), np.sin(b.psi)
    # centre of the other box in each box's own frame, and the rotation between the two
    ax, ay = cos_a * dx + sin_a * dy, cos_a * dy - sin_a * dx
    bx, by = -(cos_b * dx + sin_b * dy), -(cos_b * dy - sin_b * dx)
    cos, sin = cos_a * cos_b + sin_a * sin_b, cos_a * sin_b - sin_a * cos_b
    la, wa, lb, wb = 0.5 * a.length, 0.5 * a.width, 0.5 * b.length, 0.5 * b.width
    c, s = np.abs(cos), np.abs(sin)
    separation = np.maximum(
        np.maximum(np.abs(ax) - la - (lb * c + wb * s), np.abs(ay) - wa - (lb * s + wb * c)),
        np.maximum(np.abs(bx) - lb - (la * c + wa * s), np.abs(by) - wb - (la * s + wa * c)),
    )
    distance = np.minimum(
        _corners_to_box(ax, ay, cos, sin, lb, wb, la, wa),
        _corners_to_box(bx, by, cos, -sin, la, wa, lb, wb),
    )
    gap: Array = np.where(separation > 0.0, distance, separation)
    return gap


def _corners_to_box(
    x: Array,
    y: Array,
    cos: Array,
    sin: Array,
    half_l: Array,
    half_w: Array,
    box_l: Array,
    box_w: Array,
) -> Array:
    """Least distance from the corners of a box at (x, y) to a box at the origin, axes aligned with it."""
    along_x, along_y = half_l * cos, half_l * sin
    across_x, across_y = half_w * sin, half_w * cos
    # the four corners stand in front of all other axes
    corner_x = np.stack(
        (
            x + (along_x - across_x),
            x + (along_x + across_x),
            x - (along_x + across_x),
            x - (along_x - across_x),
        )
    )
    corner_y = np.stack(
        (
            y + (along_y + across_y),
            y + (along_y - across_y),
            y - (along_y - across_y),
            y - (along_y + across_y),
        )
    )
    out_x = np.maximum(np.abs(corner_x) - box_l, 0.0)
    out_y = np.maximum(np.abs(corner_y) - box_w, 0.0)
    distance: Array = np.sqrt((out_x * out_x + out_y * out_y).min(axis=0))
    return distance
