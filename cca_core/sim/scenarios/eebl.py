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

__all__ = ["CAR", "EEBL_CASES", "JERK", "LOSSY_CHANNEL", "eebl"]

EEBL_CASES = ("A", "B", "C", "C-gentle", "D", "sensor")
"""Who is connected: nobody, the ego, both, both (braking gently), the second car; nobody, with a sensor."""

LOSSY_CHANNEL = ChannelSettings(latency=0.1, loss_probability=0.3, mean_burst_length=6.0)
"""100 ms late and 30 % lost, in bursts of 6 messages of one modem that sends for all others."""

CAR = replace(VehicleParams.bmw_320i(), length=4.5, width=1.8)
"""The ego of all scenarios; the others have the same body."""

JERK = 12.65
"""How fast everybody's brakes build up [m/s^3]: 0.774 g in 0.6 s, the careful driver of UN R157."""

_EGO = {"A": "driver", "D": "driver", "sensor": "sensor"}
_BRAKES = {"B": 5.0, "C": 6.0, "C-gentle": 5.0}  # hardest braking of the ego [m/s^2]; else 7
_ACTS_AFTER = 0.12  # one cycle and the brakes of the second car, after a message [s]
_LEAST_GAP = 5.0  # of the ego behind a standing car [m]
_SECOND_GAP = 1.8  # of the second car behind the first [s]
_START = 50.0  # [m]


def eebl(
    case: str = "C",
    *,
    v_x: float = 29.06,
    time_gap: float = 0.5,
    brakes_at: float = 2.0,
    reaction: float = 1.25,
    channel: ChannelSettings = LOSSY_CHANNEL,
    visibility: float = math.inf,
) -> Scenario:
    """Three cars on one lane; the first (red) brakes hard, the ego tailgates the second (yellow).

    Parameters
    ----------
    case : {"A", "B", "C", "C-gentle", "D", "sensor"}
        Who is connected and how hard it brakes: A nobody; B the ego, which sees yellow; C both (the paper);
        D yellow only; sensor: nobody, the planner sees yellow. In A and D a driver drives the ego.
    v_x : float
        Speed of all [m/s].
    time_gap : float
        Bumper gap of the ego behind yellow, held until the ego knows of a hazard [s].
    brakes_at : float
        When red begins to brake [s].
    reaction : float
        Reaction time of both drivers [s].
    channel : ChannelSettings
        The radio channel.
    visibility : float
        Distance up to which anything is seen in this weather [m].

    Returns
    -------
    scenario : Scenario
        Everybody brakes with 7 m/s^2 at most; the ego in C with 6, in B and C-gentle with 5.

    Raises
    ------
    InputError
        If the case is unknown or a value is out of range.
    """
    if case not in EEBL_CASES:
        raise InputError(f"case must be one of {', '.join(EEBL_CASES)}, was {case!r}")
    v_x = check_real("v_x", v_x, gt=5.0, le=36.0)
    time_gap = check_real("time_gap", time_gap, gt=0.0)
    gap = time_gap * v_x
    yellow = _START + CAR.box_offset + gap + CAR.length
    red = yellow + CAR.length + _SECOND_GAP * v_x
    warned = case in ("C", "C-gentle", "D")
    users = (
        RoadUser(
            id="yellow", s=yellow, d=0.0, v_x=v_x, jerk=JERK, connected=warned,
            actions=(
                ReactToLeadAction(
                    lead_id="red", reaction_time=reaction, deceleration=5.5 if case == "C-gentle" else 7.0,
                    warning_delay=_ACTS_AFTER if warned else math.inf,
                ),
            ),
        ),
        RoadUser(id="red", s=red, d=0.0, v_x=v_x, jerk=JERK, actions=(BrakeAction(t=brakes_at),)),
    )  # fmt: skip
    s = np.arange(0.0, red + v_x * (brakes_at + 12.0) + 300.0, 20.0)
    road = Road(interpolate_path(np.column_stack((s, np.zeros_like(s)))), [Lane(d=0.0)], speed_limit=36.0)
    least = min(_LEAST_GAP, 0.5 * gap)
    return Scenario(
        name="eebl", case=case, road=road, vehicle=CAR, start=_START, v_x=v_x, cruise_speed=v_x, road_users=users,
        speed=SpeedSettings(
            b_max=_BRAKES.get(case, 7.0), standstill_gap=least, time_gap=(gap - least) / v_x,
        ),
        duration=brakes_at + 12.0, ego_type=_EGO.get(case, "v2v"), reaction_time=reaction, channel=channel,
        shared_modem=True, visibility=visibility, paper_figures=(5, 6, 7),
        fixed_gap=FixedTimeGap(lead_id="yellow", time_gap=time_gap),
    )  # fmt: skip
