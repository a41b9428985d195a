"""Cooperative collision avoidance of connected vehicles.

From GPS waypoints and the Basic Safety Messages of other vehicles to steering and acceleration.
"""

import logging

from cca_core.band import Band, relax_band, smooth_band
from cca_core.decide import Action, Decision, choose_action, danger_zone
from cca_core.errors import CcaError, InfeasibleError, InputError, MissingExtraError, Status
from cca_core.follow import PreviewController, design_gains
from cca_core.path import Lane, LocalFrame, Path, Road, fit_path
from cca_core.planner.command import Command
from cca_core.planner.planner import Planner
from cca_core.planner.settings import EvasionSettings
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState

__version__ = "0.2.0"

logging.getLogger("cca_core").addHandler(logging.NullHandler())

__all__ = [
    "Action", "Band", "CcaError", "Command", "Decision", "EvasionSettings", "InfeasibleError", "InputError",
    "Lane", "LocalFrame", "MissingExtraError", "Path", "Planner", "PreviewController", "RemoteVehicle",
    "Road", "Status", "VehicleParams", "VehicleState", "choose_action", "danger_zone", "design_gains",
    "fit_path", "relax_band", "smooth_band",
]  # fmt: skip
