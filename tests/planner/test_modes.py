"""Modes: single transitions of the label, and what a plan means."""

from dataclasses import replace

import numpy as np
import pytest

from cca_core.planner.modes import ACTIONS, advance, wished_mode
from cca_core.planner.records import DrivenPlan, Mode, PathKind, PlannerState
from cca_core.planner.tuning import DecisionSettings
from tests.support.driven_plan import ROUTE, plan

SETTINGS = DecisionSettings()
EVASIVE = replace(ROUTE, kind=PathKind.LEFT, begin=30.0, end=90.0)
GOES_ON = replace(EVASIVE, d=np.full(len(ROUTE.d), 3.2))  # from an earlier maneuver
BEGUN = PlannerState(s=0.0)


@pytest.mark.parametrize(
    ("driven", "mode", "s", "expected"),
    [
        (plan(), Mode.KEEP, 0.0, Mode.KEEP),
        (plan(a=-1.0), Mode.KEEP, 0.0, Mode.FOLLOW),
        (plan(a=-1.0, free_a=-1.0), Mode.KEEP, 0.0, Mode.KEEP),  # a curve slows it, no vehicle
        (plan(a=-5.0), Mode.FOLLOW, 0.0, Mode.BRAKE),
        (plan(a=-3.5), Mode.FOLLOW, 0.0, Mode.FOLLOW),
        (plan(a=-3.5), Mode.BRAKE, 0.0, Mode.BRAKE),  # released below 70 % only
        (plan(EVASIVE), Mode.KEEP, 29.0, Mode.KEEP),
        (plan(EVASIVE), Mode.FOLLOW, 9.0, Mode.FOLLOW),
        (plan(EVASIVE), Mode.FOLLOW, 11.0, Mode.EVADE_LEFT),  # within a second
        (plan(EVASIVE), Mode.KEEP, 30.0, Mode.EVADE_LEFT),
        (plan(replace(EVASIVE, kind=PathKind.RIGHT)), Mode.KEEP, 31.0, Mode.EVADE_RIGHT),
        (plan(replace(EVASIVE, kind=PathKind.RETURN)), Mode.EVADE_LEFT, 31.0, Mode.RETURN),
        (plan(EVASIVE), Mode.EVADE_LEFT, 90.0, Mode.KEEP),
        (plan(GOES_ON), Mode.KEEP, 20.0, Mode.EVADE_LEFT),
    ],
)
def test_wished_mode_follows_from_plan(driven: DrivenPlan, mode: Mode, s: float, expected: Mode) -> None:
    assert wished_mode(driven, mode, s, float(driven.a[0]), SETTINGS) is expected


def test_calm_mode_changes_after_dwell_time() -> None:
    state = advance(BEGUN, 0.0, Mode.FOLLOW)
    assert state.mode is Mode.KEEP
    assert advance(state, 0.1, Mode.FOLLOW).mode is Mode.KEEP
    assert advance(state, 0.2, Mode.FOLLOW).mode is Mode.FOLLOW


def test_interrupted_wish_starts_anew() -> None:
    state = advance(advance(BEGUN, 0.0, Mode.FOLLOW), 0.1, Mode.KEEP)
    assert advance(state, 0.2, Mode.FOLLOW).mode is Mode.KEEP


@pytest.mark.parametrize("wish", [Mode.EVADE_LEFT, Mode.RETURN, Mode.SAFE_STOP, Mode.BRAKE])
def test_urgent_mode_changes_at_once(wish: Mode) -> None:
    assert advance(BEGUN, 0.0, wish).mode is wish


def test_first_cycle_shows_its_wish() -> None:
    assert advance(PlannerState(), 0.0, Mode.FOLLOW).mode is Mode.FOLLOW


def test_every_mode_has_an_action() -> None:
    assert set(ACTIONS) == set(Mode)
