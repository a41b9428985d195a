"""The paper's third scenario: a parked car that the vehicle in front hides until late (Figs 10-12)."""

import math

import numpy as np

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.follow import SpeedSettings
from cca_core.path import Lane, Path, Road, interpolate_path
from cca_core.sim.scenarios.eebl import CAR, JERK, LOSSY_CHANNEL
from cca_core.sim.scenarios.road_user import LateralShiftAction, RoadUser
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.v2x import ChannelSettings

__all__ = ["CURBSIDE_CASES", "curbside"]

CURBSIDE_CASES = ("fast", "slow")
"""25 m/s, at which the ego evades, and 13.9 m/s, at which it brakes."""

_SPEED = {"fast": 25.0, "slow": 13.9}  # [m/s]
_LANE = 3.5  # [m]
_INTRUDES = 1.6  # how far the parked car stands in the lane [m]
_AHEAD, _SWERVES_BEFORE = 0.9, 1.1  # of the vehicle in front: gap, and time before the parked car [s]
_SWERVE, _SWERVE_TIME = 3.0, 2.0  # [m], [s]
_UNTIL = 9.0  # from the start to the parked car [s]
_LEAST_GAP = 3.0  # [m]
_FOLLOWS = 0.5  # gap with which the ego is content, on top of that [s]; messages are unsure by 0.3 s
_START = 50.0  # [m]


def curbside(
    case: str = "fast",
    *,
    ego: str = "v2v",
    v_x: float | None = None,
    lane_intrusion: float = _INTRUDES,
    radius: float = 2000.0,
    reaction: float = 1.25,
    channel: ChannelSettings = LOSSY_CHANNEL,
    visibility: float = math.inf,
) -> Scenario:
    """On a left-hand bend a parked car (red) occupies a part of the lane; yellow swerves around it late.

    Parameters
    ----------
    case : {"fast", "slow"}
        25 m/s or 13.9 m/s.
    ego : {"v2v", "driver", "sensor"}
        Who drives the ego.
    v_x : float, optional
        Another speed [m/s].
    lane_intrusion : float
        How far red stands in the ego's lane [m].
    radius : float
        Radius of the bend [m].
    reaction : float
        Reaction time of the ego's driver [s].
    channel : ChannelSettings
        The radio channel.
    visibility : float
        Distance up to which anything is seen in this weather [m].

    Returns
    -------
    scenario : Scenario
        Yellow 0.9 s ahead; red sends with its ignition on, hazard lights lit. The lane beside is free.

    Raises
    ------
    InputError
        If the case is unknown or a value is out of range.
    """
    if case not in CURBSIDE_CASES:
        raise InputError(f"case must be one of {', '.join(CURBSIDE_CASES)}, was {case!r}")
    v_x = _SPEED[case] if v_x is None else check_real("v_x", v_x, gt=5.0, le=36.0)
    lane_intrusion = check_real("intrudes", lane_intrusion, ge=0.0, le=_LANE)
    radius = check_real("radius", radius, ge=200.0)
    place = _START + _UNTIL * v_x
    gap = _AHEAD * v_x
    users = (
        RoadUser(
            id="yellow", s=_START + CAR.box_offset + CAR.length + gap, d=0.0, v_x=v_x, jerk=JERK,
            actions=(
                # its front is so much before red's rear when it begins
                LateralShiftAction(
                    s_start=place - CAR.length - _SWERVES_BEFORE * v_x, offset=_SWERVE, duration=_SWERVE_TIME
                ),
            ),
        ),
        RoadUser(
            id="red", s=place, d=-0.5 * _LANE + lane_intrusion - 0.5 * CAR.width, v_x=0.0,
            events=frozenset({"hazard_lights"}),
        ),
    )  # fmt: skip
    lanes = [Lane(d=0.0), Lane(d=_LANE)]
    return Scenario(
        name="curbside", case=case, road=Road(_bend(radius, place + 12.0 * v_x + 300.0), lanes),
        vehicle=CAR, start=_START, v_x=v_x, cruise_speed=v_x, road_users=users,
        speed=SpeedSettings(standstill_gap=_LEAST_GAP, time_gap=_FOLLOWS),
        duration=_UNTIL + 13.0, ego_type=ego, reaction_time=reaction, channel=channel, shared_modem=True,
        visibility=visibility, paper_figures=(10, 11, 12),
    )  # fmt: skip


def _bend(radius: float, length: float) -> Path:
    s = np.linspace(0.0, length, math.ceil(length / 20.0) + 1)
    x, y = radius * np.sin(s / radius), radius * (1.0 - np.cos(s / radius))
    return interpolate_path(np.column_stack((x, y)), start_tangent=(1.0, 0.0))
