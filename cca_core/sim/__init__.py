"""Closed loop in software: scenarios, plant, log."""

from cca_core.sim.iso3888 import DoubleLaneChange, iso3888_1, iso3888_2, plan_through
from cca_core.sim.log import Log
from cca_core.sim.loop import make_planner, simulate
from cca_core.sim.multi_body import MultiBodyPlant
from cca_core.sim.paper import CASES, maneuver
from cca_core.sim.passage import Passage, drive_through
from cca_core.sim.plant import SingleTrackPlant
from cca_core.sim.scenario import RoadUser, Scenario
from cca_core.sim.tracking import TrackingRun, lane_change, track

__all__ = [
    "CASES", "DoubleLaneChange", "Log",
    "MultiBodyPlant", "Passage", "RoadUser", "Scenario", "SingleTrackPlant", "TrackingRun",
    "drive_through", "iso3888_1", "iso3888_2", "lane_change",
    "make_planner", "maneuver", "plan_through", "simulate",
    "track",
]  # fmt: skip
