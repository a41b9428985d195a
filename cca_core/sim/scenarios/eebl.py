"""The paper's first scenario: electronic emergency brake light (Figs 5-7)."""

import math
from dataclasses import replace

import numpy as np

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.follow import SpeedSettings
from cca_core.path import Lane, Road, interpolate_path
from cca_core.sim.scenarios.road_user import BrakeAction, ReactToLeadAction, RoadUser
from cca_core.sim.scenarios.scenario import FixedTimeGap, Scenario
from cca_core.v2x import ChannelSettings
from cca_core.vehicle import VehicleParams

EEBL_CASES = ("A", "B", "C", "C-gentle", "D", "sensor")
"""Connected: none, ego, ego and yellow, the same (gentle braking), yellow, none (sensor)."""

LOSSY_CHANNEL = ChannelSettings(latency=0.1, loss_probability=0.3, mean_burst_length=6.0)
"""Latency 100 ms and 30 % loss, in bursts of 6 messages."""

CAR = replace(VehicleParams.bmw_320i(), length=4.5, width=1.8)
"""The ego of all scenarios; the road users have the same body."""

JERK = 12.65
"""Build-up rate of all brakes [m/s^3]: 0.774 g in 0.6 s, the careful driver of UN R157."""

_EGO_TYPES = {"A": "driver", "D": "driver", "sensor": "sensor"}  # else v2v
_MAX_DECELERATION = {"B": 5.0, "C": 6.0, "C-gentle": 5.0}  # of the ego [m/s^2]; else 7


def eebl(
    case: str = "C",
    *,
    v_x: float = 29.06,
    time_gap: float = 0.5,
    brakes_at: float = 2.0,
    reaction_time: float = 1.25,
    channel: ChannelSettings = LOSSY_CHANNEL,
    visibility: float = math.inf,
    second_time_gap: float = 1.8,
    standstill_gap: float = 5.0,
    start: float = 50.0,
) -> Scenario:
    """Tailgate a second car (yellow) behind a first one (red) that brakes hard.

    Parameters
    ----------
    case : {"A", "B", "C", "C-gentle", "D", "sensor"}
        Connected vehicles, and deceleration. A: none. B: the ego, which also detects yellow. C: both (the
        paper). D: yellow only. sensor: none, and the planner detects yellow. In A and D a human drives.
    v_x : float
        Speed of all three [m/s], above 5 and at most 36.
    time_gap : float
        Time gap of the ego to yellow, kept until the ego knows of a hazard [s].
    brakes_at : float
        Time at which red begins to brake [s].
    reaction_time : float
        Reaction time of both drivers [s].
    channel : ChannelSettings
        Radio channel.
    visibility : float
        Range of sight in this weather [m].
    second_time_gap : float
        Time gap of yellow to red [s].
    standstill_gap : float
        Gap at which the ego stops behind yellow [m], at most half of the gap at the start.
    start : float
        Station of the ego at the start [m].

    Returns
    -------
    scenario : Scenario
        All brake with at most 7 m/s^2, the ego in C with 6, in B and C-gentle with 5.

    Raises
    ------
    InputError
        If the case is unknown or a value is out of range.
    """
    if case not in EEBL_CASES:
        raise InputError(f"case must be one of {', '.join(EEBL_CASES)}, was {case!r}")
    v_x = check_real("v_x", v_x, gt=5.0, le=36.0)
    time_gap = check_real("time_gap", time_gap, gt=0.0, le=1e3)
    second_time_gap = check_real("second_time_gap", second_time_gap, ge=-1e3, le=1e3)
    start = check_real("start", start, ge=-1e5, le=1e5)
    brakes_at = check_real("brakes_at", brakes_at, ge=-1e3, le=1e3)
    standstill_gap = check_real("standstill_gap", standstill_gap, gt=0.0)
    gap = time_gap * v_x
    yellow = start + CAR.box_offset + gap + CAR.length
    red = yellow + CAR.length + second_time_gap * v_x
    warned = case in ("C", "C-gentle", "D")
    users = (
        RoadUser(
            id="yellow", s=yellow, d=0.0, v_x=v_x, jerk=JERK, connected=warned,
            actions=(
                ReactToLeadAction(
                    lead_id="red", reaction_time=reaction_time,
                    deceleration=5.5 if case == "C-gentle" else 7.0,
                    warning_delay=0.12 if warned else math.inf,  # one cycle and the lag of the brakes
                ),
            ),
        ),
        RoadUser(id="red", s=red, d=0.0, v_x=v_x, jerk=JERK, actions=(BrakeAction(t=brakes_at),)),
    )  # fmt: skip
    s = np.arange(0.0, red + v_x * (brakes_at + 12.0) + 300.0, 20.0)
    road = Road(interpolate_path(np.column_stack((s, np.zeros_like(s)))), [Lane(d=0.0)], speed_limit=36.0)
    standstill_gap = min(standstill_gap, 0.5 * gap)
    return Scenario(
        name="eebl", case=case, road=road, vehicle=CAR, start=start, v_x=v_x, cruise_speed=v_x,
        road_users=users,
        speed=SpeedSettings(
            b_max=_MAX_DECELERATION.get(case, 7.0), standstill_gap=standstill_gap,
            time_gap=(gap - standstill_gap) / v_x,
        ),
        duration=brakes_at + 12.0, ego_type=_EGO_TYPES.get(case, "v2v"), reaction_time=reaction_time,
        channel=channel, shared_modem=True, visibility=visibility, paper_figures=(5, 6, 7),
        fixed_gap=FixedTimeGap(lead_id="yellow", time_gap=time_gap),
    )  # fmt: skip
