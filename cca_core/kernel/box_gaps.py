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
    dx = max(abs(x) - half_length, 0.0)
    dy = max(abs(y) - half_width, 0.0)
    return dx * dx + dy * dy


def nearest_corner(
    x: Real, y: Real, c: Real, s: Real, length: Real, width: Real, own_length: Real, own_width: Real
) -> Real:
    """Smallest squared distance of the corners of a turned box at x, y from a box around the origin."""
    ax = c * length - s * width
    ay = s * length + c * width
    bx = c * length + s * width
    by = s * length - c * width
    return min(
        squared_distance(x + ax, y + ay, own_length, own_width),
        squared_distance(x - ax, y - ay, own_length, own_width),
        squared_distance(x + bx, y + by, own_length, own_width),
        squared_distance(x - bx, y - by, own_length, own_width),
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
    # b in the frame of a, and a in the frame of b
    x_b = dx * ax + dy * ay
    y_b = dy * ax - dx * ay
    x_a = -(dx * bx + dy * by)
    y_a = -(dy * bx - dx * by)
    along_a = abs(x_b) - length_a - (length_b * c + width_b * s)
    across_a = abs(y_b) - width_a - (length_b * s + width_b * c)
    along_b = abs(x_a) - length_b - (length_a * c + width_a * s)
    across_b = abs(y_a) - width_b - (length_a * s + width_a * c)
    separation = max(along_a, across_a, along_b, across_b)
    if not math.isfinite(along_a + across_a + along_b + across_b):  # NaN may be lost in a maximum
        return along_a + across_a + along_b + across_b
    if separation <= 0.0:
        return separation
    of_b = nearest_corner(x_b, y_b, turn_c, turn_s, length_b, width_b, length_a, width_a)
    of_a = nearest_corner(x_a, y_a, turn_c, -turn_s, length_a, width_a, length_b, width_b)
    squared = min(of_b, of_a)
    if squared < LARGE:
        return math.sqrt(squared)
    unit = 1.0 / separation
    of_b = nearest_corner(
        x_b * unit, y_b * unit, turn_c, turn_s,
        length_b * unit, width_b * unit, length_a * unit, width_a * unit,
    )  # fmt: skip
    of_a = nearest_corner(
        x_a * unit, y_a * unit, turn_c, -turn_s,
        length_a * unit, width_a * unit, length_b * unit, width_b * unit,
    )  # fmt: skip
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
