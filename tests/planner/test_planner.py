"""The planner: whatever comes in, a usable command goes out; and what it does on simple roads."""

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cca_core import (
    Action,
    Command,
    InputError,
    Lane,
    Path,
    Planner,
    RemoteVehicle,
    Road,
    Status,
    VehicleParams,
    VehicleState,
)  # fmt: skip
from cca_core.follow import steady_sideslip
from cca_core.geometry import box_gap, boxes
from cca_core.path import fit_path
from cca_core.planner.settings import EvasionSettings
from cca_core.sim import SingleTrackPlant

CAR = replace(VehicleParams.bmw_320i(), length=4.5, width=1.8)
TWO = (Lane(d=0.0), Lane(d=3.5))
ALL_KNOWN = EvasionSettings(awareness_range=math.inf)
START = 20.0
CYCLE = 0.02


def straight(length: float = 1200.0) -> Path:
    return Path([0.0, length], [[[0.0, 0.0, length, 0.0], [0.0, 0.0, 0.0, 0.0]]])


def planner(lanes: tuple[Lane, ...] | None = TWO, *, cruise: float = 20.0, **kwargs: Any) -> Planner:
    road = straight() if lanes is None else Road(straight(), lanes)
    return Planner(CAR, road, cruise_speed=cruise, **({"evasion": ALL_KNOWN} | kwargs))


def state(x: float = START, v_x: float = 20.0, **kwargs: float) -> VehicleState:
    return VehicleState(**({"x": x, "y": 0.0, "psi": 0.0, "v_x": v_x} | kwargs))


def car(x: float, y: float = 0.0, v_x: float = 12.0, **kwargs: Any) -> RemoteVehicle:
    return RemoteVehicle(**({"id": "R", "x": x, "y": y, "psi": 0.0, "v_x": v_x} | kwargs))


def usable(command: Command) -> None:
    assert math.isfinite(command.delta)
    assert math.isfinite(command.a_x)
    assert abs(command.delta) <= CAR.delta_max
    assert abs(command.a_x) < 10.0
    assert command.decision.reason
    assert isinstance(command.status, Status)
    assert isinstance(command.reference, Path)


def same(a: Command, b: Command) -> bool:
    return (a.delta, a.a_x, a.decision, a.status) == (b.delta, b.a_x, b.decision, b.status)


class Mover:
    """Road user on the straight road: constant lateral place, speed from a function of time."""

    def __init__(
        self, id: str, gap: float, d: float, v: float, *, a: Callable[[float], float] = lambda t: 0.0,
        psi: float = 0.0, length: float = 4.5, width: float = 1.8,
    ) -> None:  # fmt: skip
        self.id, self.x, self.d, self.v, self.a = id, START + gap, d, v, a
        self.psi, self.length, self.width, self.a_x = psi, length, width, 0.0

    def record(self) -> RemoteVehicle:
        return RemoteVehicle(
            id=self.id, x=self.x, y=self.d, psi=self.psi, v_x=self.v, a_x=self.a_x, length=self.length,
            width=self.width,
        )  # fmt: skip

    def move(self, t: float) -> None:
        self.a_x = self.a(t) if self.v > 0.0 else 0.0
        v = max(self.v + self.a_x * CYCLE, 0.0)
        self.x += math.cos(self.psi) * 0.5 * (self.v + v) * CYCLE
        self.v = v


