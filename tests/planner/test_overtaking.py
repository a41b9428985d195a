"""Overtaking against oncoming traffic in closed loop: the ego passes, waits or aborts without collision."""

import os
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import Action, Lane, Planner, RemoteVehicle, Road, VehicleState
from cca_core.planner.settings import EvasionSettings
from tests.support.planner_drives import (
    ALL_KNOWN,
    CAR,
    START,
    ClosedLoop,
    ScriptedVehicle,
    car,
    ego_state,
    straight,
)

FULL = os.environ.get("CCA_HYPOTHESIS_PROFILE") == "full"
ROAD = Road(straight(2000.0), (Lane(d=0.0), Lane(d=3.5, direction=-1)))
SLOW = 8.0  # of the car that is passed, 12 m/s slower than the ego [m/s]
SPEEDS = (10.0, 15.0, 20.0, 25.0, 30.0)
GAPS = range(50, 601) if FULL else range(60, 601, 120)


class Pass:
    """The ego at 20 m/s, 60 m behind a slow car, and an oncoming one; until it is ahead or time is over."""

    def __init__(
        self, gap: float, v: float, *, oncoming: float = 0.0, passed: float = 0.0, ahead: float = 60.0,
        seconds: float = 40.0,
    ) -> None:  # fmt: skip
        self.planner = Planner(CAR, ROAD, cruise_speed=20.0, evasion=ALL_KNOWN)
        self.began = False
        self.gap_at_start = 0.0  # between the others when the pass begins [m]
        self.slow = ScriptedVehicle("R", ahead, 0.0, SLOW, a=lambda t: passed * self.has_begun())
        self.other = ScriptedVehicle("O", gap, 3.5, v, psi=np.pi, a=lambda t: oncoming * self.has_begun())
        self.run = ClosedLoop(self.planner, [self.slow, self.other], seconds, done=self.is_expired)
        self.ahead = self.run.x[-1] > self.slow.x + 4.5
        self.inside = abs(self.run.y[-1]) + 0.5 * CAR.width < 1.75

    def has_begun(self) -> bool:
        if not self.began and self.planner.maneuver is not None:
            self.began, self.gap_at_start = True, self.other.x - self.slow.x
        return self.began

    def is_expired(self, ego: VehicleState) -> bool:
        out = self.planner.maneuver is not None
        return not out and abs(ego.y) < 0.2 and (ego.x > self.slow.x + 12.0 or self.slow.v > 22.0)


class Passed(NamedTuple):
    """How a pass at constant speeds ended."""

    waited: bool
    collided_with: str | None
    ahead: bool
    inside: bool
    gaps: dict[str, float]


@cache
def passed(gap: float, v: float) -> Passed:
    attempt = Pass(gap, v)
    run = attempt.run
    return Passed("FOLLOW" in run.actions, run.collided_with, attempt.ahead, attempt.inside, run.gaps)


@pytest.mark.parametrize("v", SPEEDS)
@pytest.mark.parametrize("gap", GAPS)
def test_slow_car_is_passed_before_or_after_oncoming_car(gap: float, v: float) -> None:
    """Before or after the oncoming car; 40 s are enough for both."""
    found = passed(gap, v)
    assert found.collided_with is None
    assert found.ahead
    assert found.inside
    assert found.gaps["R"] > 0.5
    assert found.gaps["O"] > 0.5


def test_immediate_and_delayed_passes_both_occur() -> None:
    waited = [passed(gap, v).waited for gap in GAPS for v in SPEEDS]
    assert 0.2 <= np.mean(waited) <= 0.8


@pytest.mark.parametrize(
    ("gap", "v"),
    [(gap, v) for gap in GAPS for v in SPEEDS]
    if FULL
    else [(320.0, 10.0), (470.0, 10.0), (396.0, 30.0), (402.0, 30.0), (450.0, 30.0), (470.0, 30.0)],
)
def test_accelerating_oncoming_car_is_not_hit(gap: float, v: float) -> None:
    """A car closer than 235 m and 7 s may have gone by before the maneuver starts."""
    attempt = Pass(gap, v, oncoming=3.0)
    assert attempt.gap_at_start > 0.0 or gap < 235.0 + 7.0 * v
    assert attempt.run.collided_with is None
    assert attempt.inside
    assert attempt.run.gaps["O"] > 0.5


