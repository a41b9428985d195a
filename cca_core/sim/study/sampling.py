"""The paper's scenarios with sampled speeds, gaps and positions."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

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

Uniform = Callable[[str, float, float], float]
"""Samples the parameter of a name uniformly between two bounds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """What the scenario of one run of a study is made from.

    Parameters
    ----------
    uniform : callable
        ``uniform(name, low, high)`` samples a further parameter uniformly between two bounds. Each has a
        column of its name in the table.
    case : int
        A number from 0 to 3, each with the same probability, to choose a case by.
    channel : ChannelSettings
        The sampled radio channel.
    reaction_time : float
        The sampled reaction time of the other drivers [s].
    """

    uniform: Uniform
    case: int
    channel: ChannelSettings
    reaction_time: float


ScenarioMaker = Callable[[Sample], Scenario]
"""Makes the scenario of one run from what is sampled."""


def _eebl(sample: Sample) -> Scenario:
    uniform, channel, reaction_time = sample.uniform, sample.channel, sample.reaction_time
    v_x, gap, second = uniform("v_x", 15.0, 33.0), uniform("gap", 0.4, 1.2), uniform("second_gap", 1.7, 2.5)
    made = eebl(
        "BC"[sample.case % 2], v_x=v_x, time_gap=gap, reaction_time=reaction_time, channel=channel
    )  # fmt: skip
    yellow, red = made.road_users
    braking = BrakeAction(t=2.0, deceleration=uniform("braking", 4.0, 7.0))
    red = replace(red, s=red.s + (second - 1.8) * v_x, actions=(braking,))
    return replace(made, road_users=(yellow, red), speed=replace(made.speed, b_max=7.0))


def _ima(sample: Sample) -> Scenario:
    uniform, channel, reaction_time = sample.uniform, sample.channel, sample.reaction_time
    name = IMA_CASES[sample.case % 2]
    speeds = (4.5, 7.0) if name == "left-turn" else (8.0, 14.0)
    return ima(
        name, v_x=uniform("v_x", *speeds), v_red=uniform("v_red", 10.0, 22.0), reaction_time=reaction_time,
        offset=uniform("offset", -1.0, 1.0), truck=(uniform("truck_length", 7.0, 10.0), 2.5), channel=channel,
    )  # fmt: skip


def _curbside(sample: Sample) -> Scenario:
    uniform, channel, reaction_time = sample.uniform, sample.channel, sample.reaction_time
    return curbside(
        v_x=uniform("v_x", 10.0, 34.0), lane_intrusion=uniform("lane_intrusion", 1.2, 2.2), channel=channel,
        radius=uniform("radius", 1000.0, 5000.0), reaction_time=reaction_time,
    )  # fmt: skip


def _overtaking(sample: Sample) -> Scenario:
    uniform, channel, reaction_time = sample.uniform, sample.channel, sample.reaction_time
    v_x, curvature = uniform("v_x", 18.0, 26.0), uniform("curvature", -1e-3, 1e-3)
    v_slow = v_x * uniform("slow_fraction", 0.5, 0.75)
    path = _circular_path(curvature, 40.0 * max(v_x, 25.0) + 200.0)
    made = overtaking(OVERTAKING_CASES[sample.case], path, start=20.0)
    users: list[RoadUser] = []
    for i, user in enumerate(made.road_users, 1):
        is_fast = user.id == "A"
        moved = replace(user, s=user.s + uniform(f"shift_{i}", -10.0, 60.0 if is_fast else 10.0), v_x=v_slow)
        if is_fast:
            moved = replace(moved, v_x=user.v_x * v_x / made.v_x, reaction_time=reaction_time)
        users.append(moved)
    evasion = replace(made.evasion, awareness_range=channel.range)
    return replace(made, v_x=v_x, cruise_speed=v_x, road_users=tuple(users), evasion=evasion)


def _circular_path(curvature: float, length: float) -> Path:
    s: Array = np.linspace(0.0, length, math.ceil(length / 20.0) + 1)
    # x + iy, the integral of exp(i kappa s)
    z = s * np.exp(0.5j * curvature * s) * np.sinc(0.5 * curvature * s / np.pi)
    return interpolate_path(np.column_stack((z.real, z.imag)), start_tangent=(1.0, 0.0))


SAMPLERS: dict[str, ScenarioMaker] = {
    "eebl": _eebl, "ima": _ima, "curbside": _curbside, "maneuver": _overtaking,
}  # fmt: skip
"""Sampler by scenario."""

STUDY_SCENARIOS = tuple(SAMPLERS)
"""Scenarios of studies."""
