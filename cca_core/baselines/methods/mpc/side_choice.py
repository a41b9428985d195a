"""Sides on which the other vehicles are passed: the corridor of each choice, least effort first."""

import itertools
from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array, Mask
from cca_core.baselines.methods.mpc.horizon import Horizon


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SideChoice:
    """Corridor of one choice of sides."""

    lower: Array  # (2, n + 1): bounds of the center line at the ego's rear and front end [m]
    upper: Array
    overlap: float  # largest contradiction of the bounds [m]


@dataclass(frozen=True, slots=True)
class _Passage:
    """A vehicle alongside the ego at some nodes, with the sides on which it may be passed."""

    alongside: Mask  # (2, n + 1): of the rear and front end
    left: float  # smallest offset that passes it on the left [m]
    right: float  # largest offset that passes it on the right [m]
    sides: tuple[bool, ...]  # True is left


def side_choices(horizon: Horizon, s: Array, v: Array, d: float, max_vehicles: int = 5) -> list[SideChoice]:
    """Corridors without contradiction, least effort first; if none exists, the least contradictory one."""
    # The ego is at stations `s` (n + 1,) with speeds `v`, and its lateral offset is `d` now. Beyond
    # `max_vehicles`, vehicles are passed on the side of the route.
    n = len(horizon.t)
    lower, upper = np.full((2, n), horizon.edges[0]), np.full((2, n), horizon.edges[1])
    lower[:, -1] = np.maximum(lower[:, -1], horizon.final_d[0])
    upper[:, -1] = np.minimum(upper[:, -1], horizon.final_d[1])
    passages = _passages(horizon, s, v, d)
    for i, passage in enumerate(passages):
        if i >= max_vehicles and len(passage.sides) > 1:
            nearest = (abs(passage.left) < abs(passage.right),)
            passages[i] = _Passage(passage.alongside, passage.left, passage.right, nearest)
    found = []
    for sides in itertools.product(*(passage.sides for passage in passages)):
        low, high = lower.copy(), upper.copy()
        for passage, is_left in zip(passages, sides, strict=True):
            at = passage.alongside
            if is_left:
                low[at] = np.maximum(low[at], passage.left)
            else:
                high[at] = np.minimum(high[at], passage.right)
        overlap = max(float((low - high)[:, 1:].max()), 0.0)
        choice = SideChoice(lower=low, upper=high, overlap=overlap)
        found.append((overlap > 1e-9, overlap, _effort(low, high, d), choice))
    found.sort(key=lambda f: f[:3])
    free = [choice for contradicts, _, _, choice in found if not contradicts]
    return free or [found[0][3]]


def _passages(horizon: Horizon, s: Array, v: Array, d: float) -> list[_Passage]:
    """Vehicles that the ego must pass, in the order in which it reaches them."""
    vehicle = horizon.vehicle
    ends = s + np.array([[vehicle.rear], [vehicle.front]])
    (rightmost, leftmost), found = horizon.edges, []
    for other, stations in zip(horizon.others, horizon.stations(), strict=True):
        half = other.half_length + horizon.clearance + 0.5 * horizon.step * np.abs(v - other.v_s)
        alongside = np.abs(ends - stations) <= np.maximum(half, 0.5 * vehicle.length)
        if not alongside.any():
            continue
        lateral = other.half_width + 0.5 * vehicle.width + horizon.clearance
        left, right = other.d + lateral, other.d - lateral
        if left < rightmost or right > leftmost:
            continue
        sides: tuple[bool, ...] = (True, False) if left <= leftmost else (False,)
        if right < rightmost:
            sides = tuple(side for side in sides if side) or (d >= other.d,)
        if alongside[:, 0].any():
            sides = (d >= other.d,)
        found.append(_Passage(alongside, left, right, sides))
    return sorted(found, key=lambda passage: int(np.argmax(passage.alongside.any(axis=0))))


def _effort(lower: Array, upper: Array, d: float) -> float:
    """Motion that a corridor requires, from the present offset."""
    low, high = lower.max(axis=0), upper.min(axis=0)
    contradiction = max(float((low - high)[1:].max()), 0.0)
    middle = 0.5 * (low + high)
    # offset nearest to the route
    offset: Array = np.where(low <= high, np.clip(0.0, low, np.maximum(low, high)), middle)
    changes = float(np.sum(np.diff(offset, prepend=d) ** 2))
    return changes + 0.02 * float(np.sum(offset**2)) + 10.0 * contradiction
