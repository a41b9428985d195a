"""Nonlinear model predictive control by CasADi: steering rate and jerk of a bicycle on the route."""

from dataclasses import replace

import numpy as np

from cca_core._checks import Array, check_real
from cca_core._optional import require_extra
from cca_core.baselines.methods.mpc.horizon import SAMPLES, FrenetState, Horizon, MpcSettings
from cca_core.baselines.methods.mpc.linear import LinearMpc
from cca_core.baselines.methods.mpc.nonlinear_program import NU, NX, NonlinearProgram, cached_program
from cca_core.baselines.methods.mpc.trajectory import Trajectory, violated_limit
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.errors import Status

_SLOTS = (0, 1, 2, 3, 4, 6, 8)  # numbers of vehicles for which a program is built
# half axes of a rounded box over those of the box that it surrounds: 1.22^-8 + 1.03^-8 = 1
_ROUND_LENGTH, _ROUND_WIDTH = 1.22, 1.03


class NonlinearMpc:
    """Nonlinear controller of steering and speed.

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
    A bicycle in Frenet coordinates that turns as in the steady state, kappa = delta / (L + K v^2):
    s' = v cos(angle) / (1 - d kappa_r), d' = v sin(angle), angle' = v kappa - kappa_r s', v' = a_x, with the
    rates of delta and a_x as inputs. One Runge-Kutta step per interval, multiple shooting, exact derivatives.
    Each vehicle is a rounded box (x/a)^8 + (y/b)^8 = 1 around the positions at which the bodies, their
    clearance and their motion within half an interval overlap. The largest violation of these boxes and of
    the lane at the end has an exact linear penalty. A program is built once for a number of intervals and
    vehicles; everything else is a parameter. It starts from the result of the linear controller, which
    chooses the sides.
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
            The problem.

        Returns
        -------
        plan : Plan
            Five samples per interval; it reaches the goal in the time that the wanted speed takes.
        """
        path = problem.road.path
        horizon = Horizon.of(problem, self.settings.intervals)
        start = FrenetState(s=problem.start, v=problem.v_x, kappa=path.curvature_at(problem.start))
        v = np.full(len(horizon.t), problem.v_x)
        wider = replace(horizon, clearance=problem.clearance + self.settings.guess_margin)
        guess = self._linear.solve(wider, start, problem.start + v * horizon.t, v)
        return self.solve(horizon, start, *guess.nodes(len(v)), v).plan(path)

    def prepare(self, vehicles: int) -> None:
        """Build the program for a number of other vehicles ahead of its use, which takes 0.1 s once.

        Parameters
        ----------
        vehicles : int
            Largest number of vehicles [-]; of more than eight the nearest ones count.
        """
        self.program(vehicles)

    def program(self, vehicles: int) -> NonlinearProgram:
        """Program for a number of other vehicles.

        Parameters
        ----------
        vehicles : int
            Largest number of vehicles [-].

        Returns
        -------
        program : NonlinearProgram
            The same one for the same settings.

        Raises
        ------
        InputError
            If `vehicles` is no number, or negative.
        """
        vehicles = int(check_real("vehicles", vehicles, ge=0))
        slots, own = next((m for m in _SLOTS if m >= vehicles), _SLOTS[-1]), self.settings
        return cached_program(
            own.intervals, slots, own.solver, own.iterations, own.cpu_time, own.vehicle_penalty
        )

    def solve(self, horizon: Horizon, start: FrenetState, s: Array, d: Array, v: Array) -> Trajectory:
        """Find the local optimum near a guess.

        Parameters
        ----------
        horizon : Horizon
            Limits and all other vehicles, with the intervals of the settings.
        start : FrenetState
            The ego now.
        s, d : ndarray, shape (n + 1,)
            The guess: stations and offsets at the times of the horizon [m], which choose the sides.
        v : ndarray, shape (n + 1,)
            Wanted speeds then [m/s].

        Returns
        -------
        trajectory : Trajectory
            Five samples per interval.
        """
        own, vehicle = self.settings, horizon.vehicle
        near = _nearest(horizon, s)
        program = self.program(len(near))
        guess = _guess(horizon, start, s, d)
        understeer = vehicle.understeer_gradient
        common = np.array(
            [horizon.step, vehicle.wheelbase, understeer, own.weight_d, own.weight_a, own.weight_jerk,
             own.weight_v, own.weight_a_x]
        )  # fmt: skip
        road = horizon.road.path.curvature(s)
        boxes = _rounded_boxes(horizon, start.s, near, program.slots, own.vehicle_margin)
        low, high = _bounds(horizon, start, guess, own)
        given = np.concatenate((common, road, v, boxes.ravel()))
        z, cost, failure = program.run(guess, low, high, given, horizon)
        motion = program.sampled(guess if failure else z, common, road)
        v, delta = motion[3], motion[4]
        fine = horizon.step / SAMPLES * np.arange(SAMPLES)
        trajectory = Trajectory(
            status=Status.OK, message="", t=np.append(np.add.outer(horizon.t[:-1], fine), horizon.t[-1]),
            s=start.s + motion[0], d=motion[1], angle=motion[2], v=v,
            kappa=delta / (vehicle.wheelbase + understeer * v * v), delta=delta, a_x=motion[5], cost=cost,
        )  # fmt: skip
        if failure:
            return replace(trajectory, status=Status.NOT_CONVERGED, message=f"the solver failed: {failure}")
        violated = violated_limit(trajectory, horizon)
        return trajectory if not violated else replace(trajectory, status=Status.INFEASIBLE, message=violated)


