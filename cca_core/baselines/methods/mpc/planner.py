"""Model predictive control in closed loop, called like the planner of this library."""

import math
from collections.abc import Iterable
from typing import Literal

import numpy as np

from cca_core._checks import Array, check_real
from cca_core.baselines.methods.mpc.horizon import FrenetState, Horizon, MpcSettings
from cca_core.baselines.methods.mpc.linear import LinearMpc
from cca_core.baselines.methods.mpc.nonlinear import NonlinearMpc
from cca_core.baselines.methods.mpc.trajectory import Trajectory
from cca_core.decide import Action, Decision
from cca_core.errors import InputError, Status
from cca_core.follow import SpeedSettings, cruise_acceleration, follow_acceleration, jerk_limited
from cca_core.frenet import FrenetVehicle, to_frenet
from cca_core.path import Path, Road, interpolate_path
from cca_core.planner.command import Command
from cca_core.planner.inputs import invalid_input_reason
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState

__all__ = ["MpcPlanner"]

_PERIOD = 0.1  # between two solutions [s]
_OFF_ROUTE = 15.0  # farther from the route than this the planner does not know where it is [m]
_DRIVE_LAG = 0.1  # of drive and brakes [s]
_YAW_LAG = 0.1  # from steering angle to yaw rate [s]
_BRAKE = 4.0  # when there is no solution [m/s^2]
_HELD = 1.0  # for so long an old solution is driven on [s]
# share of the clearance that a way past must keep to be begun, to be gone on with
_BEGUN, _GOES_ON = 0.8, 0.4
_HARDER = 1.5  # share of the lateral acceleration that is allowed outside the own lane
_CURVE = 2.5  # lateral acceleration for which speed is cut in bends [m/s^2]
_IN_THE_WAY = 0.3  # lateral gap to the ego below which a vehicle ahead is followed [m]
_USUAL = 4  # for up to so many others all is built before the first cycle
_SEEN = 250.0  # others farther along the route are left out [m]


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

    Raises
    ------
    InputError
        If an argument has the wrong type or is out of range. After that, `step` never raises.
    MissingExtraError
        If a solver is not installed.

    Notes
    -----
    Ten times a second the way past all others at the wanted speed is asked for; it must end in the ego's own
    lane within the horizon, so that no lane beside is entered that may be needed by somebody beyond it. If
    there is none, the way behind the leader at the speed of `follow_acceleration` is driven. The linear
    controller chooses and draws the way; the nonlinear one begins there and changes speed, too.
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
        self._linear = LinearMpc(self.settings)
        self._nonlinear = NonlinearMpc(self.settings) if method == "nonlinear" else None
        if self._nonlinear is not None:
            for others in range(_USUAL + 1):
                self._nonlinear.prepare(others)
        path = self.road.path
        self._s_cap = np.linspace(path.start, path.end, max(2, math.ceil(path.length / 5.0)))
        bend = np.maximum(np.abs(path.curvature(self._s_cap)), 1e-9)
        self._v_cap = np.minimum(np.sqrt(_CURVE / bend), min(self.cruise_speed, self.road.speed_limit))
        self._t = self._solved = self._found = -math.inf
        self._s: float | None = None
        self._places: dict[str, float] = {}
        self._dropped: tuple[tuple[str, str], ...] = ()
        self._way: Trajectory | None = None
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
            What is known of other vehicles, dead-reckoned to `t`.
        awareness_range : float
            Distance up to which they are all that there are [m]; it plans with those it is told of.

        Returns
        -------
        command : Command
            Steering, acceleration, and why. It never raises and never holds NaN: what cannot be used leads to
            braking with `Status.INVALID_INPUT`, a missing solution to the last one and then to braking with
            `Status.FALLBACK`.
        """
        defect = invalid_input_reason(t, self._t, state)
        if defect:
            return self._brake(defect, Status.INVALID_INPUT)
        moment = float(t)
        dt, self._t = min(moment - self._t, _PERIOD), moment
        try:
            return self._cycle(moment, dt, state, remotes)
        except Exception as error:  # no input and no defect may leave the car without a command
            return self._brake(f"internal error: {error!r}", Status.INVALID_INPUT)

    def _cycle(self, t: float, dt: float, state: VehicleState, remotes: Iterable[RemoteVehicle]) -> Command:
        path = self.road.path
        near = self._s if self._s is not None else float(path.project((state.x, state.y))[0])
        s, d, heading, _ = path.foot_point(state.x, state.y, near)
        if not abs(d) < _OFF_ROUTE:
            return self._brake(f"the ego is not on its route (d = {d:.1f} m)", Status.INVALID_INPUT)
        if math.cos(state.psi - heading) < 0.0:
            reason = f"the ego heads against its route ({state.psi:.2f} instead of {heading:.2f} rad)"
            return self._brake(reason, Status.INVALID_INPUT)
        self._s = s
        if t - self._solved >= _PERIOD - 1e-6:
            neighbors, self._dropped = to_frenet(remotes, path, self._places)
            v = max(state.v_x, 0.0)
            slip = math.atan2(state.v_y, v) if v > 1.0 else 0.0
            gain = self.vehicle.wheelbase + self.vehicle.understeer_gradient * v * v
            start = FrenetState(
                s=s, d=d, angle=math.remainder(state.psi - heading, 2.0 * math.pi) + slip, v=v,
                kappa=state.delta / gain, a_x=min(max(state.a_x, -self.speed.b_max), self.speed.a_max),
            )  # fmt: skip
            self._renew(t, start, neighbors)
        if self._way is None or t - self._found > _HELD:
            return self._brake("no solution", Status.DEGRADED)
        since = t - self._found
        lag = self.vehicle.steering_lag + _YAW_LAG
        delta = float(np.interp(since + lag, self._way.t, self._way.delta))
        a_x = float(np.interp(since + _DRIVE_LAG, self._way.t, self._way.a_x))
        limit = self.vehicle.delta_max
        self._last_delta = min(max(delta, -limit), limit)
        hard = a_x < -2.0 * self.speed.b_comfort
        self._last_a_x = a_x = jerk_limited(a_x, self._last_a_x, dt, self.speed, emergency=hard)
        return Command(
            delta=self._last_delta, a_x=a_x, decision=self._decision, band=None, reference=self._reference,
            status=self._status, dropped=self._dropped,
        )  # fmt: skip

    def _renew(self, t: float, start: FrenetState, neighbors: list[FrenetVehicle]) -> None:
        """Solve again, or keep the last solution."""
        self._solved = t
        rear = start.s + self.vehicle.rear
        own, half = self.road.ego_lane, 0.5 * self.vehicle.width
        others = [
            n for n in neighbors
            if abs(n.s - start.s) < _SEEN
            and not (n.s + n.half_length < rear and own.right < n.d < own.left and n.v_s >= 0.0)
        ]  # fmt: skip
        outside = self._passing and not own.right + half < start.d < own.left - half
        times = np.linspace(0.0, self.settings.horizon, self.settings.intervals + 1)
        hard = 1.0 if not outside else _HARDER
        found: list[tuple[bool, Trajectory]] = []
        for passes in (True, False):
            leader = None if passes else self._leader(others, start)
            if not passes and leader is None:
                break
            s, v = self._profile(start, leader, times)
            horizon = Horizon(
                road=self.road, vehicle=self.vehicle, t=times, others=others, v_wanted=float(v.max()),
                clearance=self.settings.clearance, a_y_max=hard * self.settings.a_y_max,
                share=_GOES_ON if self._passing or not passes else _BEGUN,
                final=(own.right + half, own.left - half),
            )  # fmt: skip
            way = self._linear.solve(horizon, start, s, v)
            if self._nonlinear is not None:
                way = self._refined(self._nonlinear, t if passes else math.inf, horizon, start, way, v)
            found.append((passes, way))
            if way.status is Status.OK:
                break
        good = [f for f in found if f[1].status is Status.OK]
        usable = good or [f for f in reversed(found) if f[1].status is Status.INFEASIBLE]
        self._status = Status.OK if good else Status.DEGRADED
        if not usable:
            self._decision = Decision(action=Action.BRAKE, reason=found[-1][1].message)
            return
        passes, way = usable[0]
        self._way = way
        self._found = t
        self._passing = passes and float(np.abs(way.d).max()) > own.left - half
        self._decide(way, passes, found[0][1].message)
        self._reference = self._along(way)

    def _refined(
        self, solver: NonlinearMpc, t: float, horizon: Horizon, start: FrenetState, way: Trajectory, v: Array
    ) -> Trajectory:
        """Solve for steering and speed, beginning at the last way past if it is young, else at `way`."""
        last, since = self._way, t - self._found
        if self._passing and last is not None and since < 3.5 * _PERIOD:
            end = since + horizon.t - last.t[-1]
            s = np.interp(since + horizon.t, last.t, last.s) + last.v[-1] * np.maximum(end, 0.0)
            again = solver.solve(horizon, start, s, np.interp(since + horizon.t, last.t, last.d), v)
            if again.status is Status.OK:
                return again
        return solver.solve(horizon, start, *way.nodes(len(v)), v)

    def _decide(self, way: Trajectory, passes: bool, obstruction: str) -> None:
        """Say what the chosen way is."""
        if self._status is not Status.OK:
            self._decision = Decision(action=Action.BRAKE, reason=way.message)
        elif not passes:
            self._decision = Decision(action=Action.FOLLOW, reason=f"no way past: {obstruction}")
        elif self._passing:
            left = way.d[np.argmax(np.abs(way.d))] > 0.0
            action = Action.EVADE_LEFT if left else Action.EVADE_RIGHT
            self._decision = Decision(action=action, reason="the way past is free and ends in the own lane")
        else:
            self._decision = Decision(action=Action.KEEP, reason="the lane is free")

    def _leader(self, others: list[FrenetVehicle], start: FrenetState) -> FrenetVehicle | None:
        """Nearest vehicle ahead of the ego, on the route or in its way."""
        half, front = 0.5 * self.vehicle.width + _IN_THE_WAY, start.s + self.vehicle.box_offset
        ahead = [
            n for n in others
            if n.s > front and (abs(n.d) < half + n.half_width or abs(n.d - start.d) < half + n.half_width)
        ]  # fmt: skip
        return min(ahead, key=lambda n: n.s - n.half_length, default=None)

    def _profile(self, start: FrenetState, leader: FrenetVehicle | None, t: Array) -> tuple[Array, Array]:
        """Path coordinates and speeds at times, freely or behind a leader."""
        s, v = np.empty_like(t), np.empty_like(t)
        s[0], v[0], h, last = start.s, max(start.v, 0.0), float(t[1] - t[0]), start.a_x
        own = self.vehicle.front
        for k in range(len(t) - 1):
            a = cruise_acceleration(v[k], float(np.interp(s[k], self._s_cap, self._v_cap)), self.speed)
            if leader is not None:
                rear = leader.occupied_interval(t[k : k + 1], braking=0.0, acceleration=0.0)[0][0]
                a = min(a, follow_acceleration(v[k], rear - s[k] - own, leader.v_s, self.speed))
            last = jerk_limited(a, last, h, self.speed, emergency=a < -2.0 * self.speed.b_comfort)
            v[k + 1] = max(v[k] + h * last, 0.0)
            s[k + 1] = s[k] + 0.5 * h * (v[k] + v[k + 1])
        return s, v

    def _along(self, way: Trajectory) -> Path:
        """Path along a trajectory, for those who want to see it."""
        xy = way.xy(self.road.path)
        kept = np.flatnonzero(np.diff(np.floor((way.s - way.s[0]) / 2.0), prepend=-1.0) > 0.0)
        if len(kept) < 3:
            return self.road.path
        return interpolate_path(xy[kept], start=float(way.s[0]))

    def _brake(self, reason: str, status: Status) -> Command:
        """Hold the steering and brake: the lowest rung of the ladder."""
        self._status, self._decision = status, Decision(action=Action.BRAKE, reason=reason)
        self._last_a_x = -_BRAKE
        return Command(
            delta=self._last_delta, a_x=-_BRAKE, decision=self._decision, band=None,
            reference=self.road.path, status=status, dropped=self._dropped,
        )  # fmt: skip
