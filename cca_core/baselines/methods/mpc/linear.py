"""Linear time-varying model predictive control of the lateral motion along a speed profile."""

from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.baselines.methods.mpc.horizon import SAMPLES, FrenetState, Horizon, MpcSettings
from cca_core.baselines.methods.mpc.lateral_qp import LateralQp, exponentials
from cca_core.baselines.methods.mpc.side_choice import SideChoice, side_choices
from cca_core.baselines.methods.mpc.trajectory import Trajectory, violated_limit
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.errors import Status
from cca_core.follow import steady_steering


class LinearMpc:
    """Linear time-varying controller of the lateral motion along a speed profile.

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
    The kinematic bicycle is linearized about the route at speeds v_k along it. With the lateral rate
    w = v angle, the lateral acceleration relative to the route a = v^2 (kappa - kappa_route) and its rate j
    as the input, d' = w, w' = (v'/v) w + a, a' = j. The rear and the front end of the ego stay out of each
    vehicle on the side of the corridor, elastically with a square penalty. Side choices are solved in turn
    until one keeps every limit. The matrices are set up once; a new solution changes bounds and, with the
    speeds, some entries in place.
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
            The problem.

        Returns
        -------
        plan : Plan
            Five samples per interval.
        """
        path = problem.road.path
        horizon = Horizon.of(problem, self.settings.intervals)
        start = FrenetState(s=problem.start, v=problem.v_x, kappa=path.curvature_at(problem.start))
        v = np.full(len(horizon.t), problem.v_x)
        return self.solve(horizon, start, problem.start + v * horizon.t, v).plan(path)

    def solve(self, horizon: Horizon, start: FrenetState, s: Array, v: Array) -> Trajectory:
        """Find the lateral motion for a speed profile.

        Parameters
        ----------
        horizon : Horizon
            Limits and all other vehicles, with the intervals of the settings.
        start : FrenetState
            The ego now.
        s : ndarray, shape (n + 1,)
            Stations at the times of the horizon [m].
        v : ndarray, shape (n + 1,)
            Speeds along the route then [m/s].

        Returns
        -------
        trajectory : Trajectory
            The first one that keeps all limits, or else the cheapest; five samples per interval.
        """
        found = []
        for choice in side_choices(horizon, s, v, start.d)[: self.settings.max_side_choices]:
            for margin in self.settings.corridor_margins:
                found.append(self._within(horizon, start, s, v, choice, margin))
                if found[-1].status is Status.OK:
                    return found[-1]
        return min(found, key=lambda f: (f.status is Status.NOT_CONVERGED, f.cost))

    def _within(
        self, horizon: Horizon, start: FrenetState, s: Array, v: Array, choice: SideChoice, margin: float
    ) -> Trajectory:
        """Lateral motion within one corridor."""
        vehicle, model_v = horizon.vehicle, np.maximum(v, self.settings.min_model_speed)
        road = horizon.road.path.curvature(s)
        ends = np.array([[vehicle.rear], [vehicle.front]])
        growth = np.diff(model_v) / (0.5 * horizon.step * (model_v[1:] + model_v[:-1]))  # v' / v
        now = start.d, model_v[0] * np.sin(start.angle), model_v[0] ** 2 * (start.kappa - road[0])
        a_y_route = model_v**2 * road
        a_y_max = self.settings.a_y_fraction * horizon.a_y_max
        rate = model_v[:-1] ** 2 * vehicle.delta_rate_max / steady_steering(1.0, model_v[:-1], vehicle)
        x, status, cost = self._program.solve(
            horizon.step, growth, ends / model_v, now,
            (choice.lower[:, 1:] + margin, choice.upper[:, 1:] - margin),
            (np.minimum(-a_y_max - a_y_route[1:], 0.0), np.maximum(a_y_max - a_y_route[1:], 0.0)), rate,
        )  # fmt: skip
        t, motion = _sampled(horizon, growth, x, s, v)
        trajectory = _trajectory(horizon, t, motion, cost, np.diff(v) / horizon.step, self.settings)
        if status is not Status.OK:
            return replace(trajectory, status=status, message="the quadratic program was not solved")
        violated = violated_limit(trajectory, horizon)
        return trajectory if not violated else replace(trajectory, status=Status.INFEASIBLE, message=violated)


def _sampled(
    horizon: Horizon, growth: Array, x: tuple[Array, Array, Array, Array], s: Array, v: Array
) -> tuple[Array, Array]:
    """Sample times, and d, w, a, s and v then, from their values at the nodes and the jerk between them."""
    d, w, a, jerk = x
    fraction = np.arange(SAMPLES) / SAMPLES
    h = horizon.step * fraction[:, None]
    p0, p1, p2, p3 = exponentials(growth, h)
    motion = np.empty((5, SAMPLES * len(jerk) + 1))
    for row, last, values in zip(
        motion, (d[-1], w[-1], a[-1], s[-1], v[-1]),
        (
            d[:-1] + p1 * w[:-1] + p2 * a[:-1] + p3 * jerk, p0 * w[:-1] + p1 * a[:-1] + p2 * jerk,
            a[:-1] + h * jerk, s[:-1] + h * v[:-1] + 0.5 * h * fraction[:, None] * np.diff(v),
            v[:-1] + fraction[:, None] * np.diff(v),
        ), strict=True,
    ):  # fmt: skip
        row[:-1], row[-1] = values.T.ravel(), last
    return np.append((horizon.t[:-1] + h).T.ravel(), horizon.t[-1]), motion


def _trajectory(
    horizon: Horizon, t: Array, motion: Array, cost: float, a_x: Array, settings: MpcSettings
) -> Trajectory:
    """Exact heading, speed and curvature of a lateral motion."""
    d, w, a, s, v = motion
    model_v = np.maximum(v, settings.min_model_speed)
    road = horizon.road.path.curvature(s)
    along = 1.0 - road * d
    tan = w / (model_v * along)
    cos2 = 1.0 / (1.0 + tan * tan)
    kappa = ((a / model_v**2 + road * tan * tan * along) * cos2 / along + road) * np.sqrt(cos2) / along
    speed = v * along / np.sqrt(cos2)
    return Trajectory(
        status=Status.OK, message="", t=t, s=s, d=d, angle=np.arctan(tan), v=speed, kappa=kappa,
        delta=steady_steering(kappa, speed, horizon.vehicle), a_x=np.append(np.repeat(a_x, SAMPLES), a_x[-1]),
        cost=cost,
    )  # fmt: skip
