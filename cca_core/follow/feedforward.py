"""Feedforward of curvature: the single-track model inverted along a path."""

import math
from collections import deque

from cca_core.vehicle import GRAVITY, VehicleParams

ROLLING_SPEED = 3.0
"""Below this speed the tires roll without slip, and the sideslip is too small to measure [m/s]."""


class InverseSteering:
    """Dynamic feedforward of curvature.

    Parameters
    ----------
    vehicle : VehicleParams
        Geometry, inertia, tires and friction.

    Notes
    -----
    If the center of gravity stays on the path, its lateral acceleration is v^2 kappa. This fixes the sum of
    the tires' side forces. The yaw balance then leaves two states, lateral speed and yaw rate:

    ``I_z r' = l_f m v^2 kappa - L F_r``,  ``v_y' = v^2 kappa - v r``,

    with the rear axle's force F_r from its slip angle. These states are the zero dynamics of the lateral
    position and are stable, so the class integrates them along the path. The steering angle follows from the
    slip that the front axle needs for the rest of the force (brush tire, solved for the slip angle). In a
    steady turn this is the static law delta = kappa (L + K v^2).
    """

    def __init__(self, vehicle: VehicleParams) -> None:
        self._vehicle = vehicle
        length = vehicle.wheelbase
        self._grip_f = vehicle.mu * GRAVITY * vehicle.m * vehicle.l_r / length
        self._grip_r = vehicle.mu * GRAVITY * vehicle.m * vehicle.l_f / length
        self._v_y = self._r = self._kappa = 0.0
        self._s: float | None = None
        self._trace: deque[tuple[float, float, float]] = deque()

    def __repr__(self) -> str:
        if self._s is None:
            return "InverseSteering(not started)"
        return f"InverseSteering(s={self._s:.1f} m, kappa={self._kappa:.4f} 1/m, r={self._r:.3f} rad/s)"

    def advance(self, s: float, kappa: float, v_x: float, dt: float) -> float:
        """Integrate to the next station and return the steering angle there.

        Parameters
        ----------
        s : float
            Station of the point [m].
        kappa : float
            Curvature there [1/m], left turn positive.
        v_x : float
            Forward speed [m/s].
        dt : float
            Time since the last call [s].

        Returns
        -------
        delta : float
            Road-wheel angle [rad], left positive.
        """
        p, v = self._vehicle, max(v_x, 0.0)
        jump = self._s is None or abs(s - self._s) > 20.0  # [m]: another stretch of the path
        if jump or v < ROLLING_SPEED:
            self._steady_state(kappa, v)
        else:
            self._integrate(kappa, v, dt)
        self._s, self._kappa = s, kappa
        self._trace.append((s, math.atan2(self._v_y, max(v, 0.1)), self._r))
        if v < ROLLING_SPEED:
            return math.atan(p.wheelbase * kappa)
        rest = p.m * v * v * kappa - self._rear_force(v)
        return math.atan2(self._v_y + p.l_f * self._r, v) + self.front_slip(rest / self._grip_f)

    def front_slip(self, fraction: float) -> float:
        """Slip angle at which the front tires carry a fraction of their grip (brush tire).

        Parameters
        ----------
        fraction : float
            Fraction of the largest side force, left positive [-]; limited to 0.97, where the slip is finite.

        Returns
        -------
        slip : float
            Angle between the wheels and their direction of motion [rad], left positive.
        """
        fraction = min(max(fraction, -0.97), 0.97)
        slip = 3.0 * (1.0 - (1.0 - abs(fraction)) ** (1.0 / 3.0)) * self._grip_f / self._vehicle.C_f
        return math.copysign(math.atan(slip), fraction)

    def motion_at(self, s: float) -> tuple[float, float]:
        """Motion of the ideal car at a station that it has passed.

        Parameters
        ----------
        s : float
            Station [m], not ahead of the last `advance`.

        Returns
        -------
        beta : float
            Sideslip angle [rad], left positive.
        r : float
            Yaw rate [rad/s], left positive.
        """
        trace = self._trace
        while len(trace) > 1 and trace[1][0] <= s:
            trace.popleft()
        s0, beta, r = trace[0]
        if len(trace) == 1 or s <= s0:
            return beta, r
        s1, beta1, r1 = trace[1]
        w = (s - s0) / (s1 - s0)
        return beta + w * (beta1 - beta), r + w * (r1 - r)

    def _steady_state(self, kappa: float, v: float) -> None:
        """Set the states to the steady turn of this curvature."""
        p = self._vehicle
        self._trace.clear()
        self._r = v * kappa
        rolling = 0.0 if v < ROLLING_SPEED else p.l_f * p.m * v * v / (p.C_r * p.wheelbase)
        self._v_y = v * kappa * (p.l_r - rolling)

    def _integrate(self, kappa: float, v: float, dt: float) -> None:
        p = self._vehicle
        n = max(1, math.ceil(dt / 0.005 - 1e-9))  # steps of at most 5 ms
        h = dt / n
        for i in range(n):
            a_y = v * v * (self._kappa + (i + 0.5) / n * (kappa - self._kappa))
            r_dot = (p.l_f * p.m * a_y - p.wheelbase * self._rear_force(v)) / p.I_z
            v_y_dot = a_y - v * self._r
            self._r += h * r_dot
            self._v_y += h * v_y_dot

    def _rear_force(self, v: float) -> float:
        p = self._vehicle
        z = -p.C_r * (self._v_y - p.l_r * self._r) / (v * self._grip_r)
        z = min(max(z, -3.0), 3.0)
        return self._grip_r * z * (1.0 - abs(z) / 3.0 + z * z / 27.0)
