"""Braking and standing vehicles that others hide, and crossing ones, in closed loop."""

import math
from dataclasses import replace

import pytest

from cca_core import Action, Command, Lane, Path, Planner, RemoteVehicle, Road
from cca_core.follow import SpeedSettings
from tests.planner.test_planner import ALL_KNOWN, CAR, CYCLE, START, Drive, Mover, state, straight


class Swerver(Mover):
    """Swings out to `aside` in two seconds when it comes within `reach` of a place."""

    def __init__(self, gap: float, v: float, *, place: float, reach: float, aside: float) -> None:
        super().__init__("Y", gap, 0.0, v)
        self.place, self.reach, self.aside, self.since = START + place, reach, aside, 0.0

    def move(self, t: float) -> None:
        super().move(t)
        if self.x > self.place - self.reach:
            self.since = min(self.since + 0.5 * CYCLE, 1.0)
            self.d = self.aside * self.since**3 * (10.0 - 15.0 * self.since + 6.0 * self.since**2)


class Crosser(Mover):
    """Drives across the road at one place, at heading 90 degrees or -90 degrees."""

    def move(self, t: float) -> None:
        self.d += math.sin(self.psi) * self.v * CYCLE


def ego(lanes: tuple[Lane, ...] = (), cruise: float = 20.0, time_gap: float = 1.5) -> Planner:
    path = straight(1200.0)
    road: Road | Path = Road(path, lanes) if lanes else path
    return Planner(CAR, road, cruise_speed=cruise, evasion=ALL_KNOWN, speed=SpeedSettings(time_gap=time_gap))


