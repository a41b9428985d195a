"""Replanning of an ongoing maneuver: each level, cancel, continue, abort."""

import pytest

from cca_core import Status
from cca_core.decide import Candidate, Rejection, RejectionKind
from cca_core.frenet import FrenetVehicle
from cca_core.planner import replan as replan_module
from cca_core.planner.candidates import maneuver_levels, plan_candidates
from cca_core.planner.maneuver import Maneuver
from cca_core.planner.replan import Outcome, ReplanResult, replan
from tests.support.planner_drives import CAR, NO_ASSUMPTIONS, TWO_LANE_ROAD, frenet_car, frenet_ego

LEVELS = maneuver_levels(NO_ASSUMPTIONS, CAR)
SLOW = frenet_car(25.0, 0.0, 12.0)
ALONGSIDE = frenet_car(30.0, 3.5, 12.0, "L")


def replanned(
    maneuver: Maneuver, *others: FrenetVehicle, within_lane: bool = False, following_feasible: bool = False
) -> ReplanResult:
    return replan(
        frenet_ego(), TWO_LANE_ROAD, maneuver, [SLOW], others, LEVELS, within_lane=within_lane,
        following_feasible=following_feasible,
    )  # fmt: skip


def test_replan_at_comfort_level(maneuver: Maneuver) -> None:
    result = replanned(maneuver)
    assert result.status is Status.OK
    assert result.maneuver is not None
    assert result.maneuver.band.clearance > 0.99


def test_replan_at_last_level_between_two_vehicles(maneuver: Maneuver) -> None:
    """Less than 2 x 1 m is left between the slow car and the one alongside."""
    result = replanned(maneuver, frenet_car(25.0, 4.6, 12.0, "L"))
    assert result.status is Status.DEGRADED
    assert result.maneuver is not None
    assert 0.29 < result.maneuver.band.clearance < 1.0
    assert result.outcome is Outcome.CONTINUED


def test_cancel_within_lane_if_following_is_feasible(maneuver: Maneuver) -> None:
    result = replanned(maneuver, ALONGSIDE, within_lane=True, following_feasible=True)
    assert result.maneuver is None
    assert result.outcome is Outcome.CANCELED
    assert result.rejection is not None
    assert result.rejection.vehicle_id == "L"


def test_keep_maneuver_while_clear(maneuver: Maneuver, monkeypatch: pytest.MonkeyPatch) -> None:
    rejection = Rejection(kind=RejectionKind.NOT_CONVERGED, side="left")

    def reject(*args: object, **kwargs: object) -> Candidate:
        return Candidate(side="left", rejection=rejection)

    monkeypatch.setattr(replan_module, "plan_maneuver", reject)
    result = replanned(maneuver)
    assert result.maneuver is maneuver
    assert result.status is Status.DEGRADED
    assert result.outcome is Outcome.CONTINUED
    blocked = replanned(maneuver, ALONGSIDE)
    assert blocked.maneuver is not None
    assert blocked.maneuver is not maneuver
    assert (blocked.outcome, blocked.rejection) == (Outcome.ABORTED, rejection)


def test_first_feasible_level_is_used() -> None:
    """35 m behind a stationary car at 25 m/s: comfort is too late, more grip is not."""
    ego, stationary = frenet_ego(0.0, 25.0), [frenet_car(40.0, 0.0, 0.0)]
    _, candidates, _ = plan_candidates(ego, TWO_LANE_ROAD, stationary, [], LEVELS[:1], start_now=False)
    assert all(c.rejection for c in candidates)
    plans, candidates, status = plan_candidates(ego, TWO_LANE_ROAD, stationary, [], LEVELS, start_now=False)
    assert status is Status.DEGRADED
    assert candidates[0].rejection is None
    assert plans["left"].band.status is Status.OK
    assert candidates[1].rejection is not None


def test_last_resort_uses_nominal_positions() -> None:
    """The uncertainty bound leaves no space on the road, and a collision is certain otherwise."""
    ego, uncertain = frenet_ego(), frenet_car(50.0, 0.5, 0.0, sigma_along=0.5, sigma_across=1.0)
    _, candidates, _ = plan_candidates(ego, TWO_LANE_ROAD, [uncertain], [], LEVELS, start_now=True)
    assert all(c.rejection for c in candidates)
    plans, candidates, status = plan_candidates(
        ego, TWO_LANE_ROAD, [uncertain], [], LEVELS, start_now=True, braking_insufficient=True
    )
    assert not all(c.rejection for c in candidates)
    assert status is Status.DEGRADED
    assert plans["left"].band.clearance > 0.29
