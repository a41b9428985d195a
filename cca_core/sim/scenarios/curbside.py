"""The paper's third scenario: a parked car that the lead vehicle occludes until late (Figs 10-12)."""

import math

import numpy as np

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.follow import SpeedSettings
from cca_core.path import Lane, Path, Road, interpolate_path
from cca_core.sim.scenarios.eebl import CAR, JERK, LOSSY_CHANNEL
from cca_core.sim.scenarios.road_user import LateralShiftAction, RoadUser
from cca_core.sim.scenarios.scenario import LANE_WIDTH, Scenario
from cca_core.v2x import ChannelSettings

CURBSIDE_CASES = ("fast", "slow")
"""The ego drives 25 m/s or 13.9 m/s."""


def curbside(
    case: str = "fast",
    *,
    ego_type: str = "v2v",
    v_x: float | None = None,
    lane_intrusion: float = 1.6,
    radius: float = 2000.0,
    reaction_time: float = 1.25,
    channel: ChannelSettings = LOSSY_CHANNEL,
    visibility: float = math.inf,
    lead_time_gap: float = 0.9,
    lead_ttc: float = 1.1,
    start: float = 50.0,
) -> Scenario:
    """Follow a lead (yellow) that evades a car parked in a curve (red) late.

    Parameters
    ----------
    case : {"fast", "slow"}
        25 m/s or 13.9 m/s.
    ego_type : {"v2v", "driver", "sensor"}
        Controller of the ego.
    v_x : float, optional
        Another speed [m/s], above 5 and at most 36.
    lane_intrusion : float
        Width of the ego's lane that red blocks [m], at most the lane.
    radius : float
        Radius of the curve [m], at least 200.
    reaction_time : float
        Reaction time of the ego's driver [s].
    channel : ChannelSettings
        Radio channel.
    visibility : float
        Range of sight in this weather [m].
    lead_time_gap : float
        Time gap of the ego to yellow [s].
    lead_ttc : float
        Time to collision of yellow with red when yellow begins to evade [s].
    start : float
        Station of the ego at the start [m].

    Returns
    -------
    scenario : Scenario
        Red sends with its ignition on and its hazard lights lit. The adjacent lane is free.

    Raises
    ------
    InputError
        If the case is unknown or a value is out of range.
    """
    if case not in CURBSIDE_CASES:
        raise InputError(f"case must be one of {', '.join(CURBSIDE_CASES)}, was {case!r}")
    case_speed = 25.0 if case == "fast" else 13.9
    v_x = case_speed if v_x is None else check_real("v_x", v_x, gt=5.0, le=36.0)
    lane_intrusion = check_real("lane_intrusion", lane_intrusion, ge=0.0, le=LANE_WIDTH)
    radius = check_real("radius", radius, ge=200.0)
    lead_time_gap, lead_ttc = check_real("lead_time_gap", lead_time_gap), check_real("lead_ttc", lead_ttc)
    start = check_real("start", start, ge=-1e5, le=1e5)
    t_red = 9.0  # from the start to the parked car at constant speed [s]
    s_red = start + t_red * v_x
    gap = lead_time_gap * v_x
    users = (
        RoadUser(
            id="yellow", s=start + CAR.box_offset + CAR.length + gap, d=0.0, v_x=v_x, jerk=JERK,
            actions=(
                LateralShiftAction(s_start=s_red - CAR.length - lead_ttc * v_x, offset=3.0, duration=2.0),
            ),
        ),
        RoadUser(
            id="red", s=s_red, d=-0.5 * LANE_WIDTH + lane_intrusion - 0.5 * CAR.width, v_x=0.0,
            events=frozenset({"hazard_lights"}),
        ),
    )  # fmt: skip
    lanes = [Lane(d=0.0), Lane(d=LANE_WIDTH)]
    return Scenario(
        name="curbside", case=case, road=Road(_curve(radius, s_red + 12.0 * v_x + 300.0), lanes),
        vehicle=CAR, start=start, v_x=v_x, cruise_speed=v_x, road_users=users,
        # the time gap counts on top of an uncertainty of the messages of 0.3 s
        speed=SpeedSettings(standstill_gap=3.0, time_gap=0.5),
        duration=t_red + 13.0, ego_type=ego_type, reaction_time=reaction_time, channel=channel,
        shared_modem=True, visibility=visibility, hazard_id="red",
        paper_figures=(10, 11, 12),
    )  # fmt: skip


def _curve(radius: float, length: float) -> Path:
    s = np.linspace(0.0, length, math.ceil(length / 20.0) + 1)
    x, y = radius * np.sin(s / radius), radius * (1.0 - np.cos(s / radius))
    return interpolate_path(np.column_stack((x, y)), start_tangent=(1.0, 0.0))
