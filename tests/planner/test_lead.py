"""Lead vehicles in closed loop: downstream, crossing, uncertain and stale ones."""

import math
from dataclasses import replace

import pytest

from cca_core import Action, Command, Lane, Path, Planner, RemoteVehicle, Road
from cca_core.follow import SpeedSettings
from tests.support.planner_drives import (
    ALL_KNOWN,
    CAR,
    CYCLE,
    START,
    ClosedLoop,
    CrossingVehicle,
    LaneLeavingVehicle,
    ScriptedVehicle,
    ego_state,
    straight,
)


def ego(lanes: tuple[Lane, ...] = (), cruise: float = 20.0, time_gap: float = 1.5) -> Planner:
    path = straight(1200.0)
    road: Road | Path = Road(path, lanes) if lanes else path
    return Planner(CAR, road, cruise_speed=cruise, evasion=ALL_KNOWN, speed=SpeedSettings(time_gap=time_gap))


@pytest.mark.parametrize("v", [20.0, 29.0])
class TestDownstreamBraking:
    """Red brakes at 7 m/s^2 after two seconds, yellow 1.25 s later; the ego is a second behind yellow."""

    def drive(self, v: float, *, connected: bool) -> ClosedLoop:
        ahead = 4.5 + 3.0 + 1.0 * v
        yellow = ScriptedVehicle("Y", ahead, 0.0, v, a=lambda t: -7.0 if t >= 3.25 else 0.0)
        red = ScriptedVehicle("R", ahead + 4.5 + 1.8 * v, 0.0, v, a=lambda t: -7.0 if t >= 2.0 else 0.0)
        return ClosedLoop(
            ego(cruise=v, time_gap=1.0), [yellow, red], 14.0, v=v,
            receive=lambda t, remotes: [r for r in remotes if connected or r.id == "Y"],
        )  # fmt: skip

    def test_ego_brakes_gently_before_lead(self, v: float) -> None:
        run = self.drive(v, connected=True)
        assert run.collided_with is None
        assert run.v[-1] < 0.1
        first = next(i for i, a in enumerate(run.a_x) if a < -1.0)
        assert 2.0 < first * CYCLE < 3.0
        assert min(run.a_x) > -6.0

    def test_reported_hard_braking_brakes_at_once(self, v: float) -> None:
        """Reported hard braking counts before the vehicle directly ahead brakes."""
        ahead = 4.5 + 0.6 * v
        yellow = ScriptedVehicle("Y", ahead, 0.0, v, a=lambda t: -7.0 if t >= 3.0 else 0.0)
        red = ScriptedVehicle("R", ahead + 4.5 + 1.8 * v, 0.0, v, a=lambda t: -7.0 if t >= 2.0 else 0.0)
        run = ClosedLoop(
            ego(cruise=v, time_gap=0.5), [yellow, red], 14.0, v=v,
            receive=lambda t, remotes: [
                replace(r, events=frozenset({"hard_braking"})) if r.id == "R" and r.a_x < -4.0 else r
                for r in remotes
            ],
        )  # fmt: skip
        assert run.collided_with is None
        assert run.gaps["Y"] > 1.0
        first = next(i for i, a in enumerate(run.a_x) if a < -3.0)
        assert first * CYCLE < 2.5

    def test_ego_brakes_after_lead_without_messages(self, v: float) -> None:
        run = self.drive(v, connected=False)
        first = next(i for i, a in enumerate(run.a_x) if a < -2.0)
        assert first * CYCLE > 3.25


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["left", "right"])
class TestDownstreamStationary:
    """Yellow leaves the lane 1.1 s before a stationary car that is half in the lane."""

    def drive(self, v: float, sign: float, *others: ScriptedVehicle, adjacent: bool = True) -> ClosedLoop:
        lanes = (Lane(d=0.0), Lane(d=3.5 * sign)) if adjacent else (Lane(d=0.0),)
        station = 9.0 * v
        yellow = LaneLeavingVehicle(1.5 * v + 4.5, v, station=station, range=1.1 * v + 4.5, offset=3.0 * sign)
        red = ScriptedVehicle("R", station, -1.05 * sign, 0.0)
        return ClosedLoop(
            ego(lanes, cruise=v), [yellow, red, *others], 22.0, v=v,
            done=lambda s: s.v_x < 0.05 or s.x > START + station + 60.0,
        )  # fmt: skip

    def test_ego_stops_at_50_km_h(self, sign: float) -> None:
        run = self.drive(13.9, sign)
        assert run.collided_with is None
        assert run.v[-1] < 0.1
        assert not any(c.decision.action.is_evading for c in run.commands)
        assert run.gaps["R"] == pytest.approx(3.0, abs=1.0)
        assert min(run.a_x) > -3.0

    def test_ego_passes_at_90_km_h(self, sign: float) -> None:
        run = self.drive(25.0, sign)
        side = Action.EVADE_LEFT if sign > 0.0 else Action.EVADE_RIGHT
        assert run.collided_with is None
        assert side in {c.decision.action for c in run.commands}
        assert run.gaps["R"] > 0.5
        assert min(run.v) > 20.0
        assert max(map(abs, run.a_y)) < 4.0

    def test_ego_brakes_at_90_km_h_if_lane_is_blocked(self, sign: float) -> None:
        run = self.drive(25.0, sign, ScriptedVehicle("L", -6.0, 3.5 * sign, 25.0))
        assert run.collided_with is None
        assert not any(c.decision.action.is_evading for c in run.commands[: round(4.0 / CYCLE)])
        assert min(run.a_x) < -0.5

    def test_ego_brakes_at_90_km_h_without_adjacent_lane(self, sign: float) -> None:
        run = self.drive(25.0, sign, adjacent=False)
        assert run.collided_with is None
        assert run.v[-1] < 0.1
        assert min(run.a_x) > -5.0


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["from the right", "from the left"])
class TestCrossing:
    STATION = 120.0  # of the crossing [m]; the ego would be there 6 s after the start

    def drive(self, sign: float, early: float, v: float = 10.0) -> ClosedLoop:
        there = self.STATION / 20.0 - early
        crossing = CrossingVehicle("X", self.STATION, -sign * v * there, v, psi=sign * 0.5 * math.pi)
        return ClosedLoop(ego(), [crossing], 22.0, done=lambda s: s.x > START + self.STATION + 120.0)

    @pytest.mark.parametrize("early", [-0.8, 0.0, 0.8])
    def test_ego_yields_and_continues(self, sign: float, early: float) -> None:
        run = self.drive(sign, early)
        assert run.collided_with is None
        assert run.gaps["X"] > 1.0
        assert run.x[-1] > START + self.STATION + 100.0
        assert run.v[-1] > 15.0
        assert min(run.a_x) > -5.0
        assert max(map(abs, run.y)) < 0.1

    @pytest.mark.parametrize("early", [-12.0, 5.0])
    def test_ego_does_not_yield_if_far_apart_in_time(self, sign: float, early: float) -> None:
        run = self.drive(sign, early)
        assert run.collided_with is None
        assert min(run.v) > 18.0


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["from the right", "from the left"])
class TestLateCrossing:
    """The first message comes when the ego can no longer stop before the conflict area."""

    def drive(self, sign: float, *, v: float, ahead: float, after: float, sigma: float = 0.0) -> ClosedLoop:
        there = 60.0 / v
        crossing = CrossingVehicle("X", 60.0, -sign * 10.0 * (there + after), 10.0, psi=sign * 0.5 * math.pi)
        return ClosedLoop(
            ego(cruise=v), [crossing], 16.0, v=v, done=lambda s: s.x > START + 100.0,
            receive=lambda t, remotes: [
                replace(r, sigma_along=sigma, sigma_across=sigma) for r in remotes if v * t > 60.0 - ahead
            ],
        )  # fmt: skip

    def test_ego_continues_if_braking_stops_in_conflict_area(self, sign: float) -> None:
        run = self.drive(sign, v=10.0, ahead=9.0, after=1.3)
        assert run.collided_with is None
        assert min(run.v) > 9.0

    @pytest.mark.parametrize("after", [0.0, 0.5])
    def test_ego_brakes_if_only_uncertainty_bound_conflicts(self, sign: float, after: float) -> None:
        run = self.drive(sign, v=8.0, ahead=11.0, after=after, sigma=2.0)
        assert run.collided_with is None
        assert min(run.v) < 0.5
        assert run.v[-1] > 6.0

    def test_ego_slows_if_collision_is_certain(self, sign: float) -> None:
        run = self.drive(sign, v=10.0, ahead=10.0, after=0.25)
        assert run.collided_with == "X"
        assert run.v[-1] < 8.0


