"""Preview steering: PD on the lateral error ahead, and the steering that the path ahead asks for."""

import math
from bisect import bisect_right
from dataclasses import dataclass
from typing import Literal

from cca_core._checks import check_array, check_real
from cca_core.errors import InputError
from cca_core.follow.inverse import InverseSteering
from cca_core.geometry import wrap_angle
from cca_core.path.path import Path
from cca_core.vehicle import VehicleParams, VehicleState

__all__ = ["PreviewController", "PreviewGains"]

_INTEGRAL_TIME = 6.0  # of the slow correction of what the model does not know [s]
_INTEGRAL_LIMIT = 0.02  # of that correction [rad]
_SMALL = 0.2  # only errors below this are integrated [m]


@dataclass(frozen=True, slots=True, kw_only=True)
class PreviewGains:
    """Gains of the preview steering law over speed, linear between grid points and held outside.

    Parameters
    ----------
    speeds : tuple of float
        Grid [m/s], positive, increasing.
    k_p : tuple of float
        Steering angle per lateral error at the preview point [rad/m].
    k_d : tuple of float
        Steering angle per rate of that error [rad s/m].
    l_s : tuple of float
        Preview distance in front of the centre of gravity [m].

    Raises
    ------
    InputError
        If the lengths differ, the grid does not increase, or a gain is negative.
    """

    speeds: tuple[float, ...]
    k_p: tuple[float, ...]
    k_d: tuple[float, ...]
    l_s: tuple[float, ...]

    def __post_init__(self) -> None:
        for name in ("speeds", "k_p", "k_d", "l_s"):
            column = check_array(name, getattr(self, name), (None,)).tolist()
            if len(column) != len(self.speeds) or not column:
                raise InputError(
                    f"{name} must have one value per speed ({len(self.speeds)}), had {len(column)}"
                )
            for value in column:
                check_real(name, value, least=0.0)
        check_real("speeds", self.speeds[0], above=0.0)
        if any(b <= a for a, b in zip(self.speeds, self.speeds[1:], strict=False)):
            raise InputError("speeds must increase")

    @classmethod
    def default(cls) -> "PreviewGains":
        """Schedule for passenger cars from 2 to 40 m/s.

        Returns
        -------
        gains : PreviewGains
            A preview of one second, k_p = 9 / v^2 and k_d = 0.14 k_p above 4 m/s: poles left of -0.8 1/s with
            a damping of at least 0.5 for a third more mass and two thirds of the grip.
        """
        speeds = (2.0, 4.0, 6.0, 8.0, 10.0, 13.0, 16.0, 20.0, 25.0, 30.0, 35.0, 40.0)
        clipped = [max(v, 4.0) for v in speeds]
        k_p = tuple(9.0 / v**2 for v in clipped)
        return cls(speeds=speeds, k_p=k_p, k_d=tuple(0.14 * k for k in k_p), l_s=tuple(clipped))

    def at(self, v_x: float) -> tuple[float, float, float]:
        """Gains at a speed.

        Parameters
        ----------
        v_x : float
            Forward speed [m/s].

        Returns
        -------
        k_p, k_d, l_s : float
            Gains [rad/m], [rad s/m] and preview distance [m].
        """
        i = bisect_right(self.speeds, v_x)
        if i == 0 or i == len(self.speeds):
            j = max(i - 1, 0)
            return self.k_p[j], self.k_d[j], self.l_s[j]
        w = (v_x - self.speeds[i - 1]) / (self.speeds[i] - self.speeds[i - 1])
        k_p, k_d, l_s = (c[i - 1] + w * (c[i] - c[i - 1]) for c in (self.k_p, self.k_d, self.l_s))
        return k_p, k_d, l_s


