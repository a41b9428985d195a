"""Names of records, fields and values in dictionaries of version 1."""

from collections.abc import Mapping
from typing import Any

CLASSES = {
    "BandProblem": "Task",
    "BrakeAction": "Brakes",
    "BrakeStatus": "Brakes",
    "CleanedRoute": "CleanRoute",
    "FixedTimeGap": "PinnedGap",
    "LateralShiftAction": "Swerves",
    "LeadVehicle": "Leader",
    "ParameterRanges": "Variation",
    "PositionalAccuracy": "Accuracy",
    "ReactToLeadAction": "Follows",
    "UpdateResult": "Outcome",
}
"""Class today to its name in version 1."""

FIELDS = {
    "Alert": {"remote": "vehicle_id"},
    "AlertSettings": {"standing": "standstill_speed", "oldest": "max_age"},
    "Band": {
        "binding": "active_constraint", "solves": "n_solves", "sixth": "moment_over_6", "task": "problem",
    },
    "ChannelSettings": {
        "loss": "loss_probability", "burst": "mean_burst_length", "edge_loss": "loss_at_range",
        "reordered": "reorder_probability", "reordering": "reorder_delay",
        "duplicated": "duplicate_probability",
    },
    "CleaningReport": {"resorted": "reordered"},
    "Conflict": {
        "remote": "vehicle_id", "s_in": "s_enter", "s_out": "s_exit", "ego": "t_ego", "other": "t_other",
        "expected": "t_other_nominal", "margin": "min_pet",
    },
    "CrossingSettings": {"margin": "min_pet", "least_angle": "min_angle", "standing": "standstill_speed"},
    "Decision": {"leader": "lead_id", "zone": "danger_zone"},
    "EvasionSettings": {
        "lateral_limit": "lateral_acceleration_limit", "lead_time": "min_ttc",
        "preparation": "preparation_time", "known_range": "awareness_range",
        "speed_floor": "min_speed_advantage", "braking": "assumed_braking",
        "acceleration": "assumed_acceleration", "passed_acceleration": "assumed_acceleration_passed",
    },
    "GainRegion": {"asked": "requested", "chosen": "selected"},
    "LateralShiftAction": {"at": "s_start", "width": "offset"},
    "LeadVehicle": {"stop_in_comfort": "comfort_stop_deceleration"},
    "ParameterRanges": {"reach": "radio_range", "noise": "position_noise", "reaction": "reaction_time"},
    "PlausibilitySettings": {
        "replayed": "replay", "inside": "overlap", "longest": "max_length", "widest": "max_width",
        "least_size": "min_size", "room": "position_tolerance", "timing": "time_tolerance",
        "strongest": "max_acceleration",
    },
    "ReactToLeadAction": {"leader": "lead_id", "reaction": "reaction_time", "warned_after": "warning_delay"},
    "RoadUser": {"reaction": "reaction_time", "acts": "actions"},
    "FixedTimeGap": {"leader": "lead_id"},
    "Scenario": {
        "users": "road_users", "ego": "ego_type", "reaction": "reaction_time", "one_modem": "shared_modem",
        "pinned": "fixed_gap", "scenery": "other_roads", "figures": "paper_figures",
    },
    "SenderSettings": {
        "noise_time": "noise_time_constant", "frozen": "freeze_probability",
        "frozen_length": "mean_freeze_length",
    },
    "TrackerSettings": {
        "most_senders": "max_tracks", "keep_within": "retention_range", "established_after": "confirm_after",
        "lost_after": "reassociate_after", "reaction": "reaction_time",
        "least_reach": "min_stopping_distance", "outlook": "approach_horizon",
        "forget_after": "delete_after", "most_accuracy": "max_reported_accuracy",
    },
    "UpdateResult": {"what": "kind"},
}  # fmt: skip
"""Class today to its fields that had another name: old to new."""

VALUES = {"Status": {"FALLBACK": "DEGRADED"}, "LeadVehicle.kind": {"ahead": "direct", "hidden": "downstream"}}
"""Enum or field today to its values in version 1, each with its value today."""

ADDED: dict[str, dict[str, Any]] = {
    "BandProblem": {"settings": {"type": "BandSettings"}},
    "CleaningReport": {"stationary": {"shape": [0]}},
}
"""Class today to values of fields that version 1 did not have."""


def updated_fields(name: str, data: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of a class with the names and values of today."""
    renamed, updated = FIELDS.get(name, {}), dict(ADDED.get(name, {}))
    for key, value in data.items():
        field = renamed.get(key, key)
        updated[field] = updated_value(f"{name}.{field}", value)
    return updated


def updated_value(name: str, value: Any) -> Any:
    """Value of an enum or of a field (`Class.field`) today."""
    return VALUES.get(name, {}).get(value, value) if isinstance(value, str) else value