@pytest.mark.parametrize("v", [20.0, 29.0])
class TestHiddenBraking:
    """Red brakes at 7 m/s^2 after two seconds, yellow 1.25 s later; the ego is a second behind yellow."""

    def drive(self, v: float, *, connected: bool) -> Drive:
        ahead = 4.5 + 3.0 + 1.0 * v
        yellow = Mover("Y", ahead, 0.0, v, a=lambda t: -7.0 if t >= 3.25 else 0.0)
        red = Mover("R", ahead + 4.5 + 1.8 * v, 0.0, v, a=lambda t: -7.0 if t >= 2.0 else 0.0)
        return Drive(
            ego(cruise=v, time_gap=1.0), [yellow, red], 14.0, v=v,
            heard=lambda t, known: [r for r in known if connected or r.id == "Y"],
        )  # fmt: skip

    def test_brakes_before_the_leader_and_gently(self, v: float) -> None:
        run = self.drive(v, connected=True)
        assert run.hit is None
        assert run.v[-1] < 0.1
        first = next(i for i, a in enumerate(run.a_x) if a < -1.0)
        assert 2.0 < first * CYCLE < 3.0
        assert min(run.a_x) > -6.0

    def test_hard_braking_told_is_braked_for_at_once(self, v: float) -> None:
        """Who says that it brakes hard is believed before the second in line shows it."""
        ahead = 4.5 + 0.6 * v
        yellow = Mover("Y", ahead, 0.0, v, a=lambda t: -7.0 if t >= 3.0 else 0.0)
        red = Mover("R", ahead + 4.5 + 1.8 * v, 0.0, v, a=lambda t: -7.0 if t >= 2.0 else 0.0)
        run = Drive(
            ego(cruise=v, time_gap=0.5), [yellow, red], 14.0, v=v,
            heard=lambda t, known: [
                replace(r, events=frozenset({"hard_braking"})) if r.id == "R" and r.a_x < -4.0 else r
                for r in known
            ],
        )  # fmt: skip
        assert run.hit is None
        assert run.gaps["Y"] > 1.0
        first = next(i for i, a in enumerate(run.a_x) if a < -3.0)
        assert first * CYCLE < 2.5

    def test_without_messages_of_the_hidden_one_it_brakes_after_the_leader(self, v: float) -> None:
        run = self.drive(v, connected=False)
        first = next(i for i, a in enumerate(run.a_x) if a < -2.0)
        assert first * CYCLE > 3.25


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["left", "right"])
class TestHiddenStanding:
    """Yellow swings out 1.1 s before a car that stands half in the lane."""

    def drive(self, v: float, sign: float, *others: Mover, beside: bool = True) -> Drive:
        lanes = (Lane(d=0.0), Lane(d=3.5 * sign)) if beside else (Lane(d=0.0),)
        place = 9.0 * v
        yellow = Swerver(1.5 * v + 4.5, v, place=place, reach=1.1 * v + 4.5, aside=3.0 * sign)
        red = Mover("R", place, -1.05 * sign, 0.0)
        return Drive(
            ego(lanes, cruise=v), [yellow, red, *others], 22.0, v=v,
            done=lambda s: s.v_x < 0.05 or s.x > START + place + 60.0,
        )  # fmt: skip

    def test_stops_at_50_km_h(self, sign: float) -> None:
        run = self.drive(13.9, sign)
        assert run.hit is None
        assert run.v[-1] < 0.1
        assert not any(c.decision.action.is_evading for c in run.commands)
        assert run.gaps["R"] == pytest.approx(3.0, abs=1.0)
        assert min(run.a_x) > -3.0

    def test_passes_at_90_km_h(self, sign: float) -> None:
        run = self.drive(25.0, sign)
        side = Action.EVADE_LEFT if sign > 0.0 else Action.EVADE_RIGHT
        assert run.hit is None
        assert side in {c.decision.action for c in run.commands}
        assert run.gaps["R"] > 0.5
        assert min(run.v) > 20.0
        assert max(map(abs, run.a_y)) < 4.0

    def test_brakes_at_90_km_h_when_the_lane_beside_is_not_free(self, sign: float) -> None:
        run = self.drive(25.0, sign, Mover("L", -6.0, 3.5 * sign, 25.0))
        assert run.hit is None
        assert not any(c.decision.action.is_evading for c in run.commands[: round(4.0 / CYCLE)])
        assert min(run.a_x) < -0.5

    def test_brakes_at_90_km_h_when_there_is_no_lane_beside(self, sign: float) -> None:
        run = self.drive(25.0, sign, beside=False)
        assert run.hit is None
        assert run.v[-1] < 0.1
        assert min(run.a_x) > -5.0


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["from the right", "from the left"])
class TestCrossing:
    PLACE = 120.0  # of the crossing [m]; the ego would be there 6 s after the start

    def drive(self, sign: float, early: float, v: float = 10.0) -> Drive:
        there = self.PLACE / 20.0 - early
        crosser = Crosser("X", self.PLACE, -sign * v * there, v, psi=sign * 0.5 * math.pi)
        return Drive(ego(), [crosser], 22.0, done=lambda s: s.x > START + self.PLACE + 120.0)

    @pytest.mark.parametrize("early", [-0.8, 0.0, 0.8])
    def test_waits_and_goes_on(self, sign: float, early: float) -> None:
        run = self.drive(sign, early)
        assert run.hit is None
        assert run.gaps["X"] > 1.0
        assert run.x[-1] > START + self.PLACE + 100.0
        assert run.v[-1] > 15.0
        assert min(run.a_x) > -5.0
        assert max(map(abs, run.y)) < 0.1

    @pytest.mark.parametrize("early", [-12.0, 5.0])
    def test_far_in_time_nobody_is_waited_for(self, sign: float, early: float) -> None:
        run = self.drive(sign, early)
        assert run.hit is None
        assert min(run.v) > 18.0


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["from the right", "from the left"])
class TestToldLate:
    """A crossing car is first heard when the ego can no longer stay out of where it may be."""

    def drive(self, sign: float, *, v: float, ahead: float, after: float, sigma: float = 0.0) -> Drive:
        there = 60.0 / v
        crosser = Crosser("X", 60.0, -sign * 10.0 * (there + after), 10.0, psi=sign * 0.5 * math.pi)
        return Drive(
            ego(cruise=v), [crosser], 16.0, v=v, done=lambda s: s.x > START + 100.0,
            heard=lambda t, known: [
                replace(r, sigma_along=sigma, sigma_across=sigma) for r in known if v * t > 60.0 - ahead
            ],
        )  # fmt: skip

    def test_goes_on_where_braking_would_leave_it_in_the_way(self, sign: float) -> None:
        run = self.drive(sign, v=10.0, ahead=9.0, after=1.3)
        assert run.hit is None
        assert min(run.v) > 9.0

    @pytest.mark.parametrize("after", [0.0, 0.5])
    def test_brakes_where_only_its_bounds_reach_the_ego(self, sign: float, after: float) -> None:
        run = self.drive(sign, v=8.0, ahead=11.0, after=after, sigma=2.0)
        assert run.hit is None
        assert min(run.v) < 0.5
        assert run.v[-1] > 6.0

    def test_where_nothing_helps_it_meets_it_more_slowly(self, sign: float) -> None:
        run = self.drive(sign, v=10.0, ahead=10.0, after=0.25)
        assert run.hit == "X"
        assert run.v[-1] < 8.0


