"""Pose estimate: dead reckoning, corrected by noisy position fixes."""

import math
from dataclasses import replace

from cca_core._checks import check_real, formula
from cca_core.geometry import wrap_angle
from cca_core.vehicle import VehicleState


class PoseEstimator:
    """Position and heading from speed and yaw rate, corrected by GPS fixes.

    Parameters
    ----------
    state : VehicleState
        Initial motion.
    fix_sigma : float
        Standard deviation of a fix along each axis [m].
    position_drift : float
        Random walk of the dead-reckoned position [m/s^0.5].
    heading_drift : float
        Random walk of the dead-reckoned heading [rad/s^0.5].

    Raises
    ------
    InputError
        If a value is not positive or exceeds 1e6.

    Notes
    -----
    The estimator is a Kalman filter in the axes of the vehicle. The lateral error of a fix corrects position
    and heading, because a heading error causes a lateral drift over the distance driven. The longitudinal
    error corrects the position alone.
    """

    def __init__(
        self,
        state: VehicleState,
        *,
        fix_sigma: float = 0.1,
        position_drift: float = 0.02,
        heading_drift: float = 0.002,
    ) -> None:
        self._fix_variance = check_real("fix_sigma", fix_sigma, gt=0.0, le=1e6) ** 2
        self._q_position = check_real("position_drift", position_drift, gt=0.0, le=1e6) ** 2
        self._q_heading = check_real("heading_drift", heading_drift, gt=0.0, le=1e6) ** 2
        self._state = state
        # variances along and across; covariance of across and heading; variance of the heading
        self._along = self._across = self._fix_variance
        self._cross, self._heading = 0.0, 1e-4

    def __repr__(self) -> str:
        s = self._state
        along, across, heading = self.standard_deviations
        return (
            f"PoseEstimator(x={s.x:.2f} m, y={s.y:.2f} m, psi={s.psi:.3f} rad, standard deviations "
            f"{max(along, across):.2f} m and {heading:.4f} rad)"
        )

    @property
    def standard_deviations(self) -> tuple[float, float, float]:
        """Standard deviations along and across the heading [m], and of the heading [rad]."""
        return math.sqrt(self._along), math.sqrt(self._across), math.sqrt(self._heading)

    @property
    def state(self) -> VehicleState:
        """Estimated motion now."""
        return self._state

    @formula
    def predict(self, measured: VehicleState, dt: float) -> VehicleState:
        """Dead-reckon by speed and yaw rate.

        Parameters
        ----------
        measured : VehicleState
            Speeds, yaw rate, steering angle and acceleration now; position and heading are ignored.
        dt : float
            Time since the last call [s].

        Returns
        -------
        state : VehicleState
            Estimate now.
        """
        old = self._state
        middle = old.psi + 0.5 * measured.r * dt
        cos, sin = math.cos(middle), math.sin(middle)
        self._state = replace(
            measured,
            x=old.x + (measured.v_x * cos - measured.v_y * sin) * dt,
            y=old.y + (measured.v_x * sin + measured.v_y * cos) * dt,
            psi=old.psi + measured.r * dt,
        )
        step = measured.v_x * dt
        self._along += self._q_position * dt
        self._across += 2.0 * step * self._cross + step * step * self._heading + self._q_position * dt
        self._cross += step * self._heading
        self._heading += self._q_heading * dt
        return self._state

    @formula
    def correct(self, x: float, y: float) -> VehicleState:
        """Correct the estimate by a fix.

        Parameters
        ----------
        x, y : float
            Measured position of the center of gravity now [m]; a fix that is not finite is ignored.

        Returns
        -------
        state : VehicleState
            Estimate now.
        """
        if not math.isfinite(x + y):
            return self._state
        old = self._state
        cos, sin = math.cos(old.psi), math.sin(old.psi)
        dx, dy = x - old.x, y - old.y
        along, across = cos * dx + sin * dy, cos * dy - sin * dx
        gain_along = self._along / (self._along + self._fix_variance)
        total = self._across + self._fix_variance
        gain_across, gain_heading = self._across / total, self._cross / total
        self._along *= 1.0 - gain_along
        self._heading -= gain_heading * self._cross
        self._cross *= 1.0 - gain_across
        self._across *= 1.0 - gain_across
        move, side = gain_along * along, gain_across * across
        self._state = replace(
            old,
            x=old.x + cos * move - sin * side,
            y=old.y + sin * move + cos * side,
            psi=wrap_angle(old.psi + gain_heading * across),
        )
        return self._state
