"""Inputs of a planner and of a cycle: which of them can be used."""

import math
from numbers import Real
from types import NoneType

from cca_core.errors import InputError
from cca_core.follow import PreviewController, SpeedSettings
from cca_core.path import Path, Road
from cca_core.planner.settings import EvasionSettings
from cca_core.vehicle import MAX_COORDINATE, MAX_SPEED, VehicleParams, VehicleState

__all__ = ["check_arguments", "invalid_input_reason"]

_MAX_TIME = 1e12  # [s]; larger numbers have no resolution left for a cycle


def check_arguments(
    vehicle: object, road: object, evasion: object, speed: object, controller: object
) -> None:
    """Raise InputError for an argument of `Planner` that has the wrong type."""
    for name, value, kinds in (
        ("vehicle", vehicle, (VehicleParams,)),
        ("road", road, (Road, Path)),
        ("evasion", evasion, (EvasionSettings, NoneType)),
        ("speed", speed, (SpeedSettings, NoneType)),
        ("controller", controller, (PreviewController, NoneType)),
    ):
        if not isinstance(value, kinds):
            raise InputError(f"{name} must be {kinds[0].__name__}, was {type(value).__name__}")


def invalid_input_reason(t: object, last_t: float, state: object) -> str:
    """Return why the arguments of a planner's step cannot be used; empty if they can."""
    time = float(t) if isinstance(t, Real) and abs(t) < _MAX_TIME else math.nan  # type: ignore[operator]
    if not time > last_t:
        return f"t must be finite and increase, was {str(t)[:20]} after {last_t:g}"
    if not isinstance(state, VehicleState):
        return f"state must be a VehicleState, was {type(state).__name__}"
    if max(abs(state.x), abs(state.y)) > MAX_COORDINATE or state.v_x > MAX_SPEED:
        return "state must be that of a road vehicle (position in meters, speed in m/s)"
    return ""
