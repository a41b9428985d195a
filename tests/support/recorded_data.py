"""One of each public record of the library."""

import dataclasses
import importlib
import math
import pkgutil
from typing import Any

import numpy as np

import cca_core
from cca_core import (
    Command,
    Lane,
    LocalFrame,
    Path,
    Planner,
    RemoteVehicle,
    Road,
    VehicleParams,
    VehicleState,
    choose_action,
    fit_path,
)  # fmt: skip
from cca_core.adapters import CarlaPedals
from cca_core.band import BandSettings, BandStiffness, CurvatureBounds
from cca_core.decide import (
    RSS_EGO,
    Candidate,
    Conflict,
    CrossingSettings,
    LeadVehicle,
    Rejection,
    RejectionKind,
)
from cca_core.follow import (
    Margins,
    SpeedSettings,
    StabilityRegion,
    gain_region,
    shipped_gains,
    single_track,
)  # fmt: skip
from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.geometry import boxes
from cca_core.path import FitReport, Waypoints, clean_route
from cca_core.planner import (
    AbortSettings,
    ActuationSettings,
    Certificate,
    CertificateSettings,
    CostSettings,
    DecisionSettings,
    EvasionSettings,
    Grade,
    LaneChangeSettings,
    LastResortSettings,
    LeadSettings,
    ReplanSettings,
    SafeStop,
    YieldSettings,
)
from cca_core.real_time import RealTimeSettings
from cca_core.v2x import (
    BrakeStatus,
    Bsm,
    ChannelSettings,
    MessageFrame,
    PlausibilitySettings,
    PositionalAccuracy,
    PositionErrorModel,
    SenderSettings,
    TrackerHealth,
    TrackerSettings,
    UpdateResult,
)  # fmt: skip
from cca_core.warnings import Alert, AlertSettings, Application, Level, VehicleInView, WarningView

CAR = VehicleParams.bmw_320i()
ROUTE = fit_path(np.column_stack((np.arange(0.0, 601.0, 5.0), np.zeros(121))), tolerance=0.1)
ROAD = Road(ROUTE, lanes=[Lane(d=0.0), Lane(d=3.5, direction=-1)], speed_limit=25.0)
OTHERS = (
    RemoteVehicle(id="parked", x=120.0, y=0.0, psi=0.0, v_x=0.0),
    RemoteVehicle(
        id="oncoming", x=560.0, y=3.5, psi=math.pi, v_x=15.0, events=frozenset({"abs_active", "lights"})
    ),
)


def driven(planner: Planner, steps: range) -> list[Command]:
    """Commands of a planner that approaches a parked vehicle at 20 m/s."""
    states = (VehicleState(x=0.4 * i, y=0.0, psi=0.0, v_x=20.0) for i in steps)
    return [planner.step(0.02 * i, state, OTHERS) for i, state in zip(steps, states, strict=True)]


def public_records() -> set[type]:
    """Dataclasses among the public names of the packages of the core."""
    found = set()
    for module in pkgutil.iter_modules(cca_core.__path__, "cca_core."):
        package = module.name.removeprefix("cca_core.")
        if package.startswith("_") or package in ("plot", "report", "baselines", "sim", "rig", "fmi"):
            continue
        loaded = importlib.import_module(module.name)
        values = (getattr(loaded, name) for name in getattr(loaded, "__all__", ()))
        found |= {value for value in values if isinstance(value, type) and dataclasses.is_dataclass(value)}
    # what derives from a record of the simulation belongs to it, wherever it is public
    return {kind for kind in found if not any(b.__module__.startswith("cca_core.sim") for b in kind.__mro__)}


