"""Follow a path: single-track model, preview steering, speed."""

from cca_core.follow.bicycle import (
    SingleTrack,
    single_track,
    steady_sideslip,
    steady_steering,
    steady_yaw_rate,
)
from cca_core.follow.inverse import InverseSteering
from cca_core.follow.preview import PreviewController, PreviewGains
from cca_core.follow.speed import (
    SpeedSettings,
    arrival_times,
    cruise_acceleration,
    follow_acceleration,
    required_deceleration,
    squared_speed_limit,
)

__all__ = [
    "InverseSteering", "PreviewController", "PreviewGains", "SingleTrack", "SpeedSettings", "arrival_times",
    "cruise_acceleration", "follow_acceleration", "required_deceleration", "single_track",
    "squared_speed_limit",
    "steady_sideslip", "steady_steering", "steady_yaw_rate",
]  # fmt: skip
