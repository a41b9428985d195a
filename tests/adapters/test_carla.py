"""Conversions of CARLA, by stubs of its objects: left-handed axes, degrees, pedals."""

import math
import re
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import InputError, VehicleParams
from cca_core.adapters import (
    CarlaPedals,
    carla_remote,
    carla_state,
    from_carla_transform,
    to_carla_control,
    to_carla_pose,
)
from cca_core.geometry import wrap_angle
from tests.support.fake_carla import OutOfTicksError, World, fake_carla

CAR = VehicleParams(
    m=1500.0, I_z=2500.0, l_f=1.2, l_r=1.5, C_f=1e5, C_r=1e5, length=4.6, width=1.8, box_offset=0.1
)


def vector(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Any:
    return SimpleNamespace(x=x, y=y, z=z)


def transform(x: float, y: float, yaw: float) -> Any:
    return SimpleNamespace(location=vector(x, y), rotation=SimpleNamespace(yaw=yaw, pitch=0.0, roll=0.0))


def actor(pose: Any, velocity: Any, *, turn: float = 0.0, box: Any = None, acceleration: Any = None) -> Any:
    """A stub of ``carla.Vehicle``, with a body of 4 m x 2 m."""
    bounding_box = SimpleNamespace(extent=vector(2.0, 1.0, 0.8), location=box or vector())
    return SimpleNamespace(
        id=17,
        bounding_box=bounding_box,
        get_transform=lambda: pose,
        get_velocity=lambda: velocity,
        get_acceleration=lambda: acceleration or vector(),
        get_angular_velocity=lambda: vector(z=turn),
    )


def test_yaw_to_the_right_is_negative_heading() -> None:
    assert from_carla_transform(transform(3.0, 5.0, 90.0)) == pytest.approx((3.0, -5.0, -0.5 * math.pi))


@given(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4), st.floats(-math.pi, math.pi))
def test_pose_round_trip_returns(x: float, y: float, psi: float) -> None:
    there = from_carla_transform(transform(*to_carla_pose(x, y, psi)))
    assert there[:2] == (x, y)
    assert wrap_angle(there[2] - psi) == pytest.approx(0.0, abs=1e-9)


def test_remote_that_drives_south_and_turns_right() -> None:
    """Yaw 90 deg is the direction of CARLA's y axis, to the right of x."""
    car = actor(transform(10.0, 20.0, 90.0), vector(0.0, 15.0), turn=10.0, acceleration=vector(2.0, -3.0))
    other = carla_remote(car)
    assert (other.id, other.length, other.width, other.invalid_reason) == ("17", 4.0, 2.0, None)
    found = other.x, other.y, other.psi, other.v_x, other.a_x, other.r
    assert found == pytest.approx((10.0, -20.0, -0.5 * math.pi, 15.0, -3.0, -math.radians(10.0)))


def test_box_offset_is_in_axes_of_actor() -> None:
    other = carla_remote(actor(transform(0.0, 0.0, 90.0), vector(), box=vector(1.0, 0.5)))
    assert (other.x, other.y) == pytest.approx((-0.5, -1.0))


def test_state_is_at_center_of_gravity_with_sideslip_to_the_left() -> None:
    state = carla_state(actor(transform(5.0, 0.0, 0.0), vector(10.0, -1.0), turn=-5.0), CAR, delta=0.1)
    found = state.x, state.y, state.v_x, state.v_y, state.r, state.delta
    assert found == pytest.approx((4.9, 0.0, 10.0, 1.0, math.radians(5.0), 0.1))


def test_reverse_motion_counts_as_standstill() -> None:
    assert carla_state(actor(transform(0.0, 0.0, 0.0), vector(-2.0, 0.0)), CAR).v_x == 0.0


@pytest.mark.parametrize(
    ("a_x", "v_x", "throttle", "brake"),
    [
        (1.7, 10.0, 0.5, 0.0),
        (-0.3, 10.0, 0.0, 0.0),
        (-4.3, 10.0, 0.0, 0.5),
        (-20.0, 10.0, 0.0, 1.0),
        (20.0, 10.0, 1.0, 0.0),
        (0.0, 0.0, 0.0, 0.3),
        (1.7, 0.0, 0.5, 0.0),
    ],
)
def test_pedals_follow_acceleration(a_x: float, v_x: float, throttle: float, brake: float) -> None:
    control = to_carla_control(0.0, a_x, v_x)
    assert (control.throttle, control.steer, control.brake) == pytest.approx((throttle, 0.0, brake))


@pytest.mark.parametrize(("delta", "steer"), [(0.25 * math.pi, -0.5), (-0.25 * math.pi, 0.5), (3.0, -1.0)])
def test_steering_is_positive_to_the_right(delta: float, steer: float) -> None:
    assert to_carla_control(delta, 0.0, 5.0, CarlaPedals(max_steering_deg=90.0)).steer == pytest.approx(steer)


@given(st.floats(-12.0, 8.0), st.floats(0.0, 40.0), st.floats(-0.6, 0.6))
def test_control_is_within_range_and_one_pedal_is_free(a_x: float, v_x: float, delta: float) -> None:
    control = to_carla_control(delta, a_x, v_x)
    assert 0.0 <= control.throttle <= 1.0
    assert 0.0 <= control.brake <= 1.0
    assert control.throttle * control.brake == 0.0


def test_pedals_without_brakes_raise() -> None:
    with pytest.raises(InputError, match="full_brake must be greater than 0, was 0"):
        CarlaPedals(full_brake=0.0)


def test_program_of_the_page_stops_behind_a_parked_car(monkeypatch: pytest.MonkeyPatch) -> None:
    page = (Path(__file__).parents[2] / "docs" / "adapters.md").read_text(encoding="utf-8")
    (program,) = (block for block in re.findall(r"```\{code-block\} python\n(.*?)```", page, re.DOTALL)
                  if "import carla\n" in block)  # fmt: skip
    world = World(1300, parked_at=120.0)
    monkeypatch.setitem(sys.modules, "carla", fake_carla(world))
    with pytest.raises(OutOfTicksError):
        exec(program, {})
    parked, ego = world.actors
    assert world.settings.synchronous_mode
    along = 200.0 * math.atan2(ego.x, 205.0 - ego.y)  # of the arc that both are on
    assert 100.0 < along < 120.0 - 4.6
    assert math.hypot(ego.x, 205.0 - ego.y) == pytest.approx(200.0, abs=0.3)
    assert (parked.v, ego.v) == (0.0, pytest.approx(0.0, abs=0.1))