def test_crossing_is_mirrored() -> None:
    left, right = (TestCrossing().drive(sign, 0.3) for sign in (1.0, -1.0))
    assert left.v == pytest.approx(right.v, abs=1e-6)
    assert left.actions == right.actions


class TestUncertain:
    """A vehicle of the other lane that may be in the way by its bounds alone."""

    def drive(self, sigma: float, behind: float = math.inf) -> Drive:
        beside = Mover("L", 4.0, 3.5, 18.0)
        others = [beside] if math.isinf(behind) else [beside, Mover("B", -behind, 0.0, 20.0)]
        return Drive(
            ego((Lane(d=0.0), Lane(d=3.5))), others, 4.0,
            heard=lambda t, known: [
                replace(r, sigma_across=sigma, sigma_along=2.0) if r.id == "L" else r for r in known
            ],
        )  # fmt: skip

    def test_is_given_room_in_comfort(self) -> None:
        run = self.drive(1.0)
        assert -2.5 < min(run.a_x) < -0.5
        assert 15.0 < min(run.v) < 18.0

    def test_does_not_matter_where_it_is_known(self) -> None:
        assert min(self.drive(0.1).a_x) > -0.1

    def test_whoever_follows_is_not_surprised(self) -> None:
        assert self.drive(1.0, behind=15.0).gaps["B"] > 0.5


class TestOncoming:
    """One that comes toward the ego, heard at a place, and then no more: its bounds grow, it drifts."""

    def then(
        self, heard_at: float, d: float, age: float, sigma: float, v: float = -20.0, turn: float = 0.0,
        heard_to: float = 0.1,
    ) -> Command:  # fmt: skip
        planner = ego()
        for t, x, y, old, error in ((0.0, 150.0, heard_at, 0.1, heard_to), (age, 120.0, d, age, sigma)):
            remote = RemoteVehicle(
                id="A", x=START + x, y=y, psi=math.pi + turn if v < 0.0 else 0.0, v_x=abs(v), age=old,
                sigma_across=error,
            )  # fmt: skip
            command = planner.step(t, state(), [remote])
        return command

    @pytest.mark.parametrize("d", [0.0, 1.4, -1.0])
    def test_heard_beside_it_keeps_to_its_side(self, d: float) -> None:
        command = self.then(3.5, d, 4.0, 3.4)
        assert command.decision.action is Action.KEEP
        assert command.a_x > -0.5

    @pytest.mark.parametrize("age", [1.1, 4.0, 10.0])
    @pytest.mark.parametrize("sigma", [0.1, 1.1, 6.0])
    def test_heard_on_the_route_it_is_still_there(self, age: float, sigma: float) -> None:
        """Head-on: silence makes nobody vanish."""
        assert self.then(0.0, 0.3, age, sigma).decision.action is Action.BRAKE

    @pytest.mark.parametrize(("d", "age", "sigma"), [(1.4, 0.3, 0.5), (0.0, 0.3, 0.5)])
    def test_heard_to_come_over_it_is_braked_for(self, d: float, age: float, sigma: float) -> None:
        assert self.then(3.5, d, age, sigma).decision.action is Action.BRAKE

    def test_heard_to_head_for_the_route_it_is_taken_to_come(self) -> None:
        """At 1 m/s to the side it is in the lane two seconds later."""
        assert self.then(3.5, 0.2, 3.0, 2.5, turn=0.05).decision.action is Action.BRAKE
        assert self.then(3.5, 0.2, 3.0, 2.5, turn=-0.05).decision.action is Action.KEEP
        assert self.then(3.5, 0.2, 3.0, 2.5, turn=0.01).decision.action is Action.KEEP

    def test_where_it_was_heard_is_known_well_or_not(self) -> None:
        """Its bounds reached into the lane when it was heard: where it said to be counts, not they."""
        assert self.then(3.5, 1.4, 4.0, 3.4, heard_to=1.0).decision.action is Action.KEEP
        assert self.then(1.9, 1.4, 4.0, 3.4, heard_to=1.0).decision.action is Action.BRAKE

    def test_one_that_drives_ahead_is_not_left_out(self) -> None:
        assert self.then(3.5, 0.0, 4.0, 3.4, v=10.0).decision.action is not Action.KEEP

    def test_first_known_by_an_old_message_it_is_where_that_says(self) -> None:
        remote = RemoteVehicle(
            id="A", x=START + 120.0, y=0.0, psi=math.pi, v_x=20.0, age=4.0, sigma_across=3.4
        )
        assert ego().step(0.0, state(), [remote]).decision.action is Action.BRAKE
