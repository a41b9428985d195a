"""The planner in other simulators: conversions, messages, SUMO, highway-env, CARLA."""

from cca_core.adapters.carla import (
    CarlaControl,
    CarlaPedals,
    carla_remote,
    carla_state,
    from_carla_transform,
    to_carla_control,
    to_carla_pose,
)
from cca_core.adapters.commonroad_file import CommonRoadMap, read_commonroad_map
from cca_core.adapters.conversions import (
    Motion,
    MotionDifferences,
    compass_to_heading,
    convert_reference,
    flip_axes,
    heading_to_compass,
    shift_point,
)
from cca_core.adapters.highway_env import (
    HighwayAgent,
    configure_highway,
    highway_vehicle,
)
from cca_core.adapters.highway_net import read_highway_road
from cca_core.adapters.lanelets import join_lanelets
from cca_core.adapters.opendrive import OpenDriveMap, read_opendrive
from cca_core.adapters.radio import RadioLink
from cca_core.adapters.sumo import SumoWorld
from cca_core.adapters.sumo_file import SumoNet, read_sumo_net

__all__ = [
    "CarlaControl",
    "CarlaPedals",
    "CommonRoadMap",
    "HighwayAgent",
    "Motion",
    "MotionDifferences",
    "OpenDriveMap",
    "RadioLink",
    "SumoNet",
    "SumoWorld",
    "carla_remote",
    "carla_state",
    "compass_to_heading",
    "configure_highway",
    "convert_reference",
    "flip_axes",
    "from_carla_transform",
    "heading_to_compass",
    "highway_vehicle",
    "join_lanelets",
    "read_commonroad_map",
    "read_highway_road",
    "read_opendrive",
    "read_sumo_net",
    "shift_point",
    "to_carla_control",
    "to_carla_pose",
]