@pytest.mark.parametrize("a_x", np.arange(0.5, 3.1, 0.1).tolist() if FULL else (0.5, 1.0, 1.1, 1.5, 2.0))
@pytest.mark.parametrize(("gap", "v"), [(320.0, 10.0), (470.0, 30.0)])
def test_accelerating_overtaken_car_is_not_hit(gap: float, v: float, a_x: float) -> None:
    attempt = Pass(gap, v, passed=a_x, seconds=20.0)
    assert attempt.began
    assert attempt.run.collided_with is None
    assert attempt.inside
    assert attempt.ahead or attempt.run.commands[-1].decision.action is not Action.EVADE_LEFT
    assert attempt.run.gaps["R"] > 0.5
    assert attempt.run.gaps["O"] > 0.5


def gap_is_accepted(
    other: RemoteVehicle, *, braking: float = 8.0, acceleration: float = 3.0, sign: float = 1.0
) -> bool:
    """Whether the first decision behind a slow car accepts the gap in the adjacent lane."""
    lanes = (Lane(d=0.0), Lane(d=3.5 * sign, direction=-1 if other.psi > 1.0 else 1))
    caution = EvasionSettings(
        awareness_range=np.inf, assumed_braking=braking, assumed_acceleration=acceleration
    )
    planner = Planner(CAR, Road(ROAD.path, lanes), cruise_speed=20.0, evasion=caution)
    there = replace(other, x=START + other.x, y=sign * other.y, psi=sign * other.psi)
    decision = planner.step(0.0, ego_state(), [car(START + 60.0, 0.0, SLOW), there]).decision
    wrong = Action.EVADE_RIGHT if sign > 0.0 else Action.EVADE_LEFT
    assert decision.action is not wrong
    return decision.action not in (Action.FOLLOW, Action.BRAKE)


in_adjacent_lane = st.builds(
    lambda x, v, back, age, along, across: RemoteVehicle(
        id="O", x=x + (220.0 if back else 0.0), y=3.5, psi=np.pi if back else 0.0, v_x=v, age=age,
        sigma_along=along, sigma_across=across,
    ),
    st.floats(-150.0, 150.0), st.floats(5.0, 35.0), st.booleans(), st.floats(0.0, 0.9), st.floats(0.0, 2.0),
    st.floats(0.0, 0.2),
)  # fmt: skip


class TestGapAcceptance:
    """More uncertainty or larger assumptions never accept a rejected gap."""

    @given(in_adjacent_lane, st.floats(0.0, 1.0), st.floats(0.0, 5.0), st.floats(0.0, 0.2))
    def test_more_uncertainty_never_accepts_more(
        self, other: RemoteVehicle, older: float, along: float, across: float
    ) -> None:
        worse = replace(
            other, age=other.age + older, sigma_along=other.sigma_along + along,
            sigma_across=other.sigma_across + across,
        )  # fmt: skip
        assert gap_is_accepted(other) or not gap_is_accepted(worse)

    @given(
        in_adjacent_lane, st.floats(0.1, 8.0), st.floats(0.1, 3.0), st.floats(0.0, 4.0), st.floats(0.0, 3.0)
    )
    def test_larger_assumptions_never_accept_more(
        self, other: RemoteVehicle, braking: float, acceleration: float, more_b: float, more_a: float
    ) -> None:
        less = gap_is_accepted(other, braking=braking, acceleration=acceleration)
        more = gap_is_accepted(other, braking=braking + more_b, acceleration=acceleration + more_a)
        assert less or not more

    @given(in_adjacent_lane, st.floats(1.001, 10.0))
    def test_stale_vehicle_is_rejected(self, other: RemoteVehicle, age: float) -> None:
        assert not gap_is_accepted(replace(other, age=age))

    @given(in_adjacent_lane)
    def test_gap_acceptance_is_mirror_symmetric(self, other: RemoteVehicle) -> None:
        assert gap_is_accepted(other) == gap_is_accepted(other, sign=-1.0)

    def test_accepted_and_rejected_gaps_both_occur(self) -> None:
        far = RemoteVehicle(id="O", x=600.0, y=3.5, psi=np.pi, v_x=20.0)
        assert gap_is_accepted(far)
        assert gap_is_accepted(replace(far, x=-150.0, psi=0.0, v_x=10.0))
        assert not gap_is_accepted(replace(far, x=200.0))