class Drive:
    """Closed loop on the straight road with 10 Hz messages; ends at the first contact, or when `done`."""

    def __init__(
        self, p: Planner, movers: Iterable[Mover], seconds: float, *, v: float = 20.0,
        heard: Callable[[float, list[RemoteVehicle]], list[RemoteVehicle]] = lambda t, r: r,
        start: float = START, done: Callable[[VehicleState], bool] = lambda s: False,
    ) -> None:  # fmt: skip
        movers = list(movers)
        plant = SingleTrackPlant(CAR, state(start, v))
        self.v: list[float] = []
        self.x: list[float] = []
        self.y: list[float] = []
        self.a_y: list[float] = []
        self.a_x: list[float] = []
        self.commands: list[Command] = []
        self.gaps: dict[str, float] = {m.id: math.inf for m in movers}
        self.hit: str | None = None
        latest: list[RemoteVehicle] = []
        for k in range(round(seconds / CYCLE)):
            t = k * CYCLE
            s = plant.state
            if k % 5 == 0:
                latest = [m.record() for m in movers]
            age = k % 5 * CYCLE
            known = [
                replace(r, x=r.x + r.v_x * math.cos(r.psi) * age, age=age) for r in latest
            ]  # fmt: skip
            command = p.step(t, s, heard(t, known))
            usable(command)
            self.commands.append(command)
            self.v.append(s.v_x)
            self.x.append(s.x)
            self.y.append(s.y)
            self.a_y.append(plant.a_y)
            self.a_x.append(s.a_x)
            body = boxes(s.x, s.y, s.psi, CAR.length, CAR.width)
            for m in movers:
                gap = float(box_gap(body, boxes(m.x, m.d, m.psi, m.length, m.width)))
                self.gaps[m.id] = min(self.gaps[m.id], gap)
                if gap <= 0.0:
                    self.hit = m.id
            if self.hit or done(s):
                break
            plant.step(command.delta, command.a_x, CYCLE)
            for m in movers:
                m.move(t)

    @property
    def actions(self) -> list[str]:
        names = [c.decision.action.name for c in self.commands]
        return [name for i, name in enumerate(names) if i == 0 or names[i - 1] != name]


class TestArguments:
    @pytest.mark.parametrize(
        ("kwargs", "named"),
        [
            ({"cruise_speed": -1.0}, "cruise_speed"), ({"cruise_speed": 0.0}, "cruise_speed"),
            ({"cruise_speed": math.nan}, "cruise_speed"), ({"cruise_speed": "fast"}, "cruise_speed"),
            ({"vehicle": None}, "vehicle"), ({"vehicle": state()}, "vehicle"),
            ({"road": None}, "road"), ({"road": [[0.0, 0.0], [1.0, 0.0]]}, "road"),
            ({"evasion": {"clearance": 1.0}}, "evasion"), ({"speed": 20.0}, "speed"),
            ({"controller": "pid"}, "controller"),
        ],
    )  # fmt: skip
    def test_bad_ones_are_named(self, kwargs: dict[str, Any], named: str) -> None:
        args: dict[str, Any] = {"vehicle": CAR, "road": straight(), "cruise_speed": 20.0} | kwargs
        with pytest.raises(InputError, match=rf"\b{named}\b"):
            Planner(args.pop("vehicle"), args.pop("road"), **args)

    @pytest.mark.parametrize(
        "name",
        [
            "lateral_acceleration",
            "clearance",
            "min_ttc",
            "preparation_time",
            "x_safety",
            "awareness_range",
            "min_speed_advantage",
        ],
    )
    @pytest.mark.parametrize("bad", [-1.0, math.nan, "far"])
    def test_bad_settings_are_named(self, name: str, bad: Any) -> None:
        with pytest.raises(InputError, match=name):
            EvasionSettings(**{name: bad})


wild = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True), st.floats(-200.0, 200.0),
    st.sampled_from([0.0, -0.0, 1e-320, 1e9, 1e155, -1e300, 1.7e308]),
)  # fmt: skip
remotes = st.builds(
    RemoteVehicle,
    id=st.sampled_from(["a", "b", "", "a" * 50]), x=wild, y=wild, psi=wild, v_x=wild, a_x=wild, r=wild,
    length=wild, width=wild, age=wild, sigma_along=wild, sigma_across=wild,
    events=st.sampled_from([frozenset(), frozenset({"hard_braking"})]),
)  # fmt: skip
tame = st.builds(
    RemoteVehicle,
    id=st.sampled_from("abcd"), x=st.floats(-100.0, 300.0), y=st.floats(-6.0, 6.0), psi=st.floats(-4.0, 4.0),
    v_x=st.floats(-20.0, 100.0), a_x=st.floats(-12.0, 12.0), length=st.floats(1e-3, 40.0),
    width=st.floats(1e-3, 5.0), age=st.floats(0.0, 30.0), sigma_along=st.floats(0.0, 50.0),
    sigma_across=st.floats(0.0, 50.0),
)  # fmt: skip


