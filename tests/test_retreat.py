"""Giving up a swerve: back behind the vehicle in front, unless somebody comes from behind."""

import numpy as np
import pytest

from cca_core import Lane, Road
from cca_core.evasion import Evasion, plan_evasion
from cca_core.evasion_settings import EvasionSettings
from cca_core.follow import SpeedSettings
from cca_core.retreat import plan_retreat
from cca_core.scene import Ego, Neighbour
from tests.test_planner import CAR, START, car, straight

ROAD = Road(straight(), (Lane(d=0.0), Lane(d=3.5)))
SETTINGS = EvasionSettings(braking=0.0, acceleration=0.0, known_range=np.inf)


def at(gap: float, d: float, v: float, name: str = "R") -> Neighbour:
    return Neighbour.seen_from(car(START + gap, d, v, id=name), START + gap, d, 0.0, 0.0)


@pytest.fixture(scope="module")
def maneuver() -> Evasion:
    """Fully beside a slower vehicle's path, 25 m behind it."""
    ego = Ego(
        vehicle=CAR, s=START - 60.0, v_x=20.0, v_target=20.0, speed=SpeedSettings(),
        history=np.empty((0, 2)),
    )  # fmt: skip
    plan = plan_evasion(ego, ROAD, [at(0.0, 0.0, 12.0)], [], "left", SETTINGS, at_once=True)
    assert isinstance(plan, Evasion)
    assert not plan.candidate.obstruction
    return plan


def retreat(maneuver: Evasion, gap: float, *others: Neighbour) -> Evasion | None:
    ego = Ego(vehicle=CAR, s=START, v_x=20.0, v_target=20.0, speed=SpeedSettings(), history=np.empty((0, 2)))
    return plan_retreat(ego, ROAD, maneuver, [at(gap, 0.0, 12.0), *others], "somebody comes")


def test_falls_back_and_returns(maneuver: Evasion) -> None:
    back = retreat(maneuver, 25.0)
    assert back is not None
    assert back.offset_at(START) > 1.0
    assert back.offset_at(back.end) == pytest.approx(0.0, abs=1e-9)
    assert "somebody comes" in back.band.message


def test_beyond_the_point_of_no_return(maneuver: Evasion) -> None:
    assert retreat(maneuver, -4.0) is None


@pytest.mark.parametrize("d", [0.0, 3.5], ids=["own lane", "lane beside"])
def test_not_into_the_way_of_those_behind(maneuver: Evasion, d: float) -> None:
    assert retreat(maneuver, 15.0, at(-30.0, d, 20.0, "B")) is None
    assert retreat(maneuver, 15.0, at(-80.0, d, 20.0, "B")) is not None
    assert retreat(maneuver, 15.0, at(-30.0, d, -20.0, "B")) is not None


def test_waits_beside_until_the_brakes_suffice(maneuver: Evasion) -> None:
    """8 m/s faster and 3.5 m behind: first slower, and only then back."""
    near, far = retreat(maneuver, 8.0), retreat(maneuver, 25.0)
    assert near is not None
    assert far is not None
    assert near.offset_at(START + 20.0) == pytest.approx(maneuver.offset_at(START + 20.0), abs=0.05)
    assert far.offset_at(START + 20.0) < 0.9 * maneuver.offset_at(START + 20.0)
