"""Distances of oriented boxes."""

import math
from typing import Annotated

from cca_core.kernel.types import Grid, Int, Real, Reals

__all__ = ["box_gap", "box_gaps", "oriented_box_gap"]

Row = Annotated[Reals, "n"]
Boxes = Annotated[Grid, "n", 5]
EgoBoxes = Annotated[Grid, "k", 5]

SMALL = 1e-280  # squares that have all digits
LARGE = 1e300


def scaled_norm(x: Real, y: Real) -> Real:
    """Length of a vector whose square overflows or has lost its digits."""
    if not abs(x) + abs(y) > 0.0:
        return abs(x) + abs(y)
    scale = max(abs(x), abs(y))
    if scale == math.inf:
        return scale
    a = x / scale
    b = y / scale
    return scale * math.sqrt(a * a + b * b)


def norm(x: Real, y: Real) -> Real:
    """Length of a vector; `math.hypot` has other bits in Python than in C."""
    squared = x * x + y * y
    return math.sqrt(squared) if SMALL < squared < LARGE else scaled_norm(x, y)


def squared_distance(x: Real, y: Real, half_length: Real, half_width: Real) -> Real:
    """Squared distance of a point from a box around the origin."""
    dx = abs(x) - half_length
    dy = abs(y) - half_width
    if dx > 0.0:
        return dx * dx + dy * dy if dy > 0.0 else dx * dx
    return dy * dy if dy > 0.0 else 0.0


def nearest_corner(
    near_x: Real, side_y: Real, side_x: Real, near_y: Real, half_length: Real, half_width: Real
) -> Real:
    """Smaller squared distance of the two corners that protrude most towards a box around the origin."""
    return min(
        squared_distance(near_x, side_y, half_length, half_width),
        squared_distance(side_x, near_y, half_length, half_width),
    )


def oriented_box_gap(
    dx: Real,
    dy: Real,
    ax: Real,
    ay: Real,
    bx: Real,
    by: Real,
    length_a: Real,
    width_a: Real,
    length_b: Real,
    width_b: Real,
) -> Real:
    """Signed distance of box b, at dx, dy from box a, from unit headings and half extents [m]."""
    turn_c = bx * ax + by * ay
    turn_s = by * ax - bx * ay
    c = abs(turn_c)
    s = abs(turn_s)
    # b in the frame of a, and a in the frame of b, each mirrored to lie ahead and to the left
    x_b = dx * ax + dy * ay
    y_b = dy * ax - dx * ay
    x_a = dx * bx + dy * by
    y_a = dy * bx - dx * by
    turn = turn_c * turn_s
    turn_b = 1.0 if turn * x_b * y_b >= 0.0 else -1.0
    turn_a = -1.0 if turn * x_a * y_a >= 0.0 else 1.0
    x_b = abs(x_b)
    y_b = abs(y_b)
    x_a = abs(x_a)
    y_a = abs(y_a)
    # each box protrudes most towards the other one, along and across, with one corner: its coordinate there
    near_x_b = x_b - (length_b * c + width_b * s)
    near_y_b = y_b - (length_b * s + width_b * c)
    near_x_a = x_a - (length_a * c + width_a * s)
    near_y_a = y_a - (length_a * s + width_a * c)
    along_a = near_x_b - length_a
    across_a = near_y_b - width_a
    along_b = near_x_a - length_b
    across_b = near_y_a - width_b
    total = along_a + across_a + along_b + across_b
    if not math.isfinite(total):  # NaN may be lost in a maximum
        return total
    separation = along_a
    if across_a > separation:
        separation = across_a
    if along_b > separation:
        separation = along_b
    if across_b > separation:
        separation = across_b
    if separation <= 0.0:
        return separation
    # and the other coordinate: if it lies next to that side, nothing is closer
    side_y_b = y_b - turn_b * (length_b * s - width_b * c)
    if separation == along_a and abs(side_y_b) <= width_a:
        return separation
    side_x_b = x_b - turn_b * (length_b * c - width_b * s)
    if separation == across_a and abs(side_x_b) <= length_a:
        return separation
    side_y_a = y_a - turn_a * (length_a * s - width_a * c)
    if separation == along_b and abs(side_y_a) <= width_b:
        return separation
    side_x_a = x_a - turn_a * (length_a * c - width_a * s)
    if separation == across_b and abs(side_x_a) <= length_b:
        return separation
    of_b = nearest_corner(near_x_b, side_y_b, side_x_b, near_y_b, length_a, width_a)
    of_a = nearest_corner(near_x_a, side_y_a, side_x_a, near_y_a, length_b, width_b)
    squared = min(of_b, of_a)
    if squared < LARGE:
        return math.sqrt(squared)
    unit = 1.0 / separation
    of_b = nearest_corner(
        near_x_b * unit, side_y_b * unit, side_x_b * unit, near_y_b * unit, length_a * unit, width_a * unit
    )
    of_a = nearest_corner(
        near_x_a * unit, side_y_a * unit, side_x_a * unit, near_y_a * unit, length_b * unit, width_b * unit
    )
    return separation * math.sqrt(min(of_b, of_a))


def box_gap(
    ax: Real,
    ay: Real,
    a_psi: Real,
    a_length: Real,
    a_width: Real,
    bx: Real,
    by: Real,
    b_psi: Real,
    b_length: Real,
    b_width: Real,
) -> Real:
    """Signed distance of two boxes from centers, headings and full extents [m]; NaN if one is not finite."""
    headings = 0.0 * a_psi + 0.0 * b_psi
    if math.isnan(headings):
        return headings
    return oriented_box_gap(
        bx - ax, by - ay, math.cos(a_psi), math.sin(a_psi), math.cos(b_psi), math.sin(b_psi),
        0.5 * a_length, 0.5 * a_width, 0.5 * b_length, 0.5 * b_width,
    )  # fmt: skip


def box_gaps(n: Int, k: Int, a: EgoBoxes, b: Boxes, gap: Row) -> None:
    """Signed distances of n boxes b from k boxes a, which repeat: x, y, heading, length, width of each."""
    j = 0
    for i in range(n):
        gap[i] = box_gap(
            a[j, 0], a[j, 1], a[j, 2], a[j, 3], a[j, 4], b[i, 0], b[i, 1], b[i, 2], b[i, 3], b[i, 4]
        )
        j += 1
        if j == k:
            j = 0
