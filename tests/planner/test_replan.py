"""Going on with a swerve: each rung of the ladder."""

import pytest

from cca_core import Status
from cca_core.follow import SpeedSettings
from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.planner.maneuver import Maneuver
from cca_core.planner.replan import ReplanResult, maneuver_levels, plan_candidates, replan
from tests.planner.test_abort import ROAD, SETTINGS, at, maneuver
from tests.planner.test_planner import CAR, START, car

__all__ = ["maneuver"]  # the fixture

SWERVES = maneuver_levels(SETTINGS, CAR)
SLOW = at(25.0, 0.0, 12.0)


def renewed(
    old: Maneuver,
    *others: FrenetVehicle,
    s: float = START,
    inside: bool = False,
    following_feasible: bool = False,
) -> ReplanResult:
    speed = SpeedSettings()
    ego = FrenetEgo(vehicle=CAR, s=s, v_x=20.0, v_target=20.0, speed=speed)
    return replan(
        ego, ROAD, old, [SLOW], others, SWERVES, within_lane=inside, following_feasible=following_feasible
    )


def test_replan_at_comfort_level(maneuver: Maneuver) -> None:
    now = renewed(maneuver)
    assert now.status is Status.OK
    assert now.maneuver is not None
    assert now.maneuver.band.clearance > 0.99


def test_replan_at_last_level_between_two_vehicles(maneuver: Maneuver) -> None:
    """Less than 2 x 1 m is left between the slow car and one beside it."""
    now = renewed(maneuver, at(25.0, 4.6, 12.0, "L"))
    assert now.status is Status.DEGRADED
    assert now.maneuver is not None
    assert 0.29 < now.maneuver.band.clearance < 1.0
    assert not now.reason


def test_cancel_within_lane_if_following_is_feasible(maneuver: Maneuver) -> None:
    now = renewed(maneuver, at(30.0, 3.5, 12.0, "L"), inside=True, following_feasible=True)
    assert now.maneuver is None
    assert "given up" in now.reason


def test_keep_maneuver_while_clear(maneuver: Maneuver, monkeypatch: pytest.MonkeyPatch) -> None:
    from cca_core.decide import Candidate
    from cca_core.planner import replan as swerve

    def fails(*args: object, **kwargs: object) -> Candidate:
        return Candidate(side="left", rejection="contact set did not settle")

    monkeypatch.setattr(swerve, "plan_maneuver", fails)
    now = renewed(maneuver)
    assert now.maneuver is maneuver
    assert now.status is Status.DEGRADED
    assert not now.reason
    blocked = renewed(maneuver, at(30.0, 3.5, 12.0, "L"))
    assert blocked.maneuver is not None
    assert blocked.maneuver is not maneuver
    assert "returning: contact set" in blocked.reason


def test_first_feasible_level_is_used() -> None:
    """35 m behind a standing car at 25 m/s: comfort comes too late, more grip does not."""
    speed = SpeedSettings()
    ego = FrenetEgo(vehicle=CAR, s=START, v_x=25.0, v_target=25.0, speed=speed)
    standing = [at(40.0, 0.0, 0.0)]
    plans, candidates, status = plan_candidates(ego, ROAD, standing, [], SWERVES[:1], start_now=False)
    assert all(c.rejection for c in candidates)
    plans, candidates, status = plan_candidates(ego, ROAD, standing, [], SWERVES, start_now=False)
    assert status is Status.DEGRADED
    assert not candidates[0].rejection
    assert plans["left"].band.status is Status.OK
    assert candidates[1].rejection


def test_last_resort_uses_nominal_positions() -> None:
    """His bounds leave no room on the road, and to hit him is certain otherwise."""
    ego = FrenetEgo(vehicle=CAR, s=START, v_x=20.0, v_target=20.0, speed=SpeedSettings())
    remote = car(START + 50.0, 0.5, 0.0, id="R", sigma_along=0.5, sigma_across=1.0)
    vague = FrenetVehicle.from_remote(remote, START + 50.0, 0.5, 0.0, 0.0)
    plans, candidates, _ = plan_candidates(ego, ROAD, [vague], [], SWERVES, start_now=True)
    assert all(c.rejection for c in candidates)
    plans, candidates, status = plan_candidates(
        ego, ROAD, [vague], [], SWERVES, start_now=True, braking_insufficient=True
    )
    assert not all(c.rejection for c in candidates)
    assert status is Status.DEGRADED
    assert plans["left"].band.clearance > 0.29
