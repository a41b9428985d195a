"""Limits of the ego: what the settings allow and the friction carries."""

from dataclasses import dataclass

from cca_core.follow import SpeedSettings
from cca_core.planner.settings import EvasionSettings
from cca_core.vehicle import GRAVITY, VehicleParams


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """Accelerations that a plan may use [m/s^2]; a slippery road lowers all of them."""

    a_max: float
    b_comfort: float
    b_max: float
    b_emergency: float  # without the reserve of grip, where the worst case cannot be excluded
    jerk_emergency: float  # at which braking builds up then [m/s^3]
    grip: float  # of all tires together
    a_y: float  # at which a comfortable path aims
    a_y_hard: float  # at which a hard path aims
    a_y_limit: float  # above which a comfortable path is rejected
    a_y_max: float  # and a hard one
    curve: float  # on curves of the route


def limits_of(vehicle: VehicleParams, speed: SpeedSettings, settings: EvasionSettings) -> Limits:
    """Return the limits of a vehicle."""
    grip = settings.actuation.emergency_grip_fraction * vehicle.mu * GRAVITY
    resort = settings.last_resort
    return Limits(
        a_max=min(speed.a_max, 0.5 * grip), b_comfort=min(speed.b_comfort, 0.5 * grip),
        b_max=min(speed.b_max, grip), b_emergency=min(speed.b_max, vehicle.mu * GRAVITY), grip=grip,
        jerk_emergency=speed.jerk_emergency, a_y=min(settings.lateral_acceleration, 0.5 * grip),
        a_y_hard=min(resort.lateral_acceleration, 0.5 * grip),
        a_y_limit=min(settings.lateral_acceleration_limit, 0.7 * grip),
        a_y_max=min(resort.grip_fraction * vehicle.mu * GRAVITY, grip),
        curve=min(settings.actuation.curve_acceleration, 0.4 * grip),
    )  # fmt: skip
