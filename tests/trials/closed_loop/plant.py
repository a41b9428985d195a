"""The ego's body: single track on saturating tires, or kinematic."""

import math

from cca_core import VehicleParams, VehicleState

GRAVITY = 9.81  # [m/s^2]
KINEMATIC_SPEED = 4.0  # below it the kinematic model is used [m/s]


class Plant:
    """Car with steering lag and a delay of acceleration; its state changes in steps of 5 ms at most."""

    def __init__(
        self, car: VehicleParams, x: float, y: float, psi: float, v: float, r: float, kinematic: bool
    ) -> None:
        self.car, self.kinematic = car, kinematic
        self.x, self.y, self.psi, self.v, self.v_y, self.r = x, y, psi, v, 0.0, r
        self.delta, self.a = 0.0, 0.0

    def state(self) -> VehicleState:
        """State as the planner takes it."""
        return VehicleState(
            x=self.x, y=self.y, psi=self.psi, v_x=self.v, v_y=self.v_y, r=self.r, delta=self.delta, a_x=self.a
        )

    def step(self, delta: float, a_x: float, dt: float) -> None:
        """Advance by a step under commands."""
        n = max(1, math.ceil(dt / 0.005 - 1e-9))
        h, p = dt / n, self.car
        grip = p.mu * GRAVITY
        for _ in range(n):
            rate = (max(-p.delta_max, min(p.delta_max, delta)) - self.delta) / max(p.steering_lag, 1e-3)
            self.delta += max(-p.delta_rate_max, min(p.delta_rate_max, rate)) * h
            self.a += (a_x - self.a) * min(1.0, h / 0.05)
            a = max(-grip, min(self.a, grip))
            v, v_y, r, psi = self.v, self.v_y, self.r, self.psi
            if v <= 0.0 and a < 0.0:
                a = v = 0.0
            if self.kinematic or v < KINEMATIC_SPEED:
                v_y, r = self._kinematic(v, v_y, r, grip, h)
            else:
                v_y, r = self._dynamic(v, v_y, r, a, grip, h)
            self.x += (v * math.cos(psi) - v_y * math.sin(psi)) * h
            self.y += (v * math.sin(psi) + v_y * math.cos(psi)) * h
            self.psi, self.v, self.v_y, self.r = psi + r * h, max(v + a * h, 0.0), v_y, r

    def _kinematic(self, v: float, v_y: float, r: float, grip: float, h: float) -> tuple[float, float]:
        """Lateral speed and yaw rate of the kinematic model after a step."""
        p = self.car
        slip = math.atan(p.l_r / p.wheelbase * math.tan(self.delta))
        turn = v * math.cos(slip) * math.tan(self.delta) / p.wheelbase
        turn = math.copysign(grip / v, turn) if abs(v * turn) > grip else turn
        r += (turn - r) * min(1.0, h / 0.05)
        v_y += (v * math.tan(slip) - v_y) * min(1.0, h / 0.05)
        return v_y, r

    def _dynamic(
        self, v: float, v_y: float, r: float, a: float, grip: float, h: float
    ) -> tuple[float, float]:
        """Lateral speed and yaw rate of the single-track model after a step."""
        p = self.car
        left = math.sqrt(max(1.0 - (a / grip) ** 2, 0.01)) * grip * p.m / p.wheelbase
        front, rear = left * p.l_r, left * p.l_f
        f_f = front * math.tanh(p.C_f * (self.delta - math.atan2(v_y + p.l_f * r, v)) / front)
        f_r = rear * math.tanh(-p.C_r * math.atan2(v_y - p.l_r * r, v) / rear)
        v_y += ((f_f * math.cos(self.delta) + f_r) / p.m - v * r) * h
        r += (p.l_f * f_f * math.cos(self.delta) - p.l_r * f_r) / p.I_z * h
        return v_y, r
