"""On which side of whom: the corridors of all choices of sides, the most promising first."""

import itertools
from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array
from cca_core.baselines.methods.mpc.horizon import Horizon

__all__ = ["SideChoice", "side_choices"]

_MOST = 5  # others whose sides are all tried; farther ones are passed on the side of the route


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SideChoice:
    """A corridor for one choice of sides.

    Parameters
    ----------
    lower, upper : ndarray, shape (2, n + 1)
        Least and largest lateral coordinate of the middle of the ego's rear and front end [m].
    overlap : float
        By how much the bounds contradict each other at worst [m]; 0 if nowhere.
    """

    lower: Array
    upper: Array
    overlap: float


def side_choices(horizon: Horizon, s: Array, v: Array, d: float) -> list[SideChoice]:
    """Corridors past all others, one for each choice of sides.

    Parameters
    ----------
    horizon : Horizon
        Limits and all others.
    s : ndarray, shape (n + 1,)
        Where the ego will be along the route [m].
    v : ndarray, shape (n + 1,)
        Its speed then [m/s].
    d : float
        Its lateral coordinate now [m].

    Returns
    -------
    passages : list of Passage
        Those without contradiction, by growing effort; if there are none, the least contradictory one.
    """
    vehicle, n = horizon.vehicle, len(horizon.t)
    ends = s + np.array([[vehicle.rear], [vehicle.front]])
    lower, upper = np.full((2, n), horizon.edges[0]), np.full((2, n), horizon.edges[1])
    lower[:, -1] = np.maximum(lower[:, -1], horizon.final[0])
    upper[:, -1] = np.minimum(upper[:, -1], horizon.final[1])
    met: list[tuple[Array, float, float, tuple[bool, ...]]] = []
    for other, places in zip(horizon.others, horizon.places(), strict=True):
        half = other.half_length + horizon.clearance + 0.5 * horizon.step * np.abs(v - other.v_s)
        beside = np.abs(ends - places) <= np.maximum(half, 0.5 * vehicle.length)
        room = other.half_width + 0.5 * vehicle.width + horizon.clearance
        if not beside.any():
            continue
        left, right = other.d + room, other.d - room
        choices: tuple[bool, ...] = (True, False) if left <= upper[0, 0] else (False,)
        if right < lower[0, 0]:
            choices = tuple(c for c in choices if c) or (d >= other.d,)
        if beside[:, 0].any():
            choices = (d >= other.d,)
        if left < lower[0, 0] or right > upper[0, 0]:
            continue
        met.append((beside, left, right, choices))
    met.sort(key=lambda m: int(np.argmax(m[0].any(axis=0))))
    for i, (beside, left, right, choices) in enumerate(met):
        if i >= _MOST and len(choices) > 1:
            met[i] = beside, left, right, (abs(left) < abs(right),)
    found = []
    for sides in itertools.product(*(m[3] for m in met)):
        low, high = lower.copy(), upper.copy()
        for (beside, left, right, _), is_left in zip(met, sides, strict=True):
            if is_left:
                low[beside] = np.maximum(low[beside], left)
            else:
                high[beside] = np.minimum(high[beside], right)
        overlap = max(float((low - high)[:, 1:].max()), 0.0)
        both = max(float((low.max(axis=0) - high.min(axis=0))[1:].max()), 0.0)
        way = _nearest(low, high)
        effort = float(np.sum(np.diff(way, prepend=d) ** 2)) + 0.02 * float(np.sum(way**2))
        found.append(
            (
                overlap > 1e-9,
                overlap,
                effort + 10.0 * both,
                SideChoice(lower=low, upper=high, overlap=overlap),
            )
        )
    found.sort(key=lambda f: f[:3])
    free = [f[3] for f in found if not f[0]]
    return free or [found[0][3]]


def _nearest(lower: Array, upper: Array) -> Array:
    low, high = lower.max(axis=0), upper.min(axis=0)
    middle = 0.5 * (low + high)
    way: Array = np.where(low <= high, np.clip(0.0, low, np.maximum(low, high)), middle)
    return way