class TestNeverRaises:
    @given(st.lists(remotes, max_size=4), st.floats(0.0, 45.0))
    def test_absurd_remotes(self, others: list[RemoteVehicle], v: float) -> None:
        p = planner()
        for k in range(3):
            usable(p.step(0.1 * k, state(START + 0.1 * k * v, v), others))

    @given(st.lists(tame, max_size=5), st.floats(0.0, 45.0), st.floats(-3.0, 3.0), st.floats(-1.0, 1.0))
    def test_remotes_anywhere_even_in_the_ego(
        self, others: list[RemoteVehicle], v: float, y: float, psi: float
    ) -> None:
        p = planner()
        for k in range(5):
            ego = state(START + 0.2 * k * v, v, y=y, psi=psi)
            usable(p.step(0.2 * k, ego, [replace(r, x=r.x + 0.2 * k * r.v_x) for r in others]))

    @given(st.lists(st.one_of(wild, st.sampled_from([None, "now", 3, True])), min_size=1, max_size=6))
    def test_absurd_times(self, times: list[Any]) -> None:
        p = planner()
        for t in times:
            usable(p.step(t, state(), [car(60.0)]))

    @given(
        st.tuples(wild, wild, wild).filter(lambda p: all(map(math.isfinite, p))),
        st.floats(-0.5, 60.0), st.floats(-20.0, 20.0), st.floats(-5.0, 5.0), st.floats(-1.0, 1.0),
    )  # fmt: skip
    def test_ego_anywhere(
        self, pose: tuple[float, float, float], v_x: float, v_y: float, r: float, delta: float
    ) -> None:
        p = planner()
        usable(p.step(0.0, state(), [car(60.0)]))
        x, y, psi = pose
        ego = VehicleState(x=x, y=y, psi=psi, v_x=v_x, v_y=v_y, r=r, delta=delta)
        for k in (1, 2):
            usable(p.step(0.1 * k, ego, [car(60.0)]))
        usable(p.step(0.3, state(), [car(60.0)]))

    @pytest.mark.parametrize(
        "others",
        [
            None, 3, [None], [object()], "abc", [car(60.0), "junk"],
            [car(60.0, id=["unhashable"])], [car(60.0, events=None)], [replace(car(60.0), x=10**400)],
            [replace(car(60.0), x="near")], [car(60.0, length=None)], [car(1e300)], [car(60.0, y=-1e200)],
        ],
        ids=lambda v: str(v)[:40],
    )  # fmt: skip
    def test_what_is_not_even_a_list_of_vehicles(self, others: Any) -> None:
        p = planner()
        usable(p.step(0.0, state(), []))
        usable(p.step(CYCLE, state(), others))

    @pytest.mark.parametrize("t", [10**400, np.float64(1.0), np.float32(1.0), np.int64(1), 1])
    def test_kinds_of_numbers_for_time(self, t: Any) -> None:
        command = planner().step(t, state(), [])
        usable(command)
        if t == 1:
            assert command.status is Status.OK

    @pytest.mark.parametrize(
        "first",
        [{"x": 1e300}, {"x": START, "y": -1e200}, {"v_x": 1e300}, {"v_x": 1e160}, {"r": 1e308}],
        ids=str,
    )
    def test_absurd_first_state(self, first: dict[str, float]) -> None:
        usable(planner().step(0.0, state(**first), [car(60.0)]))

    def test_no_state(self) -> None:
        command = planner().step(0.0, None, [])  # type: ignore[arg-type]
        assert command.status is Status.INVALID_INPUT
        assert command.decision.action is Action.BRAKE


