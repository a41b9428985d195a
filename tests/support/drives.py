"""A drive along a path at the speed that its curves allow, in closed loop."""

import math

from cca_core import PreviewController, VehicleParams
from cca_core.follow import SpeedSettings, squared_speed_limit
from cca_core.follow.bicycle import steady_turn
from cca_core.path import Path
from cca_core.sim import SingleTrackPlant, TrackingRun, track_path

CAR = VehicleParams.bmw_320i()


def drive_at_curve_speed(path: Path, max_speed: float) -> TrackingRun:
    """Drive from end to end with at most 2 m/s^2 across."""
    speed = squared_speed_limit(path, max_speed, 2.0, SpeedSettings())
    start = steady_turn(path, path.start, math.sqrt(float(speed[1][0])), CAR)
    plant = SingleTrackPlant(CAR, start)
    return track_path(plant, PreviewController(CAR).steer, path, speed, margin=min(5.0, 0.1 * path.length))
