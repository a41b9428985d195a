"""Soundness: no vehicle that moves within the assumptions hits an ego that could have avoided it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cca_core import Planner, VehicleState
from cca_core.geometry import box_gap, boxes
from cca_core.planner import EvasionSettings
from cca_core.sim import SingleTrackPlant
from tests.support.random_situations import CAR, START, Situation, roads, situation

ROADS = roads()
CYCLE = 0.02  # [s]
DURATION = 12.0  # [s]
# vehicles of the situations also accelerate with up to 3 m/s^2 while they are overtaken
CAUTIOUS = replace(EvasionSettings.cautious(), awareness_range=math.inf, assumed_acceleration_passed=3.0)


def collides(case: Situation, *, brakes: bool) -> bool:
    """Whether the ego collides while it moves: with the planner, or with brakes applied from the start."""
    path = case.road.path
    x, y = path.position(START).tolist()
    state = VehicleState(x=x, y=y, psi=float(path.heading(START)), v_x=case.v_x)
    plant = SingleTrackPlant(CAR, state)
    planner = Planner(CAR, case.road, cruise_speed=case.cruise, evasion=CAUTIOUS)
    t = CYCLE * np.arange(round(DURATION / CYCLE))
    true = []
    for other in case.others:
        s = other.stations(t)
        xy, v = path.to_cartesian(s, np.full(len(s), other.d)), np.abs(np.gradient(s, CYCLE))
        true.append((xy, path.heading(s) + (math.pi if other.v < 0.0 else 0.0), v, np.gradient(v, CYCLE)))
    for k in range(len(t)):
        remotes = [
            replace(
                o.remote, x=float(xy[k, 0]), y=float(xy[k, 1]), psi=float(psi[k]), v_x=float(v[k]),
                a_x=float(np.clip(a[k], -8.0, 3.0)), age=0.0, sigma_along=0.0, sigma_across=0.0,
            )
            for o, (xy, psi, v, a) in zip(case.others, true, strict=True)
        ]  # fmt: skip
        state = plant.state
        command = planner.step(float(t[k]), state, remotes)
        body = boxes(*CAR.center_at(state.x, state.y, state.psi), state.psi, CAR.length, CAR.width)
        for r in remotes:
            if float(box_gap(body, boxes(r.x, r.y, r.psi, r.length, r.width))) <= 0.0:
                return state.v_x > 0.2
        fully = max(-planner.speed.b_max, -planner.speed.jerk_emergency * float(t[k]))
        plant.step(command.delta, fully if brakes else command.a_x, CYCLE)
    return False


def check(block: int, count: int) -> None:
    found = []
    for i in range(count):
        case = situation(np.random.default_rng([block, i]), ROADS[i % len(ROADS)])
        if collides(case, brakes=False) and not collides(case, brakes=True):
            found.append((block, i))
    assert found == []


def test_vehicles_within_assumptions_are_not_hit() -> None:
    check(0, 8)


@pytest.mark.slow
@pytest.mark.parametrize("block", range(1, 5))
def test_vehicles_within_assumptions_are_not_hit_in_many(block: int) -> None:
    check(block, 60)
