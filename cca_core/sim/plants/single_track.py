"""A single-track car on tires that can slide, as plant."""

import math

from cca_core._checks import check_real
from cca_core.vehicle import GRAVITY, VehicleParams, VehicleState

_MIN_SLIP_SPEED = 1.0  # below this the car rolls without slip [m/s]


class SingleTrackPlant:
    """Nonlinear single-track car with friction-limited tires and lagging actuators.

    Parameters
    ----------
    vehicle : VehicleParams
        Geometry, inertia, tires, friction and steering actuator.
    state : VehicleState
        Motion of the center of gravity at the start.
    drive_lag : float
        Time constant of drive and brakes [s].

    Raises
    ------
    InputError
        If `drive_lag` is negative.

    Notes
    -----
    Brush tires (Fiala): with slip angle alpha and available side force F_max,
    ``F_y = -F_max z (1 - |z|/3 + z^2/27)`` with ``z = C tan(alpha) / F_max`` up to sliding at ``|z| = 3``.
    The drive or brake force, shared between the axles like the load, takes its part of the friction
    circle first. Integrated by the classical Runge-Kutta scheme.
    """

    def __init__(self, vehicle: VehicleParams, state: VehicleState, *, drive_lag: float = 0.1) -> None:
        self.vehicle = vehicle
        self.drive_lag = check_real("drive_lag", drive_lag, ge=0.0)
        self._x = [state.x, state.y, state.psi, state.v_x, state.v_y, state.r, state.delta, state.a_x]
        self.a_y = 0.0
        grip = vehicle.mu * GRAVITY
        # the front axle's share of load and drive, loads of both axles, grip and hardest drive, the body
        self._constants = (
            vehicle.l_r / vehicle.wheelbase, vehicle.m * vehicle.l_r / vehicle.wheelbase,
            vehicle.m * vehicle.l_f / vehicle.wheelbase, grip, 0.99 * grip,
            vehicle.m, vehicle.I_z, vehicle.l_f, vehicle.l_r, vehicle.C_f, vehicle.C_r,
        )  # fmt: skip
        self._actuators = vehicle.delta_rate_max, max(vehicle.steering_lag, 1e-3), max(self.drive_lag, 1e-3)

    @property
    def state(self) -> VehicleState:
        """Motion of the center of gravity now."""
        x, y, psi, v_x, v_y, r, delta, a_x = self._x
        return VehicleState(x=x, y=y, psi=psi, v_x=v_x, v_y=v_y, r=r, delta=delta, a_x=a_x)

    def step(self, delta: float, a_x: float, dt: float) -> None:
        """Advance by a time step.

        Parameters
        ----------
        delta : float
            Commanded road-wheel angle [rad], left positive.
        a_x : float
            Commanded acceleration [m/s^2].
        dt : float
            Time step [s].
        """
        limit = self.vehicle.delta_max
        delta = min(max(delta, -limit), limit)
        if self._x[3] == 0.0 and a_x <= 0.0 and self._x[7] <= 0.0:
            self._rest(delta, dt)
            return
        # the lateral dynamics are faster at low speed: half the step below 5 m/s
        n = max(1, math.ceil(dt / (0.01 if self._x[3] > 5.0 else 0.5 * 0.01) - 1e-9))
        h = dt / n
        for _ in range(n):
            x, y, psi, v, w, r, angle, force = self._x
            slope, m = self._derivative, 0.5 * h
            ax, ay, ap, av, aw, ar, aa, af = slope(psi, v, w, r, angle, force, delta, a_x)
            bx, by, bp, bv, bw, br, ba, bf = slope(
                psi + m * ap, v + m * av, w + m * aw, r + m * ar, angle + m * aa, force + m * af, delta, a_x
            )
            cx, cy, cp, cv, cw, cr, ca, cf = slope(
                psi + m * bp, v + m * bv, w + m * bw, r + m * br, angle + m * ba, force + m * bf, delta, a_x
            )
            dx, dy, dp, dv, dw, dr, da, df = slope(
                psi + h * cp, v + h * cv, w + h * cw, r + h * cr, angle + h * ca, force + h * cf, delta, a_x
            )
            m = h / 6.0
            self._x = [
                x + m * (ax + 2.0 * bx + 2.0 * cx + dx),
                y + m * (ay + 2.0 * by + 2.0 * cy + dy),
                psi + m * (ap + 2.0 * bp + 2.0 * cp + dp),
                v + m * (av + 2.0 * bv + 2.0 * cv + dv),
                w + m * (aw + 2.0 * bw + 2.0 * cw + dw),
                r + m * (ar + 2.0 * br + 2.0 * cr + dr),
                angle + m * (aa + 2.0 * ba + 2.0 * ca + da),
                force + m * (af + 2.0 * bf + 2.0 * cf + df),
            ]
            if self._x[3] < _MIN_SLIP_SPEED:
                self._roll()
        _, _, psi, v, w, r, angle, force = self._x
        self.a_y = self._derivative(psi, v, w, r, angle, force, delta, a_x)[4] + v * r

    def _rest(self, delta: float, dt: float) -> None:
        """Stand with the brakes applied; only the steering moves."""
        turn = (delta - self._x[6]) * -math.expm1(-dt / self._actuators[1])
        limit = self.vehicle.delta_rate_max * dt
        self._x[6] += min(max(turn, -limit), limit)
        self._x[4] = self._x[5] = self._x[7] = self.a_y = 0.0

    def _roll(self) -> None:
        """Remove slip and reversing at low speed."""
        v = self._x[3] = max(self._x[3], 0.0)
        if v == 0.0:
            self._x[7] = max(self._x[7], 0.0)
        self._x[5] = v * math.tan(self._x[6]) / self.vehicle.wheelbase
        self._x[4] = self.vehicle.l_r * self._x[5]

    def _derivative(
        self,
        psi: float,
        v_x: float,
        v_y: float,
        r: float,
        angle: float,
        force: float,
        delta: float,
        a_x: float,
    ) -> tuple[float, float, float, float, float, float, float, float]:
        """Rates of change of the eight states; they do not depend on the position."""
        front, load_f, load_r, grip, hardest, m, i_z, l_f, l_r, c_f, c_r = self._constants
        fastest, steering_lag, drive_lag = self._actuators
        rate = (delta - angle) / steering_lag
        rate = min(max(rate, -fastest), fastest)
        drive = (min(max(a_x, -hardest), hardest) - force) / drive_lag
        cos, sin = math.cos(psi), math.sin(psi)
        if v_x < _MIN_SLIP_SPEED:
            return v_x * cos - v_y * sin, v_x * sin + v_y * cos, r, force, 0.0, 0.0, rate, drive
        side = math.sqrt(max(grip * grip - force * force, (0.1 * grip) ** 2))
        cos_d, sin_d = math.cos(angle), math.sin(angle)
        v_f, v_r = v_y + l_f * r, v_y - l_r * r
        slip_f = (v_f * cos_d - v_x * sin_d) / max(abs(v_x * cos_d + v_f * sin_d), 1e-6)
        f_f = fiala_force(c_f, slip_f, load_f * side)
        f_r = fiala_force(c_r, v_r / v_x, load_r * side)
        pull = m * front * force  # of the front axle, along its wheels
        front_x, front_y = pull * cos_d - f_f * sin_d, pull * sin_d + f_f * cos_d
        return (
            v_x * cos - v_y * sin,
            v_x * sin + v_y * cos,
            r,
            force * (1.0 - front) + front_x / m + v_y * r,
            (front_y + f_r) / m - v_x * r,
            (l_f * front_y - l_r * f_r) / i_z,
            rate,
            drive,
        )


def fiala_force(stiffness: float, slip: float, f_max: float) -> float:
    """Side force [N] for the tangent of the slip angle."""
    z = stiffness * slip / f_max
    if z >= 3.0 or z <= -3.0:
        return -math.copysign(f_max, z)
    return -f_max * z * (1.0 - abs(z) / 3.0 + z * z / 27.0)
