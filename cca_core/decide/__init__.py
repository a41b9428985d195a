"""Decide: danger zone (eq 11), safe distances, crossing conflicts, warnings, choice of action."""

from cca_core.decide.action import Action, Candidate, Decision, Leader, choose_action
from cca_core.decide.ahead import brake_light, forward_collision, stationary_ahead
from cca_core.decide.alert import Alert, AlertSettings, Application, EgoView, Level, Sighting
from cca_core.decide.around import blind_spot, do_not_pass, intersection, left_turn
from cca_core.decide.crossing import Conflict, CrossingSettings, crossing
from cca_core.decide.danger_zone import danger_zone, danger_zone_end
from cca_core.decide.rss import (
    RSS_EGO,
    RSS_OTHER,
    RssSettings,
    rss_lateral,
    rss_opposite_direction,
    rss_same_direction,
)
from cca_core.decide.sight import sight
from cca_core.decide.warnings import warn

__all__ = [
    "RSS_EGO", "RSS_OTHER", "Action", "Alert", "AlertSettings", "Application", "Candidate", "Conflict",
    "CrossingSettings", "Decision", "EgoView", "Leader", "Level", "RssSettings", "Sighting", "blind_spot",
    "brake_light", "choose_action", "crossing", "danger_zone", "danger_zone_end", "do_not_pass",
    "forward_collision", "intersection", "left_turn", "rss_lateral", "rss_opposite_direction",
    "rss_same_direction", "sight", "stationary_ahead", "warn",
]  # fmt: skip
