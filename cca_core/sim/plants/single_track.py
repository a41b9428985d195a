"""A single-track car on tires that can slide, as plant."""

import math
from copy import copy
from typing import Self

from cca_core._checks import check_real
from cca_core.kernel import bind
from cca_core.kernel.memory import lend, put
from cca_core.kernel.single_track import SingleTrackCar, drive
from cca_core.vehicle import VehicleParams, VehicleState

_drive = bind(drive)


class SingleTrackPlant:
    """Nonlinear single-track car with friction-limited tires and lagging actuators.

    Parameters
    ----------
    vehicle : VehicleParams
        Geometry, inertia, tires, friction and steering actuator.
    state : VehicleState
        Motion of the center of gravity at the start.
    drive_lag : float
        Time constant of drive and brakes [s].

    Raises
    ------
    InputError
        If `drive_lag` is negative.

    Notes
    -----
    Brush tires (Fiala): with slip angle alpha and available side force F_max,
    ``F_y = -F_max z (1 - |z|/3 + z^2/27)`` with ``z = C tan(alpha) / F_max`` up to sliding at ``|z| = 3``.
    The drive or brake force, shared between the axles like the load, takes its part of the friction
    circle first. Integrated by the classical Runge-Kutta scheme.
    """

    def __init__(self, vehicle: VehicleParams, state: VehicleState, *, drive_lag: float = 0.1) -> None:
        self.vehicle = vehicle
        self.drive_lag = check_real("drive_lag", drive_lag, ge=0.0)
        self.a_y = 0.0
        self._lent = lend(SingleTrackCar)
        put(
            self._lent.workspace,
            l_f=vehicle.l_f, l_r=vehicle.l_r, m=vehicle.m, inertia=vehicle.I_z,
            c_f=vehicle.C_f, c_r=vehicle.C_r, mu=vehicle.mu, delta_rate_max=vehicle.delta_rate_max,
            steering_lag=max(vehicle.steering_lag, 1e-3), drive_lag=max(self.drive_lag, 1e-3),
            x=state.x, y=state.y, psi=state.psi, delta=state.delta,
            v_x=state.v_x, v_y=state.v_y, r=state.r, a_x=state.a_x,
        )  # fmt: skip

    def __copy__(self) -> Self:
        twin = object.__new__(type(self))
        twin.__dict__ |= self.__dict__ | {"_lent": copy(self._lent)}
        return twin

    @property
    def state(self) -> VehicleState:
        """Motion of the center of gravity now."""
        car = self._lent.workspace
        return VehicleState(
            x=car.x, y=car.y, psi=car.psi, v_x=car.v_x, v_y=car.v_y, r=car.r, delta=car.delta, a_x=car.a_x
        )

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
        car, limit = self._lent.workspace, self.vehicle.delta_max
        delta = min(max(delta, -limit), limit)
        if car.v_x == 0.0 and a_x <= 0.0 and car.a_x <= 0.0:
            self._rest(delta, dt)
        else:
            _drive(car, delta, a_x, dt)
            self.a_y = car.a_y

    def _rest(self, delta: float, dt: float) -> None:
        """Stand with the brakes applied; only the steering moves."""
        car, limit = self._lent.workspace, self.vehicle.delta_rate_max * dt
        turn = (delta - car.delta) * -math.expm1(-dt / car.steering_lag)
        car.delta += min(max(turn, -limit), limit)
        car.v_y = car.r = car.a_x = self.a_y = 0.0
