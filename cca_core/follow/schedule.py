"""Schedules of the preview gains over speed, and those that ship with the library."""

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass

from cca_core._checks import check_array, check_real
from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.vehicle import VehicleParams

SPEEDS = (2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 13.0, 16.0, 20.0, 25.0, 30.0, 35.0, 40.0)
"""Default grid of a schedule, and grid of the shipped schedules [m/s]."""


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
        Preview distance in front of the center of gravity [m].

    Raises
    ------
    InputError
        If the lengths differ, the grid does not increase, or a gain is negative.

    Notes
    -----
    Above the last speed the ego is steered with the gains of the last speed, without a warning or a fault.
    Their margins decrease with speed: `stability_margins` evaluates them there. A grid up to the highest
    speed of the ego avoids this.
    """

    speeds: tuple[float, ...]
    k_p: tuple[float, ...]
    k_d: tuple[float, ...]
    l_s: tuple[float, ...]

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for name in ("speeds", "k_p", "k_d", "l_s"):
            column = check_array(name, getattr(self, name), (None,)).tolist()
            object.__setattr__(self, name, tuple(column))
            if len(column) != len(self.speeds) or not column:
                raise InputError(
                    f"{name} must have one value per speed ({len(self.speeds)}), had {len(column)}"
                )
            for value in column:
                check_real(name, value, ge=0.0)
        check_real("speeds", self.speeds[0], gt=0.0)
        if any(b <= a for a, b in zip(self.speeds, self.speeds[1:], strict=False)):
            raise InputError("speeds must increase")

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


def shipped_gains(vehicle: VehicleParams) -> PreviewGains:
    """Return the schedule that ships for a vehicle.

    Parameters
    ----------
    vehicle : VehicleParams
        The vehicle; only inertia, axles and tires count.

    Returns
    -------
    gains : PreviewGains
        Result of `design_gains` for the presets of `VehicleParams`. Any other vehicle gets the schedule of
        the BMW 320i; use `design_gains` for it.
    """
    k_p, k_d = _SHIPPED[_preset(vehicle) or VehicleParams.bmw_320i]
    return PreviewGains(speeds=SPEEDS, k_p=k_p, k_d=k_d, l_s=tuple(max(1.1 * v, 4.4) for v in SPEEDS))


def has_shipped_gains(vehicle: VehicleParams) -> bool:
    """Whether the schedule of `shipped_gains` was designed for a vehicle.

    Parameters
    ----------
    vehicle : VehicleParams
        The vehicle; inertia, axles, tires and steering lag count.

    Returns
    -------
    shipped : bool
        False if it is no preset, or its steering is slower than that of the preset.
    """
    preset = _preset(vehicle)
    return preset is not None and vehicle.steering_lag <= preset().steering_lag


def _preset(vehicle: VehicleParams) -> Callable[[], VehicleParams] | None:
    return next((preset for preset in _SHIPPED if _dynamics(preset()) == _dynamics(vehicle)), None)


def _dynamics(vehicle: VehicleParams) -> tuple[float, ...]:
    return vehicle.m, vehicle.I_z, vehicle.l_f, vehicle.l_r, vehicle.C_f, vehicle.C_r


# k_p [rad/m] and k_d [rad s/m] of design_gains with its defaults
# fmt: off
_SHIPPED = {
    VehicleParams.bmw_320i: (
        (0.3503, 0.3098, 0.2848, 0.1431, 0.08049, 0.05151, 0.03446,
         0.02572, 0.01861, 0.01347, 0.01195, 0.01123, 0.009718),
        (0.01078, 0, 0, 0.004403, 0.002477, 0.002113, 0.003534,
         0.003957, 0.0042, 0.004006, 0.003065, 0.002418, 0.001994),
    ),
    VehicleParams.ford_escort: (
        (0.3098, 0.3098, 0.2848, 0.1266, 0.07119, 0.05151, 0.03446,
         0.02275, 0.01646, 0.01347, 0.01057, 0.00993, 0.008596),
        (0, 0.01589, 0.01168, 0.001298, 0.0007301, 0.00317, 0.004241,
         0.003267, 0.003377, 0.003591, 0.002711, 0.002139, 0.001763),
    ),
    VehicleParams.vw_vanagon: (
        (0.3503, 0.3098, 0.2848, 0.1266, 0.08049, 0.05151, 0.03446,
         0.02572, 0.01861, 0.01347, 0.01195, 0.01123, 0.008596),
        (0.01796, 0.003178, 0.002921, 0, 0.004128, 0.00317, 0.004241,
         0.004749, 0.004772, 0.004006, 0.003065, 0.002418, 0.002028),
    ),
}
# fmt: on