def test_crossing_is_mirror_symmetric() -> None:
    left, right = (TestCrossing().drive(sign, 0.3) for sign in (1.0, -1.0))
    assert left.v == pytest.approx(right.v, abs=1e-6)
    assert left.actions == right.actions


class TestUncertainLead:
    """A vehicle in the adjacent lane whose uncertainty bound reaches into the ego lane."""

    def drive(self, sigma: float, behind: float = math.inf) -> ClosedLoop:
        uncertain = ScriptedVehicle("L", 4.0, 3.5, 18.0)
        others = [uncertain] if math.isinf(behind) else [uncertain, ScriptedVehicle("B", -behind, 0.0, 20.0)]
        return ClosedLoop(
            ego((Lane(d=0.0), Lane(d=3.5))), others, 4.0,
            receive=lambda t, remotes: [
                replace(r, sigma_across=sigma, sigma_along=2.0) if r.id == "L" else r for r in remotes
            ],
        )  # fmt: skip

    def test_uncertain_lead_is_followed_in_comfort(self) -> None:
        run = self.drive(1.0)
        assert -2.5 < min(run.a_x) < -0.5
        assert 15.0 < min(run.v) < 18.0

    def test_certain_vehicle_in_other_lane_is_ignored(self) -> None:
        assert min(self.drive(0.1).a_x) > -0.1

    def test_following_vehicle_keeps_its_gap(self) -> None:
        assert self.drive(1.0, behind=15.0).gaps["B"] > 0.5


