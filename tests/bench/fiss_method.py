"""FISS as a planning method of the comparison, by way of its package."""

import math
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from cca_core.baselines import Plan, Problem
from cca_core.errors import Status

INSTALLED = find_spec("fiss_planner") is not None
_CYCLE = 0.3  # driven before the next plan [s]
_STRAY = 0.05  # from the route at the end [m]
_LATER = 3.0  # than at the goal it may be back on the route [s]
_OTHER_LANE = 200.0  # cost [-]
_RUN_UP, _RUN_OUT = 20.0, 145.0  # of the reference line before start and behind goal [m]


class Fiss:
    """FISS in receding horizon: a plan of 1 to 3 s every 0.3 s, of which so much is kept, until the end.

    Its limits are those of the problem: its safety rules beyond a clearance are off, speed may change by 5 %.
    The other lane costs extra and the distance to the center of a lane ten times the default, or it would not
    return to the route; it may be back up to 3 s later than at the goal, since it knows none.
    """

    def __init__(self) -> None:
        self._fiss: Any = import_module("fiss_planner")

    def plan(self, problem: Problem) -> Plan:
        fiss, car, path, v = self._fiss, problem.vehicle, problem.road.path, problem.v_x
        vehicle = fiss.VehicleParams()
        vehicle.length, vehicle.width, vehicle.wheelbase = car.length, car.width, car.wheelbase
        vehicle.rear_axle_to_center = car.l_r + car.box_offset
        vehicle.max_steer, vehicle.max_steer_rate = car.delta_max, car.delta_rate_max
        vehicle.max_lat_accel = problem.a_y_max
        config = fiss.make_config("fiss", num_width=21)
        config.safety.enabled = False
        config.collision.margin_lat = config.collision.margin_lon = problem.clearance
        config.sampling.lane_margin, config.sampling.min_speed = 0.0, 0.95 * v
        config.sampling.num_speed, config.sampling.min_t, config.sampling.max_t = 3, 1.0, 3.0
        config.cost.w_lateral, config.cost.w_lane_change, config.cost.w_clearance = 20.0, 0.0, 0.0
        planner = fiss.make_planner(config, vehicle)
        first = problem.start - _RUN_UP
        line = path.position(np.arange(first, problem.goal + _RUN_OUT, 1.0))
        road = fiss.ReferenceLine(*line.T)
        stations = np.arange(0.0, road.length, 1.0)
        lanes = fiss.Corridor(stations)
        for lane in problem.road.lanes:
            band = fiss.LaneBand()
            band.offset, band.extra_cost = round(lane.d / lane.width), _OTHER_LANE * (lane.d != 0.0)
            band.center, band.left, band.right = (
                np.full_like(stations, d) for d in (lane.d, lane.left, lane.right)
            )
            lanes.add_lane(band)
        state = fiss.FrenetState(s=_RUN_UP - car.l_r, s_d=v)
        moments = 0.1 * np.arange(80)
        parts, now = [], 0.0
        while True:
            others = [
                fiss.Obstacle.from_arrays(
                    i, float(b.length), float(b.width), moments, b.x, b.y, b.psi, is_static=False
                )
                for i, b in enumerate(problem.boxes_at(now + moments))
            ]
            found = planner.plan(state, road, lanes, others, target_speed=v)
            if not found.success:
                return Plan(status=Status.INFEASIBLE, message=f"no trajectory {now:.1f} s ahead")
            way = found.trajectory
            t = np.asarray(way.t)
            back = abs(way.d[0]) < _STRAY and now >= problem.duration
            last = back or now > problem.duration + _LATER
            kept = t < 0.5 * _CYCLE if last else t < _CYCLE - 1e-9
            parts.append(np.column_stack((now + t, way.x, way.y, way.yaw, way.v))[kept])
            if last:
                break
            state = way.frenet_state_at(round(_CYCLE / config.sampling.dt))
            now += _CYCLE
        t, x, y, yaw, speed = np.vstack(parts).T
        xy = np.column_stack((x + car.l_r * np.cos(yaw), y + car.l_r * np.sin(yaw)))
        off = abs(float(path.project(xy[-1])[1]))
        if not off < 0.1 or not math.isfinite(off):
            return Plan(
                status=Status.NOT_CONVERGED, message=f"{off:.1f} m beside the route 3 s after the goal"
            )
        return Plan(status=Status.OK, t=t - t[0], xy=xy, v_x=speed)
