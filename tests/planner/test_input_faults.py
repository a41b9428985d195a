"""Wrong inputs of a cycle: what the planner assumes instead, and that the command lists them."""

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from cca_core import (
    Action,
    Command,
    InputError,
    LocalFrame,
    Planner,
    RemoteVehicle,
    Road,
    Status,
    VehicleState,
    fit_path,
)
from cca_core.geometry import box_gap, boxes
from cca_core.sim import SingleTrackPlant
from cca_core.v2x import Tracker
from tests.support.planner_drives import CAR, CYCLE, START, assert_valid, car, ego_state, make_planner


def drive(
    clock: Callable[[int], Any] = lambda k: CYCLE * k,
    *,
    cycles: int = 250,
    sensed: Callable[[int, VehicleState], Any] = lambda k, state: state,
    period: float = CYCLE,
) -> tuple[list[float], list[Command]]:
    """Speeds and commands on an empty road at 20 m/s; `clock` is the time stamp of a cycle."""
    planner, plant = make_planner(None), SingleTrackPlant(CAR, ego_state())
    speeds, commands = [], []
    for k in range(cycles):
        command = planner.step(clock(k), sensed(k, plant.state), [])
        assert_valid(command)
        plant.step(command.delta, command.a_x, period)
        speeds.append(plant.state.v_x)
        commands.append(command)
    return speeds, commands


class Health:
    """What a receiver reports of itself."""

    def __init__(self, trusted: bool, reason: str = "no message accepted") -> None:
        self.trusted, self.reason = trusted, reason


class TestTime:
    @pytest.mark.parametrize("period", [0.02, 0.1])
    @pytest.mark.parametrize("stamp", [None, math.nan, math.inf, "noon", 10**400, 1e300, 1.98, 1.9], ids=str)
    def test_wrong_stamp_costs_no_cycle(self, stamp: Any, period: float) -> None:
        odd = round(2.0 / period)
        if stamp in (1.98, 1.9):  # the stamp of the cycle before
            stamp = period * (odd - 1)
        speeds, commands = drive(lambda k: stamp if k == odd else period * k, cycles=2 * odd, period=period)
        assert min(speeds) > 19.9
        assert {c.status for c in commands} == {Status.OK}
        assert [k for k, c in enumerate(commands) if c.input_faults] == [odd]
        assert "t " in commands[odd].input_faults[0]
        assert "last period" in commands[odd].input_faults[0]

    @pytest.mark.parametrize("step", [-5.0, -0.3, -3600.0])
    def test_clock_set_back_is_reported_once(self, step: float) -> None:
        speeds, commands = drive(lambda k: CYCLE * k + step * (k >= 100))
        assert min(speeds) > 19.9
        assert [k for k, c in enumerate(commands) if c.input_faults] == [100]
        assert "stepped back" in commands[100].input_faults[0]
        assert {c.status for c in commands} == {Status.OK}

    def test_clock_set_back_with_stamped_states_is_passed(self) -> None:
        speeds, commands = drive(
            lambda k: CYCLE * k - 5.0 * (k >= 100),
            sensed=lambda k, state: replace(state, t=CYCLE * (k - 1) - 5.0 * (k >= 101)),
        )
        assert min(speeds) > 19.9
        assert {c.status for c in commands} == {Status.OK}

    def test_clock_of_low_resolution_keeps_the_speed(self) -> None:
        speeds, commands = drive(lambda k: math.floor(0.2 * k + 1e-9) * 0.1)
        assert min(speeds) > 19.9
        assert {c.status for c in commands} == {Status.OK}

    @pytest.mark.parametrize("t", [0.4, None, math.nan], ids=["constant", "none", "nan"])
    def test_clock_that_stands_ends_in_safe_stop(self, t: Any) -> None:
        speeds, commands = drive(lambda k: t if 20 < k < 200 else CYCLE * k)
        stopped = [k for k, c in enumerate(commands) if c.status is Status.INVALID_INPUT]
        assert stopped[0] in (71, 72)
        assert stopped == list(range(stopped[0], 200))
        assert "no usable time" in commands[100].decision.reason
        assert commands[-1].status is Status.OK
        assert min(speeds) > 20.0 - 4.0 * 130 * CYCLE - 0.5

    def test_jump_forward_is_reported(self) -> None:
        _, commands = drive(lambda k: CYCLE * k + 7.0 * (k >= 100))
        assert [k for k, c in enumerate(commands) if c.input_faults] == [100]
        assert "jumped by 7.0 s" in commands[100].input_faults[0]

    def test_steering_rate_ignores_wrong_stamp(self) -> None:
        def turning(stamps: Sequence[Any]) -> list[float]:
            planner = make_planner(None)
            return [
                planner.step(t, ego_state(START + 0.2 * k, 10.0, y=-1.5), []).delta
                for k, t in enumerate(stamps)
            ]

        stamps = [CYCLE * k for k in range(30)]
        wrong: list[Any] = [stamps[9] if k == 10 else None if k == 20 else t for k, t in enumerate(stamps)]
        assert turning(wrong) == pytest.approx(turning(stamps), abs=1e-9)


