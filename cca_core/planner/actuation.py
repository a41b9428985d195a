"""Acceleration of a cycle from the speed profile, the lead vehicle and the limits of tires and jerk."""

from cca_core.decide import Action, LeadVehicle
from cca_core.follow import SpeedSettings, friction_limited, jerk_limited
from cca_core.planner.settings import EvasionSettings
from cca_core.vehicle import GRAVITY, VehicleParams


def requested_acceleration(
    cruise: float, action: Action, lead: LeadVehicle | None, speed: SpeedSettings, settings: EvasionSettings
) -> float:
    """Return the acceleration that the action asks for [m/s^2], at most that of the speed profile."""
    if lead is None or action is Action.KEEP:
        return cruise
    brake = settings.actuation.safe_stop_deceleration
    if action is not Action.BRAKE:
        return min(cruise, lead.follow_acceleration)
    stops = lead.comfort_stop_deceleration <= settings.decision.comfort_deceleration
    if stops and lead.required_deceleration < brake:
        return min(cruise, lead.follow_acceleration, 0.0)
    return -min(max(lead.required_deceleration, brake), speed.b_max)


def limit_acceleration(
    requested: float,
    last: float,
    a_y: float,
    dt: float,
    lead: LeadVehicle | None,
    vehicle: VehicleParams,
    speed: SpeedSettings,
    settings: EvasionSettings,
    *,
    maneuvering: bool,
) -> float:
    """Return the acceleration within the limits of friction and jerk [m/s^2]."""
    actuation, grip = settings.actuation, vehicle.mu * GRAVITY
    emergency = requested < -min(2.0 * speed.b_comfort, actuation.hard_braking_fraction * speed.b_max)
    fraction = actuation.emergency_grip_fraction if emergency else actuation.grip_fraction
    if emergency and lead is not None:  # all of the grip if less does not avoid the collision
        fraction = min(max(lead.required_deceleration / grip, fraction), 1.0)
    limited = friction_limited(requested, a_y, vehicle.mu, grip_fraction=fraction)
    # no jerk limit on brake release: the maneuver was timed for the target speed
    releasing = maneuvering and last < min(limited, 0.0)
    return jerk_limited(limited, last, dt, speed, emergency=emergency or releasing)
