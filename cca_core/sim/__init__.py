"""Closed loop in software: scenarios, plants, log; and worlds recorded elsewhere."""

from cca_core.sim.archive import load_log, save_log
from cca_core.sim.car import PLANTS, make_plant
from cca_core.sim.commonroad import read_commonroad
from cca_core.sim.commonroad_drive import CommonRoadRun, drive_commonroad
from cca_core.sim.curbside import CURBSIDE_CASES, curbside
from cca_core.sim.driver import Driver
from cca_core.sim.eebl import EEBL_CASES, REALISTIC, eebl
from cca_core.sim.frames import read_frames
from cca_core.sim.ima import IMA_CASES, ima
from cca_core.sim.iso3888 import DoubleLaneChange, iso3888_1, iso3888_2, plan_through
from cca_core.sim.log import Log
from cca_core.sim.loop import make_driver, make_planner, simulate
from cca_core.sim.multi_body import MultiBodyPlant
from cca_core.sim.paper import CASES, maneuver, paper_scenarios
from cca_core.sim.passage import Passage, drive_through
from cca_core.sim.plant import SingleTrackPlant
from cca_core.sim.rates import Rate, StudyTable
from cca_core.sim.recorded import CommonRoadScenario
from cca_core.sim.rerun import replay
from cca_core.sim.road_user import Brakes, Follows, RoadUser, Swerves
from cca_core.sim.scenario import EGOS, PinnedGap, Scenario
from cca_core.sim.sensor import Sensor, visible_share
from cca_core.sim.study import Study, run_study
from cca_core.sim.tracking import TrackingRun, lane_change, track
from cca_core.sim.variation import Variation

__all__ = [
    "CASES", "CURBSIDE_CASES", "EEBL_CASES", "EGOS", "IMA_CASES", "PLANTS", "REALISTIC", "Brakes",
    "CommonRoadRun", "CommonRoadScenario", "DoubleLaneChange", "Driver", "Follows", "Log", "MultiBodyPlant",
    "Passage", "PinnedGap", "Rate", "RoadUser", "Scenario", "Sensor", "SingleTrackPlant", "Study",
    "StudyTable", "Swerves", "TrackingRun", "Variation", "curbside", "drive_commonroad", "drive_through",
    "eebl", "ima", "iso3888_1", "iso3888_2", "lane_change", "load_log", "make_driver", "make_planner",
    "make_plant", "maneuver", "paper_scenarios", "plan_through", "read_commonroad", "read_frames", "replay",
    "run_study", "save_log", "simulate", "track", "visible_share",
]  # fmt: skip
