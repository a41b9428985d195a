"""Abort and early return."""

import numpy as np
import pytest

from cca_core import Status
from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.path import Path, interpolate_path
from cca_core.planner.abort import delay_return, plan_abort, plan_early_return, return_deceleration
from cca_core.planner.maneuver import Maneuver
from cca_core.planner.maneuver_tuning import AbortSettings
from tests.support.planner_drives import (
    BLOCKED,
    CAR,
    START,
    TWO_LANE_ROAD,
    car,
    frenet_car,
    frenet_ego,
    straight,
)

SETTINGS = AbortSettings()


def abort(maneuver: Maneuver, gap: float, *others: FrenetVehicle) -> Maneuver | None:
    vehicles = [frenet_car(gap, 0.0, 12.0), *others]
    return plan_abort(frenet_ego(), TWO_LANE_ROAD, maneuver, vehicles, BLOCKED, SETTINGS)


def delayed(ego: FrenetEgo, aborted: Maneuver, *others: FrenetVehicle) -> Maneuver:
    return delay_return(ego, TWO_LANE_ROAD, aborted, others, SETTINGS)


def test_abort_returns_behind_lead(maneuver: Maneuver) -> None:
    back = abort(maneuver, 25.0)
    assert back is not None
    assert back.offset_at(START) > 1.0
    assert back.offset_at(back.end) == pytest.approx(0.0, abs=1e-9)
    assert back.candidate.rejection is BLOCKED


def test_no_abort_beyond_point_of_no_return(maneuver: Maneuver) -> None:
    assert abort(maneuver, -4.0) is None


@pytest.mark.parametrize("d", [0.0, 3.5], ids=["ego lane", "adjacent lane"])
def test_no_abort_in_front_of_following_vehicle(maneuver: Maneuver, d: float) -> None:
    assert abort(maneuver, 15.0, frenet_car(-30.0, d, 20.0, "B")) is None
    assert abort(maneuver, 15.0, frenet_car(-80.0, d, 20.0, "B")) is not None
    assert abort(maneuver, 15.0, frenet_car(-30.0, d, -20.0, "B")) is not None


def test_abort_holds_offset_until_gap_opens(maneuver: Maneuver) -> None:
    """8 m/s faster and 3.5 m behind: brake first, then return."""
    near, far = abort(maneuver, 8.0), abort(maneuver, 25.0)
    assert near is not None
    assert far is not None
    assert near.offset_at(START + 20.0) == pytest.approx(maneuver.offset_at(START + 20.0), abs=0.05)
    assert far.offset_at(START + 20.0) < 0.9 * maneuver.offset_at(START + 20.0)


def test_abort_while_returning_holds_offset(maneuver: Maneuver) -> None:
    """The maneuver returns ahead of the vehicle; the abort returns behind it, and later."""
    u = maneuver.band.displacement
    peak = int(u.argmax())
    s = np.linspace(maneuver.start, maneuver.end, len(u))[peak + int(np.argmax(u[peak:] < 0.8 * u.max()))]
    ego = frenet_ego(float(s) - START)
    back = plan_abort(
        ego, TWO_LANE_ROAD, maneuver, [frenet_car(float(s) - START + 2.0, 0.0, 12.0)], BLOCKED, SETTINGS
    )
    assert back is not None
    assert maneuver.offset_at(s + 20.0) < 0.5 * maneuver.offset_at(s)
    assert back.offset_at(s + 20.0) > 0.85 * maneuver.offset_at(s)
    assert back.offset_at(back.end) == pytest.approx(0.0, abs=1e-9)


def test_late_braking_delays_return(maneuver: Maneuver) -> None:
    """A second later the brakes have hardly acted: the vehicle is still alongside, or none is."""
    back = abort(maneuver, 8.0)
    assert back is not None
    late = frenet_ego(19.0, 19.0, 20.0)
    later = delayed(late, back, frenet_car(20.0, 0.0, 12.0))
    assert later.end > back.end + 5.0
    assert later.band.message == back.band.message
    assert later.offset_at(late.s + 20.0) >= back.offset_at(late.s) - 0.05
    assert delayed(late, back, frenet_car(60.0, 0.0, 12.0)) is back  # none is alongside
    assert delayed(late, back, frenet_car(20.0, 3.5, 12.0)) is back  # not in the ego lane
    assert delayed(late, back) is back


def test_passed_vehicle_triggers_early_return(maneuver: Maneuver) -> None:
    """The vehicle has fallen behind instead of the ego: return ahead of it, without brakes."""
    back = abort(maneuver, 8.0)
    assert back is not None
    late = frenet_ego(40.0, 18.0, 20.0)
    sooner = delayed(late, back, frenet_car(35.0, 0.0, 12.0))
    assert sooner is not back
    assert sooner.offset_at(late.s) == pytest.approx(back.offset_at(late.s), abs=0.05)
    assert return_deceleration(sooner.reference, late.s, late.v_x, SETTINGS) < 1.0
    assert delayed(late, back, frenet_car(20.0, 0.0, 12.0)) is back  # far enough behind


