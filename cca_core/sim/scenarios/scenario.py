"""Scenarios as data: a road, an ego, scripted road users, a channel."""

import math
from dataclasses import dataclass, field

import numpy as np

from cca_core._checks import check_array, check_bool, check_real
from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.follow import SpeedSettings
from cca_core.path import Road
from cca_core.planner.settings import EvasionSettings
from cca_core.sim.scenarios.road_user import ReactToLeadAction, RoadUser
from cca_core.v2x import ChannelSettings, SenderSettings
from cca_core.vehicle import VehicleParams

EGO_TYPES = ("v2v", "driver", "sensor")
"""Controllers of the ego: planner with messages, human driver, planner with sensor alone."""

LANE_WIDTH = 3.5
"""Width of the lanes of all scenarios [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedTimeGap:
    """Tailgating: a time gap that the ego keeps until it knows of a hazard.

    Parameters
    ----------
    lead_id : str
        Id of the lead vehicle.
    time_gap : float
        Bumper-to-bumper gap divided by the ego's speed [s], positive.

    Raises
    ------
    InputError
        If `time_gap` is not positive.
    """

    lead_id: str
    time_gap: float

    def __post_init__(self) -> None:
        check_real("time_gap", self.time_gap, gt=0.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scenario:
    """Road, ego, road users and channel: all that one run depends on.

    Parameters
    ----------
    name : str
        Name, such as ``"eebl"``.
    case : str or None
        Case, such as ``"C"``.
    road : Road
        Route and lanes.
    vehicle : VehicleParams
        The ego.
    start : float
        Station of the ego's center of gravity at the start [m].
    v_x : float
        Its speed at the start [m/s].
    cruise_speed : float
        Its cruise speed [m/s].
    road_users : tuple of RoadUser
        All other vehicles.
    evasion : EvasionSettings
        Settings of its evasive maneuvers.
    speed : SpeedSettings
        Settings of its longitudinal control; the driver brakes with its `b_max` and `jerk_emergency` too.
    duration : float
        Length of the run [s].
    ego_type : {"v2v", "driver", "sensor"}
        Controller of the ego: the planner with messages and a sensor; a human driver, who brakes fully after
        their reaction time; the planner with the sensor alone. Without messages the planner accepts no gap
        in an adjacent lane.
    reaction_time : float
        Reaction time of the driver [s].
    sensor_range : float
        Range of sensor and driver between the centers of two bodies [m].
    field_of_view : float
        Their field of view [rad], half of it on each side.
    sensor_delay : float
        Age of the sensor's detections [s]; the driver's is part of the reaction time.
    visibility : float
        Range of sight in this weather [m].
    latency : float
        From a message's measurement to its arrival [s], if there is no `channel`.
    channel : ChannelSettings, optional
        Radio channel; the default loses nothing and has that latency.
    sender : SenderSettings
        Rate and position error of all senders.
    shared_modem : bool
        Whether one modem sends for all road users, as in the paper's test rig, so that one burst of loss
        covers the messages of all. Otherwise each has its own.
    fixed_gap : FixedTimeGap, optional
        Time gap that the ego keeps until it knows of a hazard.
    stop_line : float, optional
        Station of a stop line in figures [m]; the planner uses those of `road`.
    occluders : tuple of tuple of float
        Buildings that block the line of sight: x, y [m], psi [rad], length, width [m] of each.
    other_roads : tuple of Road
        Other roads in figures.
    paper_figures : tuple of int
        Numbers of the paper's figures of this scenario.
    seed : int
        Seed of the senders' phases and of the channel.
    hazard_id : str, optional
        Id of the road user whose first message warns of the hazard, in studies; by default it is the first
        message of hard braking of any.
    origin : tuple of float
        Latitude and longitude of x = y = 0 [deg].

    Raises
    ------
    InputError
        If a value is out of range, or an id is used twice or unknown.
    """

    name: str
    case: str | None
    road: Road
    vehicle: VehicleParams
    start: float
    v_x: float
    cruise_speed: float
    road_users: tuple[RoadUser, ...]
    evasion: EvasionSettings = field(default_factory=EvasionSettings)
    speed: SpeedSettings = field(default_factory=SpeedSettings)
    duration: float = 40.0
    ego_type: str = "v2v"
    reaction_time: float = 1.25
    sensor_range: float = 100.0
    field_of_view: float = math.radians(120.0)
    sensor_delay: float = 0.4
    visibility: float = math.inf
    latency: float = 0.1
    channel: ChannelSettings | None = None
    sender: SenderSettings = field(default_factory=SenderSettings)
    shared_modem: bool = False
    fixed_gap: FixedTimeGap | None = None
    stop_line: float | None = None
    occluders: tuple[tuple[float, float, float, float, float], ...] = ()
    other_roads: tuple[Road, ...] = ()
    paper_figures: tuple[int, ...] = ()
    seed: int = 1
    hazard_id: str | None = None
    origin: tuple[float, float] = (41.3, -105.6)

    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_real("start", self.start, ge=self.road.path.start, le=self.road.path.end)
        check_real("v_x", self.v_x, ge=0.0)
        check_real("cruise_speed", self.cruise_speed, gt=0.0)
        check_real("duration", self.duration, gt=0.0)
        for name in ("reaction_time", "sensor_range", "sensor_delay", "latency"):
            check_real(name, getattr(self, name), ge=0.0)
        check_real("field_of_view", self.field_of_view, ge=0.0, le=math.tau)
        check_real("visibility", self.visibility, ge=0.0, allow_inf=True)
        check_bool("shared_modem", self.shared_modem)
        if self.stop_line is not None:
            check_real("stop_line", self.stop_line)
        check_real("origin", self.origin[0], ge=-89.0, le=89.0)
        check_real("origin", self.origin[1], ge=-180.0, le=180.0)
        check_array("occluders", self.occluders or np.empty((0, 5)), (None, 5))
        if self.ego_type not in EGO_TYPES:
            raise InputError(f"ego_type must be one of {', '.join(EGO_TYPES)}, was {self.ego_type!r}")
        names = [user.id for user in self.road_users]
        if len(set(names)) < len(names):
            raise InputError(f"road_users must have different ids, had {', '.join(names)}")
        actions = [action for user in self.road_users for action in user.actions]
        lead_ids = [action.lead_id for action in actions if isinstance(action, ReactToLeadAction)]
        lead_ids += [] if self.fixed_gap is None else [self.fixed_gap.lead_id]
        for lead_id in lead_ids:
            if lead_id not in names:
                raise InputError(f"lead_id must be the id of a road user, was {lead_id!r}")

    @property
    def v2v(self) -> bool:
        """Whether messages are exchanged with the ego."""
        return self.ego_type == "v2v"
