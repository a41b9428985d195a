"""The paper's second scenario: a turn, or a crossing, in front of an occluded car (Figs 8-9)."""

import math

import numpy as np

from cca_core._checks import Array, check_array, check_real
from cca_core.errors import InputError
from cca_core.follow import SpeedSettings, squared_speed_limit
from cca_core.path import Lane, Path, Road, interpolate_path
from cca_core.sim.human_driver import CURVE_ACCELERATION
from cca_core.sim.scenarios.eebl import CAR, JERK, LOSSY_CHANNEL
from cca_core.sim.scenarios.road_user import RoadUser
from cca_core.sim.scenarios.scenario import LANE_WIDTH, Scenario
from cca_core.v2x import ChannelSettings

IMA_CASES = ("left-turn", "crossing")
"""Left turn in front of an occluded oncoming car, or straight on with one from the right."""

_ARM_LENGTH = 400.0  # of the roads on either side of the junction [m]


def ima(
    case: str = "left-turn",
    *,
    ego_type: str = "v2v",
    v_x: float | None = None,
    v_red: float = 60.0 / 3.6,
    offset: float = 0.0,
    truck: tuple[float, float] = (8.0, 2.5),
    reaction_time: float = 1.25,
    channel: ChannelSettings = LOSSY_CHANNEL,
    sensor_range: float = 100.0,
    visibility: float = math.inf,
    x_stop_line: float = -8.0,
    building: tuple[float, float, float, float, float] = (-38.0, -34.0, 0.0, 64.0, 52.0),
    start: float = 5.0,
) -> Scenario:
    """Cross the path of a fast car (red) that is occluded.

    Parameters
    ----------
    case : {"left-turn", "crossing"}
        The ego turns left across the opposing through lane, occluded by a truck that waits on the opposing
        left-turn lane; or it goes straight on and red comes from the right, occluded by a building.
    ego_type : {"v2v", "driver", "sensor"}
        Controller of the ego.
    v_x : float, optional
        Its speed [m/s]; the default is 20 km/h for the turn and 40 km/h straight on.
    v_red : float
        Speed of red [m/s].
    offset : float
        Arrival of red at the conflict point after the arrival of an ego that does not brake [s], -5 to 5.
    truck : tuple of float
        Length and width of the truck [m].
    reaction_time : float
        Reaction time of both drivers [s].
    channel : ChannelSettings
        Radio channel.
    sensor_range, visibility : float
        Range of the ego's sensor, and range of sight in this weather [m].
    x_stop_line : float
        Position of the ego's stop line [m].
    building : tuple of float
        Building at the corner on the right: x, y [m], psi [rad], length, width [m].
    start : float
        Station of the ego at the start [m].

    Returns
    -------
    scenario : Scenario
        x points east and y north; the center of the junction is the origin.

    Raises
    ------
    InputError
        If the case is unknown or a value is out of range.
    """
    if case not in IMA_CASES:
        raise InputError(f"case must be one of {', '.join(IMA_CASES)}, was {case!r}")
    turns = case == "left-turn"
    v_x = (20.0 if turns else 40.0) / 3.6 if v_x is None else check_real("v_x", v_x, gt=0.0, le=100.0)
    v_red = check_real("v_red", v_red, gt=0.0)
    offset = check_real("offset", offset, ge=-5.0, le=5.0)
    x_stop_line = check_real("x_stop_line", x_stop_line, ge=-1e3, le=1e3)
    start = check_real("start", start, ge=-1e3, le=1e3)
    length, width = check_array("truck", truck, (2,)).tolist()
    speed = SpeedSettings()
    path, red_path, conflict = _left_turn() if turns else _crossing()
    arrival = _arrival_time(path, start, float(path.project(conflict)[0]), v_x, speed)
    users = [
        RoadUser(
            id="red", s=float(red_path.project(conflict)[0]) - v_red * (arrival + offset), d=0.0, v_x=v_red,
            route=red_path, reaction_time=reaction_time, deceleration=7.0, jerk=JERK,
        )
    ]  # fmt: skip
    if turns:
        left_turn_lane = _straight((_ARM_LENGTH, 0.5 * LANE_WIDTH), (-_ARM_LENGTH, 0.5 * LANE_WIDTH))
        users.append(
            RoadUser(
                id="truck", s=_ARM_LENGTH + x_stop_line - 0.5 * length, d=0.0, v_x=0.0, length=length,
                width=width, route=left_turn_lane,
            )
        )  # fmt: skip
    stop_line = float(path.project((x_stop_line, -0.5 * LANE_WIDTH))[0])
    return Scenario(
        name="ima", case=case, road=Road(path, speed_limit=v_x, stop_lines=(stop_line,)),
        vehicle=CAR, start=start, v_x=v_x, cruise_speed=v_x, road_users=tuple(users),
        speed=speed, duration=float(math.ceil(arrival + 14.0)), ego_type=ego_type,
        reaction_time=reaction_time, channel=channel, shared_modem=True, sensor_range=sensor_range,
        visibility=visibility, stop_line=stop_line, occluders=() if turns else (building,),
        hazard_id="red", paper_figures=(8, 9), other_roads=_other_roads(),
    )  # fmt: skip


