"""The car that is driven in simulation: a single track on tyres that can slide."""

import math

from cca_core._checks import check_real
from cca_core.vehicle import VehicleParams, VehicleState

_G = 9.81
_STEP = 0.01  # integration step at speed [s]
_SLOW = 5.0  # below this the step is halved [m/s]
_KINEMATIC = 1.0  # below this the car rolls without slip [m/s]


class SingleTrackPlant:
    """Nonlinear single-track car with friction-limited tyres and lagging actuators.

    Parameters
    ----------
    vehicle : VehicleParams
        Geometry, inertia, tyres, friction and steering actuator.
    state : VehicleState
        Where it starts.
    drive_lag : float
        Time constant of drive and brakes [s].

    Raises
    ------
    InputError
        If `drive_lag` is negative.

    Notes
    -----
    Brush tyres (Fiala): with slip angle alpha and available side force F_max,
    ``F_y = -F_max z (1 - |z|/3 + z^2/27)`` with ``z = C tan(alpha) / F_max`` up to sliding at ``|z| = 3``.
    The drive or brake force, shared between the axles like the load, takes its part of the friction
    circle first. Integrated by the classical Runge-Kutta scheme.
    """

    name = "single_track"

    def __init__(self, vehicle: VehicleParams, state: VehicleState, *, drive_lag: float = 0.1) -> None:
        self.vehicle = vehicle
        self.drive_lag = check_real("drive_lag", drive_lag, least=0.0)
        self._x = [
            state.x,
            state.y,
            state.psi,
            state.v_x,
            state.v_y,
            state.r,
            state.delta,
            state.a_x,
        ]
        self.a_y = 0.0

    @property
    def state(self) -> VehicleState:
        """Motion of the centre of gravity now."""
        x, y, psi, v_x, v_y, r, delta, a_x = self._x
        return VehicleState(x=x, y=y, psi=psi, v_x=v_x, v_y=v_y, r=r, delta=delta, a_x=a_x)

    def step(self, delta: float, a_x: float, dt: float) -> None:
        """Drive on for a while.

        Parameters
        ----------
        delta : float
            Commanded road-wheel angle [rad], left positive.
        a_x : float
            Commanded acceleration [m/s^2].
        dt : float
            Duration [s].
        """
        limit = self.vehicle.delta_max
        delta = min(max(delta, -limit), limit)
        n = max(1, math.ceil(dt / (_STEP if self._x[3] > _SLOW else 0.5 * _STEP) - 1e-9))
        h = dt / n
        for _ in range(n):
            x = self._x
            k1 = self._derivative(x, delta, a_x)
            k2 = self._derivative([a + 0.5 * h * b for a, b in zip(x, k1, strict=True)], delta, a_x)
            k3 = self._derivative([a + 0.5 * h * b for a, b in zip(x, k2, strict=True)], delta, a_x)
            k4 = self._derivative([a + h * b for a, b in zip(x, k3, strict=True)], delta, a_x)
            self._x = [
                a + h / 6.0 * (p + 2.0 * q + 2.0 * u + w)
                for a, p, q, u, w in zip(x, k1, k2, k3, k4, strict=True)
            ]
            if self._x[3] < _KINEMATIC:
                self._roll()
        v_dot = self._derivative(self._x, delta, a_x)
        self.a_y = v_dot[4] + self._x[3] * self._x[5]

    def _roll(self) -> None:
        """Below walking speed: no slip, no reversing."""
        v = self._x[3] = max(self._x[3], 0.0)
        if v == 0.0:
            self._x[7] = max(self._x[7], 0.0)
        self._x[5] = v * math.tan(self._x[6]) / self.vehicle.wheelbase
        self._x[4] = self.vehicle.l_r * self._x[5]

    def _derivative(self, x: list[float], delta: float, a_x: float) -> list[float]:
        p = self.vehicle
        _, _, psi, v_x, v_y, r, angle, force = x
        rate = (delta - angle) / max(p.steering_lag, 1e-3)
        rate = min(max(rate, -p.delta_rate_max), p.delta_rate_max)
        grip = p.mu * _G
        drive = (min(max(a_x, -0.99 * grip), 0.99 * grip) - force) / max(self.drive_lag, 1e-3)
        cos, sin = math.cos(psi), math.sin(psi)
        if v_x < _KINEMATIC:
            return [v_x * cos - v_y * sin, v_x * sin + v_y * cos, r, force, 0.0, 0.0, rate, drive]
        side = math.sqrt(max(grip * grip - force * force, (0.1 * grip) ** 2))
        load_f, load_r = p.m * p.l_r / p.wheelbase, p.m * p.l_f / p.wheelbase
        cos_d, sin_d = math.cos(angle), math.sin(angle)
        v_f, v_r = v_y + p.l_f * r, v_y - p.l_r * r
        slip_f = (v_f * cos_d - v_x * sin_d) / max(abs(v_x * cos_d + v_f * sin_d), 1e-6)
        f_f = _fiala(p.C_f, slip_f, load_f * side)
        f_r = _fiala(p.C_r, v_r / v_x, load_r * side)
        front = p.l_r / p.wheelbase  # the front axle's share of load and drive, which acts along its wheels
        front_x = p.m * front * force * cos_d - f_f * sin_d
        front_y = p.m * front * force * sin_d + f_f * cos_d
        return [
            v_x * cos - v_y * sin,
            v_x * sin + v_y * cos,
            r,
            force * (1.0 - front) + front_x / p.m + v_y * r,
            (front_y + f_r) / p.m - v_x * r,
            (p.l_f * front_y - p.l_r * f_r) / p.I_z,
            rate,
            drive,
        ]


def _fiala(stiffness: float, slip: float, f_max: float) -> float:
    """Side force [N] for the tangent of the slip angle."""
    z = stiffness * slip / f_max
    if z >= 3.0 or z <= -3.0:
        return -math.copysign(f_max, z)
    return -f_max * z * (1.0 - abs(z) / 3.0 + z * z / 27.0)
