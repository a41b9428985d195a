"""The planner in other simulators: conversions, messages, SUMO, highway-env, CARLA."""

from cca_core.adapters.conversions import (
    Motion,
    MotionDifferences,
    compass_to_heading,
    convert_reference,
    flip_axes,
    heading_to_compass,
    shift_point,
)
from cca_core.adapters.opendrive import OpenDriveMap, read_opendrive
from cca_core.adapters.radio import RadioLink
from cca_core.adapters.sumo import SumoWorld

__all__ = [
    "Motion",
    "MotionDifferences",
    "OpenDriveMap",
    "RadioLink",
    "SumoWorld",
    "compass_to_heading",
    "convert_reference",
    "flip_axes",
    "heading_to_compass",
    "read_opendrive",
    "shift_point",
]
