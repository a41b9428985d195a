"""What a predictive controller intends, and which limit it misses."""

from dataclasses import dataclass, replace

import numpy as np

from cca_core._checks import Array
from cca_core.baselines.methods.mpc.horizon import Horizon
from cca_core.baselines.problems.problem import Plan
from cca_core.errors import Status
from cca_core.follow import steady_sideslip
from cca_core.geometry import Boxes, box_gap
from cca_core.path import Path
from cca_core.vehicle import VehicleParams

__all__ = ["Trajectory", "violated_limit"]

_MISSED = 0.01  # by so much a trajectory may miss a distance and still count as keeping it [m]
_EXCEEDED = 1.01  # share of the lateral acceleration likewise [-]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trajectory:
    """What a controller intends, in path coordinates.

    Parameters
    ----------
    status : Status
        `Status.OK` if every limit is kept, `Status.INFEASIBLE` if one is missed, `Status.NOT_CONVERGED` if
        the solver gave up.
    message : str
        Why, in words, if it is not OK.
    t : ndarray, shape (n,)
        Times from now [s].
    s, d : ndarray, shape (n,)
        Center of gravity [m].
    angle : ndarray, shape (n,)
        Its course relative to the route [rad], counter-clockwise.
    v : ndarray, shape (n,)
        Speed [m/s].
    kappa : ndarray, shape (n,)
        Curvature of its way [1/m], left turn positive.
    delta : ndarray, shape (n,)
        Road-wheel angle [rad], left positive.
    a_x : ndarray, shape (n,)
        Acceleration [m/s^2].
    cost : float
        Cost without penalties [-].
    """

    status: Status
    message: str
    t: Array
    s: Array
    d: Array
    angle: Array
    v: Array
    kappa: Array
    delta: Array
    a_x: Array
    cost: float

    def xy(self, path: Path) -> Array:
        """Center of gravity in the local frame.

        Parameters
        ----------
        path : Path
            The route.

        Returns
        -------
        xy : ndarray, shape (n, 2)
            Positions [m].
        """
        return path.to_cartesian(self.s, self.d)

    def plan(self, path: Path) -> Plan:
        """Turn it into an answer.

        Parameters
        ----------
        path : Path
            The route.

        Returns
        -------
        plan : Plan
            Status and way; without the way if the solver gave up.
        """
        if self.status is Status.NOT_CONVERGED:
            return Plan(status=self.status, message=self.message)
        return Plan(status=self.status, message=self.message, t=self.t, xy=self.xy(path), v_x=self.v)

    def nodes(self, n: int) -> tuple[Array, Array]:
        """Places at equidistant times, to begin another solver with.

        Parameters
        ----------
        n : int
            How many [-].

        Returns
        -------
        s, d : ndarray, shape (n,)
            Path coordinates [m].
        """
        t = np.linspace(self.t[0], self.t[-1], n)
        return np.interp(t, self.t, self.s), np.interp(t, self.t, self.d)

    def body(self, path: Path, vehicle: VehicleParams) -> Boxes:
        """Boxes of the ego.

        Parameters
        ----------
        path : Path
            The route.
        vehicle : VehicleParams
            The ego.

        Returns
        -------
        body : Boxes
            One for each time.
        """
        xy = self.xy(path)
        psi = path.heading(self.s) + self.angle - steady_sideslip(self.kappa, self.v, vehicle)
        return vehicle.body_at(xy[:, 0], xy[:, 1], psi)


def violated_limit(trajectory: Trajectory, horizon: Horizon) -> str:
    """Name the limit that a trajectory misses, judged by its boxes and not by what the solver was told.

    Parameters
    ----------
    trajectory : Trajectory
        Finely sampled.
    horizon : Horizon
        Limits and all others.

    Returns
    -------
    message : str
        The first limit that is missed, in words; empty if none.
    """
    path, vehicle = horizon.road.path, horizon.vehicle
    body = trajectory.body(path, vehicle)
    fine, kept = replace(horizon, t=trajectory.t), horizon.share * horizon.clearance
    for other, s in zip(horizon.others, fine.places(), strict=True):
        near = np.abs(s - trajectory.s) < other.half_length + vehicle.length + horizon.clearance
        if not near.any():
            continue
        at = path.to_cartesian(s[near], np.full(int(near.sum()), other.d))
        psi = path.heading(s[near])
        size = 2.0 * np.array([other.half_length, other.half_width])
        own = Boxes(body.x[near], body.y[near], body.psi[near], body.length, body.width)
        least = float(box_gap(own, Boxes(at[:, 0], at[:, 1], psi, size[0], size[1])).min())
        if least < kept - _MISSED:
            return f"{least:.2f} m to {other.remote.id}, {kept:.2f} m are to be kept"
    right, left = horizon.edges
    turned = 0.5 * vehicle.length * np.abs(np.sin(trajectory.angle))
    if (np.maximum(right - trajectory.d, trajectory.d - left) + turned).max() > 2.0 * _MISSED:
        return "the body leaves the road"
    a_y = float(np.abs(trajectory.v**2 * trajectory.kappa).max())
    if a_y > _EXCEEDED * horizon.a_y_max:
        return f"lateral acceleration of {a_y:.2f} m/s^2, {horizon.a_y_max:.2f} m/s^2 are allowed"
    d = float(trajectory.d[-1])
    if not horizon.final[0] - 2.0 * _MISSED <= d <= horizon.final[1] + 2.0 * _MISSED:
        return f"the end is beside its lane, at d = {d:.2f} m"
    return ""
