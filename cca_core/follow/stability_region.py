"""Region of the poles of the steering loop, and the gains that keep it at one speed."""

from dataclasses import dataclass, replace

import numpy as np

from cca_core._checks import Array, Mask, check_real
from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.follow.margins import LOOP_DELAY, steering_loop
from cca_core.vehicle import VehicleParams


@dataclass(frozen=True, slots=True, kw_only=True)
class StabilityRegion:
    """Region in which the poles of the steering loop must lie, and the vehicles that count.

    Parameters
    ----------
    decay : float
        Least distance of every pole to the left of the imaginary axis [1/s]. The design selects the fastest
        of the admissible gains, so a smaller value does not make the steering calmer.
    damping : float
        Least damping ratio of every pole [-].
    mass : tuple of float
        Range of the mass, as factors of the nominal mass [-]; the yaw inertia scales with it.
    friction : tuple of float
        Range of both cornering stiffnesses, as factors of the nominal values [-].
    delay : float
        Dead time of the loop [s], on top of the steering lag: computation, sample and hold.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    decay: float = 0.8
    damping: float = 0.4
    mass: tuple[float, float] = (1.0, 1.3)
    friction: tuple[float, float] = (0.6, 1.0)
    delay: float = LOOP_DELAY

    def __post_init__(self) -> None:
        check_real("decay", self.decay, ge=0.0)
        check_real("damping", self.damping, ge=0.0, le=1.0)
        check_real("delay", self.delay, ge=0.0)
        for name in ("mass", "friction"):
            pair: object = getattr(self, name)
            numbers = [check_real(name, each) for each in pair] if isinstance(pair, (tuple, list)) else []
            if len(numbers) != 2 or not 0.0 < numbers[0] <= numbers[1] <= 10.0:  # kilograms are no factor
                raise InputError(f"{name} must be a pair of factors (min, max) of at most 10, was {pair!r}")
            object.__setattr__(self, name, tuple(numbers))

    def vehicles(self, vehicle: VehicleParams) -> list[VehicleParams]:
        """Vehicles at the corners of the ranges.

        Parameters
        ----------
        vehicle : VehicleParams
            The nominal vehicle.

        Returns
        -------
        vehicles : list of VehicleParams
            Lightest and heaviest vehicle with the largest and the least grip.
        """
        return [
            replace(
                vehicle, m=vehicle.m * mass, I_z=vehicle.I_z * mass,
                C_f=vehicle.C_f * grip, C_r=vehicle.C_r * grip,
            )
            for mass in sorted(set(self.mass))
            for grip in sorted(set(self.friction))
        ]  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GainRegion:
    """Admissible gains at one speed, in the parameter space of k_p and k_d.

    Parameters
    ----------
    v_x : float
        Speed [m/s].
    l_s : float
        Preview distance [m].
    k_p, k_d : ndarray, shape (n, n)
        Grid of gains [rad/m], [rad s/m].
    decay, damping : ndarray, shape (n, n)
        Least values over all vehicles [1/s], [-].
    requested : tuple of float
        Least decay [1/s] and damping [-] requested at this speed.
    admissible : ndarray of bool, shape (n, n)
        Where both are at least as requested.
    selected : tuple of float or None
        Admissible k_p [rad/m] and k_d [rad s/m] with the largest decay; None if no gains are admissible.
    """

    v_x: float
    l_s: float
    k_p: Array
    k_d: Array
    decay: Array
    damping: Array
    requested: tuple[float, float]
    admissible: Mask
    selected: tuple[float, float] | None

    __repr__ = short_repr


def gain_region(vehicle: VehicleParams, v_x: float, l_s: float, region: StabilityRegion) -> GainRegion:
    """Evaluate a grid of gains at one speed.

    Parameters
    ----------
    vehicle : VehicleParams
        The vehicle.
    v_x : float
        Speed [m/s], positive.
    l_s : float
        Preview distance [m].
    region : StabilityRegion
        Requirements on the poles.

    Returns
    -------
    found : GainRegion
        Least decay and damping over all vehicles for each pair of gains, and the selected pair.

    Raises
    ------
    InputError
        If `v_x` is not positive or exceeds 1e6, or `l_s` is negative.

    Notes
    -----
    The poles are those of the single-track model with steering lag, second-order Pade delay and the steering
    law. At low speed the requested decay is limited to nine tenths of the speed over the preview distance: a
    vehicle cannot return to its path faster than it moves.
    """
    v_x = check_real("v_x", v_x, gt=0.0, le=1e6)
    k_p, ratio = np.meshgrid(np.geomspace(0.5, 60.0, 40) / max(v_x, 3.0) ** 2, np.linspace(0.0, 0.4, 40))
    k_d = ratio * k_p
    decay, damping = np.full(k_p.shape, np.inf), np.full(k_p.shape, np.inf)
    for car in region.vehicles(vehicle):
        A, B, C_p, C_d = steering_loop(car, v_x, l_s, region.delay)
        feedback = k_p[..., None] * C_p + k_d[..., None] * C_d
        poles = np.linalg.eigvals(A - B[:, None] * feedback[..., None, :])
        size = np.maximum(np.abs(poles), 1e-12)
        damped = np.where(np.abs(poles.imag) > 1e-9 * size, -poles.real / size, np.sign(-poles.real))
        decay = np.minimum(decay, -poles.real.max(axis=-1))
        damping = np.minimum(damping, damped.min(axis=-1))
    requested = min(region.decay, 0.9 * v_x / max(l_s, 1e-9))
    admissible = (decay >= requested) & (damping >= region.damping)
    best = np.unravel_index(int(np.argmax(np.where(admissible, decay, -np.inf))), decay.shape)
    selected = (float(k_p[best]), float(k_d[best])) if admissible.any() else None
    return GainRegion(
        v_x=v_x, l_s=l_s, k_p=k_p, k_d=k_d, decay=decay, damping=damping,
        requested=(requested, region.damping), admissible=admissible, selected=selected,
    )  # fmt: skip
