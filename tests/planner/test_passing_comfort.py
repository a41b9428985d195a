"""A slow lead is passed from the gap at which it is followed, in comfort; if not, the reason says why."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from cca_core import RemoteVehicle
from cca_core.planner.candidates import Rollout
from cca_core.planner.records import Level
from cca_core.planner.scene import N_ROWS
from tests.support.planner_drives import ClosedLoop, ScriptedVehicle, make_planner
from tests.support.sweeps import sweep

LENGTH = 4.5  # of the lead [m]


def follow(v: float, gain: float, *, added_age: float, sigma: float, seconds: float = 25.0) -> ClosedLoop:
    """Drive from the gap at which the ego follows, behind inexact and old records of the lead."""

    def receive(t: float, remotes: list[RemoteVehicle]) -> list[RemoteVehicle]:
        return [
            replace(r, age=r.age + added_age, sigma_along=sigma, sigma_across=0.4 * sigma) for r in remotes
        ]

    lead = ScriptedVehicle("R", 4.0 + 1.5 * v + LENGTH, 0.0, v)
    return ClosedLoop(make_planner(cruise=v + gain), [lead], seconds, v=v, receive=receive)


@pytest.mark.parametrize(
    ("v", "gain", "added_age", "sigma"),
    sweep(
        (12.0, 5.0, 0.05, 0.5), (8.0, 5.0, 0.0, 0.5), (8.0, 8.0, 0.35, 0.5), (12.0, 5.0, 0.3, 0.0),
        (17.0, 5.0, 0.35, 0.5), (17.0, 3.0, 0.1, 1.0), (25.0, 5.0, 0.35, 0.5), (12.0, 8.0, 0.1, 1.0),
        quick=3,
    ),
)  # fmt: skip
def test_followed_car_is_passed(v: float, gain: float, added_age: float, sigma: float) -> None:
    run = follow(v, gain, added_age=added_age, sigma=sigma)
    assert run.collided_with is None
    assert run.x[-1] > run.traffic[0].x + LENGTH
    assert max(map(abs, run.a_y)) < 3.6
    assert min(run.a_x) > -1.0


def test_ego_speeds_up_once_it_is_alongside() -> None:
    """At the speed of the lead the way out is gentle; at a higher one it would be sharp."""
    run = follow(12.0, 5.0, added_age=0.05, sigma=0.5)
    out = next(i for i, y in enumerate(run.y) if y > 1.8)
    assert run.v[out] < 14.0
    assert max(map(abs, run.a_y[:out])) < 2.6


@pytest.mark.parametrize(("v", "gain"), [(12.0, 5.0), (8.0, 3.0)])
def test_pass_that_is_not_worth_it_is_named(v: float, gain: float) -> None:
    """It would be sharp, behind an old record."""
    run = follow(v, gain, added_age=0.45, sigma=0.5, seconds=5.0)
    reason = run.commands[-1].decision.reason
    assert reason.startswith("following R")
    assert "not passing on the left: not worth it (costs " in reason


def test_full_scene_has_no_calm_motion() -> None:
    """There is no row for it; one beyond the last is not memory of the scene."""
    around: Any = SimpleNamespace(creeps=False)
    path: Any = SimpleNamespace(level=Level.COMFORT)
    scene: Any = SimpleNamespace(arrays={})
    rollout = Rollout(scene, around)
    rollout.n_rows = N_ROWS - 1
    assert rollout.calm_motion(path) is None
