"""One lane of a road, of constant or varying width."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import check_array, check_real, shown
from cca_core.errors import InputError

__all__ = ["Lane"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Lane:
    """One lane of a road.

    Parameters
    ----------
    d : float
        Lateral offset of its center line [m], left of the route positive.
    width : float
        Width [m].
    direction : int
        Direction of travel [-]: 1 along the route, -1 against it.
    boundaries : sequence of tuple of float
        Station, lateral offset of the right and of the left lane boundary [m] in each row, linear between
        stations. The lane begins at the first station and ends at the last one. `d` and `width` are then
        nominal. By default the lane is as long as the road and does not vary.

    Raises
    ------
    InputError
        If a value is not finite, the width is not positive, or the direction is neither 1 nor -1. If
        `boundaries` has fewer than two rows, its stations do not increase, a right boundary is left of the
        left one, or the lane has no width at all.

    See Also
    --------
    Lane.from_boundaries : a lane that begins, ends or changes its width.
    """

    d: float
    width: float = 3.5
    direction: int = 1
    boundaries: tuple[tuple[float, float, float], ...] = ()

    def __post_init__(self) -> None:
        check_real("d", self.d)
        check_real("width", self.width, gt=0.0)
        if self.direction not in (1, -1):
            raise InputError(f"direction must be 1 or -1, was {shown(self.direction)}")
        object.__setattr__(self, "boundaries", _check_boundaries(self.boundaries))

    @classmethod
    def from_boundaries(cls, boundaries: ArrayLike, direction: int = 1) -> Self:
        """Make a lane that begins, ends, or changes its width.

        Parameters
        ----------
        boundaries : array_like, shape (n, 3)
            Station, lateral offset of the right and of the left lane boundary [m], as for `Lane`.
        direction : int
            Direction of travel [-]: 1 along the route, -1 against it.

        Returns
        -------
        lane : Lane
            Its `d` and `width` are those where it is widest.

        Raises
        ------
        InputError
            As for `Lane`.

        Examples
        --------
        >>> lane = Lane.from_boundaries([(0.0, 1.75, 5.25), (200.0, 1.75, 5.25), (260.0, 1.75, 1.75)])
        >>> lane.width, lane.end, lane.bounds_at(230.0)
        (3.5, 260.0, (1.75, 3.5))
        """
        rows = _check_boundaries(boundaries)
        if not rows:
            raise InputError("boundaries must have at least two rows, had 0")
        _, right, left = max(rows, key=lambda row: row[2] - row[1])
        return cls(d=0.5 * (right + left), width=left - right, direction=direction, boundaries=rows)

    @property
    def right(self) -> float:
        """Lateral offset of the right lane boundary [m]; nominal if it varies."""
        return self.d - 0.5 * self.width

    @property
    def left(self) -> float:
        """Lateral offset of the left lane boundary [m]; nominal if it varies."""
        return self.d + 0.5 * self.width

    @property
    def start(self) -> float:
        """Station at which the lane begins [m]; -inf if it is as long as the road."""
        return self.boundaries[0][0] if self.boundaries else -math.inf

    @property
    def end(self) -> float:
        """Station at which the lane ends [m]; inf if it is as long as the road."""
        return self.boundaries[-1][0] if self.boundaries else math.inf

    def bounds_at(self, s: float) -> tuple[float, float] | None:
        """Lane boundaries at a station.

        Parameters
        ----------
        s : float
            Station [m].

        Returns
        -------
        bounds : tuple of float or None
            Lateral offsets of the right and the left lane boundary [m]; None where the lane does not exist.
        """
        if not self.boundaries:
            return self.right, self.left
        if not self.start <= s <= self.end:
            return None
        at, right, left = np.array(self.boundaries).T
        return float(np.interp(s, at, right)), float(np.interp(s, at, left))

    def inner_bounds(self, start: float, end: float) -> tuple[float, float] | None:
        """Lane boundaries within which the lane is for a whole stretch.

        Parameters
        ----------
        start, end : float
            Stations [m].

        Returns
        -------
        bounds : tuple of float or None
            Largest offset of the right and least of the left lane boundary [m]; None if the lane does not
            exist over the whole stretch.
        """
        ends = self.bounds_at(start), self.bounds_at(end)
        if ends[0] is None or ends[1] is None:
            return None
        rows = [*ends, *(row[1:] for row in self.boundaries if start < row[0] < end)]
        return max(row[0] for row in rows if row), min(row[1] for row in rows if row)

    @property
    def outer_bounds(self) -> tuple[float, float]:
        """Least offset of the right and largest of the left lane boundary [m]."""
        if not self.boundaries:
            return self.right, self.left
        return min(row[1] for row in self.boundaries), max(row[2] for row in self.boundaries)


def _check_boundaries(boundaries: ArrayLike) -> tuple[tuple[float, float, float], ...]:
    """Return the rows of boundaries."""
    if isinstance(boundaries, Sequence) and not boundaries:
        return ()
    rows = check_array("boundaries", boundaries, (None, 3))
    if len(rows) < 2:
        raise InputError(f"boundaries must have at least two rows, had {len(rows)}")
    if not (np.diff(rows[:, 0]) > 0.0).all():
        raise InputError("stations of boundaries must increase, did not")
    width = rows[:, 2] - rows[:, 1]
    if width.min() < 0.0 or width.max() <= 0.0:
        word = "at least 0 and somewhere positive"
        raise InputError(f"width between boundaries must be {word}, was {width.min():g} to {width.max():g} m")
    return tuple((float(s), float(right), float(left)) for s, right, left in rows.tolist())
