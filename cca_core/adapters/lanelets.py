"""A road along lanelets of a CommonRoad scenario."""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from cca_core._checks import Array, check_real, shown
from cca_core.adapters.lane_lines import LaneLine, lanes_along
from cca_core.errors import InputError
from cca_core.path import Road, fit_path
from cca_core.sim import CommonRoadScenario
from cca_core.sim.commonroad.lanelets import Lanelet

__all__ = ["join_lanelets"]

_TOLERANCE = 0.1  # of the path [m]
_DETAIL = 0.1  # of lane boundaries [m]
_MIN_CHORD = 0.1  # between points of the path [m]


def join_lanelets(
    scenario: CommonRoadScenario, lanelet_ids: Sequence[int], *, speed_limit: float = 36.0
) -> Road:
    """Make the road along lanelets.

    Parameters
    ----------
    scenario : CommonRoadScenario
        Scenario that `read_commonroad` read; its obstacles and problems do not matter.
    lanelet_ids : sequence of int
        Ids of the lanelets in driving order [-], each a successor of the one before.
    speed_limit : float
        Legal speed where no sign limits it [m/s].

    Returns
    -------
    road : Road
        The center line of the lanelets, fitted within 0.1 m, with the lanes next to them in both directions,
        each as far as it goes along, and the speed limits of the lanelets.

    Raises
    ------
    InputError
        If there is no such lanelet, or one is no successor of the one before.
    InfeasibleError
        If no path fits the center line.

    See Also
    --------
    cca_core.sim.drive_commonroad : drive a planning problem, with lane changes to its goal.
    """
    lanelets, speed_limit = scenario.lanelets, check_real("speed_limit", speed_limit, gt=0.0)
    given: object = lanelet_ids
    if isinstance(given, str) or not isinstance(given, Sequence) or not len(given):
        raise InputError(f"lanelet_ids must be a sequence of ids, was {shown(given)}")
    for id_ in lanelet_ids:
        if id_ not in lanelets:
            raise InputError(f"lanelet_ids must be lanelets of the scenario, one was {shown(id_)}")
    for before, after in pairwise(lanelet_ids):
        if after not in lanelets[before].successors:
            raise InputError(f"lanelet {after} must be a successor of lanelet {before}, was not")
    route = [lanelets[id_] for id_ in lanelet_ids]
    center = np.concatenate([lane.center for lane in route])
    path = fit_path(_spaced(center), tolerance=_TOLERANCE)
    limits = np.array([lane.speed_limit for lane in route])
    limits = np.where(np.isfinite(limits), limits, speed_limit)
    starts, s = [path.start], path.start
    for before_lane, lane in pairwise(route):
        s = float(path.project(lane.center[0], s + before_lane.length)[0])
        starts.append(max(s, starts[-1] + 1e-3))
    changes = np.append(True, np.diff(limits) != 0.0)
    table = np.column_stack((starts, limits))[changes]
    lanes = lanes_along(path, [list(_lines(lane, lanelets)) for lane in route], _DETAIL)
    return Road(path, lanes, float(table[0, 1]), speed_limits=table if len(table) > 1 else None)


def _spaced(points: Array) -> Array:
    """Return points without those that lie near the one before."""
    kept = [points[0]]
    for point in points[1:]:
        if math.dist(point, kept[-1]) > _MIN_CHORD:
            kept.append(point)
    return np.array(kept)


def _lines(lane: Lanelet, lanelets: Mapping[int, Lanelet]) -> Iterator[LaneLine]:
    """Yield a lanelet and those next to it on both sides."""
    yield LaneLine(lane.right, lane.left, 1, True)
    for is_left in (True, False):
        here, direction, seen = lane, 1, {lane.id}
        while True:
            # the left of the route is on the right of a lanelet against it
            pair = here.on_left if is_left == (direction == 1) else here.on_right
            if pair is None or pair[0] in seen or pair[0] not in lanelets:
                break
            here, direction = lanelets[pair[0]], direction * pair[1]
            seen.add(here.id)
            if direction == 1:
                yield LaneLine(here.right, here.left)
            else:
                yield LaneLine(here.left[::-1], here.right[::-1], -1)
