"""Which lane of a road is the ego lane, and which one is to become it."""

from itertools import pairwise

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.path import Road
from cca_core.path.parallel import parallel_road
from cca_core.planner.records import DrivenPlan, LaneWish
from cca_core.planner.setup import Setup

__all__ = ["LaneChoice"]

_GAP = 0.5  # between neighboring lanes, at most [m]


class LaneChoice:
    """Lanes of a route by their order: the one that the ego keeps to, and the one that is requested.

    For each lane that is driven there is a setup whose route is in that lane.
    """

    def __init__(self, setup: Setup) -> None:
        self._road, self._first = setup.road, setup.road.lanes.index(setup.road.ego_lane)
        self._setups = {self._first: setup}
        self.here = self.wanted = self._first
        self._since = 0.0  # time of the request [s]

    def offset(self, index: int) -> float:
        """Return the lateral offset on the road at which a lane is driven [m]."""
        return 0.0 if index == self._first else self._road.lanes[index].d

    def request(self, d: float | None, t: float) -> bool:
        """Wish for the lane at an offset from a time on; return whether that is new."""
        wanted = _find_lane(self._road, d, self._first)
        made = {}
        for index in _between(self.here, wanted):
            if index not in self._setups:
                road, last = parallel_road(self._road, self._road.lanes[index]), self._setups[self._first]
                made[index] = Setup.make(last.vehicle, road, last.settings, last.speed)
        self._setups |= made
        is_new = wanted != self.wanted
        if is_new:
            self.wanted, self._since = wanted, t
        return is_new

    def wish(self, t: float) -> LaneWish | None:
        """Return the next lane on the way to the one that is wanted, as seen from the one that is driven."""
        if self.here == self.wanted:
            return None
        index, lanes = _between(self.here, self.wanted)[0], self._setups[self.here].road.lanes
        return LaneWish(
            side="left" if self.wanted > self.here else "right", lane=lanes[index],
            d=self.offset(index) - self.offset(self.here), waited=max(t - self._since, 0.0),
        )  # fmt: skip

    def enter(self, plan: DrivenPlan, s: float) -> Setup | None:
        """Return the setup of the next lane if the path is inside it at a station: it is the ego lane now."""
        wish = self.wish(self._since)
        if wish is None:
            return None
        setup = self._setups[self.here]
        d, half = plan.path.offset_at(s), 0.5 * setup.vehicle.width
        bounds = wish.lane.bounds_at(s)
        if bounds is None or not bounds[0] < d - half < d + half < bounds[1]:
            return None
        self.here = _between(self.here, self.wanted)[0]
        return self._setups[self.here]


def _between(here: int, wanted: int) -> range:
    """Return the lanes on the way from one to another, with the last."""
    step = 1 if wanted > here else -1
    return range(here + step, wanted + step, step) if here != wanted else range(0)


def _find_lane(road: Road, d: float | None, first: int) -> int:
    """Return the lane that a request means; None is the one of the route."""
    d = 0.0 if d is None else check_real("d", d)
    if road.ego_lane.right < d < road.ego_lane.left:
        return first
    index = next((i for i, lane in enumerate(road.lanes) if lane.right < d < lane.left), None)
    if index is None:
        found = ", ".join(f"{lane.d:g}" for lane in road.lanes if lane.direction == 1)
        raise InputError(f"d must be in a lane of the road (centers {found} m), was {d:g}")
    lanes = [road.lanes[i] for i in range(min(first, index), max(first, index) + 1)]
    apart = any(after.right - before.left > _GAP for before, after in pairwise(lanes))
    if apart or any(lane.direction != 1 for lane in lanes):
        raise InputError(f"d must be in a lane of direction 1 next to others of it, was {d:g}")
    return index
