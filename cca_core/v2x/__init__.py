"""V2X: message bytes to plausible vehicles with uncertainty bounds, and back; no sockets."""

from cca_core.v2x.bsm import BrakeStatus, Bsm, PositionalAccuracy, decode_bsm, encode_bsm
from cca_core.v2x.channel import Channel, ChannelSettings, ReceivedMessage
from cca_core.v2x.health import TrackerHealth
from cca_core.v2x.motion import Fix, PositionErrorModel, dead_reckon, position_bounds
from cca_core.v2x.plausibility import PLAUSIBILITY_CHECKS, PlausibilitySettings
from cca_core.v2x.sender import Sender, SenderSettings
from cca_core.v2x.tracker import Tracker
from cca_core.v2x.tracker_settings import TrackerSettings
from cca_core.v2x.update_result import UpdateResult
from cca_core.v2x.wrappers import MessageFrame, unwrap_message

__all__ = [
    "PLAUSIBILITY_CHECKS",
    "BrakeStatus",
    "Bsm",
    "Channel",
    "ChannelSettings",
    "Fix",
    "MessageFrame",
    "PlausibilitySettings",
    "PositionErrorModel",
    "PositionalAccuracy",
    "ReceivedMessage",
    "Sender",
    "SenderSettings",
    "Tracker",
    "TrackerHealth",
    "TrackerSettings",
    "UpdateResult",
    "dead_reckon",
    "decode_bsm",
    "encode_bsm",
    "position_bounds",
    "unwrap_message",
]  # fmt: skip