class TestStateAge:
    @pytest.mark.parametrize("age", [0.0, 0.05, 0.0999])
    def test_recent_state_is_used(self, age: float) -> None:
        _, commands = drive(sensed=lambda k, state: replace(state, t=CYCLE * k - age), cycles=20)
        assert {c.status for c in commands} == {Status.OK}
        assert not any(c.input_faults for c in commands)

    @pytest.mark.parametrize(
        ("age", "words"), [(0.11, "0.11 s old"), (5.0, "5 s old"), (-0.2, "0.2 s after t")]
    )
    def test_old_state_makes_safe_stop(self, age: float, words: str) -> None:
        command = make_planner().step(10.0, ego_state(t=10.0 - age), [])
        assert (command.status, command.decision.action) == (Status.INVALID_INPUT, Action.BRAKE)
        assert words in command.decision.reason

    def test_frozen_state_stops_the_ego(self) -> None:
        frozen: list[VehicleState] = []

        def sensed(k: int, state: VehicleState) -> VehicleState:
            if k <= 50:
                frozen[:] = [replace(state, t=CYCLE * k)]
            return frozen[0]

        speeds, commands = drive(sensed=sensed, cycles=400)
        assert [c.status is Status.OK for c in commands].index(False) == 56
        assert speeds[-1] < 0.1

    def test_outlier_of_one_cycle_costs_little_speed(self) -> None:
        speeds, commands = drive(
            sensed=lambda k, state: replace(state, y=state.y + 20.0) if k == 100 else state
        )
        assert commands[100].status is Status.INVALID_INPUT
        assert commands[101].status is Status.OK
        assert min(speeds) > 19.7


class TestAwareness:
    @pytest.mark.parametrize("wrong", [math.nan, -1.0, "far", None, [300.0, 2.0], 1j], ids=str)
    def test_wrong_range_counts_as_zero(self, wrong: Any) -> None:
        command = self.behind_van(awareness_range=wrong)
        assert not command.decision.action.is_evading
        assert "awareness_range must be" in command.input_faults[0]
        assert command.status is Status.OK

    def test_radio_without_trust_counts_as_zero(self) -> None:
        assert self.behind_van(radio=Health(True)).decision.action.is_evading
        command = self.behind_van(radio=Health(False))
        assert not command.decision.action.is_evading
        assert "no message accepted" in command.input_faults[0]

    def test_tracker_that_accepts_nothing_counts_as_zero(self) -> None:
        tracker = Tracker(LocalFrame(45.0, 14.0))
        assert self.behind_van(radio=tracker.health(7.0)).decision.action.is_evading
        tracker.update(b"noise", 7.0)
        command = self.behind_van(radio=tracker.health(7.0))
        assert not command.decision.action.is_evading
        assert "none of 1 messages" in command.input_faults[0]

    @pytest.mark.parametrize("trusted", ["no", "yes", 1, None, [True], math.nan, np.float64(1.0)], ids=str)
    def test_trust_that_is_no_bool_counts_as_zero(self, trusted: Any) -> None:
        command = self.behind_van(radio=Health(trusted))
        assert not command.decision.action.is_evading
        assert "trusted must be True or False" in command.input_faults[0]

    def test_numpy_bool_is_a_bool(self) -> None:
        assert self.behind_van(radio=Health(np.True_)).decision.action.is_evading  # type: ignore[arg-type]

    def test_radio_that_fails_counts_as_zero(self) -> None:
        assert "radio cannot be used" in self.behind_van(radio=object()).input_faults[0]

    @staticmethod
    def behind_van(**inputs: Any) -> Command:
        planner = make_planner()
        for k in range(200):
            command = planner.step(CYCLE * k, ego_state(START + 0.4 * k), [car(160.0, v_x=0.0)], **inputs)
            if command.decision.action.is_evading:
                break
        return command


