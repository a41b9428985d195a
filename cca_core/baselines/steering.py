"""Three textbook steering laws: pure pursuit, Stanley, LQR."""

import math
from typing import Any

import numpy as np
from scipy.linalg import solve_discrete_are

from cca_core._checks import Array, check_real
from cca_core.follow import discretized, single_track, steady_sideslip, steady_steering
from cca_core.geometry import wrap_angle
from cca_core.path import Path
from cca_core.vehicle import VehicleParams, VehicleState

_SPEED_STEP = 0.25  # LQR gains are computed once for each step of speed [m/s]


class PurePursuit:
    """Steer the rear axle along the circle to a goal point on the path ahead.

    Parameters
    ----------
    vehicle : VehicleParams
        Geometry and the limit of the steering angle.
    look_ahead_time : float
        Distance of the goal point per speed [s].
    min_look_ahead : float
        Its smallest distance [m], at low speed.

    Raises
    ------
    InputError
        If a tuning value is not positive.

    Notes
    -----
    delta = atan(L 2 y_g / D^2) with lateral offset y_g and distance D of the goal point in the axes of the
    car, both from the rear axle [1]_. The goal point lies on the path, the look-ahead distance beyond the
    foot point of the rear axle.

    References
    ----------
    .. [1] R. C. Coulter, *Implementation of the Pure Pursuit Path Tracking Algorithm*, CMU-RI-TR-92-01,
       Carnegie Mellon University, 1992.
    """

    name = "pure pursuit"

    def __init__(
        self, vehicle: VehicleParams, *, look_ahead_time: float = 0.7, min_look_ahead: float = 4.0
    ) -> None:
        self.vehicle = vehicle
        self.look_ahead_time = check_real("look_ahead_time", look_ahead_time, gt=0.0)
        self.min_look_ahead = check_real("min_look_ahead", min_look_ahead, gt=0.0)
        self._foot = _FootPoint()

    def steer(self, state: VehicleState, path: Path) -> float:
        """Compute the road-wheel angle for this cycle.

        Parameters
        ----------
        state : VehicleState
            Motion of the car now.
        path : Path
            Path to follow.

        Returns
        -------
        delta : float
            Road-wheel angle [rad], left positive, within the limit of the angle.
        """
        p = self.vehicle
        cos, sin = math.cos(state.psi), math.sin(state.psi)
        x, y = state.x - p.l_r * cos, state.y - p.l_r * sin
        s, _, _, _ = self._foot.on(x, y, path)
        distance = max(self.look_ahead_time * state.v_x, self.min_look_ahead)
        goal_x, goal_y = path.position(s + distance).tolist()
        dx, dy = goal_x - x, goal_y - y
        lateral = cos * dy - sin * dx
        return _limited(math.atan(2.0 * p.wheelbase * lateral / (dx * dx + dy * dy)), p)


class Stanley:
    """Steer the front wheels along the path, and toward it by their lateral error.

    Parameters
    ----------
    vehicle : VehicleParams
        Geometry, mass, front tires and the limit of the steering angle.
    gain : float
        Approach to the path: lateral error times this per speed [1/s].
    softening : float
        Added to the speed in that ratio [m/s].
    yaw_damping : float
        Steering against the difference to the path's yaw rate [s].

    Raises
    ------
    InputError
        If a tuning value is negative.

    Notes
    -----
    delta = -(psi - psi_p) + psi_ss - atan(gain e / (softening + v)) - yaw_damping (r - v kappa) with error e,
    path heading psi_p and curvature kappa at the foot point of the front axle [1]_; psi_ss, the slip of the
    front tires in the steady turn, is m v^2 kappa l_r / (C_f L). The damping of the steering actuator that
    the source adds for its slow actuator is left out.

    References
    ----------
    .. [1] G. M. Hoffmann, C. J. Tomlin, M. Montemerlo, S. Thrun, *Autonomous Automobile Trajectory Tracking
       for Off-Road Driving: Controller Design, Experimental Validation and Racing*, American Control
       Conference, 2007.
    """

    name = "Stanley"

    def __init__(
        self, vehicle: VehicleParams, *, gain: float = 2.5, softening: float = 1.0, yaw_damping: float = 0.1
    ) -> None:
        self.vehicle = vehicle
        self.gain = check_real("gain", gain, ge=0.0)
        self.softening = check_real("softening", softening, ge=0.0)
        self.yaw_damping = check_real("yaw_damping", yaw_damping, ge=0.0)
        self._foot = _FootPoint()

    def steer(self, state: VehicleState, path: Path) -> float:
        """Compute the road-wheel angle for this cycle.

        Parameters
        ----------
        state : VehicleState
            Motion of the car now.
        path : Path
            Path to follow.

        Returns
        -------
        delta : float
            Road-wheel angle [rad], left positive, within the limit of the angle.
        """
        p, v = self.vehicle, max(state.v_x, 0.0)
        x, y = state.x + p.l_f * math.cos(state.psi), state.y + p.l_f * math.sin(state.psi)
        _, e, heading, kappa = self._foot.on(x, y, path)
        slip = p.m * v * v * kappa * p.l_r / (p.C_f * p.wheelbase)
        approach = math.atan2(self.gain * e, self.softening + v) if e else 0.0
        damping = self.yaw_damping * (state.r - v * kappa)
        return _limited(slip - wrap_angle(state.psi - heading) - approach - damping, p)


