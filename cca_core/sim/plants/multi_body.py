"""A 29-state multi-body car as plant (extra ``plant``)."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from cca_core._checks import check_real
from cca_core._optional import require_extra
from cca_core.errors import InputError
from cca_core.vehicle import VehicleState

MIN_MULTI_BODY_SPEED = 2.0
"""Speed of the model below which the car rolls to rest along its heading [m/s]."""

# [m/s^2] by vehicle; braking beyond it locks the wheels: the model has no anti-lock brakes
_MAX_DECELERATION = {1: 8.0, 2: 8.0, 3: 6.5}


class MultiBodyPlant:
    """Multi-body vehicle of the CommonRoad vehicle models with lagging actuators.

    Parameters
    ----------
    state : VehicleState
        Motion of the center of gravity at the start.
    vehicle : {1, 2, 3}
        Ford Escort, BMW 320i or VW Vanagon [-].
    friction : float
        Factor on the tires' peak friction [-]; 1 is the dry road of the model.
    mass : float
        Factor on the sprung mass and its inertias [-].
    steering_lag, drive_lag : float
        Time constants of the actuators [s].

    Raises
    ------
    MissingExtraError
        If commonroad-vehicle-models is not installed.
    InputError
        If an argument is out of range.

    Notes
    -----
    The model's input is a steering rate (at most 0.4 rad/s) and an acceleration at the wheels; both follow
    their commands with a first-order lag. Its fastest eigenvalue is about -4700/v, so it is integrated with
    1 ms steps of the classical Runge-Kutta scheme above 2 m/s; below, the car rolls to rest along its
    heading. It has no anti-lock brakes: commands are limited to what it holds without locking. A car that
    spins is beyond the model; it stops where it was.

    References
    ----------
    .. [1] M. Althoff, G. Wuersching, *CommonRoad: Vehicle Models*, package
       commonroad-vehicle-models 3.0.2 (BSD-3).
    """

    def __init__(
        self,
        state: VehicleState,
        *,
        vehicle: int = 2,
        friction: float = 1.0,
        mass: float = 1.0,
        steering_lag: float = 0.1,
        drive_lag: float = 0.1,
    ) -> None:
        vehicle = int(check_real("vehicle", vehicle))
        if vehicle not in _MAX_DECELERATION:
            raise InputError(f"vehicle must be 1, 2 or 3, was {vehicle}")
        friction = check_real("friction", friction, gt=0.0)
        mass = check_real("mass", mass, gt=0.0)
        self._lags = (
            check_real("steering_lag", steering_lag, gt=0.0),
            check_real("drive_lag", drive_lag, gt=0.0),
        )
        self._dynamics: Any = require_extra("vehiclemodels.vehicle_dynamics_mb", "plant").vehicle_dynamics_mb
        parameters = require_extra(f"vehiclemodels.parameters_vehicle{vehicle}", "plant")
        self._p: Any = getattr(parameters, f"parameters_vehicle{vehicle}")()
        self._p.tire.p_dx1 *= friction
        self._p.tire.p_dy1 *= friction
        for name in ("m", "m_s", "I_Phi_s", "I_y_s", "I_z", "I_xz_s"):
            setattr(self._p, name, getattr(self._p, name) * mass)
        start = [state.x, state.y, state.delta, max(state.v_x, MIN_MULTI_BODY_SPEED), state.psi, state.r, 0.0]
        init = require_extra("vehiclemodels.init_mb", "plant").init_mb
        self._x = np.array(init(start, self._p), dtype=np.float64)
        self._x[10] = state.v_y
        self._a_x = state.a_x
        self._max_deceleration = _MAX_DECELERATION[vehicle]
        self._stopped: VehicleState | None = None
        self.a_y = 0.0

    @property
    def state(self) -> VehicleState:
        """Motion of the center of gravity now."""
        if self._stopped is not None:
            return self._stopped
        x = self._x.tolist()
        return VehicleState(x=x[0], y=x[1], psi=x[4], v_x=x[3], v_y=x[10], r=x[5], delta=x[2], a_x=self._a_x)

    def step(self, delta: float, a_x: float, dt: float) -> None:
        """Advance by a time step.

        Parameters
        ----------
        delta : float
            Commanded road-wheel angle [rad], left positive.
        a_x : float
            Commanded acceleration [m/s^2].
        dt : float
            Time step [s].
        """
        a_x = min(max(a_x, -self._max_deceleration), self._max_deceleration)
        if self._stopped is not None or self._x[3] < MIN_MULTI_BODY_SPEED:
            self._roll(a_x, dt)
            return
        before = self.state
        try:
            self._integrate(delta, a_x, dt)
        except (ArithmeticError, ValueError):  # in a spin: the model's tires divide by the forward speed
            self._x[3] = math.nan
        if not np.isfinite(self._x).all():
            self._stopped = replace(before, v_x=0.0, v_y=0.0, r=0.0, a_x=0.0)
            self.a_y = 0.0

    def _integrate(self, delta: float, a_x: float, dt: float) -> None:
        n = max(1, math.ceil(dt / 0.001 - 1e-9))
        h = dt / n
        for _ in range(n):
            rate = min(max((delta - self._x[2]) / self._lags[0], -0.4), 0.4)
            self._a_x += h / self._lags[1] * (a_x - self._a_x)
            u = [rate, self._a_x]
            x = self._x
            slope = self._slope(x, u)
            k2 = self._slope(x + 0.5 * h * slope, u)
            k3 = self._slope(x + 0.5 * h * k2, u)
            k4 = self._slope(x + h * k3, u)
            self._x = x + h / 6.0 * (slope + 2.0 * k2 + 2.0 * k3 + k4)
        self.a_y = float(slope[10] + self._x[3] * self._x[5])

    def _slope(self, x: "np.ndarray[Any, np.dtype[np.float64]]", u: list[float]) -> Any:
        return np.array(self._dynamics(x.tolist(), u, self._p))  # a list is a copy: the model writes into it

    def _roll(self, a_x: float, dt: float) -> None:
        """Roll along the heading to standstill, without moving off again."""
        old = self.state
        v = max(old.v_x + min(a_x, 0.0) * dt, 0.0)
        distance = 0.5 * (old.v_x + v) * dt
        self._stopped = VehicleState(
            x=old.x + distance * math.cos(old.psi),
            y=old.y + distance * math.sin(old.psi),
            psi=old.psi, v_x=v, delta=old.delta, a_x=min(a_x, 0.0) if v > 0.0 else 0.0,
        )  # fmt: skip
        self.a_y = 0.0