class TestInvalidTimeAndPlace:
    @pytest.mark.parametrize("t", [math.nan, math.inf, 1.0, 0.5, -1.0])
    def test_brakes_with_a_reason(self, t: float) -> None:
        p = planner()
        p.step(1.0, state(), [])
        command = p.step(t, state(), [])
        assert command.status is Status.INVALID_INPUT
        assert command.a_x < 0.0
        assert "t must" in command.decision.reason

    def test_goes_on_when_time_does(self) -> None:
        p = planner()
        p.step(1.0, state(), [])
        p.step(math.nan, state(), [])
        assert p.step(1.02, state(START + 0.4), []).status is Status.OK

    def test_ego_far_off_the_route_or_against_it(self) -> None:
        for bad in (state(y=40.0), state(psi=math.pi)):
            command = planner().step(0.0, bad, [])
            assert command.status is Status.INVALID_INPUT
            assert command.a_x < 0.0
            assert "route" in command.decision.reason


class TestDropping:
    def drive(self, extra: list[RemoteVehicle]) -> list[Command]:
        p = planner()
        commands = []
        for k in range(240):
            x = START + 0.4 * k
            commands.append(p.step(CYCLE * k, state(x), [*extra, car(90.0 + 0.24 * k)]))
        return commands

    @pytest.mark.parametrize(
        ("broken", "named"),
        [
            (car(math.nan, id="X"), "x"), (car(50.0, math.inf, id="X"), "y"),
            (car(50.0, id="X", psi=math.nan), "psi"),
            (car(50.0, v_x=math.nan, id="X"), "v_x"), (car(50.0, id="X", length=-4.0), "size"),
            (car(50.0, id="X", width=0.0), "size"), (car(50.0, v_x=300.0, id="X"), "speed"),
            (car(50.0, id="X", age=-1.0), "age"), (car(50.0, id="X", a_x=math.nan), "a_x"),
        ],
        ids=lambda v: v if isinstance(v, str) else "",
    )  # fmt: skip
    def test_cycle_goes_on_as_without_it(self, broken: RemoteVehicle, named: str) -> None:
        clean, disturbed = self.drive([]), self.drive([broken])
        assert all(map(same, clean, disturbed))
        assert any(c.decision.action.is_evading for c in clean)
        for command in disturbed:
            (id_, reason) = command.dropped[0]
            assert id_ == "X"
            assert named in reason
            assert len(command.dropped) == 1
        assert not any(c.dropped for c in clean)

    def test_numpy_scalars_are_numbers(self) -> None:
        command = planner().step(0.0, state(), [car(np.float32(90.0)), car(np.int64(90), id="S")])
        assert command.dropped == ()


@pytest.mark.parametrize("dt", [0.02, 0.05, 0.1])
def test_the_wheels_turn_as_far_as_the_time_since_the_last_step_allows(dt: float) -> None:
    p = planner(None)
    before = p.step(0.0, state(v_x=10.0), []).delta
    assert p.step(dt, state(START + 10.0 * dt, v_x=10.0, y=-1.5), []).delta - before == pytest.approx(
        CAR.delta_rate_max * dt
    )


class TestOneId:
    def after(self, *others: RemoteVehicle) -> Command:
        p = planner(None)
        command = p.step(0.0, state(), others)
        for k in range(1, 20):
            command = p.step(CYCLE * k, state(), others)
        return command

    def test_younger_wins_in_any_order(self) -> None:
        near, far = car(50.0, age=0.1), car(250.0, age=0.3)
        assert same(self.after(near, far), self.after(near))
        assert same(self.after(far, near), self.after(near))
        old_near, young_far = car(50.0, age=0.3), car(250.0, age=0.1)
        assert same(self.after(old_near, young_far), self.after(young_far))
        assert not same(self.after(near), self.after(young_far))

    def test_broken_younger_one_does_not_win(self) -> None:
        assert same(self.after(car(50.0, age=0.3), car(math.nan, age=0.0)), self.after(car(50.0, age=0.3)))