def _nearest(horizon: Horizon, s: Array) -> list[int]:
    """Vehicles that come within 60 m along the route, nearest first, as many as there are slots."""
    distance = [float(np.abs(row - s).min()) for row in horizon.stations()]
    near = [i for i in np.argsort(distance) if distance[i] < 60.0]
    return near[: _SLOTS[-1]]


def _rounded_boxes(horizon: Horizon, s_start: float, near: list[int], slots: int, margin: float) -> Array:
    """Center and half axes (n + 1, slots, 4) of the rounded boxes; those of empty slots are far away."""
    vehicle = horizon.vehicle
    found = np.full((len(horizon.t), slots, 4), [-1e3, 0.0, 1.0, 1.0])
    stations, swept = horizon.stations(), horizon.swept_half_lengths()
    for i, k in enumerate(near):
        other = horizon.others[k]
        found[:, i, 0], found[:, i, 1] = stations[k] - vehicle.box_offset - s_start, other.d
        found[:, i, 2] = _ROUND_LENGTH * (swept[k] + 0.5 * vehicle.length + horizon.clearance)
        half_width = other.half_width + 0.5 * vehicle.width + horizon.clearance + margin
        found[:, i, 3] = _ROUND_WIDTH * half_width
    return found


def _guess(horizon: Horizon, start: FrenetState, s: Array, d: Array) -> Array:
    """States and inputs (n + 1, 8) that approximate the motion of a guess."""
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
    """Smallest and largest values of all variables, shape as the guess."""
    vehicle = horizon.vehicle
    right, left = horizon.edges
    v_max = max(1.1 * horizon.v_wanted, start.v + 1.0)
    turn, rate = vehicle.delta_max, vehicle.delta_rate_max
    low, high = np.empty_like(guess), np.empty_like(guess)
    low[:] = [-np.inf, right, -np.inf, 0.0, -turn, -own.b_max, -rate, -own.jerk_max]
    high[:] = [np.inf, left, np.inf, v_max, turn, own.a_max, rate, own.jerk_max]
    back = np.exp(-horizon.t / 1.0)  # an ego off the road has time to return
    low[:, 1] -= np.maximum(right - start.d, 0.0) * back * 1.5
    high[:, 1] += np.maximum(start.d - left, 0.0) * back * 1.5
    low[-1, 0] = horizon.goal - start.s
    # a plan ends on the route and along it
    straight = own.heading_tolerance if horizon.final_d[0] < horizon.final_d[1] else 1e-3
    low[-1, 2], high[-1, 2] = -straight, straight
    if own.solver == "ipopt":  # FATROP has a constraint for the start
        low[0, :NX] = high[0, :NX] = guess[0, :NX]
        low[-1, NX:] = high[-1, NX:] = 0.0
    else:
        low[0, :NX], high[0, :NX] = -np.inf, np.inf
    return low, high
