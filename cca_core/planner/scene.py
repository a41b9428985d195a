"""Scenes: workspaces of the kernel for a decision, by number of vehicles."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cca_core._checks import Array
from cca_core.kernel import bind
from cca_core.kernel.conflicts import find_conflicts
from cca_core.kernel.gap_checks import check_nominal, check_worst_case
from cca_core.kernel.memory import Lent, lend
from cca_core.kernel.obstacles import find_meetings, find_obstacles, find_span
from cca_core.kernel.rollout import limit_path_speed, roll_out, sum_costs
from cca_core.kernel.scene import Scene
from cca_core.kernel.traffic import locate_vehicles

N_ROWS = 72
"""Motions of the ego that a scene holds; the last one is for the braking tail of a check."""

N_PATHS = 24
"""Candidate paths that a scene holds."""

TIMES = np.concatenate((np.arange(40) * 0.1, 4.0 + 0.2 * np.arange(81)))
"""Times from now at which vehicles are compared [s]: finer at first, 20 s in all."""

FREE_ROW = 0
"""Row of the motion along the route, or back to it, that no vehicle limits."""

locate = bind(locate_vehicles)
limit_path = bind(limit_path_speed)
roll = bind(roll_out)
sum_up = bind(sum_costs)
check_gaps = bind(check_nominal)
check_worst = bind(check_worst_case)
find = bind(find_conflicts)
meet = bind(find_meetings)
span_of = bind(find_span)
obstacles_of = bind(find_obstacles)

_CAPACITIES = (8, 24, 72, 216, 648)  # numbers of vehicles for which scenes are made
_ROUTE = ("x", "y", "psi", "kappa", "cap")


class Scenes:
    """Workspaces by number of vehicles, made once each with the numbers that do not change."""

    def __init__(
        self, n: int, numbers: Mapping[str, float], other_lanes: Sequence[tuple[float, float]]
    ) -> None:
        self._n, self._numbers, self._lanes = n, numbers, other_lanes
        self._made: dict[int, Lent[Scene]] = {}
        self.route: dict[str, Array] = {name: np.zeros(n) for name in _ROUTE}

    def for_vehicles(self, m: int) -> Lent[Scene]:
        """Return a workspace for a number of vehicles, with the route in it."""
        capacity = next((c for c in _CAPACITIES if c >= m), _CAPACITIES[-1])
        if capacity not in self._made:
            made = lend(
                Scene, n=self._n, max_m=capacity, max_paths=N_PATHS, max_rows=N_ROWS, steps=len(TIMES),
                max_lanes=len(self._lanes),
            )  # fmt: skip
            made.arrays["other_lanes"][:] = np.reshape(self._lanes, (-1, 2))
            made.arrays["t"][:] = TIMES
            set_numbers(made, **self._numbers)
            self._made[capacity] = made
        scene = self._made[capacity]
        for name, row in self.route.items():
            scene.arrays[name][:] = row
        scene.workspace.m = min(m, capacity)
        return scene


def set_numbers(scene: Lent[Scene], **values: float) -> None:
    """Set fields of a workspace."""
    workspace: Any = scene.workspace
    for name, value in values.items():
        setattr(workspace, name, value)
