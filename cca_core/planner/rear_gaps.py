"""Gaps to drivers behind: whether they can stop for an ego that brakes ahead of them."""

from collections.abc import Mapping

import numpy as np

from cca_core._checks import Array
from cca_core.planner.paths import Surroundings
from cca_core.planner.scene import TIMES

__all__ = ["keeps_rear_gaps"]


def keeps_rear_gaps(around: Surroundings, rows: Mapping[str, Array], row: int, path_row: int) -> bool:
    """Return whether drivers behind can stop who react to a slower ego that blocks their path.

    They react after `EvasionSettings.rear_reaction_time` and brake as hard as the ego can.
    """
    relative, v, lateral = rows["s"][row], rows["v"][row], rows["d"][path_row]
    d = np.interp(relative, np.arange(float(len(lateral))), lateral)
    rear, traffic = relative + around.lateral.base + around.vehicle.rear, around.traffic
    for j in range(len(traffic.ids)):
        front, speed = traffic.s[j] + traffic.half_l[j], traffic.v[j]
        overlaps = np.abs(traffic.d[j] - d) < traffic.half_w[j] + 0.5 * around.vehicle.width
        blocks = overlaps & (front < rear) & (speed > v)
        k = int(np.argmax(blocks))
        if not blocks[k]:
            continue
        braking = np.maximum(TIMES[k:] - TIMES[k] - around.settings.rear_reaction_time, 0.0)
        left = np.maximum(speed[k] - around.limits.b_max * braking, 0.0)
        driven = np.cumsum(0.5 * (left[1:] + left[:-1]) * np.diff(TIMES[k:]))
        if (front[k] + driven > rear[k + 1 :]).any():
            return False
    return True
