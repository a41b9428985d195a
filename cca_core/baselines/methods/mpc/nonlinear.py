"""Nonlinear model predictive control: a bicycle on the route, steering rate and jerk as inputs, by CasADi."""

from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core._optional import require_extra
from cca_core.baselines.methods.mpc.horizon import FrenetState, Horizon, MpcSettings
from cca_core.baselines.methods.mpc.linear import LinearMpc
from cca_core.baselines.methods.mpc.nonlinear_program import FINE, NU, NX, NonlinearProgram, cached_program
from cca_core.baselines.methods.mpc.trajectory import Trajectory, violated_limit
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.errors import Status

__all__ = ["NonlinearMpc"]

_SLOTS = (0, 1, 2, 3, 4, 6, 8)  # numbers of others for which a program is built
_LONGER, _WIDER = 1.22, 1.03  # of the body around which the rounded one is laid: 1.22^-8 + 1.03^-8 = 1
_ROOM = 0.03  # kept beyond the clearance [m]
_SPARE = 0.2  # clearance that the guess keeps in addition [m]
_FAR = 1e3  # of a vehicle that is not there [m]
_ALIGNED = 0.05  # at the end [rad]
_EXACTLY = 1e-3  # likewise, where the plan ends on the route [rad]
_BRAKES, _DRIVE, _JERK = 7.0, 2.0, 12.0  # longitudinal limits [m/s^2, m/s^3]


class NonlinearMpc:
    """Steering and speed at once.

    Parameters
    ----------
    settings : MpcSettings, optional
        Horizon, weights and solver.

    Raises
    ------
    MissingExtraError
        If CasADi is not installed.

    Notes
    -----
    A bicycle in path coordinates that turns as in the steady state, kappa = delta / (L + K v^2):
    s' = v cos(angle) / (1 - d kappa_r), d' = v sin(angle), angle' = v kappa - kappa_r s', v' = a_x, with the
    rates of delta and a_x as inputs; one Runge-Kutta step an interval, multiple shooting, exact derivatives.
    Each other is a rounded box (x/a)^8 + (y/b)^8 = 1 around all places where the bodies, their clearance and
    their motion within half an interval meet; it and the lane at the end may be left at an exact linear
    penalty on the farthest way out. A program is built once for a number of intervals and others, all
    else being parameters. It is begun at what the linear controller finds, which chooses the sides.
    """

    name = "nonlinear MPC"

    def __init__(self, settings: MpcSettings | None = None) -> None:
        self.settings = settings or MpcSettings()
        require_extra("casadi", "mpc")
        self._linear = LinearMpc(self.settings)

    def plan(self, problem: Problem) -> Plan:
        """Plan once.

        Parameters
        ----------
        problem : Problem
            What is to be driven.

        Returns
        -------
        plan : Plan
            The way of the center of gravity, five times as fine as the intervals; it reaches the goal in the
            time that the wanted speed takes.
        """
        path = problem.road.path
        horizon = Horizon.of(problem, self.settings.intervals)
        start = FrenetState(s=problem.start, v=problem.v_x, kappa=path.curvature_at(problem.start))
        v = np.full(len(horizon.t), problem.v_x)
        wider = replace(horizon, clearance=problem.clearance + _SPARE)
        guess = self._linear.solve(wider, start, problem.start + v * horizon.t, v)
        return self.solve(horizon, start, *guess.nodes(len(v)), v).plan(path)

    def prepare(self, others: int) -> None:
        """Build the program for a number of others ahead of its use: it takes a tenth of a second, once.

        Parameters
        ----------
        others : int
            How many there is to be room for [-]; of more than eight the nearest count.
        """
        self._built(others)

    def _built(self, others: int) -> NonlinearProgram:
        slots, own = next((m for m in _SLOTS if m >= others), _SLOTS[-1]), self.settings
        return cached_program(own.intervals, slots, own.solver, own.iterations, own.cpu_time)

    def solve(self, horizon: Horizon, start: FrenetState, s: Array, d: Array, v: Array) -> Trajectory:
        """Trajectory near a guess.

        Parameters
        ----------
        horizon : Horizon
            Limits and all others; as many intervals as the settings say.
        start : FrenetState
            The ego now.
        s, d : ndarray, shape (n + 1,)
            The guess: path coordinates at the times of the horizon [m], which choose on which side of whom.
        v : ndarray, shape (n + 1,)
            Wanted speeds then [m/s].

        Returns
        -------
        trajectory : Trajectory
            The local optimum, five times as fine as the intervals.
        """
        own, vehicle, n = self.settings, horizon.vehicle, self.settings.intervals
        near = _nearest(horizon, s)
        built = self._built(len(near))
        gain, grip = vehicle.wheelbase, vehicle.understeer_gradient
        guess = _guess(horizon, start, s, d)
        places = np.full((n + 1, built.slots, 4), [-_FAR, 0.0, 1.0, 1.0])
        every, swept = horizon.places(), horizon.swept()
        for i, k in enumerate(near):
            other = horizon.others[k]
            places[:, i, 0], places[:, i, 1] = every[k] - vehicle.box_offset - start.s, other.d
            places[:, i, 2] = _LONGER * (swept[k] + 0.5 * vehicle.length + horizon.clearance)
            places[:, i, 3] = _WIDER * (other.half_width + 0.5 * vehicle.width + horizon.clearance + _ROOM)
        common = np.array(
            [horizon.step, gain, grip, own.weight_d, own.weight_a, own.weight_jerk, own.weight_v,
             own.weight_a_x]
        )  # fmt: skip
        road = horizon.road.path.curvature(s)
        given = np.concatenate((common, road, v, places.ravel()))
        low, high = _bounds(horizon, start, guess, own)
        z, cost, failure = built.run(guess, low, high, given, horizon)
        sampled = built.sampled(guess if failure else z, common, road)
        v, delta = sampled[3], sampled[4]
        t = np.append(np.add.outer(horizon.t[:-1], horizon.step / FINE * np.arange(FINE)), horizon.t[-1])
        trajectory = Trajectory(
            status=Status.OK, message="", t=t, s=start.s + sampled[0], d=sampled[1], angle=sampled[2], v=v,
            kappa=delta / (gain + grip * v * v), delta=delta, a_x=sampled[5], cost=cost,
        )  # fmt: skip
        if failure:
            return replace(trajectory, status=Status.NOT_CONVERGED, message=f"the solver gave up: {failure}")
        missed = violated_limit(trajectory, horizon)
        return trajectory if not missed else replace(trajectory, status=Status.INFEASIBLE, message=missed)


