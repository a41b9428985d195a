"""Trajectory of a predictive controller, and the limit that it violates."""

from dataclasses import dataclass, replace

import numpy as np

from cca_core._checks import Array
from cca_core.baselines.methods.mpc.horizon import Horizon
from cca_core.baselines.problems.problem import Plan
from cca_core.errors import Status
from cca_core.follow import steady_sideslip
from cca_core.geometry import Boxes, box_gap
from cca_core.path import Path, interpolate_path
from cca_core.vehicle import VehicleParams

_TOLERANCE = 0.01  # of a distance [m], and of the lateral acceleration [-]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trajectory:
    """Trajectory in Frenet coordinates, finely sampled."""

    status: Status  # OK if every limit is kept, INFEASIBLE if one is violated, NOT_CONVERGED without solution
    message: str  # reason if the status is not OK
    t: Array  # times from now [s]
    s: Array  # center of gravity [m]
    d: Array
    angle: Array  # of the velocity relative to the route [rad], counter-clockwise
    v: Array
    kappa: Array  # curvature of the trajectory [1/m], left positive
    delta: Array  # road-wheel angle [rad]
    a_x: Array
    cost: float  # without penalties [-]

    def xy(self, path: Path) -> Array:
        """Center of gravity (n, 2) in the local frame [m]."""
        return path.to_cartesian(self.s, self.d)

    def plan(self, path: Path) -> Plan:
        """Plan with this trajectory, or without one if the solver found none."""
        if self.status is Status.NOT_CONVERGED:
            return Plan(status=self.status, message=self.message)
        return Plan(status=self.status, message=self.message, t=self.t, xy=self.xy(path), v_x=self.v)

    def path(self, route: Path) -> Path:
        """Path with nodes every 2 m, for figures and logs; the route if it is shorter than three nodes."""
        nodes = np.flatnonzero(np.diff(np.floor((self.s - self.s[0]) / 2.0), prepend=-1.0) > 0.0)
        if len(nodes) < 3:
            return route
        return interpolate_path(self.xy(route)[nodes], start=float(self.s[0]))

    def nodes(self, n: int) -> tuple[Array, Array]:
        """Stations and offsets at n equidistant times, as a guess for another solver [m]."""
        t = np.linspace(self.t[0], self.t[-1], n)
        return np.interp(t, self.t, self.s), np.interp(t, self.t, self.d)

    def body(self, path: Path, vehicle: VehicleParams) -> Boxes:
        """Boxes of the ego at each time."""
        xy = self.xy(path)
        psi = path.heading(self.s) + self.angle - steady_sideslip(self.kappa, self.v, vehicle)
        return vehicle.body_at(xy[:, 0], xy[:, 1], psi)


def violated_limit(trajectory: Trajectory, horizon: Horizon) -> str:
    """First limit that a trajectory violates, in words, from its boxes alone; empty if none."""
    path, vehicle = horizon.road.path, horizon.vehicle
    body = trajectory.body(path, vehicle)
    fine, required = replace(horizon, t=trajectory.t), horizon.clearance_fraction * horizon.clearance
    for other, s in zip(horizon.others, fine.stations(), strict=True):
        near = np.abs(s - trajectory.s) < other.half_length + vehicle.length + horizon.clearance
        if not near.any():
            continue
        at = path.to_cartesian(s[near], np.full(int(near.sum()), other.d))
        psi = path.heading(s[near])
        size = 2.0 * np.array([other.half_length, other.half_width])
        own = Boxes(body.x[near], body.y[near], body.psi[near], body.length, body.width)
        gap = float(box_gap(own, Boxes(at[:, 0], at[:, 1], psi, size[0], size[1])).min())
        if gap < required - _TOLERANCE:
            return f"clearance to {other.remote.id} {gap:.2f} m (limit {required:.2f} m)"
    right, left = horizon.edges
    turned = 0.5 * vehicle.length * np.abs(np.sin(trajectory.angle))
    if (np.maximum(right - trajectory.d, trajectory.d - left) + turned).max() > 2.0 * _TOLERANCE:
        return "the body leaves the road"
    a_y = float(np.abs(trajectory.v**2 * trajectory.kappa).max())
    if a_y > (1.0 + _TOLERANCE) * horizon.a_y_max:
        return f"lateral acceleration {a_y:.2f} m/s² (limit {horizon.a_y_max:.2f} m/s²)"
    d = float(trajectory.d[-1])
    if not horizon.final_d[0] - 2.0 * _TOLERANCE <= d <= horizon.final_d[1] + 2.0 * _TOLERANCE:
        return f"the trajectory ends outside its lane, at d = {d:.2f} m"
    return ""