def examples() -> dict[str, Any]:
    """One record of each class, by class name."""
    commands = driven(Planner(CAR, ROAD, cruise_speed=20.0), range(400))
    command = next(c for c in reversed(commands) if c.band is not None)
    conflict = Conflict(
        vehicle_id="a", s_enter=20.0, s_exit=30.0, distance=17.0, t_ego=(1.0, 1.5), t_other=(0.5, math.inf),
        t_other_nominal=(0.5, 2.0), min_pet=1.0,
    )  # fmt: skip
    candidate = Candidate(
        side="left",
        available_distance=40.0,
        required_distance=35.0,
        t_maneuver=4.0,
        danger_zone=(-10.0, 60.0),
    )
    lead = LeadVehicle(id="a", gap=30.0, v_x=10.0, required_deceleration=2.0, follow_acceleration=-1.0)
    ego = FrenetEgo(vehicle=CAR, s=1.0, v_x=20.0, v_target=20.0)
    frenet_vehicle = FrenetVehicle.from_remote(OTHERS[0], 120.0, 0.0, 0.0, 0.0)
    in_view = VehicleInView(vehicle=frenet_vehicle, gap=5.0, lateral_offset=0.0, conflict=conflict)
    rejection = Rejection(kind=RejectionKind.CLEARANCE, side="left", vehicle_id="a", value=0.6, limit=1.0)
    values = [
        ROUTE, ROAD, ROAD.lanes[1], LocalFrame(41.3, -105.6),
        clean_route(ROUTE.sample(10.0)), clean_route(ROUTE.sample(10.0)).report,
        FitReport(
            tolerance=0.3, noise=None, max_deviation=0.7, s_max_deviation=30.0, missed=np.array([3]),
            missed_by=np.array([0.7]), outliers=np.array([3]),
        ),
        Waypoints(lat=np.array([41.0, 41.1]), lon=np.array([-105.0, -105.1]), duplicates=2),
        CAR, VehicleState(x=1.0, y=2.0, psi=0.1, v_x=20.0), OTHERS[1],
        command, command.band, BandStiffness(k_b=2.0), BandSettings(),
        CurvatureBounds(contact=np.ones(1), lower=np.full((1, 5), -0.1), upper=np.full((1, 5), 0.1)),
        boxes([0.0, 1.0], 2.0, 0.1, 4.5, 1.8),
        SpeedSettings(), StabilityRegion(), shipped_gains(CAR), single_track(CAR, 20.0, 22.0),
        gain_region(CAR, 20.0, 22.0, StabilityRegion()),
        Margins(v_x=20.0, gain=3.0, phase=1.0, delay=0.1, disk=0.8, crossover=2.0),
        choose_action(lead, [candidate]), lead, candidate, CrossingSettings(), conflict, RSS_EGO,
        AlertSettings(), WarningView(path=ROUTE, ego=ego, intent="left", vehicles=(in_view,)), in_view,
        Alert(
            application=Application.FCW, level=Level.WARN, vehicle_id="a", time_to_conflict=math.inf,
            reason="",
        ),
        EvasionSettings(awareness_range=math.inf),
        SafeStop(
            t=np.arange(3.0), delta=np.zeros(3), a_x=np.zeros(3), v=np.zeros(3), poses=np.zeros((3, 3))
        ),
        Certificate(grade=Grade.FULL, braking=4.0, gap=2.5, vehicle_id="A", passed=frozenset({"B"})),
        rejection, CertificateSettings(), CostSettings(),
        AbortSettings(), ActuationSettings(), DecisionSettings(), LastResortSettings(), LaneChangeSettings(),
        CarlaPedals(),
        LeadSettings(), ReplanSettings(), YieldSettings(),
        ego, frenet_vehicle,
        PositionalAccuracy(), PositionErrorModel(), BrakeStatus(wheels=(True, False)),
        Bsm(msg_count=3, id="01ab23cd", speed=20.0),
        ChannelSettings(), UpdateResult(accepted=True, kind="new", id="a", t=3.0), PlausibilitySettings(),
        SenderSettings(), MessageFrame(data=b"\x00\x14\x00", message_id=20, name="BSM"),
        RealTimeSettings(cpus=(0, 1)), TrackerSettings(),
        TrackerHealth(t=3.0, received=20.0, accepted=19.0, rejected=(("frozen", 1.0),)),
    ]  # fmt: skip
    return {type(value).__name__: value for value in values}


def parts(value: Any) -> Any:
    """Nested values that `==` compares exactly; NaN equals NaN."""
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype.str, value.tobytes() if value.dtype != object else value.tolist()
    if isinstance(value, Path):
        return parts(value.breaks), parts(value.coefficients)
    if isinstance(value, Road):
        return parts(value.path), value.lanes, value.speed_limit
    if isinstance(value, LocalFrame):
        return value.lat0, value.lon0
    if dataclasses.is_dataclass(value):
        return type(value), [parts(getattr(value, field.name)) for field in dataclasses.fields(value)]
    if isinstance(value, (tuple, list)):
        return [parts(item) for item in value]
    return "NaN" if isinstance(value, float) and math.isnan(value) else value
