"""Decide: danger zone (eq 11), safe distances, crossing conflicts, choice of action."""

from cca_core.decide.action import Action, Candidate, Decision, LeadVehicle, choose_action
from cca_core.decide.crossing import Conflict, CrossingSettings, find_conflict
from cca_core.decide.danger_zone import danger_zone, danger_zone_end
from cca_core.decide.rejection import Rejection, RejectionKind
from cca_core.decide.rss import (
    RSS_EGO,
    RSS_OTHER,
    RssSettings,
    rss_lateral,
    rss_opposite_direction,
    rss_same_direction,
)

__all__ = [
    "RSS_EGO",
    "RSS_OTHER",
    "Action",
    "Candidate",
    "Conflict",
    "CrossingSettings",
    "Decision",
    "LeadVehicle",
    "Rejection",
    "RejectionKind",
    "RssSettings",
    "choose_action",
    "danger_zone",
    "danger_zone_end",
    "find_conflict",
    "rss_lateral",
    "rss_opposite_direction",
    "rss_same_direction",
]
