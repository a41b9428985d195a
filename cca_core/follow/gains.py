"""Design of the preview gains by D-stability over a box of cars, and the margins that result."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cca_core._checks import Array, Mask, check_real
from cca_core.errors import InfeasibleError, InputError
from cca_core.follow.bicycle import single_track
from cca_core.follow.schedule import SLIP_SHARE, PreviewGains
from cca_core.vehicle import VehicleParams

__all__ = ["GainRegion", "Margins", "StabilityRegion", "design_gains", "gain_region", "stability_margins"]

SPEEDS = (2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 13.0, 16.0, 20.0, 25.0, 30.0, 35.0, 40.0)
"""Default grid of a schedule [m/s]."""

_FREQUENCIES = np.geomspace(1e-2, 1e2, 4000)  # [rad/s]
_GRID = 40  # gains tried in each direction


@dataclass(frozen=True, slots=True, kw_only=True)
class StabilityRegion:
    """Where the poles of the steering loop must lie, and for which cars.

    Parameters
    ----------
    decay : float
        Every pole is at least this far left of the imaginary axis [1/s].
    damping : float
        Least damping ratio of every pole [-].
    mass : tuple of float
        Range of the mass, as factors of the vehicle's [-]; the yaw inertia goes with it.
    friction : tuple of float
        Range of both cornering stiffnesses, as factors [-].
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
    delay: float = 0.08

    def __post_init__(self) -> None:
        check_real("decay", self.decay, least=0.0)
        check_real("damping", self.damping, least=0.0, most=1.0)
        check_real("delay", self.delay, least=0.0)
        for name in ("mass", "friction"):
            pair = getattr(self, name)
            if len(pair) != 2 or not 0.0 < pair[0] <= pair[1]:
                raise InputError(f"{name} must be a pair of factors (least, most), was {pair!r}")

    def vehicles(self, vehicle: VehicleParams) -> list[VehicleParams]:
        """Corners of the box of cars.

        Parameters
        ----------
        vehicle : VehicleParams
            The nominal car.

        Returns
        -------
        vehicles : list of VehicleParams
            Lightest and heaviest on the most and the least grip.
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
    """Admissible gains at one speed: the parameter-space picture.

    Parameters
    ----------
    v_x : float
        Speed [m/s].
    l_s : float
        Preview distance [m].
    k_p, k_d : ndarray, shape (n, n)
        Gains tried [rad/m], [rad s/m].
    decay, damping : ndarray, shape (n, n)
        Worst over the box of cars [1/s], [-].
    admissible : ndarray of bool, shape (n, n)
        Where both are as asked.
    chosen : tuple of float or None
        k_p [rad/m] and k_d [rad s/m] with the greatest decay among the admissible; None without any.
    """

    v_x: float
    l_s: float
    k_p: Array
    k_d: Array
    decay: Array
    damping: Array
    admissible: Mask
    chosen: tuple[float, float] | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Margins:
    """Robustness of the steering loop at one speed.

    Parameters
    ----------
    v_x : float
        Speed [m/s].
    gain : float
        Factor on the steering gain up to which the loop is stable [-].
    phase : float
        Phase margin [rad].
    delay : float
        Further dead time up to which the loop is stable [s].
    disk : float
        Symmetric disk margin alpha [-], 0 to 2: gain and phase may vary together by
        (2 - alpha)/(2 + alpha) to (2 + alpha)/(2 - alpha) and +-2 atan(alpha/2).
    crossover : float
        Frequency at which the phase margin is taken [rad/s].
    """

    v_x: float
    gain: float
    phase: float
    delay: float
    disk: float
    crossover: float


def design_gains(
    vehicle: VehicleParams,
    speeds: Sequence[float] = SPEEDS,
    *,
    region: StabilityRegion | None = None,
    preview_time: float = 1.1,
    least_preview: float = 4.4,
) -> PreviewGains:
    """Schedule preview gains over speed.

    Parameters
    ----------
    vehicle : VehicleParams
        The car.
    speeds : sequence of float
        Grid [m/s], positive, increasing.
    region : StabilityRegion, optional
        Demands on the poles, uncertainty and delay.
    preview_time : float
        Preview distance per speed [s].
    least_preview : float
        Preview distance at low speed [m].

    Returns
    -------
    gains : PreviewGains
        At each speed the gains with the fastest decay that keep decay and damping for every car in the box.

    Raises
    ------
    InputError
        If an argument is out of range.
    InfeasibleError
        If at some speed no gains satisfy the demands.
    """
    region = region or StabilityRegion()
    preview_time = check_real("preview_time", preview_time, above=0.0)
    least_preview = check_real("least_preview", least_preview, least=0.0)
    chosen = []
    for v_x in speeds:
        l_s = max(preview_time * check_real("speeds", v_x, above=0.0), least_preview)
        found = gain_region(vehicle, v_x, l_s, region)
        if found.chosen is None:
            raise InfeasibleError(
                f"no gains at {v_x:g} m/s with a preview of {l_s:g} m keep decay {region.decay:g} 1/s "
                f"and damping {region.damping:g}; best damping {found.damping.max():.2f}",
                found,
            )
        chosen.append((*found.chosen, l_s))
    k_p, k_d, l_s_column = zip(*chosen, strict=True)
    return PreviewGains(speeds=tuple(speeds), k_p=k_p, k_d=k_d, l_s=l_s_column)


def gain_region(vehicle: VehicleParams, v_x: float, l_s: float, region: StabilityRegion) -> GainRegion:
    """Try gains at one speed.

    Parameters
    ----------
    vehicle : VehicleParams
        The car.
    v_x : float
        Speed [m/s], positive.
    l_s : float
        Preview distance [m].
    region : StabilityRegion
        Demands on the poles.

    Returns
    -------
    found : GainRegion
        Worst decay and damping over the box for each pair of gains, and the pair chosen.

    Raises
    ------
    InputError
        If `v_x` is not positive or `l_s` is negative.

    Notes
    -----
    Poles of the single-track model with steering lag, second-order Pade delay and the steering law. At low
    speed the decay asked for is limited to nine tenths of the speed over the preview distance: a car cannot
    return to its path faster than it moves.
    """
    k_p, share = np.meshgrid(
        np.geomspace(0.5, 60.0, _GRID) / max(v_x, 3.0) ** 2, np.linspace(0.0, 0.4, _GRID)
    )
    k_d = share * k_p
    decay, damping = np.full(k_p.shape, np.inf), np.full(k_p.shape, np.inf)
    for car in region.vehicles(vehicle):
        A, B, C_p, C_d = _loop(car, v_x, l_s, region.delay)
        feedback = k_p[..., None] * C_p + k_d[..., None] * C_d
        poles = np.linalg.eigvals(A - B[:, None] * feedback[..., None, :])
        size = np.maximum(np.abs(poles), 1e-12)
        damped = np.where(np.abs(poles.imag) > 1e-9 * size, -poles.real / size, np.sign(-poles.real))
        decay = np.minimum(decay, -poles.real.max(axis=-1))
        damping = np.minimum(damping, damped.min(axis=-1))
    asked = min(region.decay, 0.9 * v_x / max(l_s, 1e-9))
    admissible = (decay >= asked) & (damping >= region.damping)
    best = np.unravel_index(int(np.argmax(np.where(admissible, decay, -np.inf))), decay.shape)
    chosen = (float(k_p[best]), float(k_d[best])) if admissible.any() else None
    return GainRegion(
        v_x=v_x, l_s=l_s, k_p=k_p, k_d=k_d, decay=decay, damping=damping, admissible=admissible, chosen=chosen
    )


def stability_margins(
    vehicle: VehicleParams, gains: PreviewGains, v_x: float, *, delay: float = 0.04
) -> Margins:
    """Margins of the steering loop, opened at the steering command.

    Parameters
    ----------
    vehicle : VehicleParams
        The car.
    gains : PreviewGains
        Schedule.
    v_x : float
        Speed [m/s], positive.
    delay : float
        Dead time of the loop [s].

    Returns
    -------
    margins : Margins
        From the frequency response, with the exact delay.

    Raises
    ------
    InputError
        If `v_x` is not positive or `delay` is negative.

    Notes
    -----
    Disk margin: ``alpha = 2 / max |S - T|`` with the sensitivities S and T.
    """
    v_x = check_real("v_x", v_x, above=0.0)
    delay = check_real("delay", delay, least=0.0)
    k_p, k_d, l_s = gains.at(v_x)
    A, B, C_p, C_d = _loop(vehicle, v_x, l_s, 0.0)
    w = _FREQUENCIES
    state = np.linalg.solve(
        1j * w[:, None, None] * np.eye(len(A)) - A, np.broadcast_to(B[:, None], (len(w), len(B), 1))
    )
    response = (state[..., 0] @ (k_p * C_p + k_d * C_d)) * np.exp(-1j * w * delay)
    size, angle = np.abs(response), np.unwrap(np.angle(response))
    angle -= 2.0 * math.pi * round((angle[0] + math.pi) / (2.0 * math.pi))  # two integrators: starts at -pi
    phase, crossover, dead_time = math.inf, math.nan, math.inf
    for i in np.flatnonzero((size[:-1] - 1.0) * (size[1:] - 1.0) < 0.0):
        part = (size[i] - 1.0) / (size[i] - size[i + 1])
        at = float(w[i] + part * (w[i + 1] - w[i]))
        margin = float(math.pi + angle[i] + part * (angle[i + 1] - angle[i]))
        if margin < phase:
            phase, crossover = margin, at
        dead_time = min(dead_time, margin / at)
    gain = math.inf
    for i in np.flatnonzero(np.diff(np.sign(angle + math.pi)) < 0):
        part = (angle[i] + math.pi) / (angle[i] - angle[i + 1])
        gain = min(gain, 1.0 / float(size[i] + part * (size[i + 1] - size[i])))
    disk = 2.0 / float(np.max(np.abs((1.0 - response) / (1.0 + response))))
    return Margins(v_x=v_x, gain=gain, phase=phase, delay=dead_time, disk=disk, crossover=crossover)


def _loop(vehicle: VehicleParams, v_x: float, l_s: float, delay: float) -> tuple[Array, Array, Array, Array]:
    """Plant from steering command to the error at the preview point and its rate: A, B, C_p, C_d."""
    model = single_track(vehicle, v_x, l_s)
    n = 7 if delay > 0.0 else 5
    A, B = np.zeros((n, n)), np.zeros(n)
    A[:4, :4], A[:4, 4] = model.A, model.B
    A[4, 4] = -1.0 / vehicle.steering_lag
    B[4] = 1.0 / vehicle.steering_lag
    if delay > 0.0:  # (s^2 - 6 s/T + 12/T^2) / (s^2 + 6 s/T + 12/T^2)
        A[5, 6] = 1.0
        A[6, 5], A[6, 6] = -12.0 / delay**2, -6.0 / delay
        A[4, 6] = -12.0 / delay / vehicle.steering_lag
        B[6] = 1.0
    C_p, C_d = np.zeros(n), np.zeros(n)
    C_p[3], C_p[0] = 1.0, SLIP_SHARE * l_s
    C_d[:4] = model.A[3]
    return A, B, C_p, C_d
