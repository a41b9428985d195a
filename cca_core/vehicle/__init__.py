"""Vehicles: parameters and state of the ego, reported state of a remote vehicle."""

from cca_core.vehicle.constants import GRAVITY, MAX_COORDINATE, MAX_SPEED, STALE_AGE, STANDSTILL_SPEED
from cca_core.vehicle.params import VehicleParams
from cca_core.vehicle.remote import RemoteVehicle
from cca_core.vehicle.state import VehicleState

__all__ = [
    "GRAVITY",
    "MAX_COORDINATE",
    "MAX_SPEED",
    "STALE_AGE",
    "STANDSTILL_SPEED",
    "RemoteVehicle",
    "VehicleParams",
    "VehicleState",
]
