"""Closed loop in software: scenarios, plants, log; and worlds recorded elsewhere."""

from cca_core.sim.bsm_log import read_frames
from cca_core.sim.commonroad.drive import CommonRoadRun, drive_commonroad
from cca_core.sim.commonroad.read import read_commonroad
from cca_core.sim.commonroad.scenario import CommonRoadScenario
from cca_core.sim.handling.gate_run import Passage, drive_through
from cca_core.sim.handling.iso3888 import DoubleLaneChange, iso3888_1, iso3888_2, plan_through
from cca_core.sim.handling.tracking import TrackingRun, lane_change, track
from cca_core.sim.human_driver import Driver
from cca_core.sim.log import Log
from cca_core.sim.log_io import load_log, save_log
from cca_core.sim.loop import make_driver, make_planner, simulate
from cca_core.sim.plants.build import PLANTS, make_plant
from cca_core.sim.plants.multi_body import MultiBodyPlant
from cca_core.sim.plants.single_track import SingleTrackPlant
from cca_core.sim.replay import replay
from cca_core.sim.scenarios.curbside import CURBSIDE_CASES, curbside
from cca_core.sim.scenarios.eebl import EEBL_CASES, REALISTIC, eebl
from cca_core.sim.scenarios.ima import IMA_CASES, ima
from cca_core.sim.scenarios.overtaking import CASES, maneuver, paper_scenarios
from cca_core.sim.scenarios.road_user import Brakes, Follows, RoadUser, Swerves
from cca_core.sim.scenarios.scenario import EGOS, PinnedGap, Scenario
from cca_core.sim.study.parameters import Variation
from cca_core.sim.study.statistics import Rate, StudyTable
from cca_core.sim.study.study import Study, run_study
from cca_core.sim.world.sensor import Sensor, visible_share

__all__ = [
    "CASES", "CURBSIDE_CASES", "EEBL_CASES", "EGOS", "IMA_CASES", "PLANTS", "REALISTIC", "Brakes",
    "CommonRoadRun", "CommonRoadScenario", "DoubleLaneChange", "Driver", "Follows", "Log", "MultiBodyPlant",
    "Passage", "PinnedGap", "Rate", "RoadUser", "Scenario", "Sensor", "SingleTrackPlant", "Study",
    "StudyTable", "Swerves", "TrackingRun", "Variation", "curbside", "drive_commonroad", "drive_through",
    "eebl", "ima", "iso3888_1", "iso3888_2", "lane_change", "load_log", "make_driver", "make_planner",
    "make_plant", "maneuver", "paper_scenarios", "plan_through", "read_commonroad", "read_frames", "replay",
    "run_study", "save_log", "simulate", "track", "visible_share",
]  # fmt: skip