class TestStaleOncoming:
    """A stale oncoming vehicle: its uncertainty bound grows and its dead-reckoned position drifts."""

    def then(
        self, last_d: float, d: float, age: float, sigma: float, v: float = -20.0, turn: float = 0.0,
        last_sigma: float = 0.1,
    ) -> Command:  # fmt: skip
        planner = ego()
        for t, x, y, old, error in ((0.0, 150.0, last_d, 0.1, last_sigma), (age, 120.0, d, age, sigma)):
            remote = RemoteVehicle(
                id="A", x=START + x, y=y, psi=math.pi + turn if v < 0.0 else 0.0, v_x=abs(v), age=old,
                sigma_across=error,
            )  # fmt: skip
            command = planner.step(t, ego_state(), [remote])
        return command

    @pytest.mark.parametrize("d", [0.0, 1.4, -1.0])
    def test_vehicle_last_off_route_is_assumed_in_its_lane(self, d: float) -> None:
        command = self.then(3.5, d, 4.0, 3.4)
        assert command.decision.action is Action.KEEP
        assert command.a_x > -0.5

    @pytest.mark.parametrize("age", [1.1, 4.0, 10.0])
    @pytest.mark.parametrize("sigma", [0.1, 1.1, 6.0])
    def test_vehicle_last_on_route_is_braked_for(self, age: float, sigma: float) -> None:
        """Head-on: a message gap does not remove a vehicle."""
        assert self.then(0.0, 0.3, age, sigma).decision.action is Action.BRAKE

    @pytest.mark.parametrize(("d", "age", "sigma"), [(1.4, 0.3, 0.5), (0.0, 0.3, 0.5)])
    def test_fresh_vehicle_on_route_is_braked_for(self, d: float, age: float, sigma: float) -> None:
        assert self.then(3.5, d, age, sigma).decision.action is Action.BRAKE

    def test_vehicle_last_heading_for_route_is_braked_for(self) -> None:
        """At 1 m/s to the side the vehicle is in the lane two seconds later."""
        assert self.then(3.5, 0.2, 3.0, 2.5, turn=0.05).decision.action is Action.BRAKE
        assert self.then(3.5, 0.2, 3.0, 2.5, turn=-0.05).decision.action is Action.KEEP
        assert self.then(3.5, 0.2, 3.0, 2.5, turn=0.01).decision.action is Action.KEEP

    def test_last_position_counts_without_its_bound(self) -> None:
        """The bound reached into the lane at the last message: the reported position counts."""
        assert self.then(3.5, 1.4, 4.0, 3.4, last_sigma=1.0).decision.action is Action.KEEP
        assert self.then(1.9, 1.4, 4.0, 3.4, last_sigma=1.0).decision.action is Action.BRAKE

    def test_stale_vehicle_ahead_is_followed(self) -> None:
        assert self.then(3.5, 0.0, 4.0, 3.4, v=10.0).decision.action is not Action.KEEP

    def test_first_report_that_is_stale_is_braked_for(self) -> None:
        remote = RemoteVehicle(
            id="A", x=START + 120.0, y=0.0, psi=math.pi, v_x=20.0, age=4.0, sigma_across=3.4
        )
        assert ego().step(0.0, ego_state(), [remote]).decision.action is Action.BRAKE
