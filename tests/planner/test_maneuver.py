"""Maneuvers: rejections of bands, and what is committed of an ongoing maneuver."""

from dataclasses import replace

import numpy as np
import pytest

from cca_core import Lane, Road
from cca_core.decide import Rejection, RejectionKind
from cca_core.frenet import FrenetVehicle
from cca_core.planner.maneuver import Maneuver, plan_maneuver
from tests.support.planner_drives import (
    CAR,
    NO_ASSUMPTIONS,
    START,
    TWO_LANE_ROAD,
    frenet_car,
    frenet_ego,
    straight,
)


def rejection_of(blocking: FrenetVehicle) -> Rejection:
    ego = frenet_ego()
    plan = plan_maneuver(ego, TWO_LANE_ROAD, [blocking], [], "left", NO_ASSUMPTIONS, start_now=True)
    assert isinstance(plan, Maneuver)
    assert plan.candidate.rejection is not None
    return plan.candidate.rejection


def test_empty_interval_reports_vehicle_and_distance() -> None:
    rejection = rejection_of(frenet_car(80.0, 2.0, 0.0, "slow"))
    assert (rejection.kind, rejection.vehicle_id) == (RejectionKind.NO_SPACE, "slow")
    assert 40.0 <= rejection.distance <= 80.0  # the ego is out of its path before it


@pytest.mark.parametrize("gap", [4.0, 8.0])
def test_vehicle_too_close_is_named(gap: float) -> None:
    rejection = rejection_of(frenet_car(gap, 0.0, 0.0, "B7"))
    assert rejection.vehicle_id == "B7"
    assert "B7" in str(rejection)


def plan(traveled: float, current: Maneuver | None = None, left: float = 5.25, **kwargs: float) -> Maneuver:
    road = Road(straight(), (Lane(d=0.0), Lane(d=0.5 * (1.75 + left), width=left - 1.75)))
    slow, settings = frenet_car(80.0, 0.0, 0.0, "slow"), replace(NO_ASSUMPTIONS, **kwargs)
    new = plan_maneuver(
        frenet_ego(traveled), road, [slow], [], "left", settings, current, start_now=current is None
    )
    assert isinstance(new, Maneuver)
    return new


def new_maneuver(gap: float, traveled: float) -> Maneuver:
    """A feasible maneuver around a slow car that is known early."""
    slow = frenet_car(gap, 0.0, 0.0, "slow")
    found = plan_maneuver(frenet_ego(traveled), TWO_LANE_ROAD, [slow], [], "left", NO_ASSUMPTIONS)
    assert isinstance(found, Maneuver)
    assert found.candidate.rejection is None
    return found


def test_window_moves_continuously_with_vehicle() -> None:
    """By as much as the vehicle: nothing is rounded to whole meters, nor to a node."""
    found = [new_maneuver(gap, 0.0) for gap in np.arange(120.0, 122.0, 0.05)]
    assert np.diff([m.start for m in found]) == pytest.approx(0.05, abs=1e-6)
    assert np.diff([m.end for m in found]) == pytest.approx(0.05, abs=1e-6)
    assert np.diff([m.candidate.available_distance for m in found]) == pytest.approx(0.05, abs=1e-6)


def test_start_is_independent_of_decision_time() -> None:
    """Decisions are 0.1 s apart, 2 m at 20 m/s: the maneuver starts where it is due."""
    first = new_maneuver(120.0, 0.0)
    early = first.candidate.available_distance - first.candidate.required_distance
    found = [new_maneuver(120.0, early + traveled) for traveled in np.linspace(0.0, 2.0, 9)]
    assert all(m.candidate.available_distance <= m.candidate.required_distance + 1e-6 for m in found)
    assert [m.start for m in found] == pytest.approx([first.start] * len(found), abs=1e-6)
    assert [m.end for m in found] == pytest.approx([first.end] * len(found), abs=1e-6)
    late = new_maneuver(120.0, early + 2.5)
    assert late.start == pytest.approx(first.start + 0.5, abs=1e-6)


class TestOngoing:
    """A maneuver past a slow car, replanned for a narrower road, or for more comfort than it has."""

    current = plan(0.0)

    @pytest.mark.parametrize(("narrower", "kind"), [(0.04, None), (0.06, RejectionKind.ROAD_EDGE)])
    def test_road_edge_has_tolerance_at_committed_body(
        self, narrower: float, kind: RejectionKind | None
    ) -> None:
        """At the largest offset, up to 5 cm: no steering moves the body back by then."""
        body = frenet_ego().swept_boxes(straight(), self.current.stations, self.current.displacement)
        corner = body.y + 0.5 * (CAR.width * np.cos(body.psi) + CAR.length * np.abs(np.sin(body.psi)))
        rejection = plan(
            70.0, self.current, float(corner.max()) - narrower, clearance=0.7
        ).candidate.rejection
        assert (None if rejection is None else rejection.kind) is kind

    @pytest.mark.parametrize("traveled", [8.0, 13.0])
    def test_committed_curvature_is_accepted(self, traveled: float) -> None:
        committed = START + traveled + np.linspace(0.0, 5.0, 20)
        assert 400.0 * np.abs(self.current.reference.curvature(committed)).max() > 1.2
        new = plan(traveled, self.current, clearance=0.7, lateral_acceleration_limit=1.2)
        assert new.candidate.rejection is None

    def test_curvature_beyond_committed_part_is_limited(self) -> None:
        new = plan(60.0, self.current, clearance=0.7, lateral_acceleration_limit=1.2)
        assert new.candidate.rejection is None
        ahead = START + np.linspace(62.0, 140.0, 200)
        assert 400.0 * np.abs(new.reference.curvature(ahead)).max() < 1.2 * 1.02
