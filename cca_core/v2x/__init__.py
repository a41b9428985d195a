"""V2X: message bytes to vehicles with honest bounds, and back; no sockets."""

from cca_core.v2x.bsm import Accuracy, Brakes, Bsm, decode_bsm, encode_bsm
from cca_core.v2x.channel import Arrival, Channel, ChannelSettings
from cca_core.v2x.motion import Fix, move_on, position_bounds
from cca_core.v2x.plausibility import PLAUSIBILITY_CHECKS, PlausibilitySettings
from cca_core.v2x.sender import Sender, SenderSettings
from cca_core.v2x.tracker import Tracker
from cca_core.v2x.tracker_settings import TrackerSettings
from cca_core.v2x.update_result import Outcome

__all__ = [
    "PLAUSIBILITY_CHECKS", "Accuracy", "Arrival", "Brakes", "Bsm", "Channel", "ChannelSettings", "Fix",
    "Outcome", "PlausibilitySettings", "Sender", "SenderSettings", "Tracker", "TrackerSettings", "decode_bsm",
    "encode_bsm", "move_on", "position_bounds",
]  # fmt: skip
