"""Closed loop in software: scenarios, plant, log."""

from cca_core.sim.log import Log
from cca_core.sim.loop import make_planner, simulate
from cca_core.sim.multi_body import MultiBodyPlant
from cca_core.sim.paper import CASES, maneuver
from cca_core.sim.plant import SingleTrackPlant
from cca_core.sim.scenario import RoadUser, Scenario
from cca_core.sim.tracking import TrackingRun, lane_change, track

__all__ = [
    "CASES", "Log",
    "MultiBodyPlant", "RoadUser", "Scenario", "SingleTrackPlant", "TrackingRun",
    "lane_change",
    "make_planner", "maneuver", "simulate",
    "track",
]  # fmt: skip
