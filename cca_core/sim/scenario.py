"""Scenarios as data: a road, an ego, scripted road users."""

import math
from dataclasses import dataclass, field

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.evasion import EvasionSettings
from cca_core.path import Road
from cca_core.v2x import ChannelSettings
from cca_core.vehicle import VehicleParams


@dataclass(frozen=True, slots=True, kw_only=True)
class RoadUser:
    """A scripted vehicle that keeps to its lane.

    Parameters
    ----------
    id : str
        Its sender id.
    s, d : float
        Centre of its body in path coordinates at the start [m], d left positive.
    v_x : float
        Its speed at the start [m/s].
    direction : int
        1 along the route, -1 against it [-].
    length, width : float
        Body box [m].
    reaction : float
        Reaction time of its driver to a body in its way [s]; infinite: it drives on.
    deceleration : float
        How hard its driver brakes then [m/s^2], positive.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    id: str
    s: float
    d: float
    v_x: float
    direction: int = 1
    length: float = 4.5
    width: float = 1.8
    reaction: float = math.inf
    deceleration: float = 7.6

    def __post_init__(self) -> None:
        check_real("s", self.s)
        check_real("d", self.d)
        check_real("v_x", self.v_x, least=0.0)
        check_real("length", self.length, above=0.0)
        check_real("width", self.width, above=0.0)
        check_real("reaction", self.reaction, least=0.0, infinite=True)
        check_real("deceleration", self.deceleration, least=0.0)
        if self.direction not in (1, -1):
            raise InputError(f"direction must be 1 or -1, was {self.direction!r}")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scenario:
    """Everything that one run depends on, but for its seed.

    Parameters
    ----------
    name : str
        Scenario, such as ``"maneuver"``.
    case : str or None
        Which case of it.
    road : Road
        Route and lanes.
    vehicle : VehicleParams
        The ego.
    start : float
        Path coordinate of the ego's centre of gravity at the start [m].
    v_x : float
        Its speed at the start [m/s].
    cruise_speed : float
        Its wanted speed [m/s].
    users : tuple of RoadUser
        The others.
    evasion : EvasionSettings
        How the ego passes.
    duration : float
        Length of the run [s].
    v2v : bool
        Whether messages are exchanged. Without them the ego sees the vehicle in front of it only.
    sensor_range : float
        Farthest vehicle in front that the ego's sensor sees [m].
    latency : float
        From a message's measurement to its arrival [s].
    channel : ChannelSettings, optional
        The radio channel; the default loses nothing and has that latency.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    name: str
    case: str | None
    road: Road
    vehicle: VehicleParams
    start: float
    v_x: float
    cruise_speed: float
    users: tuple[RoadUser, ...]
    evasion: EvasionSettings = field(default_factory=EvasionSettings)
    duration: float = 40.0
    v2v: bool = True
    sensor_range: float = 100.0
    latency: float = 0.1
    channel: ChannelSettings | None = None

    def __post_init__(self) -> None:
        check_real("start", self.start, least=self.road.path.start, most=self.road.path.end)
        check_real("v_x", self.v_x, least=0.0)
        check_real("cruise_speed", self.cruise_speed, above=0.0)
        check_real("duration", self.duration, above=0.0)
        check_real("sensor_range", self.sensor_range, least=0.0)
        check_real("latency", self.latency, least=0.0)
