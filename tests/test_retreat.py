"""Giving up a swerve: back behind the vehicle in front, unless somebody comes from behind."""

import numpy as np
import pytest

from cca_core import Lane, Road
from cca_core.evasion import Evasion, plan_evasion
from cca_core.evasion_settings import EvasionSettings
from cca_core.follow import SpeedSettings
from cca_core.path import Path, interpolate_path
from cca_core.retreat import plan_retreat, put_off, slow_enough
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
        vehicle=CAR, s=START - 60.0, v_x=20.0, v_target=20.0, speed=SpeedSettings()
    )  # fmt: skip
    plan = plan_evasion(ego, ROAD, [at(0.0, 0.0, 12.0)], [], "left", SETTINGS, at_once=True)
    assert isinstance(plan, Evasion)
    assert not plan.candidate.obstruction
    return plan


def retreat(maneuver: Evasion, gap: float, *others: Neighbour) -> Evasion | None:
    ego = Ego(vehicle=CAR, s=START, v_x=20.0, v_target=20.0, speed=SpeedSettings())
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


def test_given_up_on_the_way_back_it_stays_beside(maneuver: Evasion) -> None:
    """The swerve returns in front of the vehicle; the way back returns behind it, and not before."""
    u = maneuver.band.displacement
    peak = int(u.argmax())
    s = np.linspace(maneuver.start, maneuver.end, len(u))[peak + int(np.argmax(u[peak:] < 0.8 * u.max()))]
    ego = Ego(vehicle=CAR, s=float(s), v_x=20.0, v_target=20.0, speed=SpeedSettings())
    back = plan_retreat(ego, ROAD, maneuver, [at(float(s) - START + 2.0, 0.0, 12.0)], "somebody comes")
    assert back is not None
    assert maneuver.offset_at(s + 20.0) < 0.5 * maneuver.offset_at(s)
    assert back.offset_at(s + 20.0) > 0.85 * maneuver.offset_at(s)
    assert back.offset_at(back.end) == pytest.approx(0.0, abs=1e-9)


def test_who_has_not_fallen_back_as_counted_on_returns_later(maneuver: Evasion) -> None:
    """A second later the brakes have hardly acted, and the other is still beside; or nobody is."""
    back = retreat(maneuver, 8.0)
    assert back is not None
    late = Ego(vehicle=CAR, s=START + 19.0, v_x=19.0, v_target=20.0, speed=SpeedSettings())
    later = put_off(late, ROAD, back, [at(20.0, 0.0, 12.0)])
    assert later.end > back.end + 5.0
    assert later.band.message == back.band.message
    assert later.offset_at(late.s + 20.0) >= back.offset_at(late.s) - 0.05
    assert put_off(late, ROAD, back, [at(60.0, 0.0, 12.0)]) is back  # nobody is beside
    assert put_off(late, ROAD, back, [at(20.0, 3.5, 12.0)]) is back  # not on the own lane
    assert put_off(late, ROAD, back, []) is back


def bend_after(straight_on: float, radius: float) -> Path:
    """A straight, then an arc."""
    angle = np.linspace(0.0, 1.0, 60)[1:]
    arc = np.column_stack((straight_on + radius * np.sin(angle), radius * (1.0 - np.cos(angle))))
    return interpolate_path(
        np.vstack(
            (
                np.column_stack((np.arange(0.0, straight_on), np.zeros(int(straight_on)))),
                [[straight_on, 0.0]],
                arc,
            )
        )
    )


def test_brakes_for_the_bend_of_the_way_back() -> None:
    """20 m at 4 m/s^2 are for 8.9 m/s: (20^2 - 80) / (2 * 40 m) from 20 m/s 40 m before."""
    way = bend_after(60.0, 20.0)
    assert slow_enough(way, 20.0, 20.0) == pytest.approx(4.0, rel=0.06)
    assert slow_enough(way, 0.0, 20.0) == 0.0  # 5 m/s^2 are in time from 32 m before on
    assert slow_enough(way, 58.0, 8.5) == 0.0
    assert slow_enough(straight(), 100.0, 40.0) == 0.0
    assert slow_enough(way, 20.0, 0.0) == 0.0
