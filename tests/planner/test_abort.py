"""Giving up a swerve: back behind the vehicle in front, unless somebody comes from behind."""

import numpy as np
import pytest

from cca_core import Lane, Road, Status
from cca_core.follow import SpeedSettings
from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.path import Path, interpolate_path
from cca_core.planner.abort import delay_return, plan_abort, plan_early_return, return_deceleration
from cca_core.planner.maneuver import Maneuver, plan_maneuver
from cca_core.planner.settings import EvasionSettings
from tests.planner.test_planner import CAR, START, car, straight

ROAD = Road(straight(), (Lane(d=0.0), Lane(d=3.5)))
SETTINGS = EvasionSettings(assumed_braking=0.0, assumed_acceleration=0.0, awareness_range=np.inf)


def at(gap: float, d: float, v: float, name: str = "R") -> FrenetVehicle:
    return FrenetVehicle.from_remote(car(START + gap, d, v, id=name), START + gap, d, 0.0, 0.0)


@pytest.fixture(scope="module")
def maneuver() -> Maneuver:
    """Fully beside a slower vehicle's path, 25 m behind it."""
    ego = FrenetEgo(
        vehicle=CAR, s=START - 60.0, v_x=20.0, v_target=20.0, speed=SpeedSettings()
    )  # fmt: skip
    plan = plan_maneuver(ego, ROAD, [at(0.0, 0.0, 12.0)], [], "left", SETTINGS, at_once=True)
    assert isinstance(plan, Maneuver)
    assert not plan.candidate.rejection
    return plan


def retreat(maneuver: Maneuver, gap: float, *others: FrenetVehicle) -> Maneuver | None:
    ego = FrenetEgo(vehicle=CAR, s=START, v_x=20.0, v_target=20.0, speed=SpeedSettings())
    return plan_abort(ego, ROAD, maneuver, [at(gap, 0.0, 12.0), *others], "somebody comes")


def test_abort_returns_behind_lead(maneuver: Maneuver) -> None:
    back = retreat(maneuver, 25.0)
    assert back is not None
    assert back.offset_at(START) > 1.0
    assert back.offset_at(back.end) == pytest.approx(0.0, abs=1e-9)
    assert "somebody comes" in back.band.message


def test_no_abort_beyond_point_of_no_return(maneuver: Maneuver) -> None:
    assert retreat(maneuver, -4.0) is None


@pytest.mark.parametrize("d", [0.0, 3.5], ids=["own lane", "lane beside"])
def test_no_abort_in_front_of_following_vehicle(maneuver: Maneuver, d: float) -> None:
    assert retreat(maneuver, 15.0, at(-30.0, d, 20.0, "B")) is None
    assert retreat(maneuver, 15.0, at(-80.0, d, 20.0, "B")) is not None
    assert retreat(maneuver, 15.0, at(-30.0, d, -20.0, "B")) is not None


def test_abort_holds_offset_until_gap_opens(maneuver: Maneuver) -> None:
    """8 m/s faster and 3.5 m behind: first slower, and only then back."""
    near, far = retreat(maneuver, 8.0), retreat(maneuver, 25.0)
    assert near is not None
    assert far is not None
    assert near.offset_at(START + 20.0) == pytest.approx(maneuver.offset_at(START + 20.0), abs=0.05)
    assert far.offset_at(START + 20.0) < 0.9 * maneuver.offset_at(START + 20.0)


def test_abort_while_returning_holds_offset(maneuver: Maneuver) -> None:
    """The swerve returns in front of the vehicle; the way back returns behind it, and not before."""
    u = maneuver.band.displacement
    peak = int(u.argmax())
    s = np.linspace(maneuver.start, maneuver.end, len(u))[peak + int(np.argmax(u[peak:] < 0.8 * u.max()))]
    ego = FrenetEgo(vehicle=CAR, s=float(s), v_x=20.0, v_target=20.0, speed=SpeedSettings())
    back = plan_abort(ego, ROAD, maneuver, [at(float(s) - START + 2.0, 0.0, 12.0)], "somebody comes")
    assert back is not None
    assert maneuver.offset_at(s + 20.0) < 0.5 * maneuver.offset_at(s)
    assert back.offset_at(s + 20.0) > 0.85 * maneuver.offset_at(s)
    assert back.offset_at(back.end) == pytest.approx(0.0, abs=1e-9)


def test_late_braking_delays_return(maneuver: Maneuver) -> None:
    """A second later the brakes have hardly acted, and the other is still beside; or nobody is."""
    back = retreat(maneuver, 8.0)
    assert back is not None
    late = FrenetEgo(vehicle=CAR, s=START + 19.0, v_x=19.0, v_target=20.0, speed=SpeedSettings())
    later = delay_return(late, ROAD, back, [at(20.0, 0.0, 12.0)])
    assert later.end > back.end + 5.0
    assert later.band.message == back.band.message
    assert later.offset_at(late.s + 20.0) >= back.offset_at(late.s) - 0.05
    assert delay_return(late, ROAD, back, [at(60.0, 0.0, 12.0)]) is back  # nobody is beside
    assert delay_return(late, ROAD, back, [at(20.0, 3.5, 12.0)]) is back  # not on the own lane
    assert delay_return(late, ROAD, back, []) is back


