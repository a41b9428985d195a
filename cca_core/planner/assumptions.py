"""What a certificate assumes of other vehicles, and whether what is seen later agrees with it."""

from collections.abc import Sequence
from typing import NamedTuple, Self

import numpy as np

from cca_core._checks import Array, Mask
from cca_core.frenet import FrenetVehicle
from cca_core.kernel.memory import Lent
from cca_core.kernel.scene import Scene
from cca_core.planner.scene import TIMES

__all__ = ["Assumptions"]

_TIME = 6.0  # ahead, in which bounds are compared [s]
_TOLERANCE = 0.1  # of a bound [m]
_BOUNDS = ("low", "high", "right", "left")
_SIGNS = np.array([1.0, -1.0, 1.0, -1.0])[:, None, None]


class Assumptions(NamedTuple):
    """Where the vehicles of a decision can be in the worst case."""

    t: float
    ids: tuple[str, ...]
    crosses: Mask
    bounds: Array  # least and largest station and lateral offset (4, vehicles, steps), absolute
    errors: Array  # of the places as reported, along and across (vehicles, 2)

    @classmethod
    def of(cls, scene: Lent[Scene], vehicles: Sequence[FrenetVehicle], t: float, base: int) -> Self:
        """Return what is assumed in a decision."""
        rows, n = scene.arrays, len(vehicles)
        bounds = np.stack([rows[name][:n] for name in _BOUNDS])
        bounds[:2] += base
        errors = [
            (2.0 * vehicle.remote.sigma_along, 2.0 * vehicle.remote.sigma_across) for vehicle in vehicles
        ]
        return cls(
            t, tuple([vehicle.id for vehicle in vehicles]), rows["crosses"][:n] != 0, bounds,
            np.reshape(errors, (n, 2)),
        )  # fmt: skip

    def hold(self, now: Self) -> bool:
        """Return whether all vehicles of a later decision are within the bounds, up to errors of reports."""
        if not set(now.ids) <= set(self.ids):
            return False
        j = [self.ids.index(name) for name in now.ids]
        if not j:
            return True
        if (self.crosses[j] != now.crosses).any():
            return False
        times = TIMES[TIMES <= _TIME] + (now.t - self.t)
        i = np.searchsorted(TIMES, times, side="right") - 1
        share = (times - TIMES[i]) / (TIMES[i + 1] - TIMES[i])
        before = self.bounds[:, j]
        then = before[..., i] + share * (before[..., i + 1] - before[..., i])
        error = np.repeat(now.errors.T, 2, axis=0)[..., None] + _TOLERANCE
        beyond = _SIGNS * (then - now.bounds[..., : len(times)]) > error
        return not bool(beyond[:, ~now.crosses].any())