class LqrSteering:
    """Linear-quadratic regulator of the error states, with steady-state feed-forward of the curvature.

    Parameters
    ----------
    vehicle : VehicleParams
        Geometry, mass, inertia, tires and the limit of the steering angle.
    q_d : float
        Weight of the squared lateral error over that of the squared steering angle [rad^2/m^2].
    q_rate : float
        Weight of its squared rate [rad^2 s^2/m^2].
    q_psi : float
        Weight of the squared heading error [-].
    cycle_time : float
        Time between two steering commands [s], for which the gains are computed.
    min_speed : float
        Speed below which the gains stay as they are there [m/s].

    Raises
    ------
    InputError
        If a weight is negative, or the weight of the lateral error, the cycle time or the speed not positive.

    Notes
    -----
    States, model and feed-forward of [1]_, chapters 2 and 3: the single-track model in the lateral error of
    the center of gravity, its rate, the heading error and its rate. With the steady turn
    (beta_ss, v kappa, -beta_ss, 0) and delta_ss = kappa (L + K v^2) the law is
    delta = delta_ss - k (x - x_ss). The gains k solve the discrete Riccati equation, once for each step of
    0.25 m/s.

    References
    ----------
    .. [1] R. Rajamani, *Vehicle Dynamics and Control*, 2nd ed., Springer, 2012.
    """

    name = "LQR"

    def __init__(
        self,
        vehicle: VehicleParams,
        *,
        q_d: float = 0.01,
        q_rate: float = 0.0,
        q_psi: float = 1.0,
        cycle_time: float = 0.02,
        min_speed: float = 2.0,
    ) -> None:
        self.vehicle = vehicle
        self.q_d = check_real("q_d", q_d, gt=0.0)
        self.q_rate = check_real("q_rate", q_rate, ge=0.0)
        self.q_psi = check_real("q_psi", q_psi, ge=0.0)
        self.cycle_time = check_real("cycle_time", cycle_time, gt=0.0)
        self.min_speed = check_real("min_speed", min_speed, gt=0.0)
        self._foot = _FootPoint()
        self._gains: dict[int, list[float]] = {}

    def gains(self, v_x: float) -> Array:
        """Feedback gains at a speed.

        Parameters
        ----------
        v_x : float
            Forward speed [m/s].

        Returns
        -------
        k : ndarray, shape (4,)
            On sideslip [-], yaw rate [s], heading error [-] and lateral error [rad/m].
        """
        return np.array(self._gains_at(v_x))

    def steer(self, state: VehicleState, path: Path) -> float:
        """Compute the road-wheel angle for this cycle.

        Parameters
        ----------
        state : VehicleState
            Motion of the car now.
        path : Path
            Path to follow.

        Returns
        -------
        delta : float
            Road-wheel angle [rad], left positive, within the limit of the angle.
        """
        p, v = self.vehicle, max(state.v_x, self.min_speed)
        _, d, heading, kappa = self._foot.on(state.x, state.y, path)
        beta_ss = float(steady_sideslip(kappa, v, p))
        k_beta, k_r, k_psi, k_d = self._gains_at(v)
        delta = float(steady_steering(kappa, v, p))
        delta -= k_beta * (math.atan2(state.v_y, v) - beta_ss) + k_r * (state.r - v * kappa)
        delta -= k_psi * (wrap_angle(state.psi - heading) + beta_ss) + k_d * d
        return _limited(delta, p)

    def _gains_at(self, v_x: float) -> list[float]:
        """Gains of the step of speed."""
        step = round(max(v_x, self.min_speed) / _SPEED_STEP)
        if step not in self._gains:
            v = step * _SPEED_STEP
            model = discretized(single_track(self.vehicle, v, 0.0), self.cycle_time)
            rate = np.array([v, 0.0, v, 0.0])  # of the lateral error
            Q = self.q_rate * np.outer(rate, rate) + np.diag([0.0, 0.0, self.q_psi, self.q_d])
            A, B = model.A, model.B[:, None]
            P: Any = solve_discrete_are(A, B, Q, np.eye(1))
            self._gains[step] = ((B.T @ P @ A) / (1.0 + B.T @ P @ B))[0].tolist()
        return self._gains[step]


class _FootPoint:
    """Foot point on a path, searched from the last one."""

    def __init__(self) -> None:
        self._last: tuple[Path, float] | None = None

    def on(self, x: float, y: float, path: Path) -> tuple[float, float, float, float]:
        """Arc length [m], lateral offset [m], heading [rad] and curvature [1/m] at the foot point."""
        same = self._last is not None and self._last[0] is path
        s_guess = self._last[1] if same and self._last is not None else float(path.project((x, y))[0])
        found = path.foot_point(x, y, s_guess)
        self._last = path, found[0]
        return found


def _limited(delta: float, vehicle: VehicleParams) -> float:
    """Limit a steering angle."""
    return min(max(delta, -vehicle.delta_max), vehicle.delta_max)