@pytest.mark.parametrize("age", [0.0, 2.0])
def test_stale_following_vehicle_is_not_a_lead(maneuver: Maneuver, age: float) -> None:
    """The uncertainty bound of a stale vehicle reaches to the ego, which does not make it a lead vehicle."""
    remote = car(START - 15.0, 3.5, 26.0, id="A", age=age, sigma_along=2.5 * age, sigma_across=0.3 * age)
    stale = FrenetVehicle.from_remote(remote, START - 15.0, 3.5, 0.0, 0.0)
    assert abort(maneuver, 15.0, stale) is None


class TestEarlyReturn:
    """Return ahead of passed vehicles."""

    def back(
        self,
        maneuver: Maneuver,
        gap: float,
        *others: tuple[float, float, float],
        v: float = 20.0,
        traveled: float = 60.0,
    ) -> Maneuver | None:
        """After `traveled`, at 60 m with an offset of 2.9 m; others by gap, d and speed."""
        ego = frenet_ego(traveled, v)
        vehicles = [frenet_car(traveled + x, d, v_x, str(x)) for x, d, v_x in ((gap, 0.0, 12.0), *others)]
        return plan_early_return(ego, TWO_LANE_ROAD, maneuver, vehicles, BLOCKED, SETTINGS)

    @pytest.mark.parametrize("gap", [-12.0, -5.0, 0.0, 5.0])
    def test_early_return_keeps_gap_behind(self, maneuver: Maneuver, gap: float) -> None:
        """2 m to the passed vehicle from where both bodies overlap laterally."""
        early = self.back(maneuver, gap)
        assert early is not None
        t = np.linspace(0.0, 8.0, 400)
        s = START + 60.0 + 20.0 * t
        d = np.array([early.offset_at(x) for x in s.tolist()])
        rear = s + CAR.box_offset - 0.5 * CAR.length
        returning = d < 0.95 * d[0]
        assert (rear - (START + 60.0 + gap + 12.0 * t + 2.25))[returning].min() >= 1.9
        assert d[-1] == pytest.approx(0.0, abs=1e-9)
        assert early.band.status is Status.DEGRADED
        assert early.candidate.rejection is BLOCKED

    def test_no_early_return_if_passing_takes_too_long(self, maneuver: Maneuver) -> None:
        assert self.back(maneuver, 25.0) is None
        assert self.back(maneuver, 0.0, v=13.0) is None

    def test_no_early_return_without_lateral_gap(self, maneuver: Maneuver) -> None:
        assert self.back(maneuver, 5.0, traveled=10.0) is None

    def test_no_early_return_close_behind_next_vehicle(self, maneuver: Maneuver) -> None:
        assert self.back(maneuver, -12.0, (30.0, 0.0, 12.0)) is None
        assert self.back(maneuver, -12.0, (60.0, 0.0, 12.0)) is not None

    def test_no_early_return_if_lane_is_occupied_first(self, maneuver: Maneuver) -> None:
        """The return takes 2 s: 40 m, and the distance that the vehicle covers by then."""
        assert self.back(maneuver, -12.0, (30.0, 3.5, 0.0)) is None
        assert self.back(maneuver, -12.0, (80.0, 3.5, 0.0)) is not None
        assert self.back(maneuver, -12.0, (80.0, 3.5, -20.0)) is None
        assert self.back(maneuver, -12.0, (160.0, 3.5, -20.0)) is not None

    def test_no_early_return_ahead_of_faster_vehicle(self, maneuver: Maneuver) -> None:
        assert self.back(maneuver, -12.0, (-20.0, 0.0, 25.0)) is None
        assert self.back(maneuver, -12.0, (-80.0, 0.0, 25.0)) is not None

    def test_early_return_while_returning_is_smooth(self, maneuver: Maneuver) -> None:
        early = self.back(maneuver, -12.0, traveled=115.0)
        assert early is not None
        s = START + 115.0 + np.arange(-6.0, 50.0, 0.5)
        kappa = early.reference.curvature(s)
        assert 400.0 * np.abs(kappa).max() < 4.2
        assert 400.0 * np.abs(np.diff(kappa)).max() < 0.4


def curve_after(straight_on: float, radius: float) -> Path:
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
    path = curve_after(60.0, 20.0)
    assert return_deceleration(path, 20.0, 20.0, SETTINGS) == pytest.approx(4.0, rel=0.06)
    assert return_deceleration(path, 0.0, 20.0, SETTINGS) < 0.0  # 5 m/s^2 are in time from 32 m before on
    needed = -0.4  # (8.5^2 - 80) / (2 * 9 m)
    assert return_deceleration(path, 58.0, 8.5, SETTINGS) == pytest.approx(needed, abs=0.2)
    assert return_deceleration(straight(), 100.0, 40.0, SETTINGS) < -100.0
    assert return_deceleration(path, 20.0, 0.0, SETTINGS) < -100.0