class TestRouteAlone:
    def test_a_closed_route_can_be_driven(self) -> None:
        angle = np.linspace(0.0, 2.0 * math.pi, 100, endpoint=False)
        ring = fit_path(150.0 * np.column_stack((np.cos(angle), np.sin(angle))), tolerance=0.05, closed=True)
        p = Planner(CAR, ring, cruise_speed=15.0)
        x, y = ring.position(0.0)
        beta = float(steady_sideslip(1.0 / 150.0, 15.0, CAR))
        psi = float(ring.heading(0.0)) - beta
        ego = VehicleState(x=x, y=y, psi=psi, v_x=15.0, v_y=15.0 * beta, r=15.0 / 150.0)
        command = p.step(0.0, ego, [])
        assert command.status is Status.OK
        assert command.delta == pytest.approx(CAR.wheelbase / 150.0, rel=0.2)

    def test_stops_at_the_end_of_the_route(self) -> None:
        p = Planner(CAR, Road(straight(300.0), TWO), cruise_speed=20.0)
        run = Drive(p, [], 40.0)
        assert run.v[-1] < 0.05
        assert run.x[-1] == pytest.approx(300.0, abs=2.0)
        assert min(run.a_x) > -2.5

    @pytest.mark.parametrize("x", [1200.0, 1201.0, 1300.0])
    def test_beyond_the_end_it_stops(self, x: float) -> None:
        run = Drive(planner(), [], 15.0, start=x, v=10.0)
        assert run.v[-1] < 0.1

    def test_keeps_cruise_speed_and_lane(self) -> None:
        run = Drive(planner(), [], 10.0, v=12.0)
        assert run.v[-1] == pytest.approx(20.0, abs=0.1)
        assert max(run.v) < 20.1
        assert max(map(abs, run.y)) < 1e-9
        assert run.actions == ["KEEP"]

    def test_never_faster_than_the_limit(self) -> None:
        p = Planner(CAR, Road(straight(), TWO, speed_limit=15.0), cruise_speed=20.0)
        assert Drive(p, [], 20.0, v=10.0).v[-1] == pytest.approx(15.0, abs=0.1)

    def test_slows_for_bends(self) -> None:
        """A 90 degree bend of 40 m radius between straights: at most the 2.5 m/s^2 that speed is cut for."""
        angle = np.linspace(0.0, math.pi / 2.0, 40)
        bend = np.column_stack((200.0 + 40.0 * np.sin(angle), 40.0 * (1.0 - np.cos(angle))))
        before = np.column_stack((np.arange(0.0, 199.0, 2.0), np.zeros(100)))
        after = np.column_stack((np.full(100, 240.0), np.arange(42.0, 241.0, 2.0)))
        path = fit_path(np.vstack((before, bend, after)), tolerance=0.05)
        p = Planner(CAR, path, cruise_speed=20.0)
        plant = SingleTrackPlant(CAR, state(2.0))
        a_y, v, place = [], [], 2.0
        for k in range(1600):
            s = plant.state
            place, d, _, _ = path.foot_point(s.x, s.y, place)
            assert abs(d) < 0.5
            plant.step(*(lambda c: (c.delta, c.a_x))(p.step(CYCLE * k, s, [])), CYCLE)
            a_y.append(abs(plant.a_y))
            v.append(s.v_x)
            if place > path.end - 120.0:
                break
        assert min(v) == pytest.approx(10.0, abs=1.0)
        assert max(a_y) < 2.5 * 1.25
        assert v[-1] > 12.0

    def test_standstill_stays_finite_and_starts(self) -> None:
        assert Drive(planner(), [], 6.0, v=0.0).v[-1] > 8.0


