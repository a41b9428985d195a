"""V2V warnings: one rule for each application, and the view of the road they share."""

from cca_core.warnings.alert import Alert, AlertSettings, Application, EgoView, Level, Sighting
from cca_core.warnings.rules import (
    blind_spot,
    brake_light,
    do_not_pass,
    forward_collision,
    intersection,
    left_turn,
    stationary_ahead,
)
from cca_core.warnings.view import sight
from cca_core.warnings.warn import warn

__all__ = [
    "Alert", "AlertSettings", "Application", "EgoView", "Level", "Sighting", "blind_spot", "brake_light",
    "do_not_pass", "forward_collision", "intersection", "left_turn", "sight", "stationary_ahead", "warn",
]  # fmt: skip
