"""The paper's hardware-in-the-loop setup on real interfaces: CAN, radio, processes (extra ``rig``)."""

from cca_core.rig.bus import LOG_ENDINGS, BusLink, BusRecorder, read_bus_log, replay_bus
from cca_core.rig.clocks import ClockMap, RigClock
from cca_core.rig.kit import (
    AccelerationCommand,
    Actuation,
    DriveByWireKit,
    KitSettings,
    KitState,
    SteeringCommand,
)
from cca_core.rig.messages import COMMAND_MESSAGES, DBC_FILE, STATE_MESSAGES, Codec, Frame, KitStatus
from cca_core.rig.protection import (
    CheckStatus,
    LinkState,
    ProtectedReceiver,
    ProtectionSettings,
    crc8,
    protect,
)
from cca_core.rig.receivers import CommandReceiver, StateReceiver, StateSettings
from cca_core.rig.safe_stop import SAFE_STOP_POINTS, SafeStop, SafeStopSettings, plan_safe_stop
from cca_core.rig.settings import RigSettings, SteeringMap, read_rig_settings
from cca_core.rig.udp import UdpLink
from cca_core.rig.wrap import WRAPPERS, wrap_message

__all__ = [
    "COMMAND_MESSAGES",
    "DBC_FILE",
    "LOG_ENDINGS",
    "SAFE_STOP_POINTS",
    "STATE_MESSAGES",
    "WRAPPERS",
    "AccelerationCommand",
    "Actuation",
    "BusLink",
    "BusRecorder",
    "CheckStatus",
    "ClockMap",
    "Codec",
    "CommandReceiver",
    "DriveByWireKit",
    "Frame",
    "KitSettings",
    "KitState",
    "KitStatus",
    "LinkState",
    "ProtectedReceiver",
    "ProtectionSettings",
    "RigClock",
    "RigSettings",
    "SafeStop",
    "SafeStopSettings",
    "StateReceiver",
    "StateSettings",
    "SteeringCommand",
    "SteeringMap",
    "UdpLink",
    "crc8",
    "plan_safe_stop",
    "protect",
    "read_bus_log",
    "read_rig_settings",
    "replay_bus",
    "wrap_message",
]