class TestLeader:
    def test_follows_when_there_is_no_lane_beside_and_converges(self) -> None:
        run = Drive(planner(None), [Mover("R", 70.0, 0.0, 12.0)], 40.0)
        assert run.actions == ["KEEP", "FOLLOW"]
        assert run.v[-1] == pytest.approx(12.0, abs=0.05)
        gap = START + 70.0 + 12.0 * 40.0 - run.x[-1] - 4.5
        assert gap == pytest.approx(3.0 + 1.5 * 12.0, abs=1.0)
        assert min(run.v) > 11.5
        assert min(run.a_x) > -3.0

    def test_a_bare_path_is_never_left(self) -> None:
        run = Drive(planner(None), [Mover("R", 70.0, 0.0, 5.0)], 25.0)
        assert not any(name.startswith("EVADE") for name in run.actions)
        assert run.hit is None
        assert max(abs(y) for y in run.y) + 0.9 < 1.75

    def test_standing_car_without_a_lane_beside(self) -> None:
        run = Drive(planner(None), [Mover("R", 120.0, 0.0, 0.0)], 25.0)
        assert run.hit is None
        assert run.v[-1] < 0.1
        assert run.gaps["R"] == pytest.approx(3.0, abs=1.0)

    def test_standing_car_that_appears_late_is_braked_for(self) -> None:
        """38 m before it, at 20 m/s: 5.5 m/s^2."""
        run = Drive(planner(None), [Mover("R", 42.0, 0.0, 0.0)], 12.0)
        assert "BRAKE" in run.actions
        assert run.hit is None
        assert run.v[-1] < 0.1

    def test_leader_that_brakes_to_standstill(self) -> None:
        run = Drive(planner(None), [Mover("R", 60.0, 0.0, 18.0, a=lambda t: -6.0 if t > 8.0 else 0.0)], 30.0)
        assert run.hit is None
        assert run.v[-1] < 0.1

    def test_passes_when_the_lane_beside_is_free(self) -> None:
        run = Drive(planner(), [Mover("R", 70.0, 0.0, 12.0)], 20.0)
        assert run.actions == ["KEEP", "EVADE_LEFT", "KEEP"]
        assert run.gaps["R"] >= 0.9
        assert max(map(abs, run.a_y)) < 2.5

    def test_unknown_lane_is_never_free(self) -> None:
        p = planner(evasion=EvasionSettings(awareness_range=0.0))
        run = Drive(p, [Mover("R", 70.0, 0.0, 12.0)], 25.0)
        assert run.actions == ["KEEP", "FOLLOW"]
        assert run.hit is None

    def test_short_known_range_waits_for_what_might_come(self) -> None:
        near = Drive(
            planner(evasion=EvasionSettings(awareness_range=40.0)), [Mover("R", 70.0, 0.0, 12.0)], 20.0
        )
        assert near.actions == ["KEEP", "FOLLOW"]

    def test_almost_as_fast_is_not_passed(self) -> None:
        run = Drive(planner(), [Mover("R", 40.0, 0.0, 18.5)], 30.0)
        assert not any(name.startswith("EVADE") for name in run.actions)
        assert run.v[-1] == pytest.approx(18.5, abs=0.1)

    def test_reference_is_the_route_again_after_the_maneuver(self) -> None:
        p = planner()
        run = Drive(p, [Mover("R", 70.0, 0.0, 12.0)], 20.0)
        assert run.commands[-1].reference is p.road.path
        assert run.commands[-1].band is None
        evading = [c for c in run.commands if c.decision.action.is_evading]
        assert all(c.band is not None and c.reference is not p.road.path for c in evading)


