"""What a plan says where no swerve could be drawn, and what is kept of one that is under way."""

import re
from dataclasses import replace

import numpy as np
import pytest

from cca_core import Lane, Road
from cca_core.follow import SpeedSettings
from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.planner.maneuver import Maneuver, plan_maneuver
from cca_core.planner.settings import EvasionSettings
from tests.planner.test_planner import CAR, START, car, straight

ROAD = Road(straight(), (Lane(d=0.0), Lane(d=3.5)))
SETTINGS = EvasionSettings(assumed_braking=0.0, assumed_acceleration=0.0, awareness_range=np.inf)


def at(gap: float, d: float, name: str) -> FrenetVehicle:
    return FrenetVehicle.from_remote(car(START + gap, d, 0.0, id=name), START + gap, d, 0.0, 0.0)


def obstruction(blocker: FrenetVehicle, *others: FrenetVehicle) -> str:
    ego = FrenetEgo(vehicle=CAR, s=START, v_x=20.0, v_target=20.0, speed=SpeedSettings())
    return plan_maneuver(ego, ROAD, [blocker], others, "left", SETTINGS, at_once=True).candidate.rejection


def test_empty_interval_reports_vehicle_and_station() -> None:
    said = re.fullmatch(
        r"no space between slow and the left edge (\d+) m ahead", obstruction(at(80.0, 2.0, "slow"))
    )
    assert said
    assert 40.0 <= float(said[1]) <= 80.0  # it is passed with lead


@pytest.mark.parametrize("gap", [4.0, 8.0])
def test_too_close_names_the_vehicle(gap: float) -> None:
    said = obstruction(at(gap, 0.0, "B7"))
    assert "B7" in said
    assert "obstacle" not in said
    assert "node" not in said


def ego(gone: float) -> FrenetEgo:
    return FrenetEgo(vehicle=CAR, s=START + gone, v_x=20.0, v_target=20.0, speed=SpeedSettings())


def bent(gone: float, begun: Maneuver | None = None, left: float = 5.25, **kwargs: float) -> Maneuver:
    road = Road(straight(), (Lane(d=0.0), Lane(d=0.5 * (1.75 + left), width=left - 1.75)))
    slow, settings = at(80.0, 0.0, "slow"), replace(SETTINGS, **kwargs)
    plan = plan_maneuver(ego(gone), road, [slow], [], "left", settings, begun, at_once=begun is None)
    assert isinstance(plan, Maneuver)
    return plan


class TestUnderWay:
    """A swerve past a slow car, bent again for a narrower road, or for more comfort than it has."""

    begun = bent(0.0)

    @pytest.mark.parametrize(("narrower", "said"), [(0.04, ""), (0.06, "the body crosses the left edge")])
    def test_where_the_body_is_at_once_an_edge_may_be_a_little_nearer(
        self, narrower: float, said: str
    ) -> None:
        """At the farthest place, up to 5 cm: no steering brings the body back by then."""
        body = ego(0.0).swept_boxes(straight(), self.begun.stations, self.begun.displacement)
        corner = body.y + 0.5 * (CAR.width * np.cos(body.psi) + CAR.length * np.abs(np.sin(body.psi)))
        again = bent(70.0, self.begun, float(corner.max()) - narrower, clearance=0.7)
        assert again.candidate.rejection.startswith(said)
        assert bool(again.candidate.rejection) is bool(said)

    @pytest.mark.parametrize("gone", [8.0, 14.0])
    def test_what_is_bent_already_may_stay_bent(self, gone: float) -> None:
        soon = START + gone + np.linspace(0.0, 5.0, 20)
        assert 400.0 * np.abs(self.begun.reference.curvature(soon)).max() > 1.2
        assert not bent(gone, self.begun, clearance=0.7, lateral_acceleration_limit=1.2).candidate.rejection

    def test_but_what_is_not_may_not_be_bent_more(self) -> None:
        again = bent(60.0, self.begun, clearance=0.7, lateral_acceleration_limit=1.2)
        assert not again.candidate.rejection
        ahead = START + np.linspace(62.0, 140.0, 200)
        assert 400.0 * np.abs(again.reference.curvature(ahead)).max() < 1.2 * 1.02
