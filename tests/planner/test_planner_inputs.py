"""Planner inputs: whatever comes in, a valid command goes out."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import (
    Action,
    Command,
    InputError,
    Planner,
    RemoteVehicle,
    Status,
    VehicleState,
)
from cca_core.path import interpolate_path
from cca_core.planner import AbortSettings, ActuationSettings, EvasionSettings
from tests.support.planner_drives import (
    CAR,
    CYCLE,
    START,
    assert_valid,
    car,
    ego_state,
    make_planner,
    straight,
)


def same(a: Command, b: Command) -> bool:
    return (a.delta, a.a_x, a.decision, a.status) == (b.delta, b.a_x, b.decision, b.status)


class TestArguments:
    @pytest.mark.parametrize(
        ("kwargs", "named"),
        [
            ({"cruise_speed": -1.0}, "cruise_speed"), ({"cruise_speed": 0.0}, "cruise_speed"),
            ({"cruise_speed": math.nan}, "cruise_speed"), ({"cruise_speed": "fast"}, "cruise_speed"),
            ({"vehicle": None}, "vehicle"), ({"vehicle": ego_state()}, "vehicle"),
            ({"road": None}, "road"), ({"road": [[0.0, 0.0], [1.0, 0.0]]}, "road"),
            ({"evasion": {"clearance": 1.0}}, "evasion"), ({"speed": 20.0}, "speed"),
            ({"controller": "pid"}, "controller"),
        ],
    )  # fmt: skip
    def test_error_names_argument(self, kwargs: dict[str, Any], named: str) -> None:
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
    def test_error_names_setting(self, name: str, bad: Any) -> None:
        with pytest.raises(InputError, match=name):
            EvasionSettings(**{name: bad})

    @pytest.mark.parametrize(
        "group", ["decision", "lead", "crossing", "last_resort", "replan", "abort", "actuation"]
    )
    def test_error_names_settings_group(self, group: str) -> None:
        with pytest.raises(InputError, match=f"{group} must be"):
            EvasionSettings(**{group: {"period": 0.1}})

    def test_error_names_field_of_settings_group(self) -> None:
        with pytest.raises(InputError, match="max_hold_time must be at least 0"):
            AbortSettings(max_hold_time=-1.0)

    def test_settings_group_changes_safe_stop(self) -> None:
        gentle = ActuationSettings(safe_stop_deceleration=3.0)
        planner = make_planner(evasion=EvasionSettings(actuation=gentle))
        assert planner.step(0.0, ego_state(y=40.0), []).a_x == -3.0


wild = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True), st.floats(-200.0, 200.0),
    st.sampled_from([0.0, -0.0, 1e-320, 1e9, 1e155, -1e300, 1.7e308]),
)  # fmt: skip
remotes = st.builds(
    RemoteVehicle,
    id=st.sampled_from(["a", "b", "", "a" * 50]), x=wild, y=wild, psi=wild, v_x=wild, a_x=wild, r=wild,
    length=wild, width=wild, age=wild, sigma_along=wild, sigma_across=wild,
    events=st.sampled_from([frozenset(), frozenset({"hard_braking"})]), z=st.none() | wild, sigma_z=wild,
)  # fmt: skip
tame = st.builds(
    RemoteVehicle,
    id=st.sampled_from("abcd"), x=st.floats(-100.0, 300.0), y=st.floats(-6.0, 6.0), psi=st.floats(-4.0, 4.0),
    v_x=st.floats(-20.0, 100.0), a_x=st.floats(-12.0, 12.0), length=st.floats(1e-3, 400.0),
    width=st.floats(1e-3, 20.0), age=st.floats(0.0, 30.0), sigma_along=st.floats(0.0, 50.0),
    sigma_across=st.floats(0.0, 50.0),
)  # fmt: skip


class TestNeverRaises:
    @given(st.lists(remotes, max_size=4), st.floats(0.0, 45.0))
    def test_invalid_remotes_give_valid_command(self, others: list[RemoteVehicle], v: float) -> None:
        planner = make_planner()
        for k in range(3):
            assert_valid(planner.step(0.1 * k, ego_state(START + 0.1 * k * v, v), others))

    @given(st.lists(tame, max_size=5), st.floats(0.0, 45.0), st.floats(-3.0, 3.0), st.floats(-1.0, 1.0))
    def test_remotes_anywhere_give_valid_command(
        self, others: list[RemoteVehicle], v: float, y: float, psi: float
    ) -> None:
        planner = make_planner()
        for k in range(5):
            ego = ego_state(START + 0.2 * k * v, v, y=y, psi=psi)
            assert_valid(planner.step(0.2 * k, ego, [replace(r, x=r.x + 0.2 * k * r.v_x) for r in others]))

    @given(st.lists(st.one_of(wild, st.sampled_from([None, "now", 3, True])), min_size=1, max_size=6))
    def test_invalid_times_give_valid_command(self, times: list[Any]) -> None:
        planner = make_planner()
        for t in times:
            assert_valid(planner.step(t, ego_state(), [car(60.0)]))

    @given(
        st.tuples(wild, wild, wild).filter(lambda pose: all(map(math.isfinite, pose))),
        st.floats(-0.5, 60.0), st.floats(-20.0, 20.0), st.floats(-5.0, 5.0), st.floats(-1.0, 1.0),
    )  # fmt: skip
    def test_ego_anywhere_gives_valid_command(
        self, pose: tuple[float, float, float], v_x: float, v_y: float, r: float, delta: float
    ) -> None:
        planner = make_planner()
        assert_valid(planner.step(0.0, ego_state(), [car(60.0)]))
        x, y, psi = pose
        ego = VehicleState(x=x, y=y, psi=psi, v_x=v_x, v_y=v_y, r=r, delta=delta)
        for k in (1, 2):
            assert_valid(planner.step(0.1 * k, ego, [car(60.0)]))
        assert_valid(planner.step(0.3, ego_state(), [car(60.0)]))

    @pytest.mark.parametrize(
        "others",
        [
            None, 3, [None], [object()], "abc", [car(60.0), "junk"],
            [car(60.0, id=["unhashable"])], [car(60.0, events=None)], [replace(car(60.0), x=10**400)],
            [replace(car(60.0), x="near")], [car(60.0, length=None)], [car(1e300)], [car(60.0, y=-1e200)],
        ],
        ids=[
            "none", "number", "list_of_none", "object", "text", "text_in_list", "unhashable_id",
            "events_none", "huge_x", "text_x", "length_none", "far_x", "far_y",
        ],
    )  # fmt: skip
    def test_invalid_remotes_argument_gives_valid_command(self, others: Any) -> None:
        planner = make_planner()
        assert_valid(planner.step(0.0, ego_state(), []))
        assert_valid(planner.step(CYCLE, ego_state(), others))

    @pytest.mark.parametrize("t", [10**400, np.float64(1.0), np.float32(1.0), np.int64(1), 1])
    def test_numeric_types_of_time_are_accepted(self, t: Any) -> None:
        command = make_planner().step(t, ego_state(), [])
        assert_valid(command)
        if t == 1:
            assert command.status is Status.OK

    @pytest.mark.parametrize(
        "first",
        [{"x": 1e300}, {"x": START, "y": -1e200}, {"v_x": 1e300}, {"v_x": 1e160}, {"r": 1e308}],
        ids=str,
    )
    def test_invalid_first_state_gives_valid_command(self, first: dict[str, float]) -> None:
        assert_valid(make_planner().step(0.0, ego_state(**first), [car(60.0)]))

    def test_missing_state_makes_safe_stop(self) -> None:
        command = make_planner().step(0.0, None, [])  # type: ignore[arg-type]
        assert command.status is Status.INVALID_INPUT
        assert command.decision.action is Action.BRAKE


class TestSafeStop:
    def test_ego_off_route_or_against_it_brakes(self) -> None:
        for bad in (ego_state(y=40.0), ego_state(psi=math.pi)):
            command = make_planner().step(0.0, bad, [])
            assert command.status is Status.INVALID_INPUT
            assert command.a_x < 0.0
            assert "route" in command.decision.reason


class TestDropping:
    def drive(self, extra: list[RemoteVehicle]) -> list[Command]:
        planner = make_planner()
        commands = []
        for k in range(240):
            x = START + 0.4 * k
            commands.append(planner.step(CYCLE * k, ego_state(x), [*extra, car(90.0 + 0.24 * k)]))
        return commands

    @pytest.mark.parametrize(
        ("broken", "named"),
        [
            (car(math.nan, id="X"), "x"), (car(50.0, math.inf, id="X"), "y"),
            (car(50.0, id="X", psi=math.nan), "psi"),
            (car(50.0, v_x=math.nan, id="X"), "v_x"), (car(50.0, id="X", length=-4.0), "length"),
            (car(50.0, id="X", width=0.0), "width"), (car(50.0, v_x=300.0, id="X"), "v_x"),
            (car(50.0, id="X", age=-1.0), "age"), (car(50.0, id="X", a_x=math.nan), "a_x"),
        ],
        ids=lambda v: v if isinstance(v, str) else "",
    )  # fmt: skip
    def test_invalid_vehicle_changes_nothing_else(self, broken: RemoteVehicle, named: str) -> None:
        clean, disturbed = self.drive([]), self.drive([broken])
        assert all(map(same, clean, disturbed))
        assert any(c.decision.action.is_evading for c in clean)
        for command in disturbed:
            (id_, reason) = command.dropped[0]
            assert id_ == "X"
            assert named in reason
            assert len(command.dropped) == 1
        assert not any(c.dropped for c in clean)

    def test_numpy_scalars_are_accepted(self) -> None:
        command = make_planner().step(0.0, ego_state(), [car(np.float32(90.0)), car(np.int64(90), id="S")])
        assert command.dropped == ()


@pytest.mark.parametrize("dt", [0.02, 0.05, 0.1])
def test_steering_rate_follows_time_between_steps(dt: float) -> None:
    planner = make_planner(None)
    before = planner.step(0.0, ego_state(v_x=10.0), []).delta
    after = planner.step(dt, ego_state(START + 10.0 * dt, v_x=10.0, y=-1.5), []).delta
    assert 0.0 < after - before <= CAR.delta_rate_max * dt + 1e-9


def test_curve_beyond_turning_circle_is_warned_of_once() -> None:
    phi = np.arange(0.0, 3.0, 0.2)
    sharp, wide = (
        interpolate_path(radius * np.column_stack((np.sin(phi), 1.0 - np.cos(phi)))) for radius in (2.0, 8.0)
    )
    with pytest.warns(UserWarning, match=r"radius 1\.6 m at s=.* turns with 3\.8 m at least") as caught:
        Planner(CAR, sharp, cruise_speed=10.0)
    assert len(caught) == 1
    Planner(CAR, wide, cruise_speed=10.0)  # warnings are errors here