class TestDanger:
    """What must not happen on the road; each was once tried as an attack."""

    def test_leader_whose_messages_stop_is_still_followed(self) -> None:
        """Dead-reckoned with growing age, as a tracker does: the ego must not keep its last decision."""
        kept: dict[str, tuple[float, RemoteVehicle]] = {}

        def silent(t: float, known: list[RemoteVehicle]) -> list[RemoteVehicle]:
            if t <= 1.0:
                kept.update({r.id: (t, r) for r in known})
            return [
                replace(r, x=r.x + r.v_x * (t - since), age=r.age + t - since) for since, r in kept.values()
            ]

        run = Drive(planner(None), [Mover("R", 120.0, 0.0, 10.0)], 20.0, heard=silent)
        assert run.hit is None
        assert "FOLLOW" in run.actions

    def test_car_standing_across_the_lane(self) -> None:
        run = Drive(planner(None), [Mover("X", 150.0, 2.3, 0.0, psi=math.pi / 2.0)], 20.0)
        assert run.hit is None

    def test_lorry_standing_across_the_road(self) -> None:
        lorry = Mover("X", 150.0, 6.2, 0.0, psi=math.pi / 2.0, length=12.0, width=2.5)
        assert Drive(planner(), [lorry], 20.0).hit is None

    @pytest.mark.parametrize("gap", [0.0, -5.0])
    def test_swerve_is_given_up_while_still_in_its_lane(self, gap: float) -> None:
        """A car beside is heard for the first time when the swerve has begun, the ego's body still inside."""
        beside = Mover("L", gap, 3.5, 20.0)
        run = Drive(
            planner(), [Mover("R", 70.0, 0.0, 12.0), beside], 14.0,
            heard=lambda t, known: [r for r in known if r.id != "L" or t > 3.64],
        )  # fmt: skip
        assert 0.5 < run.y[181] < 1.75 - 0.9
        assert "EVADE_LEFT" in run.actions
        assert run.hit is None
        assert run.gaps["L"] > 0.5

    def test_car_beside_at_the_moment_of_the_decision(self) -> None:
        run = Drive(planner(), [Mover("R", 70.0, 0.0, 12.0), Mover("L", 0.0, 3.5, 20.0)], 14.0)
        assert run.hit is None
        assert run.gaps["L"] > 0.5
        assert run.gaps["R"] > 0.5

    @pytest.mark.parametrize("begin", [4.2, 4.6, 5.0, 5.5])
    def test_leader_that_brakes_hard_during_the_swerve(self, begin: float) -> None:
        leader = Mover("R", 70.0, 0.0, 12.0, a=lambda t: -7.0 if t >= begin else 0.0)
        run = Drive(planner(), [leader], 18.0)
        assert "EVADE_LEFT" in run.actions
        assert run.hit is None
        assert run.gaps["R"] > 0.5

    @pytest.mark.parametrize("seconds", [1.0, 3.0])
    def test_silence_in_mid_swerve(self, seconds: float) -> None:
        run = Drive(
            planner(), [Mover("R", 70.0, 0.0, 12.0)], 18.0,
            heard=lambda t, known: [] if 4.6 < t < 4.6 + seconds else known,
        )  # fmt: skip
        assert "EVADE_LEFT" in run.actions
        assert run.gaps["R"] > 0.9
        assert abs(run.y[-1]) < 0.1

    def test_second_of_silence_while_following(self) -> None:
        run = Drive(
            planner(None), [Mover("R", 70.0, 0.0, 12.0)], 30.0,
            heard=lambda t, known: [] if 15.0 < t < 16.0 else known,
        )  # fmt: skip
        assert run.hit is None
        assert max(run.v[int(15.0 / CYCLE) :]) < 14.5

    @pytest.mark.parametrize("gap", [35.0, 37.0, 38.0, 40.0, 60.0])
    def test_a_usable_swerve_can_be_driven(self, gap: float) -> None:
        """Status OK promises a band that the tires can hold, with some reserve."""
        run = Drive(planner(), [Mover("R", gap, 0.0, 0.0)], 8.0)
        swerves = [
            v * v * c.band.curvature
            for c, v in zip(run.commands, run.v, strict=True)
            if c.band is not None and c.status is Status.OK
        ]
        assert len(swerves) > 100
        assert max(swerves) <= 0.85 * CAR.mu * 9.81

    def test_stale_track_blocks_its_lane(self) -> None:
        """Older than a second: its lane is not free (theory.md, section 3)."""
        run = Drive(
            planner(), [Mover("R", 70.0, 0.0, 12.0), Mover("L", -30.0, 3.5, 12.0)], 12.0,
            heard=lambda t, known: [replace(r, age=r.age + 3.0) if r.id == "L" else r for r in known],
        )  # fmt: skip
        assert run.hit is None
        assert run.actions[-1] == "FOLLOW"
        assert "EVADE_LEFT" not in run.actions

    def test_oncoming_car_in_the_own_lane_without_a_lane_beside(self) -> None:
        run = Drive(planner(None), [Mover("O", 400.0, 0.0, 15.0, psi=math.pi)], 14.0)
        assert min(run.v) < 0.5  # all that can be done is to stand when it comes

    @pytest.mark.parametrize(("gap", "driven"), [(60.0, 1.15), (70.0, 1.0)])
    def test_lateral_limit_holds_for_a_car_seen_late(self, gap: float, driven: float) -> None:
        """At a difference of 21 m/s: faster than comfort, the band within the limit of 4 m/s^2.

        Steering that lags catches up in a swerve that begins at once.
        """
        run = Drive(planner(cruise=27.9), [Mover("R", gap, 0.0, 6.9)], 15.0, v=27.9)
        assert run.hit is None
        assert "EVADE_LEFT" in run.actions
        limit = EvasionSettings().lateral_acceleration_limit
        bands = [(v, c.band.curvature) for v, c in zip(run.v, run.commands, strict=True) if c.band]
        assert max(v * v * kappa for v, kappa in bands) <= limit
        assert 2.0 < max(map(abs, run.a_y)) < driven * limit

    def test_lateral_acceleration_of_a_quiet_pass_keeps_to_the_setting(self) -> None:
        """Seen in time, a large difference in speed: the knob of 2 m/s^2 still means about 2."""
        run = Drive(planner(cruise=27.9), [Mover("R", 160.0, 0.0, 6.9)], 18.0, v=27.9)
        assert run.hit is None
        assert "EVADE_LEFT" in run.actions
        assert 1.0 < max(map(abs, run.a_y)) < 2.0