class TestCruiseSpeed:
    @pytest.mark.parametrize("speed", [0.0, -3.0, math.nan, "fast", None])
    def test_invalid_speed_raises_and_changes_nothing(self, speed: Any) -> None:
        planner = make_planner()
        with pytest.raises(InputError, match="cruise_speed"):
            planner.cruise_speed = speed
        assert planner.cruise_speed == 20.0

    @pytest.mark.parametrize("speed", [5.0, 10.0, 18.0, 26.0])
    def test_new_speed_is_approached_in_comfort(self, speed: float) -> None:
        planner, plant = make_planner(None), SingleTrackPlant(CAR, ego_state())
        demanded = []
        for k in range(700):
            if k == 50:
                planner.cruise_speed = speed
            command = planner.step(CYCLE * k, plant.state, [])
            demanded.append(command.a_x)
            plant.step(command.delta, command.a_x, CYCLE)
        assert plant.state.v_x == pytest.approx(speed, abs=0.3)
        assert -2.5 < min(demanded)
        assert max(demanded) <= 2.0
        assert np.abs(np.diff(demanded)).max() <= 3.0 * CYCLE + 1e-9

    def test_speed_limit_remains(self) -> None:
        planner = make_planner(None, cruise=20.0)
        planner.cruise_speed = 200.0
        command = planner.step(0.0, ego_state(v_x=40.0), [])
        assert command.a_x < 0.0


class TestRecords:
    @staticmethod
    def first(remotes: Iterable[Any]) -> Command:
        return make_planner(None).step(0.0, ego_state(), remotes)

    def test_two_bodies_under_one_id_both_count(self) -> None:
        alongside, ahead = car(START + 2.0, 3.5), car(60.0, v_x=0.0)
        for remotes in itertools.permutations((alongside, ahead)):
            command = self.first(remotes)
            assert command.a_x == self.first([ahead]).a_x < 0.0
            assert command.dropped == ()

    def test_third_body_under_one_id_counts(self) -> None:
        command = self.first([car(300.0), car(200.0), car(60.0, v_x=0.0)])
        assert command.a_x == self.first([car(60.0, v_x=0.0)]).a_x

    def test_one_body_recorded_twice_counts_once(self) -> None:
        old, young = car(60.0, v_x=0.0, age=0.3), car(60.4, v_x=0.0, age=0.1)
        for remotes in itertools.permutations((old, young)):
            command = self.first(remotes)
            assert command.a_x == self.first([young]).a_x
            assert command.dropped == (("R", "older record of a vehicle with the same id and place"),)

    def test_invalid_record_leaves_its_namesake(self) -> None:
        command = self.first([car(50.0, age=0.3), car(math.nan, age=0.0)])
        assert command.a_x == self.first([car(50.0, age=0.3)]).a_x

    @pytest.mark.parametrize("name", ["method", "property", "number", "text", "whole"])
    def test_record_that_raises_is_dropped_alone(self, name: str) -> None:
        command = self.first([_RAISING[name](), car(60.0, v_x=0.0)])
        assert command.status is Status.OK
        assert command.a_x == self.first([car(60.0, v_x=0.0)]).a_x
        assert len(command.dropped) == 1

    @pytest.mark.parametrize("value", [Fraction(60), np.float32(60.0), np.int64(60), 60])
    def test_number_types_count_as_floats(self, value: Any) -> None:
        command = self.first([car(value, v_x=0.0)])
        assert command.dropped == ()
        assert command.a_x == self.first([car(60.0, v_x=0.0)]).a_x

    def test_list_that_fails_is_used_so_far_and_reported(self) -> None:
        def records() -> Iterator[RemoteVehicle]:
            yield car(60.0, v_x=0.0)
            raise OSError

        command = self.first(records())
        assert command.status is Status.OK
        assert command.a_x == self.first([car(60.0, v_x=0.0)]).a_x
        assert "incomplete" in command.input_faults[0]

    def test_missing_list_is_reported(self) -> None:
        assert "remotes must be" in self.first(None).input_faults[0]  # type: ignore[arg-type]

    @pytest.mark.parametrize(
        ("length", "width"), [(27.0, 2.55), (45.0, 2.6), (40.95, 10.23), (150.0, 3.0), (400.0, 20.0)]
    )
    def test_long_body_ahead_is_stopped_for(self, length: float, width: float) -> None:
        planner, plant = make_planner(None, cruise=15.0), SingleTrackPlant(CAR, ego_state(v_x=15.0))
        body = car(120.0 + 0.5 * length, v_x=0.0, length=length, width=width)
        box = boxes(body.x, body.y, body.psi, length, width)
        for k in range(800):
            command = planner.step(CYCLE * k, plant.state, [body])
            assert command.dropped == ()
            plant.step(command.delta, command.a_x, CYCLE)
            state = plant.state
            gap = float(box_gap(boxes(state.x, state.y, state.psi, CAR.length, CAR.width), box))
            assert gap > 0.5
        assert plant.state.v_x < 0.1


