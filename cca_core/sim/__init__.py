"""Closed loop in software: scenarios, plants, logs, studies and recordings."""

from cca_core.sim.bsm_log import read_bsm_log
from cca_core.sim.commonroad.drive import CommonRoadRun, drive_commonroad
from cca_core.sim.commonroad.goal_route import GoalSettings
from cca_core.sim.commonroad.read import read_commonroad
from cca_core.sim.commonroad.scenario import CommonRoadScenario
from cca_core.sim.handling.gate_run import GateRun, drive_through
from cca_core.sim.handling.iso3888 import DoubleLaneChange, iso3888_1, iso3888_2, plan_gate_path
from cca_core.sim.handling.tracking import TrackingRun, lane_change_path, track_path
from cca_core.sim.human_driver import Driver, DriverSettings
from cca_core.sim.log import Log
from cca_core.sim.log_io import load_log, save_log
from cca_core.sim.loop import make_driver, make_planner, simulate
from cca_core.sim.outcome import Collision, first_collision, first_lane_change, lead_speed
from cca_core.sim.plants.build import PLANTS, make_plant
from cca_core.sim.plants.multi_body import MultiBodyPlant
from cca_core.sim.plants.single_track import SingleTrackPlant
from cca_core.sim.recorder import Recorder
from cca_core.sim.replay import replay
from cca_core.sim.scenarios.curbside import CURBSIDE_CASES, curbside
from cca_core.sim.scenarios.demo_road import demo_route, longest_stretch
from cca_core.sim.scenarios.eebl import EEBL_CASES, LOSSY_CHANNEL, eebl
from cca_core.sim.scenarios.ima import IMA_CASES, ima
from cca_core.sim.scenarios.overtaking import OVERTAKING_CASES, overtaking
from cca_core.sim.scenarios.paper import paper_scenarios
from cca_core.sim.scenarios.road_user import (
    BrakeAction,
    LateralShiftAction,
    ReactToLeadAction,
    RoadUser,
    SpeedAction,
)
from cca_core.sim.scenarios.scenario import EGO_TYPES, FixedTimeGap, Scenario
from cca_core.sim.study.parameters import ParameterRanges
from cca_core.sim.study.sampling import Sample
from cca_core.sim.study.statistics import Rate, StudyTable
from cca_core.sim.study.study import Study, run_study
from cca_core.sim.world.sensor import Sensor, visible_fraction

__all__ = [
    "CURBSIDE_CASES",
    "EEBL_CASES",
    "EGO_TYPES",
    "IMA_CASES",
    "LOSSY_CHANNEL",
    "OVERTAKING_CASES",
    "PLANTS",
    "BrakeAction",
    "Collision",
    "CommonRoadRun",
    "CommonRoadScenario",
    "DoubleLaneChange",
    "Driver",
    "DriverSettings",
    "FixedTimeGap",
    "GateRun",
    "GoalSettings",
    "LateralShiftAction",
    "Log",
    "MultiBodyPlant",
    "ParameterRanges",
    "Rate",
    "ReactToLeadAction",
    "Recorder",
    "RoadUser",
    "Sample",
    "Scenario",
    "Sensor",
    "SingleTrackPlant",
    "SpeedAction",
    "Study",
    "StudyTable",
    "TrackingRun",
    "curbside",
    "demo_route",
    "drive_commonroad",
    "drive_through",
    "eebl",
    "first_collision",
    "first_lane_change",
    "ima",
    "iso3888_1",
    "iso3888_2",
    "lane_change_path",
    "lead_speed",
    "load_log",
    "longest_stretch",
    "make_driver",
    "make_planner",
    "make_plant",
    "overtaking",
    "paper_scenarios",
    "plan_gate_path",
    "read_bsm_log",
    "read_commonroad",
    "replay",
    "run_study",
    "save_log",
    "simulate",
    "track_path",
    "visible_fraction",
]
