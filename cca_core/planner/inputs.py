"""Inputs of a cycle: whether its time and the ego's state can be used."""

import math
from numbers import Real

from cca_core.vehicle import MAX_COORDINATE, MAX_SPEED, VehicleState

__all__ = ["invalid_input_reason"]

_MAX_TIME = 1e12  # [s]; larger numbers have no resolution left for a cycle


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
