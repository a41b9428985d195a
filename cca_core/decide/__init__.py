"""Decide: danger zone of the lane beside (eq 11) and choice of action."""

from cca_core.decide.action import Action, Candidate, Decision, Leader, choose_action
from cca_core.decide.danger_zone import danger_zone, danger_zone_end

__all__ = [
    "Action", "Candidate", "Decision", "Leader", "choose_action", "danger_zone", "danger_zone_end",
]  # fmt: skip
