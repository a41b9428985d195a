"""Choice of the lane to change to for good: the one that leads on, a faster one, or the right one."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cca_core import Lane, Planner, RemoteVehicle, VehicleState

PERIOD = 0.5  # between two choices [s]
RANGE = 300.0  # within which vehicles count, that of a radio [m]
TIME_GAP = 1.5  # to a lead vehicle that does not slow the ego down [s]
HORIZON = 25.0  # in which a larger gap is closed [s]
LEFT_GAIN = 1.5  # of speed for which the ego changes to the left [m/s]
RIGHT_LOSS = 0.5  # of speed that it accepts for the right lane [m/s]
URGENT_GAIN = 6.0  # of speed for which it asks for a change before there is a gap [m/s]
PATIENCE = 5.0  # time after which a request is withdrawn, and after which there is a new one [s]
END_TIME = 30.0  # before the end of its lane, at which the ego asks in any case [s]
END_DISTANCE = 300.0  # the same at low speed [m]
MIN_REACH = 1500.0  # of a lane to which the ego changes for its speed [m]


class LaneView(NamedTuple):
    """What a lane offers: a speed [m/s], and whether there is a gap next to the ego."""

    speed: float
    has_gap: bool


class LaneRequests:
    """Asks the planner for lane changes."""

    def __init__(self) -> None:
        self.t_next, self.t_last = 0.0, -math.inf

    def update(
        self,
        t: float,
        planner: Planner,
        state: VehicleState,
        s: float,
        vehicles: Sequence[RemoteVehicle],
        reaches: Sequence[float],
    ) -> None:
        """Ask for the best lane; `reaches` are the distances that lanes lead along the route, right first."""
        if t < self.t_next:
            return
        self.t_next = t + PERIOD
        lanes = [lane for lane in planner.road.lanes if lane.direction == 1 and lane.bounds_at(s) is not None]
        here = next((i for i, lane in enumerate(lanes) if lane.right < planner.lane < lane.left), None)
        if here is None or len(lanes) != len(reaches):  # between two edges
            return
        best = int(np.argmax(reaches))
        if reaches[here] < min(max(END_TIME * state.v_x, END_DISTANCE), reaches[best] - 1.0):
            self._request(t, planner, lanes[here + (1 if best > here else -1)].d)
        elif planner.requested_lane is not None:
            if t - self.t_last > PATIENCE and planner.maneuver is None:
                self._request(t, planner, planner.lane)
        elif t - self.t_last > PATIENCE and planner.maneuver is None:
            self._look_aside(t, planner, state, s, vehicles, lanes, here, reaches)

    def _request(self, t: float, planner: Planner, d: float) -> None:
        planner.request_lane(d)
        self.t_last = t

    def _look_aside(
        self,
        t: float,
        planner: Planner,
        state: VehicleState,
        s: float,
        vehicles: Sequence[RemoteVehicle],
        lanes: Sequence[Lane],
        here: int,
        reaches: Sequence[float],
    ) -> None:
        """Ask for a lane next to the ego lane that is better."""
        views = view_lanes(planner, state, s, lanes, vehicles)
        far = min(MIN_REACH, max(reaches) - 1.0)
        for i in (here - 1, here + 1):
            if not 0 <= i < len(lanes) or reaches[i] < far:
                continue
            gain = views[i].speed - views[here].speed
            wanted = gain > (LEFT_GAIN if i > here else -RIGHT_LOSS)
            if wanted and (views[i].has_gap or gain > URGENT_GAIN):
                self._request(t, planner, lanes[i].d)
                return


def view_lanes(
    planner: Planner, state: VehicleState, s: float, lanes: Sequence[Lane], vehicles: Sequence[RemoteVehicle]
) -> list[LaneView]:
    """Return what each lane offers."""
    path, car, v = planner.road.path, planner.vehicle, state.v_x
    views = [LaneView(min(planner.cruise_speed, planner.road.highest_limit(s, s)), True) for _ in lanes]
    near = [r for r in vehicles if math.hypot(r.x - state.x, r.y - state.y) < RANGE]
    for remote in near:
        ahead = (remote.x - state.x) * math.cos(state.psi) + (remote.y - state.y) * math.sin(state.psi)
        s_r, d_r, heading, _ = path.foot_point(remote.x, remote.y, s + ahead)
        if math.cos(remote.psi - heading) < 0.0:
            continue
        gap, reach = abs(s_r - s) - 0.5 * (car.length + remote.length), 0.3 * remote.width
        for i, lane in enumerate(lanes):
            if not lane.right - reach < d_r < lane.left + reach:
                continue
            if s_r > s:
                allowed = remote.v_x + max(gap - TIME_GAP * v, 0.0) / HORIZON
                is_clear = gap > 5.0 + 1.5 * max(v - remote.v_x, 0.0) + 0.3 * v
                views[i] = LaneView(min(views[i].speed, allowed), views[i].has_gap and is_clear)
            else:
                is_clear = gap > 5.0 + 2.5 * max(remote.v_x - v, 0.0) + 0.3 * remote.v_x
                views[i] = LaneView(views[i].speed, views[i].has_gap and is_clear)
    return views
