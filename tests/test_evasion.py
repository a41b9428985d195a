"""What a plan says where no swerve could be drawn."""

import re

import numpy as np
import pytest

from cca_core import Lane, Road
from cca_core.evasion import plan_evasion
from cca_core.evasion_settings import EvasionSettings
from cca_core.follow import SpeedSettings
from cca_core.scene import Ego, Neighbour
from tests.test_planner import CAR, START, car, straight

ROAD = Road(straight(), (Lane(d=0.0), Lane(d=3.5)))
SETTINGS = EvasionSettings(braking=0.0, acceleration=0.0, known_range=np.inf)


def at(gap: float, d: float, name: str) -> Neighbour:
    return Neighbour.seen_from(car(START + gap, d, 0.0, id=name), START + gap, d, 0.0, 0.0)


def obstruction(blocker: Neighbour, *others: Neighbour) -> str:
    ego = Ego(vehicle=CAR, s=START, v_x=20.0, v_target=20.0, speed=SpeedSettings())
    return plan_evasion(ego, ROAD, [blocker], others, "left", SETTINGS, at_once=True).candidate.obstruction


def test_no_room_names_the_vehicle_and_the_place() -> None:
    said = re.fullmatch(
        r"no room between slow and the left edge (\d+) m ahead", obstruction(at(80.0, 2.0, "slow"))
    )
    assert said
    assert 40.0 <= float(said[1]) <= 80.0  # it is passed with lead


@pytest.mark.parametrize("gap", [4.0, 8.0])
def test_too_close_names_the_vehicle(gap: float) -> None:
    said = obstruction(at(gap, 0.0, "B7"))
    assert "B7" in said
    assert "obstacle" not in said
    assert "node" not in said
