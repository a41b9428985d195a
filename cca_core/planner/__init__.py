"""Planner: one cycle from vehicles around the ego to steering and acceleration."""

from cca_core.planner.command import Command
from cca_core.planner.planner import Planner
from cca_core.planner.settings import EvasionSettings

__all__ = ["Command", "EvasionSettings", "Planner"]
