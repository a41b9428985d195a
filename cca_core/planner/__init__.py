"""Planner: one cycle from vehicles around the ego to steering and acceleration."""

from cca_core.planner.certificate import Certificate, Grade, SafeStop
from cca_core.planner.command import Command
from cca_core.planner.maneuver_tuning import (
    AbortSettings,
    CertificateSettings,
    CostSettings,
    LastResortSettings,
    ReplanSettings,
)
from cca_core.planner.planner import Planner
from cca_core.planner.records import Mode
from cca_core.planner.settings import EvasionSettings
from cca_core.planner.tuning import (
    ActuationSettings,
    DecisionSettings,
    LaneChangeSettings,
    LeadSettings,
    YieldSettings,
)

__all__ = [
    "AbortSettings",
    "ActuationSettings",
    "Certificate",
    "CertificateSettings",
    "Command",
    "CostSettings",
    "DecisionSettings",
    "EvasionSettings",
    "Grade",
    "LaneChangeSettings",
    "LastResortSettings",
    "LeadSettings",
    "Mode",
    "Planner",
    "ReplanSettings",
    "SafeStop",
    "YieldSettings",
]  # fmt: skip