def _nearest(horizon: Horizon, s: Array) -> list[int]:
    """Others that come nearest along the route, as many as there is room for."""
    apart = [float(np.abs(row - s).min()) for row in horizon.places()]
    near = [i for i in np.argsort(apart) if apart[i] < 60.0]
    return near[: _SLOTS[-1]]


def _guess(horizon: Horizon, start: FrenetState, s: Array, d: Array) -> Array:
    """States and inputs, stage by stage, that drive about through a guess; shape (n + 1, 8)."""
    h, vehicle = horizon.step, horizon.vehicle
    z = np.zeros((len(s), NX + NU))
    v = np.maximum(np.gradient(s, h), 0.5)
    angle = np.arctan2(np.gradient(d, h), v)
    kappa = np.gradient(angle, h) / v + horizon.road.path.curvature(s)
    gain = vehicle.wheelbase + vehicle.understeer_gradient * v * v
    z[:, 0], z[:, 1], z[:, 2], z[:, 3], z[:, 4], z[:, 5] = s, d, angle, v, gain * kappa, np.gradient(v, h)
    first = vehicle.wheelbase + vehicle.understeer_gradient * start.v**2
    z[:, 0] -= start.s
    z[0, :NX] = 0.0, start.d, start.angle, start.v, first * start.kappa, start.a_x
    return z


def _bounds(horizon: Horizon, start: FrenetState, guess: Array, own: MpcSettings) -> tuple[Array, Array]:
    """Least and largest values of all variables, shape as the guess."""
    vehicle = horizon.vehicle
    right, left = horizon.edges
    fast = max(1.1 * horizon.v_wanted, start.v + 1.0)
    turn, rate = vehicle.delta_max, vehicle.delta_rate_max
    low, high = np.empty_like(guess), np.empty_like(guess)
    low[:] = [-np.inf, right, -np.inf, 0.0, -turn, -_BRAKES, -rate, -_JERK]
    high[:] = [np.inf, left, np.inf, fast, turn, _DRIVE, rate, _JERK]
    back = np.exp(-horizon.t / 1.0)  # an ego beside the road has time to return
    low[:, 1] -= np.maximum(right - start.d, 0.0) * back * 1.5
    high[:, 1] += np.maximum(start.d - left, 0.0) * back * 1.5
    low[-1, 0] = horizon.goal - start.s
    straight = _ALIGNED if horizon.final[0] < horizon.final[1] else _EXACTLY
    low[-1, 2], high[-1, 2] = -straight, straight
    if own.solver == "ipopt":  # the other has a constraint for that
        low[0, :NX] = high[0, :NX] = guess[0, :NX]
        low[-1, NX:] = high[-1, NX:] = 0.0
    else:
        low[0, :NX], high[0, :NX] = -np.inf, np.inf
    return low, high
