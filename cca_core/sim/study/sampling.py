"""Each of the paper's scenarios with its speeds, gaps and places drawn."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.path import Path, interpolate_path
from cca_core.sim.scenarios.curbside import curbside
from cca_core.sim.scenarios.eebl import eebl
from cca_core.sim.scenarios.ima import IMA_CASES, ima
from cca_core.sim.scenarios.overtaking import OVERTAKING_CASES, overtaking
from cca_core.sim.scenarios.road_user import BrakeAction, RoadUser
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.v2x import ChannelSettings

__all__ = ["SAMPLERS", "STUDY_SCENARIOS"]

Number = Callable[[str, float, float], float]
"""Draws a number by its name, evenly between two bounds."""

_START = 20.0  # of the ego in the fourth scenario [m]


def _eebl(case: int, number: Number, channel: ChannelSettings, reaction: float) -> Scenario:
    v_x, gap, second = number("v_x", 15.0, 33.0), number("gap", 0.4, 1.2), number("second_gap", 1.7, 2.5)
    made = eebl("BC"[case % 2], v_x=v_x, time_gap=gap, reaction=reaction, channel=channel)
    yellow, red = made.road_users
    brakes = BrakeAction(t=2.0, deceleration=number("braking", 4.0, 7.0))
    red = replace(red, s=red.s + (second - 1.8) * v_x, actions=(brakes,))
    return replace(made, road_users=(yellow, red), speed=replace(made.speed, b_max=7.0))


def _ima(case: int, number: Number, channel: ChannelSettings, reaction: float) -> Scenario:
    name = IMA_CASES[case % 2]
    speeds = (4.5, 7.0) if name == "left-turn" else (8.0, 14.0)
    return ima(
        name, v_x=number("v_x", *speeds), v_red=number("v_red", 10.0, 22.0), reaction=reaction,
        offset=number("offset", -1.0, 1.0), truck=(number("truck", 7.0, 10.0), 2.5), channel=channel,
    )  # fmt: skip


def _curbside(case: int, number: Number, channel: ChannelSettings, reaction: float) -> Scenario:
    return curbside(
        v_x=number("v_x", 10.0, 34.0), lane_intrusion=number("intrudes", 1.2, 2.2), channel=channel,
        radius=number("radius", 1000.0, 5000.0), reaction=reaction,
    )  # fmt: skip


def _maneuver(case: int, number: Number, channel: ChannelSettings, reaction: float) -> Scenario:
    name = OVERTAKING_CASES[case]
    v_x, bend = number("v_x", 18.0, 26.0), number("bend", -1e-3, 1e-3)
    slow = v_x * number("slow", 0.5, 0.75)
    made = overtaking(name, _bend(bend, 40.0 * max(v_x, 25.0) + 200.0), start=_START)
    users: list[RoadUser] = []
    for i, user in enumerate(made.road_users, 1):
        is_other = user.id == "A"
        moved = replace(user, s=user.s + number(f"shift_{i}", -10.0, 60.0 if is_other else 10.0), v_x=slow)
        if is_other:
            moved = replace(moved, v_x=user.v_x * v_x / made.v_x, reaction_time=reaction)
        users.append(moved)
    evasion = replace(made.evasion, awareness_range=channel.range)
    return replace(made, v_x=v_x, cruise_speed=v_x, road_users=tuple(users), evasion=evasion)


def _bend(curvature: float, length: float) -> Path:
    s: Array = np.linspace(0.0, length, math.ceil(length / 20.0) + 1)
    # x + iy, the integral of exp(i kappa s)
    z = s * np.exp(0.5j * curvature * s) * np.sinc(0.5 * curvature * s / np.pi)
    return interpolate_path(np.column_stack((z.real, z.imag)), start_tangent=(1.0, 0.0))


SAMPLERS: dict[str, Callable[[int, Number, ChannelSettings, float], Scenario]] = {
    "eebl": _eebl, "ima": _ima, "curbside": _curbside, "maneuver": _maneuver,
}  # fmt: skip
"""By scenario: from a number of 0 to 3 that chooses the case, a source of numbers, the radio channel and the
others' reaction time [s] to a scenario."""

STUDY_SCENARIOS = tuple(SAMPLERS)
"""Scenarios that a study can vary."""
