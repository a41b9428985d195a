"""What the closed loop asks of a plant."""

from typing import Protocol

from cca_core.vehicle import VehicleState

__all__ = ["Plant"]


class Plant(Protocol):
    """A car that can be driven."""

    a_y: float

    @property
    def state(self) -> VehicleState:
        """Motion of the center of gravity now."""

    def step(self, delta: float, a_x: float, dt: float) -> None:
        """Drive on for a while."""
