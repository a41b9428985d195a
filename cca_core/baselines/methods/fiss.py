"""FISS as a planning method, by its own package `fiss_planner`."""

import math
from importlib import import_module
from typing import Any

import numpy as np

from cca_core._checks import Array
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.errors import Status

_RUN_UP = 20.0  # of the reference line before the start [m]


class Fiss:
    """FISS in receding horizon: plans of 1 to 3 s, joined from `replan_period` of each."""

    # Its limits are those of the problem: the safety rules beyond a clearance are off, and the speed may
    # change by 5 %. Another lane costs extra and the distance from the center of a lane ten times the
    # default: FISS does not return to the route otherwise. It knows no goal and may return up to
    # `delay_limit` after it.

    def __init__(self, *, replan_period: float = 0.3, delay_limit: float = 3.0) -> None:
        self._fiss: Any = import_module("fiss_planner")
        self._period, self._delay_limit = replan_period, delay_limit

    def plan(self, problem: Problem) -> Plan:
        """Join plans until the ego is back on the route behind the goal."""
        fiss, car, path = self._fiss, problem.vehicle, problem.road.path
        config, planner = self._planner(problem)
        line = path.position(np.arange(problem.start - _RUN_UP, problem.goal + 145.0, 1.0))
        road = fiss.ReferenceLine(*line.T)
        lanes = self._lanes(problem, road.length)
        state = fiss.FrenetState(s=_RUN_UP - car.l_r, s_d=problem.v_x)
        parts, now = list[Array](), 0.0
        while True:
            others = self._obstacles(problem, now)
            answer = planner.plan(state, road, lanes, others, target_speed=problem.v_x)
            if not answer.success:
                return Plan(status=Status.INFEASIBLE, message=f"no trajectory {now:.1f} s ahead")
            found = answer.trajectory
            t = np.asarray(found.t)
            returned = abs(found.d[0]) < 0.05 and now >= problem.duration
            last = returned or now > problem.duration + self._delay_limit
            used = t < 0.5 * self._period if last else t < self._period - 1e-9
            parts.append(np.column_stack((now + t, found.x, found.y, found.yaw, found.v))[used])
            if last:
                break
            state = found.frenet_state_at(round(self._period / config.sampling.dt))
            now += self._period
        t, x, y, yaw, speed = np.vstack(parts).T
        xy = np.column_stack((x + car.l_r * np.cos(yaw), y + car.l_r * np.sin(yaw)))
        offset = abs(float(path.project(xy[-1])[1]))
        if not offset < 0.1 or not math.isfinite(offset):
            late = f"{offset:.1f} m off the route {self._delay_limit:g} s after the goal"
            return Plan(status=Status.NOT_CONVERGED, message=late)
        return Plan(status=Status.OK, t=t - t[0], xy=xy, v_x=speed)

    def _planner(self, problem: Problem) -> tuple[Any, Any]:
        """Make configuration and planner."""
        car, v = problem.vehicle, problem.v_x
        vehicle = self._fiss.VehicleParams()
        vehicle.length, vehicle.width, vehicle.wheelbase = car.length, car.width, car.wheelbase
        vehicle.rear_axle_to_center = car.l_r + car.box_offset
        vehicle.max_steer, vehicle.max_steer_rate = car.delta_max, car.delta_rate_max
        vehicle.max_lat_accel = problem.a_y_max
        config = self._fiss.make_config("fiss", num_width=21)
        config.safety.enabled = False
        config.collision.margin_lat = config.collision.margin_lon = problem.clearance
        config.sampling.lane_margin, config.sampling.min_speed = 0.0, 0.95 * v
        config.sampling.num_speed, config.sampling.min_t, config.sampling.max_t = 3, 1.0, 3.0
        config.cost.w_lateral, config.cost.w_lane_change, config.cost.w_clearance = 20.0, 0.0, 0.0
        return config, self._fiss.make_planner(config, vehicle)

    def _lanes(self, problem: Problem, length: float) -> Any:
        """Lanes of the road along the reference line."""
        stations = np.arange(0.0, length, 1.0)
        lanes = self._fiss.Corridor(stations)
        for lane in problem.road.lanes:
            band = self._fiss.LaneBand()
            band.offset, band.extra_cost = round(lane.d / lane.width), 200.0 * (lane.d != 0.0)
            band.center, band.left, band.right = (
                np.full_like(stations, d) for d in (lane.d, lane.left, lane.right)
            )
            lanes.add_lane(band)
        return lanes

    def _obstacles(self, problem: Problem, now: float) -> list[Any]:
        """Predicted motion of the other vehicles over 8 s."""
        t = 0.1 * np.arange(80)
        return [
            self._fiss.Obstacle.from_arrays(
                i, float(b.length), float(b.width), t, b.x, b.y, b.psi, is_static=False
            )
            for i, b in enumerate(problem.boxes_at(now + t))
        ]
