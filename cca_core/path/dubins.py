"""Paths of arcs and lines between two poses (Dubins, 1957)."""

import math
from collections.abc import Iterator

import numpy as np

from cca_core._checks import Array

Pose = tuple[float, float, float]

__all__ = ["dubins_paths"]


def dubins_paths(first: Pose, last: Pose, radius: float, spacing: float) -> Iterator[Array]:
    """Positions on every arc-line-arc and arc-arc-arc path between two poses, shape (n, 2) each."""
    for turns, lengths in _words(first, last, radius):
        pieces = [np.array([first[:2]])]
        x, y, psi = first
        for turn, length in zip(turns, lengths, strict=True):
            step = np.linspace(0.0, length, max(2, math.ceil(length / spacing) + 1))[1:]
            if turn:
                heading = psi + turn * step / radius
                side = turn * radius
                piece = np.column_stack(
                    (
                        x + side * (np.sin(heading) - math.sin(psi)),
                        y - side * (np.cos(heading) - math.cos(psi)),
                    )
                )
                psi += turn * length / radius
            else:
                piece = np.column_stack((x + step * math.cos(psi), y + step * math.sin(psi)))
            x, y = piece[-1].tolist()
            if length > 1e-6:
                pieces.append(piece)
        yield np.vstack(pieces)


def _words(
    first: Pose, last: Pose, radius: float
) -> Iterator[tuple[tuple[int, int, int], tuple[float, float, float]]]:
    """Directions (left 1, right -1, straight 0) and lengths of the three pieces of each path."""
    for a in (1, -1):
        for c in (1, -1):
            # centers of the first and the last circle
            x_a, y_a = first[0] - a * radius * math.sin(first[2]), first[1] + a * radius * math.cos(first[2])
            x_c, y_c = last[0] - c * radius * math.sin(last[2]), last[1] + c * radius * math.cos(last[2])
            distance, bearing = math.hypot(x_c - x_a, y_c - y_a), math.atan2(y_c - y_a, x_c - x_a)
            if a == c:
                psi, straight = bearing, distance
            elif distance >= 2.0 * radius:
                psi = bearing + a * math.asin(2.0 * radius / distance)
                straight = math.sqrt(distance**2 - 4.0 * radius**2)
            else:
                continue
            yield (
                (a, 0, c),
                (_arc(a, first[2], psi, radius), straight, _arc(c, psi, last[2], radius)),
            )
            if a == c and distance < 4.0 * radius:
                angle = math.acos(distance / (4.0 * radius))
                for side in (1, -1):
                    # headings where the middle circle touches the first and the last one
                    enter = bearing + side * angle + 0.5 * math.pi * a
                    leave = bearing + math.pi - side * angle + 0.5 * math.pi * a
                    yield (
                        (a, -a, a),
                        (
                            _arc(a, first[2], enter, radius),
                            _arc(-a, enter, leave, radius),
                            _arc(a, leave, last[2], radius),
                        ),
                    )


def _arc(turn: int, start: float, end: float, radius: float) -> float:
    """Length of an arc between two headings."""
    angle = (turn * (end - start)) % (2.0 * math.pi)
    return 0.0 if 2.0 * math.pi - angle < 1e-6 else angle * radius
