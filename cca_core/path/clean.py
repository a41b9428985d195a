"""Cleaning of recorded routes for `fit_path`, with a report of every change."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, Index, Mask, check_array, check_points, check_real
from cca_core.errors import InputError
from cca_core.path.stationary import slow_rows, thinned

_CHANGES = ("duplicates", "dropped", "reordered", "gaps", "isolated", "reversals", "stationary")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CleaningReport:
    """Changes made by `clean_route`, as rows of its input.

    Parameters
    ----------
    duplicates : ndarray of int, shape (n_duplicates,)
        Rows merged with the row before, at a distance below `min_spacing`.
    dropped : ndarray of int, shape (n_dropped,)
        Rows dropped because of a jump or a zig-zag.
    reordered : ndarray of int, shape (n_reordered,)
        Rows swapped with the row behind.
    gaps : ndarray of int, shape (n_gaps,)
        Rows after which a new part starts.
    isolated : ndarray of int, shape (n_isolated,)
        Rows dropped because they are alone between two gaps.
    reversals : ndarray of int, shape (n_reversals,)
        Rows preserved although the route turns back there: no single point causes it.
    stationary : ndarray of int, shape (n_stationary,)
        Rows dropped because the receiver was stationary or creeping; one row of each place stays.
    closed : bool
        Whether the route is one part that returns to its start.
    """

    duplicates: Index
    dropped: Index
    reordered: Index
    gaps: Index
    isolated: Index
    reversals: Index
    stationary: Index
    closed: bool

    def __repr__(self) -> str:
        found = [f"{name} {_rows(getattr(self, name))}" for name in _CHANGES if len(getattr(self, name))]
        return f"CleaningReport({'; '.join(found) or 'nothing changed'}{'; closed' if self.closed else ''})"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CleanedRoute:
    """A route in parts that `fit_path` accepts.

    Parameters
    ----------
    parts : tuple of ndarray, shape (n, 2) each
        Positions [m] of each part in driving order, read-only.
    rows : tuple of ndarray of int, shape (n,) each
        Row of the input of each position.
    report : CleaningReport
        Rows that were merged, dropped, swapped and split.
    """

    parts: tuple[Array, ...]
    rows: tuple[Index, ...]
    report: CleaningReport

    def __repr__(self) -> str:
        counts = ", ".join(str(len(part)) for part in self.parts[:8])
        more = ", ..." if len(self.parts) > 8 else ""
        return f"CleanedRoute({len(self.parts)} parts of {counts}{more} points, {self.report!r})"


def clean_route(
    xy: ArrayLike,
    *,
    t: ArrayLike | None = None,
    max_gap: float = 500.0,
    min_spacing: float = 0.05,
    max_turn: float = math.radians(100.0),
) -> CleanedRoute:
    """Merge, swap, drop and split the points of a recorded route.

    Parameters
    ----------
    xy : array_like, shape (n, 2)
        Positions [m], roughly in driving order.
    t : array_like, shape (n,), optional
        Times of the positions [s]. Rows slower than 0.5 m/s are those of a stationary receiver.
    max_gap : float
        A longer distance between neighbors starts a new part [m].
    min_spacing : float
        A point closer than this to the point before is a duplicate [m].
    max_turn : float
        A larger change of direction at one point is a defect of the recording [rad].

    Returns
    -------
    route : CleanedRoute
        The parts, of at least two points each, and the report.

    Raises
    ------
    InputError
        If fewer than two different points are given, or an argument is out of range.

    Notes
    -----
    If the route turns by more than `max_turn`, the function makes the smallest change that leaves fewer such
    turns: it swaps two neighbors, or drops one or two points. If no change helps, for example because the car
    reversed, the point stays and is reported as a reversal. Smaller turns are left to the smoothing of
    `fit_path`.

    A receiver is also stationary or creeping where five points in a row cover twice the distance between
    the first and the last, with sharp turns to both sides. Of such points one stays for each three median
    steps of distance. Cleaning a part again changes nothing. The cost is linear in n.

    Examples
    --------
    >>> route = clean_route([[0, 0], [10, 0], [10, 0], [30, 0], [20, 0], [40, 0], [50, 0]])
    >>> route
    CleanedRoute(1 parts of 6 points, CleaningReport(duplicates 1 [2]; reordered 1 [3]))
    """
    points = check_points("xy", xy, 2)
    max_gap = check_real("max_gap", max_gap, gt=0.0)
    min_spacing = check_real("min_spacing", min_spacing, ge=0.0, le=max_gap)
    max_turn = check_real("max_turn", max_turn, gt=0.5 * math.pi, le=math.pi)
    slow = np.zeros(len(points), dtype=bool)
    if t is not None:
        slow = slow_rows(points, check_array("t", t, (len(points),)))
    cleaner = _Cleaner(points, slow, max_gap, min_spacing, max_turn)
    rows = cleaner.clean(list(range(len(points))))
    if not rows:
        raise InputError("xy must have two different points within max_gap of each other")
    parts = tuple(_frozen(points[part]) for part in rows)
    log = {name: _frozen(np.array(sorted(set(found)), dtype=np.intp)) for name, found in cleaner.log.items()}
    report = CleaningReport(closed=len(parts) == 1 and _is_closed(parts[0], max_turn), **log)
    return CleanedRoute(parts=parts, rows=tuple(_frozen(np.array(part)) for part in rows), report=report)


class _Cleaner:
    """Implementation of `clean_route` on lists of rows."""

    def __init__(
        self, points: Array, slow: Mask, max_gap: float, min_spacing: float, max_turn: float
    ) -> None:
        self._points, self._slow = points, slow
        self._x, self._y = points.T.tolist()
        self._max_gap, self._min_spacing, self._max_turn = max_gap, min_spacing, max_turn
        self.log: dict[str, list[int]] = {name: [] for name in _CHANGES}

    def clean(self, rows: list[int]) -> list[list[int]]:
        """Clean one part until nothing changes, and split it at its gaps."""
        before: list[int] = []
        while rows != before:
            before, rows = rows, self._straighten(self._thin(self._merge(rows)))
        ends = [i for i in range(1, len(rows)) if self._chord(rows[i - 1], rows[i]) > self._max_gap]
        if not ends:
            if len(rows) < 2:
                self.log["isolated"] += rows
                return []
            self.log["reversals"] += [rows[i] for i in range(1, len(rows) - 1) if self._turns(rows, i)]
            return [rows]
        self.log["gaps"] += [rows[i - 1] for i in ends]
        borders = zip([0, *ends], [*ends, len(rows)], strict=True)
        return [part for first, last in borders for part in self.clean(rows[first:last])]

    def _merge(self, rows: list[int]) -> list[int]:
        kept = rows[:1]
        for row in rows[1:]:
            chord = self._chord(kept[-1], row)
            if chord < self._min_spacing or chord == 0.0:
                self.log["duplicates"].append(row)
            else:
                kept.append(row)
        return kept

    def _thin(self, rows: list[int]) -> list[int]:
        """Leave one row of each place where the receiver was stationary."""
        index = np.array(rows)
        kept = thinned(self._points[index], self._slow[index])
        self.log["stationary"] += index[~kept].tolist()
        return [int(row) for row in index[kept]]

    def _straighten(self, rows: list[int]) -> list[int]:
        """Repair sharp turns in driving order if a small change helps."""
        done: list[int] = []  # the rows ahead are stored in reverse, so that both ends are cheap
        ahead = rows[::-1]
        while ahead:
            done.append(ahead.pop())
            if len(done) < 3 or not self._turns(done, len(done) - 2):
                continue
            # three points behind the turn and four ahead show the effect of a change
            back, front = done[-5:], [ahead.pop() for _ in range(min(4, len(ahead)))][::-1]
            del done[-5:]
            window = back + front[::-1]
            better = self._repair(window, len(back) - 2, at_start=not done, at_end=not ahead)
            if better is None:
                done += back
                ahead += front
            else:
                self.log["dropped"] += [row for row in window if row not in better]
                self.log["reordered"] += [row for k, row in enumerate(better[1:]) if row < better[k]]
                ahead += better[::-1]
        return done

    def _repair(self, window: list[int], i: int, at_start: bool, at_end: bool) -> list[int] | None:
        """Find the change around index i with the fewest sharp turns; None if no change reduces them."""
        n = len(window)
        changes = []
        for k in (i - 1, i):
            if 0 <= k < n - 1:
                changes.append((*range(k), k + 1, k, *range(k + 2, n)))
        for dropped in ((i,), (i + 1,), (i - 1,), (i, i + 1), (i - 1, i)):
            changes.append(tuple(k for k in range(n) if k not in dropped))
        now, best, best_rows = self._score(window), (math.inf, math.inf), None
        for change in changes:
            # points next to the ends of the window must stay
            if (not at_start and change[:2] != (0, 1)) or (not at_end and change[-2:] != (n - 2, n - 1)):
                continue
            rows = [window[k] for k in change]
            score = (self._score(rows), self._length(rows) + (n - len(rows)) * 1e-9)
            if len(rows) >= 2 and score[0] < now and score[0] < best[0]:
                best, best_rows = score, rows
        return best_rows

    def _score(self, rows: list[int]) -> int:
        return sum(self._turns(rows, i) for i in range(1, len(rows) - 1))

    def _length(self, rows: list[int]) -> float:
        return sum(self._chord(a, b) for a, b in pairwise(rows))

    def _chord(self, i: int, j: int) -> float:
        return math.hypot(self._x[j] - self._x[i], self._y[j] - self._y[i])

    def _turns(self, rows: list[int], i: int) -> bool:
        a, b, c = rows[i - 1 : i + 2]
        x, y = self._x, self._y
        ux, uy, vx, vy = x[b] - x[a], y[b] - y[a], x[c] - x[b], y[c] - y[b]
        return abs(math.atan2(ux * vy - uy * vx, ux * vx + uy * vy)) > self._max_turn


def _is_closed(part: Array, max_turn: float) -> bool:
    steps = np.diff(part, axis=0)
    chords = np.hypot(*steps.T)
    gap = np.hypot(*(part[0] - part[-1]))
    if len(part) < 4 or gap > 3.0 * np.median(chords) or chords.sum() < 20.0:
        return False
    return bool(steps[-1] @ steps[0] >= math.cos(max_turn) * chords[-1] * chords[0])


def _rows(rows: Index) -> str:
    shown = ", ".join(map(str, rows[:6].tolist()))
    return f"{len(rows)} [{shown}{', ...' if len(rows) > 6 else ''}]"


def _frozen(array: Any) -> Any:
    array.setflags(write=False)
    return array
