"""V2V warnings: one rule for each application, and the view of the road they share."""

from cca_core.warnings.alert import Alert, AlertSettings, Application, Level
from cca_core.warnings.rules import (
    blind_spot,
    do_not_pass,
    emergency_brake_light,
    forward_collision,
    intersection,
    left_turn,
    stationary_ahead,
)
from cca_core.warnings.view import VehicleInView, WarningView, warning_view
from cca_core.warnings.warn import warn

__all__ = [
    "Alert",
    "AlertSettings",
    "Application",
    "Level",
    "VehicleInView",
    "WarningView",
    "blind_spot",
    "do_not_pass",
    "emergency_brake_light",
    "forward_collision",
    "intersection",
    "left_turn",
    "stationary_ahead",
    "warn",
    "warning_view",
]