class PreviewController:
    """Steering law delta = delta_ff - k_p (e_y - e_ref) - k_d (e_y' - e_ref') - integral.

    Parameters
    ----------
    vehicle : VehicleParams
        The car that is steered.
    gains : PreviewGains, optional
        Schedule over speed; the default suits passenger cars.
    delay : float
        Known dead time between command and road wheel [s], on top of the steering lag.
    a_y_max : float
        Lateral acceleration that the command may ask for in a steady turn [m/s^2].
    error : {"tangent", "ahead"}
        What the error at the preview point is taken to: the tangent at the foot point of the centre of
        gravity, or the path itself at the preview point.

    Raises
    ------
    InputError
        If an argument is out of range.

    Notes
    -----
    The feed-forward is the steering that keeps an ideal car exactly on the path, taken from the curvature
    where the car will be when the wheels have answered (`InverseSteering`). The ideal car has a sideslip
    and a yaw rate in bends; e_ref is what its preview point shows, so that the feedback only acts
    on what the model does not explain. With the tangent that is e_ref = -l_s sin(beta); with the path itself
    additionally the bend of the path over the preview distance.
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
        self.gains = gains or PreviewGains.default()
        self.delay = check_real("delay", delay, least=0.0)
        self.a_y_max = check_real("a_y_max", a_y_max, above=0.0)
        self._ahead = error == "ahead"
        self._inverse = InverseSteering(vehicle)
        self._foot: tuple[Path, float] | None = None
        self._integral = 0.0
        self._delta: float | None = None

    def steer(self, state: VehicleState, path: Path, dt: float = 0.02) -> float:
        """Road-wheel angle for this cycle.

        Parameters
        ----------
        state : VehicleState
            Motion of the car now.
        path : Path
            Path to follow.
        dt : float
            Time since the last call [s].

        Returns
        -------
        delta : float
            Road-wheel angle [rad], left positive, within the limits of angle, rate and lateral acceleration.
        """
        p, v = self.vehicle, max(state.v_x, 0.0)
        if self._foot is not None and self._foot[0] is path:
            near = self._foot[1] + v * dt
        else:
            near = float(path.project((state.x, state.y))[0])
        s, d, heading, kappa = path.foot_point(state.x, state.y, near)
        self._foot = path, s
        ahead = s + v * (self.delay + p.steering_lag)
        feed_forward = self._inverse.advance(ahead, path.curvature_at(ahead), v, dt)
        beta, r = self._inverse.motion_at(s)
        k_p, k_d, l_s = self.gains.at(v)
        e_psi = wrap_angle(state.psi - heading)
        sin, cos = math.sin(e_psi), math.cos(e_psi)
        error = d + l_s * (sin + math.sin(beta))
        if self._ahead:
            error = self._error_ahead(state, path, s, l_s) + l_s * math.sin(beta) + 0.5 * kappa * l_s * l_s
        rate = v * sin + state.v_y * cos + l_s * (state.r - r)
        wanted = feed_forward - k_p * error - k_d * rate - self._integral
        delta = self._limited(wanted, v, dt)
        if delta == wanted and abs(d) < _SMALL and v > 1.0:
            grown = self._integral + k_p * d * dt / _INTEGRAL_TIME
            self._integral = min(max(grown, -_INTEGRAL_LIMIT), _INTEGRAL_LIMIT)
        self._delta = delta
        return delta

    def _error_ahead(self, state: VehicleState, path: Path, s: float, l_s: float) -> float:
        x, y = state.x + l_s * math.cos(state.psi), state.y + l_s * math.sin(state.psi)
        return path.foot_point(x, y, s + l_s)[1]

    def _limited(self, delta: float, v: float, dt: float) -> float:
        p = self.vehicle
        turn = p.wheelbase + max(p.understeer_gradient, 0.0) * v * v
        most = min(p.delta_max, math.atan(turn * self.a_y_max / max(v * v, 1.0)))
        delta = min(max(delta, -most), most)
        if self._delta is not None:
            step = p.delta_rate_max * dt
            delta = min(max(delta, self._delta - step), self._delta + step)
        return delta