@settings(max_examples=8)
@given(
    st.floats(12.0, 28.0), st.floats(0.2, 0.85), st.lists(st.floats(20.0, 120.0), min_size=1, max_size=3),
    st.floats(8.0, 33.0), st.floats(-300.0, -10.0), st.lists(st.floats(15.0, 200.0), max_size=3),
)  # fmt: skip
def test_steady_traffic_is_never_touched(
    cruise: float, slow: float, spaces: list[float], v_left: float, left: float, gaps: list[float]
) -> None:
    v = slow * cruise
    movers = [Mover(f"R{i}", 40.0 + x, 0.0, v) for i, x in enumerate(np.cumsum(spaces).tolist())]
    movers += [Mover(f"L{i}", left + x, 3.5, v_left) for i, x in enumerate(np.cumsum(gaps).tolist())]
    # a script that touches the standing start itself is no test
    run = Drive(planner(cruise=cruise), movers, 14.0, v=cruise)
    assert run.hit is None


@pytest.mark.parametrize("v_x", [15.0, 20.0, 28.0])
@pytest.mark.parametrize("d", [0.0, 0.3, -0.5])
def test_replanning_past_a_parked_car_holds_side_and_shape(v_x: float, d: float) -> None:
    """Ten times a second on the way past: the side stays, d(s) moves by millimeters, nothing tightens."""
    x = np.arange(0.0, 801.0, 5.0)
    path = fit_path(np.column_stack((x, np.zeros_like(x))), tolerance=0.05)
    road = Road(path, (Lane(d=0.0), Lane(d=3.5), Lane(d=-3.5)))
    settings = EvasionSettings(awareness_range=math.inf)
    planner = Planner(CAR, road, cruise_speed=v_x, evasion=settings)
    plant = SingleTrackPlant(CAR, VehicleState(x=100.0, y=0.0, psi=0.0, v_x=v_x))
    parked = RemoteVehicle(id="P", x=250.0, y=d, psi=0.0, v_x=0.0)
    shapes, sides, a_y = [], set(), []
    for cycle in range(3000):
        command = planner.step(0.02 * cycle, plant.state, [parked])
        plant.step(command.delta, command.a_x, 0.02)
        maneuver = planner._maneuver
        if maneuver is not None:
            shapes.append([maneuver.offset_at(s) for s in np.linspace(100.0, 400.0, 301)])
            sides.add(maneuver.side)
            at = np.linspace(maneuver.start, maneuver.end, 300)
            a_y.append(v_x**2 * np.abs(maneuver.reference.curvature(at)).max())
        elif plant.state.x > 260.0:
            break
    assert len(shapes) > 100
    assert len(sides) == 1
    assert np.abs(np.diff(shapes, axis=0)).max() < 0.05
    assert max(a_y) <= settings.lateral_acceleration
    assert max(a_y) <= 1.1 * a_y[0]
