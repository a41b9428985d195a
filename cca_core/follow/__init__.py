"""Follow a path: single-track model, preview steering, speed."""

from cca_core.follow.advice import NoGainsError
from cca_core.follow.bicycle import (
    SingleTrack,
    discretized,
    kinematic_rates,
    single_track,
    steady_sideslip,
    steady_steering,
    steady_turn,
    steady_yaw_rate,
)
from cca_core.follow.car_following import (
    cacc_acceleration,
    follow_acceleration,
    idm_acceleration,
    required_deceleration,
)
from cca_core.follow.estimate import PoseEstimator
from cca_core.follow.feedforward import InverseSteering
from cca_core.follow.gains import design_gains
from cca_core.follow.margins import Margins, stability_margins
from cca_core.follow.preview import PreviewController
from cca_core.follow.schedule import PreviewGains, has_shipped_gains, shipped_gains
from cca_core.follow.speed import (
    SpeedSettings,
    arrival_times,
    cruise_acceleration,
    friction_limited,
    jerk_limited,
    profile_acceleration,
    squared_speed_limit,
    stop_acceleration,
)
from cca_core.follow.stability_region import GainRegion, StabilityRegion, gain_region

__all__ = [
    "GainRegion",
    "InverseSteering",
    "Margins",
    "NoGainsError",
    "PoseEstimator",
    "PreviewController",
    "PreviewGains",
    "SingleTrack",
    "SpeedSettings",
    "StabilityRegion",
    "arrival_times",
    "cacc_acceleration",
    "cruise_acceleration",
    "design_gains",
    "discretized",
    "follow_acceleration",
    "friction_limited",
    "gain_region",
    "has_shipped_gains",
    "idm_acceleration",
    "jerk_limited",
    "kinematic_rates",
    "profile_acceleration",
    "required_deceleration",
    "shipped_gains",
    "single_track",
    "squared_speed_limit",
    "stability_margins",
    "steady_sideslip",
    "steady_steering",
    "steady_turn",
    "steady_yaw_rate",
    "stop_acceleration",
]
