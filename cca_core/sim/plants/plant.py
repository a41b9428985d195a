"""Interface of a plant."""

from typing import Protocol

from cca_core.vehicle import VehicleState


class Plant(Protocol):
    """The ego as the closed loop drives it."""

    a_y: float
    """Lateral acceleration of the center of gravity now [m/s^2], left positive."""

    @property
    def state(self) -> VehicleState:
        """Motion of the center of gravity now."""

    def step(self, delta: float, a_x: float, dt: float) -> None:
        """Advance by a time step [s] with a commanded road-wheel angle [rad] and acceleration [m/s^2]."""
