"""Types of the kernel's Python, and the one function that it may call, other than those of `math`."""

import math
from typing import Protocol

Real = float
Int = int
Flag = bool


class Reals(Protocol):
    """Lent row of float64."""

    def __getitem__(self, at: int, /) -> float: ...
    def __setitem__(self, at: int, value: float, /) -> None: ...


class Ints(Protocol):
    """Lent row of int32."""

    def __getitem__(self, at: int, /) -> int: ...
    def __setitem__(self, at: int, value: int, /) -> None: ...


class Grid(Protocol):
    """Lent rows of float64, one behind the other."""

    def __getitem__(self, at: tuple[int, int], /) -> float: ...
    def __setitem__(self, at: tuple[int, int], value: float, /) -> None: ...


def floor_within(value: Real, low: Int, high: Int) -> Int:
    """Largest whole number up to a value, limited to [low, high]; `low` for NaN."""
    if not value >= low:
        return low
    return high if value >= high else math.floor(value)