def _left_turn(radius: float = 10.0) -> tuple[Path, Path, tuple[float, float]]:
    """Return the ego's route, the path of the oncoming car, and the point in which they cross."""
    x_begin = 0.5 * LANE_WIDTH - radius
    approach, leaving = np.arange(-60.0, x_begin, 1.0), np.arange(1.0, 150.0, 1.0)
    angle = np.linspace(0.0, 0.5 * math.pi, 17)
    arc: Array = np.column_stack(
        (x_begin + radius * np.sin(angle), radius - 0.5 * LANE_WIDTH - radius * np.cos(angle))
    )
    points = (
        np.column_stack((approach, np.full_like(approach, -0.5 * LANE_WIDTH))),
        arc,
        np.column_stack((np.full_like(leaving, 0.5 * LANE_WIDTH), arc[-1, 1] + leaving)),
    )
    oncoming = _straight((_ARM_LENGTH, 1.5 * LANE_WIDTH), (-_ARM_LENGTH, 1.5 * LANE_WIDTH))
    x_conflict = x_begin + math.sqrt(radius**2 - 9.0)
    return interpolate_path(np.vstack(points)), oncoming, (x_conflict, 1.5 * LANE_WIDTH)


def _crossing() -> tuple[Path, Path, tuple[float, float]]:
    """Return the ego's route, the path of the crossing car, and the point in which they cross."""
    path = _straight((-120.0, -0.5 * LANE_WIDTH), (150.0, -0.5 * LANE_WIDTH))
    return path, _cross_street(), (0.5 * LANE_WIDTH, -0.5 * LANE_WIDTH)


def _cross_street() -> Path:
    return _straight((0.5 * LANE_WIDTH, -_ARM_LENGTH), (0.5 * LANE_WIDTH, _ARM_LENGTH))


def _other_roads() -> tuple[Road, Road]:
    street = _straight((-_ARM_LENGTH, -0.5 * LANE_WIDTH), (_ARM_LENGTH, -0.5 * LANE_WIDTH))
    lanes = [
        Lane(d=0.0), Lane(d=LANE_WIDTH, direction=-1), Lane(d=2.0 * LANE_WIDTH, direction=-1),
        Lane(d=-LANE_WIDTH),
    ]  # fmt: skip
    return Road(street, lanes), Road(_cross_street(), [Lane(d=0.0), Lane(d=LANE_WIDTH, direction=-1)])


def _straight(start: tuple[float, float], end: tuple[float, float]) -> Path:
    n = max(2, math.ceil(math.dist(start, end) / 20.0))
    return interpolate_path(np.linspace(start, end, n))


def _arrival_time(path: Path, start: float, end: float, v_x: float, speed: SpeedSettings) -> float:
    """Return when an ego that brakes for curves alone is at a station [s]."""
    s = np.linspace(start, end, 400)
    v = np.sqrt(np.interp(s, *squared_speed_limit(path, v_x, CURVE_ACCELERATION, speed)))
    return float(np.sum(np.diff(s) * 2.0 / (v[1:] + v[:-1])))
