"""Frenet: the ego and remote vehicles at stations and lateral offsets of the route."""

from cca_core.frenet.convert import CROSSING_SINE, INCOMPLETE, to_frenet
from cca_core.frenet.records import FrenetEgo, FrenetVehicle

__all__ = ["CROSSING_SINE", "INCOMPLETE", "FrenetEgo", "FrenetVehicle", "to_frenet"]
