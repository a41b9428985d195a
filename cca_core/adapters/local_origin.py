"""A local origin for maps in large coordinates, such as those of UTM."""

from collections.abc import Callable
from decimal import Decimal

import numpy as np

from cca_core._checks import check_real, parse_real, shown
from cca_core.errors import InputError
from cca_core.vehicle import MAX_COORDINATE

__all__ = ["Move", "Origin", "check_origin", "find_origin", "move_to_origin"]

Origin = tuple[float, float]
Move = Callable[[str, str], tuple[str, str]]
"""Takes x and y of a position as a file has them, and returns them as they are to be read."""

_MAX_MIDDLE = 0.9 * MAX_COORDINATE  # of a map that keeps its coordinates [m]; the rest is left to drives
_MAX_POSITION = 1e9  # that a file may hold [m]
_GRID = 1000.0  # of origins [m]


def check_origin(origin: object) -> Origin:
    """Return a given origin."""
    if not isinstance(origin, tuple | list | np.ndarray) or len(origin) != 2:
        raise InputError(f"origin must be x and y, was {shown(origin)}")
    x, y = (
        check_real(f"{axis} of origin", value, ge=-_MAX_POSITION, le=_MAX_POSITION)
        for axis, value in zip("xy", origin, strict=True)
    )
    return x, y


def find_origin(x: float, y: float) -> Origin:
    """Return the origin for a map around a position [m]: 0, unless that is too far away."""
    if max(abs(x), abs(y)) <= _MAX_MIDDLE:
        return 0.0, 0.0
    return _GRID * round(x / _GRID), _GRID * round(y / _GRID)


def move_to_origin(visit: Callable[[Move], None], origin: object = None) -> Origin:
    """Move the positions of a file to an origin, by default that of their middle; return the origin.

    `visit` calls what it is given for each position and keeps what that returns.
    """
    if origin is None:
        found: list[tuple[float, float]] = []

        def collect(x: str, y: str) -> tuple[str, str]:
            pair = _number(x), _number(y)
            if pair[0] is not None and pair[1] is not None:
                found.append((pair[0], pair[1]))
            return x, y

        visit(collect)
        # the median: a position that is wrong does not move the others
        origin = find_origin(*np.median(found, axis=0).tolist()) if found else (0.0, 0.0)
    x_0, y_0 = check_origin(origin)
    if x_0 or y_0:
        visit(lambda x, y: (_less(x, x_0), _less(y, y_0)))
    return x_0, y_0


def _less(text: str, by: float) -> str:
    """Return the text of a number less another, without rounding; what is no position stays."""
    number = _number(text)
    if number is None:
        return text
    # a decimal cannot hold every number that a float takes for 0
    return str((Decimal(text.strip()) if number else 0) - Decimal(str(by)))


def _number(text: str) -> float | None:
    """Return the number of a text, if it can be a position."""
    number = parse_real(text)
    return None if number is None or not abs(number) <= _MAX_POSITION else number
