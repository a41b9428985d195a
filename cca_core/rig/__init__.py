"""The paper's hardware-in-the-loop setup on real interfaces: CAN, radio, processes (extra ``rig``)."""

from cca_core.rig.kit import (
    AccelerationCommand,
    Actuation,
    DriveByWireKit,
    KitSettings,
    KitState,
    SteeringCommand,
)
from cca_core.rig.protection import (
    CheckStatus,
    LinkState,
    ProtectedReceiver,
    ProtectionSettings,
    crc8,
    protect,
)
from cca_core.rig.safe_stop import SAFE_STOP_POINTS, SafeStop, SafeStopSettings, plan_safe_stop

__all__ = [
    "SAFE_STOP_POINTS",
    "AccelerationCommand",
    "Actuation",
    "CheckStatus",
    "DriveByWireKit",
    "KitSettings",
    "KitState",
    "LinkState",
    "ProtectedReceiver",
    "ProtectionSettings",
    "SafeStop",
    "SafeStopSettings",
    "SteeringCommand",
    "crc8",
    "plan_safe_stop",
    "protect",
]
