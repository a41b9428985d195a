"""Model predictive control in closed loop, with the interface of the planner of this library."""

import math
from collections.abc import Iterable
from typing import Literal

import numpy as np

from cca_core._checks import Array, check_real
from cca_core.baselines.methods.mpc.horizon import FrenetState, Horizon, MpcSettings
from cca_core.baselines.methods.mpc.linear import LinearMpc
from cca_core.baselines.methods.mpc.nonlinear import NonlinearMpc
from cca_core.baselines.methods.mpc.planner_settings import MpcPlannerSettings
from cca_core.baselines.methods.mpc.speed_profile import SpeedProfile
from cca_core.baselines.methods.mpc.trajectory import Trajectory
from cca_core.decide import Action, Decision
from cca_core.decide.action import explained
from cca_core.errors import InputError, Status
from cca_core.follow import SpeedSettings, jerk_limited
from cca_core.frenet import FrenetVehicle, to_frenet
from cca_core.path import Path, Road
from cca_core.planner.command import Command
from cca_core.planner.inputs import invalid_input_reason
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState


class MpcPlanner:
    """Steering and acceleration from the solution of a predictive controller.

    Parameters
    ----------
    vehicle : VehicleParams
        The ego.
    road : Road or Path
        Route and lanes; a bare path is one lane of 3.5 m.
    cruise_speed : float
        Wanted speed [m/s].
    method : {"nonlinear", "linear"}
        Controller: `NonlinearMpc`, or `LinearMpc` along a speed profile.
    settings : MpcSettings, optional
        Horizon, limits and weights.
    speed : SpeedSettings, optional
        How the ego accelerates and follows.
    planning : MpcPlannerSettings, optional
        Limits and thresholds in closed loop.

    Raises
    ------
    InputError
        If an argument has the wrong type or is out of range. After that, `step` never raises.
    MissingExtraError
        If a solver is not installed.

    Notes
    -----
    The planner computes a trajectory past all vehicles at the wanted speed in each `replan_period`. It must
    end in the ego lane within the horizon: an adjacent lane is never needed beyond it. If there is none, the
    planner computes a trajectory behind the lead vehicle at the speed of `follow_acceleration`. The linear
    controller chooses the sides; the nonlinear one starts from its result and changes the speed, too.
    """

    def __init__(
        self,
        vehicle: VehicleParams,
        road: Road | Path,
        *,
        cruise_speed: float,
        method: Literal["nonlinear", "linear"] = "nonlinear",
        settings: MpcSettings | None = None,
        speed: SpeedSettings | None = None,
        planning: MpcPlannerSettings | None = None,
    ) -> None:
        if not isinstance(vehicle, VehicleParams):
            raise InputError(f"vehicle must be VehicleParams, was {type(vehicle).__name__}")
        if not isinstance(road, Road | Path):
            raise InputError(f"road must be Road or Path, was {type(road).__name__}")
        if method not in ("nonlinear", "linear"):
            raise InputError(f"method must be 'nonlinear' or 'linear', was {method!r}")
        self.vehicle = vehicle
        self.road = road if isinstance(road, Road) else Road(road)
        self.cruise_speed = check_real("cruise_speed", cruise_speed, gt=0.0)
        self.settings, self.speed = settings or MpcSettings(), speed or SpeedSettings()
        self.planning = planning or MpcPlannerSettings()
        self._linear = LinearMpc(self.settings)
        self._nonlinear = NonlinearMpc(self.settings) if method == "nonlinear" else None
        if self._nonlinear is not None:
            for vehicles in range(self.planning.prepared_vehicles + 1):
                self._nonlinear.prepare(vehicles)
        path = self.road.path
        v_max = min(self.cruise_speed, self.road.speed_limit)
        self._profile = SpeedProfile(path, vehicle, self.speed, v_max, self.planning.curve_a_y)
        self._t = self._t_solved = self._t_found = -math.inf
        self._s: float | None = None
        self._last_s: dict[str, float] = {}
        self._dropped: tuple[tuple[str, str], ...] = ()
        self._trajectory: Trajectory | None = None
        self._passing = False
        self._decision = Decision(action=Action.KEEP, reason="starting")
        self._status = Status.OK
        self._reference: Path = path
        self._last_delta = self._last_a_x = 0.0

    def step(
        self,
        t: float,
        state: VehicleState,
        remotes: Iterable[RemoteVehicle],
        *,
        awareness_range: float = math.inf,
    ) -> Command:
        """Compute steering and acceleration for this cycle.

        Parameters
        ----------
        t : float
            Time [s], increasing from call to call.
        state : VehicleState
            The ego's motion now.
        remotes : iterable of RemoteVehicle
            The other vehicles, dead-reckoned to `t`.
        awareness_range : float
            Ignored: this planner assumes that no other vehicles exist [m].

        Returns
        -------
        command : Command
            Steering and acceleration with the reason. It never raises and never contains NaN: on unusable
            input the ego brakes with `Status.INVALID_INPUT`. Without a solution it continues the last one and
            then brakes, with `Status.DEGRADED`.
        """
        invalid = invalid_input_reason(t, self._t, state)
        if invalid:
            return self._brake(invalid, Status.INVALID_INPUT)
        now = float(t)
        dt, self._t = min(now - self._t, self.planning.replan_period), now
        try:
            return self._cycle(now, dt, state, remotes)
        except Exception as error:  # no input and no fault may leave the car without a command
            return self._brake(f"internal error: {error!r}", Status.INVALID_INPUT)

    def _cycle(self, t: float, dt: float, state: VehicleState, remotes: Iterable[RemoteVehicle]) -> Command:
        """Command of a cycle with valid time and state."""
        path, own = self.road.path, self.planning
        s_guess = self._s if self._s is not None else float(path.project((state.x, state.y))[0])
        s, d, heading, _ = path.foot_point(state.x, state.y, s_guess)
        if not abs(d) < own.max_route_offset:
            reason = f"ego {abs(d):.1f} m off the route (limit {own.max_route_offset:.1f} m)"
            return self._brake(reason, Status.INVALID_INPUT)
        if math.cos(state.psi - heading) < 0.0:
            reason = f"ego against the route: heading {state.psi:.2f} rad, route {heading:.2f} rad"
            return self._brake(reason, Status.INVALID_INPUT)
        self._s = s
        if t - self._t_solved >= own.replan_period - 1e-6:
            others, self._dropped = to_frenet(remotes, path, self._last_s)
            v = max(state.v_x, 0.0)
            slip = math.atan2(state.v_y, v) if v > 1.0 else 0.0
            gain = self.vehicle.wheelbase + self.vehicle.understeer_gradient * v * v
            start = FrenetState(
                s=s, d=d, angle=math.remainder(state.psi - heading, 2.0 * math.pi) + slip, v=v,
                kappa=state.delta / gain, a_x=min(max(state.a_x, -self.speed.b_max), self.speed.a_max),
            )  # fmt: skip
            self._replan(t, start, others)
        if self._trajectory is None or t - self._t_found > own.hold_time:
            return self._brake("no solution", Status.DEGRADED)
        return self._follow(self._trajectory, t - self._t_found, dt)

    def _follow(self, trajectory: Trajectory, age: float, dt: float) -> Command:
        """Command from a trajectory of some age, ahead by the lags of the car."""
        steering_lag = self.vehicle.steering_lag + self.planning.yaw_lag
        delta = float(np.interp(age + steering_lag, trajectory.t, trajectory.delta))
        a_x = float(np.interp(age + self.planning.drive_lag, trajectory.t, trajectory.a_x))
        limit = self.vehicle.delta_max
        self._last_delta = min(max(delta, -limit), limit)
        hard = a_x < -2.0 * self.speed.b_comfort
        self._last_a_x = a_x = jerk_limited(a_x, self._last_a_x, dt, self.speed, emergency=hard)
        return Command(
            delta=self._last_delta, a_x=a_x, decision=self._decision, band=None, reference=self._reference,
            status=self._status, dropped=self._dropped,
        )  # fmt: skip

    def _replan(self, t: float, start: FrenetState, others: list[FrenetVehicle]) -> None:
        """Solve again, or keep the last solution."""
        self._t_solved = t
        found = self._solutions(t, start, self._relevant(start, others))
        good = [f for f in found if f[1].status is Status.OK]
        usable = good or [f for f in reversed(found) if f[1].status is Status.INFEASIBLE]
        self._status = Status.OK if good else Status.DEGRADED
        if not usable:
            self._decision = Decision(action=Action.BRAKE, reason=found[-1][1].message)
            return
        passes, trajectory = usable[0]
        self._trajectory, self._t_found = trajectory, t
        leftmost = self.road.ego_lane.left - 0.5 * self.vehicle.width
        self._passing = passes and float(np.abs(trajectory.d).max()) > leftmost
        self._decide(trajectory, passes, found[0][1].message)
        self._reference = trajectory.path(self.road.path)

    def _relevant(self, start: FrenetState, others: list[FrenetVehicle]) -> list[FrenetVehicle]:
        """Vehicles within range, without those that follow the ego in its lane."""
        rear, lane = start.s + self.vehicle.rear, self.road.ego_lane
        return [
            n for n in others
            if abs(n.s - start.s) < self.planning.vehicle_range
            and not (n.s + n.half_length < rear and lane.right < n.d < lane.left and n.v_s >= 0.0)
        ]  # fmt: skip

    def _solutions(
        self, t: float, start: FrenetState, others: list[FrenetVehicle]
    ) -> list[tuple[bool, Trajectory]]:
        """Trajectory past all vehicles, and if that fails the one behind the lead; True is the former."""
        lane, half, own = self.road.ego_lane, 0.5 * self.vehicle.width, self.planning
        outside = self._passing and not lane.right + half < start.d < lane.left - half
        a_y_factor = own.outside_a_y_factor if outside else 1.0
        times = np.linspace(0.0, self.settings.horizon, self.settings.intervals + 1)
        found: list[tuple[bool, Trajectory]] = []
        for passes in (True, False):
            lead = None if passes else self._find_lead(others, start)
            if not passes and lead is None:
                break
            starts = passes and not self._passing
            s, v = self._profile.at(times, start, lead)
            horizon = Horizon(
                road=self.road, vehicle=self.vehicle, t=times, others=others, v_wanted=float(v.max()),
                clearance=self.settings.clearance, a_y_max=a_y_factor * self.settings.a_y_max,
                clearance_fraction=own.start_fraction if starts else own.continue_fraction,
                final_d=(lane.right + half, lane.left - half),
            )  # fmt: skip
            trajectory = self._linear.solve(horizon, start, s, v)
            if self._nonlinear is not None:
                age = t - self._t_found if passes else math.inf
                trajectory = self._refined(self._nonlinear, age, horizon, start, trajectory, v)
            found.append((passes, trajectory))
            if trajectory.status is Status.OK:
                break
        return found

    def _refined(
        self,
        solver: NonlinearMpc,
        age: float,
        horizon: Horizon,
        start: FrenetState,
        guess: Trajectory,
        v: Array,
    ) -> Trajectory:
        """Solve from the last trajectory if it passes and is recent, else from a guess."""
        last = self._trajectory
        if self._passing and last is not None and age < 3.5 * self.planning.replan_period:
            beyond = age + horizon.t - last.t[-1]
            s = np.interp(age + horizon.t, last.t, last.s) + last.v[-1] * np.maximum(beyond, 0.0)
            again = solver.solve(horizon, start, s, np.interp(age + horizon.t, last.t, last.d), v)
            if again.status is Status.OK:
                return again
        return solver.solve(horizon, start, *guess.nodes(len(v)), v)

    def _decide(self, trajectory: Trajectory, passes: bool, rejection: str) -> None:
        """Set the decision for the chosen trajectory."""
        if self._status is not Status.OK:
            self._decision = Decision(action=Action.BRAKE, reason=trajectory.message)
        elif not passes:
            self._decision = explained(Action.FOLLOW, "passing rejected", rejection)
        elif self._passing:
            left = trajectory.d[np.argmax(np.abs(trajectory.d))] > 0.0
            action = Action.EVADE_LEFT if left else Action.EVADE_RIGHT
            self._decision = explained(action, "passing", "the trajectory is clear and ends in the ego lane")
        else:
            self._decision = Decision(action=Action.KEEP, reason="keeping lane: no vehicle ahead")

    def _find_lead(self, others: list[FrenetVehicle], start: FrenetState) -> FrenetVehicle | None:
        """Nearest vehicle ahead that blocks the route or the ego's present offset."""
        half = 0.5 * self.vehicle.width + self.planning.blocking_gap
        center = start.s + self.vehicle.box_offset
        ahead = [
            n for n in others
            if n.s > center and (abs(n.d) < half + n.half_width or abs(n.d - start.d) < half + n.half_width)
        ]  # fmt: skip
        return min(ahead, key=lambda n: n.s - n.half_length, default=None)

    def _brake(self, reason: str, status: Status) -> Command:
        """Hold the steering and brake."""
        self._status, self._decision = status, Decision(action=Action.BRAKE, reason=reason)
        self._last_a_x = -self.planning.stop_deceleration
        return Command(
            delta=self._last_delta, a_x=self._last_a_x, decision=self._decision, band=None,
            reference=self.road.path, status=status, dropped=self._dropped,
        )  # fmt: skip
