"""The paper's hardware-in-the-loop setup on real interfaces: CAN, radio, processes (extra ``rig``)."""

from cca_core.rig.bus import BusLink
from cca_core.rig.bus_log import LOG_ENDINGS, BusRecorder, read_bus_log, replay_bus
from cca_core.rig.clocks import ClockMap, RigClock
from cca_core.rig.control import ControlPort
from cca_core.rig.detections import decode_detections, encode_detections
from cca_core.rig.figure import plot_links
from cca_core.rig.frames import Frame, KitStatus
from cca_core.rig.kit import (
    AccelerationCommand,
    Actuation,
    DriveByWireKit,
    KitSettings,
    KitState,
    SteeringCommand,
)
from cca_core.rig.merge import measure_links, merge_log
from cca_core.rig.messages import COMMAND_MESSAGES, DBC_FILE, STATE_MESSAGES, Codec
from cca_core.rig.monitor import Monitor, serve
from cca_core.rig.plant import PlantNode
from cca_core.rig.processes import find_scenario, run_plant, run_vehicle, scenario_id
from cca_core.rig.protection import (
    CheckStatus,
    LinkState,
    ProtectedReceiver,
    ProtectionSettings,
    crc8,
    protect,
)
from cca_core.rig.receivers import CommandReceiver, StateReceiver, StateSettings
from cca_core.rig.records import PlantRow, ProcessRecord, VehicleRow, read_record, write_record
from cca_core.rig.run import RigError, RigOptions, RigRun, run_scenario, run_scenarios, start_process
from cca_core.rig.safe_stop import SAFE_STOP_POINTS, StopProfile
from cca_core.rig.settings import RigSettings, SteeringMap, VehicleSettings, read_rig_settings
from cca_core.rig.stop_rollout import SafeStopSettings, plan_safe_stop
from cca_core.rig.takeover import Takeover
from cca_core.rig.telemetry import encode_telemetry
from cca_core.rig.udp import UdpLink
from cca_core.rig.vehicle import VehicleNode
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
    "ControlPort",
    "DriveByWireKit",
    "Frame",
    "KitSettings",
    "KitState",
    "KitStatus",
    "LinkState",
    "Monitor",
    "PlantNode",
    "PlantRow",
    "ProcessRecord",
    "ProtectedReceiver",
    "ProtectionSettings",
    "RigClock",
    "RigError",
    "RigOptions",
    "RigRun",
    "RigSettings",
    "SafeStopSettings",
    "StateReceiver",
    "StateSettings",
    "SteeringCommand",
    "SteeringMap",
    "StopProfile",
    "Takeover",
    "UdpLink",
    "VehicleNode",
    "VehicleRow",
    "VehicleSettings",
    "crc8",
    "decode_detections",
    "encode_detections",
    "encode_telemetry",
    "find_scenario",
    "measure_links",
    "merge_log",
    "plan_safe_stop",
    "plot_links",
    "protect",
    "read_bus_log",
    "read_record",
    "read_rig_settings",
    "replay_bus",
    "run_plant",
    "run_scenario",
    "run_scenarios",
    "run_vehicle",
    "scenario_id",
    "serve",
    "start_process",
    "wrap_message",
    "write_record",
]
