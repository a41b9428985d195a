"""Stability margins of the steering loop, and its open-loop model."""

import math
from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array, check_real
from cca_core.follow.bicycle import single_track
from cca_core.follow.schedule import PreviewGains
from cca_core.kernel.steering import SIDESLIP_FRACTION
from cca_core.vehicle import VehicleParams

LOOP_DELAY = 0.08
"""Dead time of the steering loop, on top of the steering lag [s]: computation, sample and hold."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Margins:
    """Robustness of the steering loop at one speed.

    Parameters
    ----------
    v_x : float
        Speed [m/s].
    gain : float
        Factor on the steering gain up to which the loop is stable [-]; 0 if it is unstable.
    phase : float
        Phase margin [rad]; negative if the loop is unstable.
    delay : float
        Further dead time up to which the loop is stable [s]; negative if it is unstable.
    disk : float
        Symmetric disk margin alpha [-], 0 to 2: gain and phase may vary together by
        (2 - alpha)/(2 + alpha) to (2 + alpha)/(2 - alpha) and +-2 atan(alpha/2); 0 if the loop is unstable.
    crossover : float
        Frequency of the phase margin [rad/s].
    """

    v_x: float
    gain: float
    phase: float
    delay: float
    disk: float
    crossover: float


def stability_margins(
    vehicle: VehicleParams, gains: PreviewGains, v_x: float, *, delay: float = LOOP_DELAY
) -> Margins:
    """Margins of the steering loop, opened at the steering command.

    Parameters
    ----------
    vehicle : VehicleParams
        The vehicle.
    gains : PreviewGains
        Schedule of gains.
    v_x : float
        Speed [m/s], positive.
    delay : float
        Dead time of the loop [s], on top of the steering lag; the default is that of `StabilityRegion`.

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
    v_x = check_real("v_x", v_x, gt=0.0)
    delay = check_real("delay", delay, ge=0.0)
    k_p, k_d, l_s = gains.at(v_x)
    A, B, C_p, C_d = steering_loop(vehicle, v_x, l_s, 0.0)
    w = np.geomspace(1e-2, 1e2, 4000)  # [rad/s]
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
    if dead_time < 0.0:
        gain = disk = 0.0
    return Margins(v_x=v_x, gain=gain, phase=phase, delay=dead_time, disk=disk, crossover=crossover)


def steering_loop(
    vehicle: VehicleParams, v_x: float, l_s: float, delay: float
) -> tuple[Array, Array, Array, Array]:
    """Return A, B, C_p, C_d from steering command to the error at the preview point and its rate."""
    model = single_track(vehicle, v_x, l_s)
    delayed = delay > 1e-3  # [s]: a shorter one has no effect, and poles that overflow
    n = 7 if delayed else 5
    A, B = np.zeros((n, n)), np.zeros(n)
    A[:4, :4], A[:4, 4] = model.A, model.B
    lag = max(vehicle.steering_lag, 1e-3)  # [s]: an ideal actuator is a fast one
    A[4, 4] = -1.0 / lag
    B[4] = 1.0 / lag
    if delayed:  # (s^2 - 6 s/T + 12/T^2) / (s^2 + 6 s/T + 12/T^2)
        A[5, 6] = 1.0
        A[6, 5], A[6, 6] = -12.0 / delay**2, -6.0 / delay
        A[4, 6] = -12.0 / delay / lag
        B[6] = 1.0
    C_p, C_d = np.zeros(n), np.zeros(n)
    C_p[3], C_p[0] = 1.0, SIDESLIP_FRACTION * l_s
    C_d[:4] = model.A[3]
    return A, B, C_p, C_d
