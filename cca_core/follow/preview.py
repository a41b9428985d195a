"""Preview steering: PD on the lateral error ahead, with curvature feed-forward."""

import math
from bisect import bisect_right
from dataclasses import dataclass

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.geometry import wrap_angle
from cca_core.path.path import Path
from cca_core.vehicle import VehicleParams, VehicleState

_LOOK_AHEAD = 0.1  # the feed-forward acts this long before the bend, on top of the actuator lag [s]


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
            column = getattr(self, name)
            if len(column) != len(self.speeds) or not column:
                raise InputError(
                    f"{name} must have one value per speed ({len(self.speeds)}), had {len(column)}"
                )
            for value in column:
                check_real(name, value, least=0.0)
        if any(b <= a for a, b in zip(self.speeds, self.speeds[1:], strict=False)):
            raise InputError("speeds must increase")

    @classmethod
    def default(cls) -> "PreviewGains":
        """Schedule for passenger cars from 2 to 40 m/s.

        Returns
        -------
        gains : PreviewGains
            A preview of one second, k_p = 10 / v^2 and k_d = 1.2 / v^2 above 4 m/s: in the middle of the
            region where all poles have a real part below -0.8 1/s and a damping of at least 0.6.
        """
        speeds = (2.0, 4.0, 6.0, 8.0, 10.0, 13.0, 16.0, 20.0, 25.0, 30.0, 35.0, 40.0)
        clipped = [max(v, 4.0) for v in speeds]
        return cls(
            speeds=speeds,
            k_p=tuple(10.0 / v**2 for v in clipped),
            k_d=tuple(1.2 / v**2 for v in clipped),
            l_s=tuple(clipped),
        )

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
    """Steering law delta = delta_ff - k_p (e_y - e_ref) - k_d e_y'.

    Parameters
    ----------
    vehicle : VehicleParams
        The car that is steered.
    gains : PreviewGains, optional
        Schedule over speed; the default suits passenger cars.

    Notes
    -----
    The error at the preview point is taken to the path's tangent at the foot point of the centre of gravity,
    e_y = d + l_s sin(e_psi). The feed-forward is the steady steering angle for the curvature that the
    car will have reached when the actuator has answered. In a steady turn the car needs a sideslip, which
    shows as e_ref = -l_s beta; without it the car would run beside the path.
    """

    def __init__(self, vehicle: VehicleParams, gains: PreviewGains | None = None) -> None:
        self.vehicle = vehicle
        self.gains = gains or PreviewGains.default()
        self._slope = vehicle.l_f * vehicle.m / (vehicle.C_r * vehicle.wheelbase)
        self._foot: tuple[Path, float] | None = None

    def steer(self, state: VehicleState, path: Path) -> float:
        """Road-wheel angle for this cycle.

        Parameters
        ----------
        state : VehicleState
            Motion of the car now.
        path : Path
            Path to follow.

        Returns
        -------
        delta : float
            Road-wheel angle [rad], left positive, within the vehicle's limit.
        """
        if self._foot is not None and self._foot[0] is path:
            near = self._foot[1] + 0.02 * state.v_x
        else:
            near = float(path.project((state.x, state.y))[0])
        s, d, heading, kappa = path.foot_point(state.x, state.y, near)
        self._foot = path, s
        v = max(state.v_x, 0.0)
        k_p, k_d, l_s = self.gains.at(v)
        e_psi = wrap_angle(state.psi - heading)
        ahead = s + v * (self.vehicle.steering_lag + _LOOK_AHEAD)
        kappa_ahead = path.curvature_at(ahead)
        beta = kappa * (self.vehicle.l_r - self._slope * v * v)
        e_y = d + l_s * math.sin(e_psi)
        rate = v * math.sin(e_psi) + state.v_y * math.cos(e_psi) + l_s * (state.r - v * kappa)
        feed_forward = kappa_ahead * (self.vehicle.wheelbase + self.vehicle.understeer_gradient * v * v)
        delta = feed_forward - k_p * (e_y + l_s * beta) - k_d * rate
        limit = self.vehicle.delta_max
        return min(max(delta, -limit), limit)