def test_passed_vehicle_triggers_early_return(maneuver: Maneuver) -> None:
    """It has dropped behind while the ego was to drop behind it: back in front of it, without brakes."""
    back = retreat(maneuver, 8.0)
    assert back is not None
    late = FrenetEgo(vehicle=CAR, s=START + 40.0, v_x=18.0, v_target=20.0, speed=SpeedSettings())
    sooner = delay_return(late, ROAD, back, [at(35.0, 0.0, 12.0)])
    assert sooner is not back
    assert sooner.offset_at(late.s) == pytest.approx(back.offset_at(late.s), abs=0.05)
    assert return_deceleration(sooner.reference, late.s, late.v_x) < 1.0
    assert delay_return(late, ROAD, back, [at(20.0, 0.0, 12.0)]) is back  # far enough behind


@pytest.mark.parametrize("age", [0.0, 2.0])
def test_stale_following_vehicle_is_not_a_lead(maneuver: Maneuver, age: float) -> None:
    """The bounds of a stale one reach to the ego, which does not make it one to fall back behind."""
    remote = car(START - 15.0, 3.5, 26.0, id="A", age=age, sigma_along=2.5 * age, sigma_across=0.3 * age)
    stale = FrenetVehicle.from_remote(remote, START - 15.0, 3.5, 0.0, 0.0)
    assert retreat(maneuver, 15.0, stale) is None


class TestShortcut:
    """Back in front of those that are passed by then."""

    def back(
        self,
        maneuver: Maneuver,
        gap: float,
        *others: tuple[float, float, float],
        v: float = 20.0,
        out: float = 60.0,
    ) -> Maneuver | None:
        """At `out`, 60 m where it is 2.9 m to the left; others by gap, d and speed."""
        ego = FrenetEgo(vehicle=CAR, s=START + out, v_x=v, v_target=v, speed=SpeedSettings())
        all_of_them = [at(out + x, d, v_x, str(x)) for x, d, v_x in ((gap, 0.0, 12.0), *others)]
        return plan_early_return(ego, ROAD, maneuver, all_of_them, "somebody comes")

    @pytest.mark.parametrize("gap", [-12.0, -5.0, 0.0, 5.0])
    def test_returns_with_room_behind(self, maneuver: Maneuver, gap: float) -> None:
        """Body by body: 2 m to the one passed from where both overlap to the side on."""
        way = self.back(maneuver, gap)
        assert way is not None
        t = np.linspace(0.0, 8.0, 400)
        s = START + 60.0 + 20.0 * t
        d = np.array([way.offset_at(x) for x in s.tolist()])
        rear = s + CAR.box_offset - 0.5 * CAR.length
        beside = d < 0.95 * d[0]
        assert (rear - (START + 60.0 + gap + 12.0 * t + 2.25))[beside].min() >= 1.9
        assert d[-1] == pytest.approx(0.0, abs=1e-9)
        assert way.band.status is Status.DEGRADED
        assert "somebody comes" in way.band.message

    def test_not_when_it_takes_too_long_to_be_past(self, maneuver: Maneuver) -> None:
        assert self.back(maneuver, 25.0) is None
        assert self.back(maneuver, 0.0, v=13.0) is None

    def test_not_past_one_that_is_not_cleared_to_the_side(self, maneuver: Maneuver) -> None:
        assert self.back(maneuver, 5.0, out=10.0) is None

    def test_not_close_behind_the_next_one(self, maneuver: Maneuver) -> None:
        assert self.back(maneuver, -12.0, (30.0, 0.0, 12.0)) is None
        assert self.back(maneuver, -12.0, (60.0, 0.0, 12.0)) is not None

    def test_not_where_somebody_is_met_first(self, maneuver: Maneuver) -> None:
        """The return takes 2 s: 40 m, and as far as the other comes by then."""
        assert self.back(maneuver, -12.0, (30.0, 3.5, 0.0)) is None
        assert self.back(maneuver, -12.0, (80.0, 3.5, 0.0)) is not None
        assert self.back(maneuver, -12.0, (80.0, 3.5, -20.0)) is None
        assert self.back(maneuver, -12.0, (160.0, 3.5, -20.0)) is not None

    def test_not_in_front_of_one_that_is_faster(self, maneuver: Maneuver) -> None:
        assert self.back(maneuver, -12.0, (-20.0, 0.0, 25.0)) is None
        assert self.back(maneuver, -12.0, (-80.0, 0.0, 25.0)) is not None

    def test_on_its_way_back_it_goes_on_without_a_kink(self, maneuver: Maneuver) -> None:
        way = self.back(maneuver, -12.0, out=115.0)
        assert way is not None
        s = START + 115.0 + np.arange(-6.0, 50.0, 0.5)
        kappa = way.reference.curvature(s)
        assert 400.0 * np.abs(kappa).max() < 4.2
        assert 400.0 * np.abs(np.diff(kappa)).max() < 0.4


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


def test_return_deceleration_respects_path_curvature() -> None:
    """20 m at 4 m/s^2 are for 8.9 m/s: (20^2 - 80) / (2 * 40 m) from 20 m/s 40 m before."""
    way = bend_after(60.0, 20.0)
    assert return_deceleration(way, 20.0, 20.0) == pytest.approx(4.0, rel=0.06)
    assert return_deceleration(way, 0.0, 20.0) < 0.0  # 5 m/s^2 are in time from 32 m before on
    assert return_deceleration(way, 58.0, 8.5) == pytest.approx(-0.4, abs=0.2)  # (8.5^2 - 80) / (2 * 9 m)
    assert return_deceleration(straight(), 100.0, 40.0) < -100.0
    assert return_deceleration(way, 20.0, 0.0) < -100.0
