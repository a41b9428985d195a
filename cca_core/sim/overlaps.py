"""Overlaps of road users: they do not collide with each other, so a run with one means little."""

import warnings
from collections.abc import Sequence

import numpy as np

from cca_core._checks import Array
from cca_core.geometry import Boxes, box_gap
from cca_core.sim.scenarios.road_user import RoadUser

Overlap = tuple[float, str, str, float]
"""Time [s], id of the road user that drives into another, id of the other, relative speed [m/s]."""

_MIN_DEPTH = 1e-3  # of an overlap; bodies that touch are apart but for rounding [m]


def find_overlaps(t: Array, users: Sequence[RoadUser], rows: Array) -> tuple[Overlap, ...]:
    """Return the first overlap of each pair of road users, in order of time.

    Rows are x, y [m], psi [rad] and speed [m/s] by cycle and road user, NaN while one is not present.
    """
    radii = np.array([0.5 * np.hypot(user.length, user.width) for user in users])
    found = []
    for i in range(len(users) - 1):
        x, y = np.moveaxis(rows[:, i + 1 :, :2] - rows[:, i : i + 1, :2], 2, 0)
        near = x * x + y * y < (radii[i] + radii[i + 1 :]) ** 2  # else certainly apart
        for j in (np.flatnonzero(near.any(axis=0)) + i + 1).tolist():
            cycles = np.flatnonzero(near[:, j - i - 1])
            gaps = box_gap(_bodies(users[i], rows[cycles, i]), _bodies(users[j], rows[cycles, j]))
            inside = cycles[gaps < -_MIN_DEPTH]
            if len(inside):
                found.append((int(inside[0]), i, j))
    return tuple(_overlap(float(t[k]), users[i], users[j], rows[k, [i, j]]) for k, i, j in sorted(found))


def _bodies(user: RoadUser, rows: Array) -> Boxes:
    return Boxes(rows[:, 0], rows[:, 1], rows[:, 2], np.array(user.length), np.array(user.width))


def _overlap(t: float, one: RoadUser, other: RoadUser, rows: Array) -> Overlap:
    xy, velocity = rows[:, 0] + 1j * rows[:, 1], rows[:, 3] * np.exp(1j * rows[:, 2])
    # the one that is faster in the direction of the other drives into it
    approach = (velocity * np.conj(xy[::-1] - xy)).real
    ids = (one.id, other.id) if approach[0] >= approach[1] else (other.id, one.id)
    return t, *ids, float(abs(velocity[0] - velocity[1]))


def describe_overlap(overlap: Overlap) -> str:
    """State which road user drives into which."""
    t, user_id, other_id, _ = overlap
    if t == 0.0:
        return f"{user_id} and {other_id} are inside each other from the start"
    return f"{user_id} drives into {other_id} at {t:.1f} s"


def explain_overlaps(overlaps: Sequence[Overlap]) -> str:
    """State the first overlap of a run and what it means; empty without one."""
    if not overlaps:
        return ""
    pairs = "; 1 more such pair" if len(overlaps) == 2 else f"; {len(overlaps) - 1} more such pairs"
    return (
        f"{describe_overlap(overlaps[0])}: road users do not collide, so what follows means little"
        f"{pairs if len(overlaps) > 1 else ''}"
    )


def warn_of_overlaps(overlaps: Sequence[Overlap]) -> None:
    """Warn of the first overlap of a run, for the caller of the function that drove it."""
    if overlaps:
        warnings.warn(explain_overlaps(overlaps), stacklevel=3)
