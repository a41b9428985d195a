"""Linear time-varying model predictive control of the lateral motion along a speed profile."""

from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.baselines.methods.mpc.horizon import FrenetState, Horizon, MpcSettings
from cca_core.baselines.methods.mpc.lateral_qp import LateralQp, exponentials
from cca_core.baselines.methods.mpc.side_choice import SideChoice, side_choices
from cca_core.baselines.methods.mpc.trajectory import Trajectory, violated_limit
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.errors import Status
from cca_core.follow import steady_steering

__all__ = ["LinearMpc"]

# what a corridor is narrowed by, and what by if the way between nodes is too close then [m]
_ROOMS = 0.03, 0.12
_SPARE = 0.97  # share of the lateral acceleration that the linear model may use [-]
_SLOWEST = 2.0  # the model is held at this speed below it [m/s]
_TRIED = 3  # choices of sides for which the program is solved
_FINE = 5  # samples in an interval


class LinearMpc:
    """Lateral motion along a speed profile.

    Parameters
    ----------
    settings : MpcSettings, optional
        Horizon and weights.

    Raises
    ------
    MissingExtraError
        If PIQP is not installed.

    Notes
    -----
    The kinematic bicycle linearized about the route at speeds v_k along it: with the lateral rate
    w = v angle, the lateral acceleration relative to the route a = v^2 (kappa - kappa_route) and its rate j
    as the input, d' = w, w' = (v'/v) w + a, a' = j. The ego's rear and front end keep out of each other
    vehicle (elastically, with a square penalty) on the side that the corridor gives it; of all choices of
    sides up to three are solved until one keeps every limit. The matrices are set up once; a replan changes
    bounds and, with the speeds, some entries in place.
    """

    name = "linear MPC"

    def __init__(self, settings: MpcSettings | None = None) -> None:
        self.settings = settings or MpcSettings()
        self._program = LateralQp(self.settings)

    def plan(self, problem: Problem) -> Plan:
        """Plan once, at constant speed along the route.

        Parameters
        ----------
        problem : Problem
            What is to be driven.

        Returns
        -------
        plan : Plan
            The way of the center of gravity, five times as fine as the intervals.
        """
        path = problem.road.path
        horizon = Horizon.of(problem, self.settings.intervals)
        start = FrenetState(s=problem.start, v=problem.v_x, kappa=path.curvature_at(problem.start))
        v = np.full(len(horizon.t), problem.v_x)
        return self.solve(horizon, start, problem.start + v * horizon.t, v).plan(path)

    def solve(self, horizon: Horizon, start: FrenetState, s: Array, v: Array) -> Trajectory:
        """Lateral motion for a speed profile.

        Parameters
        ----------
        horizon : Horizon
            Limits and all others; as many intervals as the settings say.
        start : FrenetState
            The ego now.
        s : ndarray, shape (n + 1,)
            Path coordinates at the times of the horizon [m].
        v : ndarray, shape (n + 1,)
            Speeds along the route then [m/s].

        Returns
        -------
        trajectory : Trajectory
            The first one that keeps all limits, else the cheapest; five times as fine as the intervals.
        """
        found = []
        for passage in side_choices(horizon, s, v, start.d)[:_TRIED]:
            for room in _ROOMS:
                found.append(self._through(horizon, start, s, v, passage, room))
                if found[-1].status is Status.OK:
                    return found[-1]
        return min(found, key=lambda f: (f.status is Status.NOT_CONVERGED, f.cost))

    def _through(
        self, horizon: Horizon, start: FrenetState, s: Array, v: Array, passage: SideChoice, room: float
    ) -> Trajectory:
        """Lateral motion through one corridor."""
        vehicle, slow = horizon.vehicle, np.maximum(v, _SLOWEST)
        road = horizon.road.path.curvature(s)
        ends = np.array([[vehicle.rear], [vehicle.front]])
        stretch = np.diff(slow) / (0.5 * horizon.step * (slow[1:] + slow[:-1]))
        now = start.d, slow[0] * np.sin(start.angle), slow[0] ** 2 * (start.kappa - road[0])
        turning = slow**2 * road
        most = _SPARE * horizon.a_y_max
        rate = slow[:-1] ** 2 * vehicle.delta_rate_max / steady_steering(1.0, slow[:-1], vehicle)
        x, status, cost = self._program.solve(
            horizon.step, stretch, ends / slow, now,
            (passage.lower[:, 1:] + room, passage.upper[:, 1:] - room),
            (np.minimum(-most - turning[1:], 0.0), np.maximum(most - turning[1:], 0.0)), rate,
        )  # fmt: skip
        d, w, a, jerk = x
        share = np.arange(_FINE) / _FINE
        h = horizon.step * share[:, None]
        grow, p1, p2, p3 = exponentials(stretch, h)
        sampled = np.empty((5, _FINE * len(jerk) + 1))
        for row, last, values in zip(
            sampled, (d[-1], w[-1], a[-1], s[-1], v[-1]),
            (
                d[:-1] + p1 * w[:-1] + p2 * a[:-1] + p3 * jerk, grow * w[:-1] + p1 * a[:-1] + p2 * jerk,
                a[:-1] + h * jerk, s[:-1] + h * v[:-1] + 0.5 * h * share[:, None] * np.diff(v),
                v[:-1] + share[:, None] * np.diff(v),
            ), strict=True,
        ):  # fmt: skip
            row[:-1], row[-1] = values.T.ravel(), last
        t = np.append((horizon.t[:-1] + h).T.ravel(), horizon.t[-1])
        trajectory = _trajectory(horizon, t, sampled, float(cost), np.diff(v) / horizon.step)
        if status is not Status.OK:
            return replace(trajectory, status=status, message="the quadratic program was not solved")
        missed = violated_limit(trajectory, horizon)
        return trajectory if not missed else replace(trajectory, status=Status.INFEASIBLE, message=missed)


def _trajectory(horizon: Horizon, t: Array, sampled: Array, cost: float, a_x: Array) -> Trajectory:
    """Exact course, speed and curvature of a lateral motion."""
    d, w, a, s, v = sampled
    slow = np.maximum(v, _SLOWEST)
    road = horizon.road.path.curvature(s)
    along = 1.0 - road * d
    tan = w / (slow * along)
    cos2 = 1.0 / (1.0 + tan * tan)
    kappa = ((a / slow**2 + road * tan * tan * along) * cos2 / along + road) * np.sqrt(cos2) / along
    speed = v * along / np.sqrt(cos2)
    return Trajectory(
        status=Status.OK, message="", t=t, s=s, d=d, angle=np.arctan(tan), v=speed, kappa=kappa,
        delta=steady_steering(kappa, speed, horizon.vehicle), a_x=np.append(np.repeat(a_x, _FINE), a_x[-1]),
        cost=cost,
    )  # fmt: skip
