"""Deliberation: candidates, certificates and choice of one decision."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core import EvasionSettings, Lane, RemoteVehicle, Road
from cca_core.decide import RssSettings, rss_same_direction
from cca_core.follow import SpeedSettings, squared_speed_limit
from cca_core.frenet import to_frenet
from cca_core.planner.certificate import Grade
from cca_core.planner.deliberation import Deliberation, Setup
from cca_core.planner.records import DrivenPlan, Observation, PathKind, PlannerState
from tests.support.planner_drives import ALL_KNOWN, CAR, car, straight

S = 100.0  # station of the ego [m]
TWO_LANES = (Lane(d=0.0), Lane(d=3.5))
OPPOSING = (Lane(d=0.0), Lane(d=3.5, direction=-1))


def decide(
    remotes: list[RemoteVehicle], *, v: float = 20.0, cruise: float = 20.0, lanes: Any = None,
    settings: EvasionSettings = ALL_KNOWN, mu: float = 0.9, d: float = 0.0,
) -> DrivenPlan:  # fmt: skip
    """First decision of an ego on a straight road."""
    vehicle, speed, road = replace(CAR, mu=mu), SpeedSettings(), Road(straight(2000.0), lanes)
    setup = Setup.make(vehicle, road, settings, speed)
    vehicles, _ = to_frenet(remotes, road.path, {})
    observation = Observation(
        t=0.0, s=S, d=d, angle=0.0, bend=0.0, v=v, vehicles=tuple(vehicles),
        awareness_range=settings.awareness_range,
    )  # fmt: skip
    slowing = replace(speed, b_comfort=setup.limits.b_comfort)
    profile = squared_speed_limit(road.path, cruise, setup.limits.curve, slowing)
    return Deliberation(setup, PlannerState(), observation, profile, cruise).decide()


def test_empty_road_is_cruised() -> None:
    plan = decide([])
    assert plan.path.kind is PathKind.ROUTE
    assert plan.grade is Grade.COMFORTABLE
    assert np.abs(plan.a).max() < 0.01


@pytest.mark.parametrize("v", [8.0, 14.0, 20.0, 30.0])
def test_gap_beyond_rss_distance_is_certified(v: float) -> None:
    """The closed form of the same certificate: reaction, then full braking behind a lead that brakes."""
    rss = RssSettings(response_time=0.4, a_max=0.001, b_min=7.0, b_max=8.0, b_correct=3.0)
    need = float(rss_same_direction(v, v, rear=rss, front=rss))
    build_up = 0.5 * 7.0 / 12.65 * v + 0.15 * v  # brakes' jerk and lag
    far = decide([car(S + CAR.front + 2.25 + need + build_up + 3.0, v_x=v)], v=v, cruise=v)
    assert far.grade <= Grade.FULL
    near = decide([car(S + CAR.front + 2.25 + 0.3 * need + 0.5, v_x=v)], v=v, cruise=v)
    assert near.a[10] < far.a[10] + 1e-9
    assert near.a[:20].min() <= -1.5


def test_slow_car_is_passed_on_free_lane() -> None:
    plan = decide([car(S + 80.0, v_x=10.0)], lanes=TWO_LANES)
    assert plan.path.kind is PathKind.LEFT
    assert plan.path.band is not None
    nodes, reference = plan.path.band.nodes, plan.reference
    _, offset = reference.project(nodes, np.linspace(plan.path.begin, plan.path.end, len(nodes)))
    assert np.abs(offset).max() < 0.01  # the band lies on the reference


@pytest.mark.parametrize(
    "other",
    [
        car(S + 250.0, 3.5, 20.0, id="O", psi=math.pi),
        car(S + 10.0, 3.5, 20.0, id="O", psi=math.pi, age=2.0),
    ],
    ids=["oncoming", "stale"],
)
def test_adjacent_lane_in_use_is_refused(other: RemoteVehicle) -> None:
    plan = decide([car(S + 60.0, v_x=8.0), other], lanes=OPPOSING)
    assert plan.path.kind is PathKind.ROUTE
    assert any("O" in str(r) for r in plan.rejections)


def test_unknown_lane_is_refused() -> None:
    blind = EvasionSettings(awareness_range=0.0)
    plan = decide([car(S + 60.0, v_x=8.0)], lanes=TWO_LANES, settings=blind)
    assert plan.path.kind is PathKind.ROUTE
    assert "on the left: lane not confirmed clear (awareness range 0 m)" in map(str, plan.rejections)


@pytest.mark.parametrize("mu", [0.1, 0.2, 0.5, 1.0])
def test_plan_stays_within_friction(mu: float) -> None:
    plan = decide([car(S + 60.0, v_x=0.0)], mu=mu, lanes=TWO_LANES)
    assert np.abs(plan.a).max() <= mu * 9.81 + 1e-9


def test_vehicle_ahead_of_ego_off_its_route_counts() -> None:
    plan = decide([car(S + 9.0, 2.5, 0.0)], v=6.0, cruise=6.0, d=2.5, lanes=TWO_LANES)
    assert plan.a[:20].min() < -1.0


def test_oncoming_truck_over_line_is_passed_within_lane() -> None:
    truck = car(S + 150.0, 1.8, 12.0, id="T", psi=math.pi, length=12.0, width=2.55)
    plan = decide([truck], v=15.0, cruise=15.0, lanes=OPPOSING)
    half = 0.5 * CAR.width
    assert plan.path.kind is PathKind.RIGHT
    assert plan.path.d.min() - half > -1.75
    assert plan.path.d.min() < -0.3
    assert plan.grade <= Grade.FULL


def test_several_crossing_cars_are_yielded_to() -> None:
    crossing = [
        car(S + 70.0, -y, 12.0, id=f"X{i}", psi=0.5 * math.pi) for i, y in enumerate((30.0, 50.0, 70.0))
    ]
    plan = decide(crossing, v=15.0, cruise=15.0)
    assert plan.grade <= Grade.FULL
    assert plan.yields_to
    passed = plan.s > S + 70.0 - 3.0
    assert passed.any()  # it goes on behind them


def test_safe_stop_ends_at_rest_in_lane() -> None:
    stop = decide([car(S + 60.0, v_x=15.0)], v=15.0, cruise=15.0).safe_stop
    assert stop.t[-1] >= 5.0
    assert stop.v[-1] == 0.0
    assert np.abs(stop.delta).max() < 0.01
    assert stop.a_x.min() < -1.0


def test_costs_of_nearer_leads_grow() -> None:
    costs = [decide([car(S + gap, v_x=20.0)], v=20.0).costs.risk for gap in (10.0, 14.0, 20.0, 60.0)]
    assert costs == sorted(costs, reverse=True)
    assert costs[-1] == 0.0