class TestFirstStation:
    """Out along y = 0, back along y = 4."""

    OUT = tuple((float(x), 0.0) for x in range(0, 601, 10))
    PATH = fit_path(
        [*OUT, (620.0, -10.0), (640.0, 0.0), (630.0, 8.0), *[(x, 4.0) for x, _ in OUT[::-1]]], tolerance=0.3
    )

    @pytest.mark.parametrize("y", [0.0, 1.8, 2.3, 3.0])
    def test_ego_begins_on_branch_of_its_heading(self, y: float) -> None:
        for psi in (0.0, math.pi):
            planner = Planner(CAR, Road(self.PATH), cruise_speed=10.0)
            command = planner.step(0.0, VehicleState(x=300.0, y=y, psi=psi, v_x=10.0), [])
            assert command.status is Status.OK
            assert abs(command.delta) < 0.3

    def test_ego_begins_on_first_lap(self) -> None:
        a = np.linspace(0.0, 4.0 * math.pi, 400)
        laps = fit_path(np.column_stack((80.0 * np.sin(a), 80.0 - 80.0 * np.cos(a))), tolerance=0.05)
        planner = Planner(CAR, Road(laps), cruise_speed=10.0)
        x, y = laps.to_cartesian(40.0, 0.2)
        state = VehicleState(x=float(x), y=float(y), psi=float(laps.heading(40.0)), v_x=10.0)
        parked = laps.position(70.0)
        remote = RemoteVehicle(id="R", x=float(parked[0]), y=float(parked[1]), psi=0.0, v_x=0.0)
        assert planner.step(0.0, state, [remote]).a_x < 0.0


class _RaisingMethod(RemoteVehicle):
    @property
    def invalid_reason(self) -> str | None:
        raise KeyError


class _NumberAsReason(RemoteVehicle):
    @property
    def invalid_reason(self) -> str | None:
        return math.nan  # type: ignore[return-value]


class _RaisingProperty(RemoteVehicle):
    @property
    def sigma_z(self) -> float:  # type: ignore[override]
        raise OSError

    @sigma_z.setter
    def sigma_z(self, value: float) -> None:
        pass


class _RaisingNumber(float):
    def __float__(self) -> float:
        raise ZeroDivisionError

    __le__ = __lt__ = __abs__ = __float__  # type: ignore[assignment]


class _RaisingText(str):
    __slots__ = ()

    def __str__(self) -> str:
        raise ValueError

    def __hash__(self) -> int:
        raise ValueError


class _RaisingWhole:
    def __str__(self) -> str:
        raise ValueError


_RAISING: dict[str, Callable[[], Any]] = {
    "method": lambda: _RaisingMethod(id="a", x=40.0, y=0.0, psi=0.0, v_x=0.0),
    "number-as-reason": lambda: _NumberAsReason(id="a", x=40.0, y=0.0, psi=0.0, v_x=0.0),
    "property": lambda: _RaisingProperty(id="a", x=40.0, y=0.0, psi=0.0, v_x=0.0),
    "number": lambda: car(40.0, length=_RaisingNumber(4.0)),
    "text": lambda: car(40.0, id=_RaisingText("a")),
    "whole": _RaisingWhole,
}
