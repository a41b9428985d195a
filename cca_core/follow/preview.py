"""Preview steering: PD control of the lateral error ahead, and feedforward of curvature."""

import math
from typing import Literal

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.follow.feedforward import ROLLING_SPEED, InverseSteering
from cca_core.follow.schedule import SIDESLIP_FRACTION, PreviewGains, shipped_gains
from cca_core.geometry import wrap_angle
from cca_core.path.path import Path
from cca_core.vehicle import GRAVITY, VehicleParams, VehicleState

_INTEGRAL_TIME = 3.0  # slow: it corrects what the model omits, such as load and alignment [s]
_INTEGRAL_LIMIT = 0.02  # [rad]


class PreviewController:
    """Steering law delta = delta_ff - k_p (e_y - e_ref) - k_d (e_y' - e_ref') - integral.

    Parameters
    ----------
    vehicle : VehicleParams
        The controlled vehicle.
    gains : PreviewGains, optional
        Schedule over speed; the default is the shipped schedule of this vehicle (`shipped_gains`).
    delay : float
        Known dead time between command and road wheel [s], on top of the steering lag.
    a_y_max : float
        Limit of the commanded lateral acceleration [m/s^2]. It limits the steady turn. Before the vehicle has
        begun to turn it limits the force of the front tires instead, to 80 % of their grip at most.
    error : {"tangent", "ahead"}
        Reference of the error at the preview point: the tangent at the foot point of the center of gravity,
        or the path itself at the preview point.

    Raises
    ------
    InputError
        If an argument is out of range.

    Notes
    -----
    The feedforward delta_ff keeps an ideal car exactly on the path (`InverseSteering`). It uses the curvature
    at the point that the car reaches when the wheels have responded. The ideal car has a sideslip and a yaw
    rate on curves; e_ref is the error of its preview point. The feedback therefore acts only on deviations
    from the model. Three tenths of the sideslip are measured, because load and tires differ from the model.
    For the tangent e_ref is -l_s sin(beta); for the path itself the curvature over the preview distance adds.
    """

    def __init__(
        self,
        vehicle: VehicleParams,
        gains: PreviewGains | None = None,
        *,
        delay: float = 0.0,
        a_y_max: float = 8.0,
        error: Literal["tangent", "ahead"] = "tangent",
    ) -> None:
        if error not in ("tangent", "ahead"):
            raise InputError(f"error must be 'tangent' or 'ahead', was {error!r}")
        self.vehicle = vehicle
        self.gains = gains or shipped_gains(vehicle)
        self.delay = check_real("delay", delay, ge=0.0)
        self.a_y_max = check_real("a_y_max", a_y_max, gt=0.0)
        self._ahead = error == "ahead"
        self._inverse = InverseSteering(vehicle)
        self._foot: tuple[Path, float] | None = None
        self._integral = 0.0
        self._delta: float | None = None

    def __repr__(self) -> str:
        return f"PreviewController(gains at {len(self.gains.speeds)} speeds, delay={self.delay:g} s)"

    def steer(
        self, state: VehicleState, path: Path, dt: float = 0.02, *, s_guess: float | None = None
    ) -> float:
        """Road-wheel angle for this cycle.

        Parameters
        ----------
        state : VehicleState
            Motion of the vehicle now.
        path : Path
            Path to follow.
        dt : float
            Time since the last call [s].
        s_guess : float, optional
            Station close to the vehicle on a path that is new to the controller [m]; the default searches the
            whole path.

        Returns
        -------
        delta : float
            Road-wheel angle [rad], left positive, within the limits of angle, rate and lateral acceleration.
        """
        p, v = self.vehicle, max(state.v_x, 0.0)
        if self._foot is not None and self._foot[0] is path:
            s_guess = self._foot[1] + v * dt
        elif s_guess is None:
            s_guess = float(path.project((state.x, state.y))[0])
        s, d, heading, kappa = path.foot_point(float(state.x), float(state.y), s_guess)
        self._foot = path, s
        ahead = s + v * (self.delay + p.steering_lag)
        feedforward = self._inverse.advance(ahead, path.curvature_at(ahead), v, dt)
        beta, r = self._inverse.motion_at(s)
        if v > ROLLING_SPEED:
            beta += SIDESLIP_FRACTION * (math.atan2(state.v_y, v) - beta)
        k_p, k_d, l_s = self.gains.at(v)
        e_psi = wrap_angle(state.psi - heading)
        sin, cos = math.sin(e_psi), math.cos(e_psi)
        error = d + l_s * (sin + math.sin(beta))
        if self._ahead:
            error = self._error_ahead(state, path, s, l_s) + l_s * math.sin(beta) + 0.5 * kappa * l_s * l_s
        rate = v * sin + state.v_y * cos + l_s * (state.r - r)
        target = feedforward - k_p * error - k_d * rate - self._integral
        delta = self._limited(target, state, dt)
        if delta == target and abs(d) < 0.1 and v > 1.0:  # only small errors: large ones are transients
            integral = self._integral + k_p * d * dt / _INTEGRAL_TIME
            self._integral = min(max(integral, -_INTEGRAL_LIMIT), _INTEGRAL_LIMIT)
        self._delta = float(delta)
        return self._delta

    def _error_ahead(self, state: VehicleState, path: Path, s: float, l_s: float) -> float:
        x, y = state.x + l_s * math.cos(state.psi), state.y + l_s * math.sin(state.psi)
        return path.foot_point(x, y, s + l_s)[1]

    def _limited(self, delta: float, state: VehicleState, dt: float) -> float:
        p, v = self.vehicle, max(state.v_x, 1.0)
        turn = p.wheelbase + max(p.understeer_gradient, 0.0) * v * v
        steady = math.atan(turn * self.a_y_max / (v * v))
        # direction of motion of the front wheels; beyond 80 % of the grip a car on a slippery road spins
        motion = math.atan2(state.v_y + p.l_f * state.r, v)
        slip = self._inverse.front_slip(min(self.a_y_max / (p.mu * GRAVITY), 0.8))
        low = max(min(-steady, motion - slip), -p.delta_max)
        high = min(max(steady, motion + slip), p.delta_max)
        delta = min(max(delta, low), high)
        if self._delta is not None:
            step = p.delta_rate_max * dt
            delta = min(max(delta, self._delta - step), self._delta + step)
        return delta
