"""Closed loop in software: scenarios, plant, log."""

from cca_core.sim.log import Log
from cca_core.sim.loop import make_planner, simulate
from cca_core.sim.paper import CASES, maneuver
from cca_core.sim.plant import SingleTrackPlant
from cca_core.sim.scenario import RoadUser, Scenario

__all__ = [
    "CASES", "Log", "RoadUser", "Scenario", "SingleTrackPlant", "make_planner", "maneuver", "simulate",
]  # fmt: skip
