"""The paper's second scenario: a turn, or a crossing, in front of somebody hidden (Figs 8-9)."""

import math

import numpy as np

from cca_core._checks import Array, check_real
from cca_core.errors import InputError
from cca_core.follow import SpeedSettings, squared_speed_limit
from cca_core.path import Lane, Path, Road, interpolate_path
from cca_core.sim.human_driver import CURVE_ACCELERATION
from cca_core.sim.scenarios.eebl import CAR, JERK, LOSSY_CHANNEL
from cca_core.sim.scenarios.road_user import RoadUser
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.v2x import ChannelSettings

__all__ = ["IMA_CASES", "ima"]

IMA_CASES = ("left-turn", "crossing")
"""Left turn in front of a hidden oncoming car, or straight on across the way of one from the right."""

_LANE = 3.5  # [m]
_LINE = -8.0  # x of the stop line [m]
_RADIUS = 10.0  # of the turn [m]
_BEFORE, _AFTER = 60.0, 150.0  # the route before and after the junction [m]
_FAR = 400.0  # length of the other roads on either side [m]
_TRUCK = 8.0, 2.5  # the stopped vehicle [m]
_BUILDING = (-38.0, -34.0, 0.0, 64.0, 52.0)  # at the corner on the right: x, y, psi, length, width [m]


def ima(
    case: str = "left-turn",
    *,
    ego: str = "v2v",
    v_x: float | None = None,
    v_red: float = 60.0 / 3.6,
    offset: float = 0.0,
    truck: tuple[float, float] = _TRUCK,
    reaction: float = 1.25,
    channel: ChannelSettings = LOSSY_CHANNEL,
    sensor_range: float = 100.0,
    visibility: float = math.inf,
) -> Scenario:
    """Cross the way of a fast car (red) that is hidden.

    Parameters
    ----------
    case : {"left-turn", "crossing"}
        The ego turns left across the opposite through lane, hidden by a truck that waits on the opposite
        left-turn lane; or goes straight on, red comes from the right, hidden by a building at the corner.
    ego : {"v2v", "driver", "sensor"}
        Who drives the ego.
    v_x : float, optional
        Its speed [m/s]; the default is 20 km/h to turn and 40 km/h straight on.
    v_red : float
        Speed of red [m/s].
    offset : float
        How much later red is at the conflict point than the ego would be if it did not brake [s].
    truck : tuple of float
        Length and width of the stopped vehicle [m].
    reaction : float
        Reaction time of both drivers [s].
    channel : ChannelSettings
        The radio channel.
    sensor_range, visibility : float
        How far the ego sees, and how far anybody sees in this weather [m].

    Returns
    -------
    scenario : Scenario
        x points east and y north, the center of the junction is the origin.

    Raises
    ------
    InputError
        If the case is unknown or a value is out of range.
    """
    if case not in IMA_CASES:
        raise InputError(f"case must be one of {', '.join(IMA_CASES)}, was {case!r}")
    turns = case == "left-turn"
    v_x = (20.0 if turns else 40.0) / 3.6 if v_x is None else check_real("v_x", v_x, gt=0.0)
    v_red = check_real("v_red", v_red, gt=0.0)
    offset = check_real("offset", offset, ge=-5.0, le=5.0)
    speed = SpeedSettings()
    before = _BEFORE if turns else 2.0 * _BEFORE
    path = _turn(before) if turns else _straight((-before, -0.5 * _LANE), (_AFTER, -0.5 * _LANE))
    if turns:
        way = _straight((_FAR, 1.5 * _LANE), (-_FAR, 1.5 * _LANE))
        meets = 0.5 * _LANE - _RADIUS + math.sqrt(_RADIUS**2 - 9.0), 1.5 * _LANE
    else:
        way = _straight((0.5 * _LANE, -_FAR), (0.5 * _LANE, _FAR))
        meets = 0.5 * _LANE, -0.5 * _LANE
    start = 5.0
    at = _arrival(path, start, float(path.project(meets)[0]), v_x, speed)
    users = [
        RoadUser(
            id="red", s=float(way.project(meets)[0]) - v_red * (at + offset), d=0.0, v_x=v_red, route=way,
            reaction_time=reaction, deceleration=7.0, jerk=JERK,
        )
    ]  # fmt: skip
    if turns:
        waits = _straight((_FAR, 0.5 * _LANE), (-_FAR, 0.5 * _LANE))
        users.append(
            RoadUser(
                id="truck", s=_FAR + _LINE - 0.5 * truck[0], d=0.0, v_x=0.0, length=truck[0], width=truck[1],
                route=waits,
            )
        )  # fmt: skip
    line = float(path.project((_LINE, -0.5 * _LANE))[0])
    street = _straight((-_FAR, -0.5 * _LANE), (_FAR, -0.5 * _LANE))
    beside = [Lane(d=_LANE, direction=-1), Lane(d=2.0 * _LANE, direction=-1), Lane(d=-_LANE)]
    across = _straight((0.5 * _LANE, -_FAR), (0.5 * _LANE, _FAR))
    return Scenario(
        name="ima", case=case, road=Road(path, speed_limit=v_x, stop_lines=(line,)),
        vehicle=CAR, start=start, v_x=v_x, cruise_speed=v_x, road_users=tuple(users),
        speed=speed, duration=float(math.ceil(at + 14.0)), ego_type=ego,
        reaction_time=reaction, channel=channel, shared_modem=True, sensor_range=sensor_range, visibility=visibility,
        stop_line=line, occluders=() if turns else (_BUILDING,), paper_figures=(8, 9),
        other_roads=(
            Road(street, [Lane(d=0.0), *beside]), Road(across, [Lane(d=0.0), Lane(d=_LANE, direction=-1)]),
        ),
    )  # fmt: skip


def _straight(start: tuple[float, float], end: tuple[float, float]) -> Path:
    n = max(2, math.ceil(math.dist(start, end) / 20.0))
    return interpolate_path(np.linspace(start, end, n))


def _turn(before: float) -> Path:
    """Left turn from the lane y = -1.75 m to the lane x = 1.75 m."""
    begin = 0.5 * _LANE - _RADIUS
    approach = np.arange(-before, begin, 1.0)
    angle = np.linspace(0.0, 0.5 * math.pi, 17)
    leaving = np.arange(1.0, _AFTER, 1.0)
    arc: Array = np.column_stack(
        (begin + _RADIUS * np.sin(angle), _RADIUS - 0.5 * _LANE - _RADIUS * np.cos(angle))
    )
    return interpolate_path(
        np.vstack(
            (
                np.column_stack((approach, np.full_like(approach, -0.5 * _LANE))),
                arc,
                np.column_stack((np.full_like(leaving, 0.5 * _LANE), arc[-1, 1] + leaving)),
            )
        )
    )


def _arrival(path: Path, start: float, end: float, v_x: float, speed: SpeedSettings) -> float:
    """When an ego that does not brake for others is at a place [s]."""
    s = np.linspace(start, end, 400)
    v = np.sqrt(np.interp(s, *squared_speed_limit(path, v_x, CURVE_ACCELERATION, speed)))
    return float(np.sum(np.diff(s) * 2.0 / (v[1:] + v[:-1])))
