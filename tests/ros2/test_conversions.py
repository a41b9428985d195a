"""Conversions of the ROS 2 package, with messages that have the fields of ROS and nothing else of it."""

import math
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cca_core import Lane, Planner, RemoteVehicle, Road, VehicleParams, VehicleState, fit_path
from cca_core.v2x import Bsm, decode_bsm, encode_bsm

PACKAGE = Path(__file__).resolve().parents[2] / "ros2"
CAR = VehicleParams.bmw_320i()
pytestmark = pytest.mark.skipif(not PACKAGE.is_dir(), reason="needs the folder ros2")


@pytest.fixture(scope="module")
def conversions() -> Iterator[ModuleType]:
    sys.path.insert(0, str(PACKAGE))
    yield import_module("cca_core_ros.conversions")
    sys.path.remove(str(PACKAGE))


def message(**fields: Any) -> SimpleNamespace:
    return SimpleNamespace(**fields)


def stamp(t: float) -> SimpleNamespace:
    return message(sec=int(t), nanosec=round(1e9 * (t % 1.0)))


def quaternion(psi: float) -> SimpleNamespace:
    return message(x=0.0, y=0.0, z=math.sin(0.5 * psi), w=math.cos(0.5 * psi))


def odometry(x: float, y: float, psi: float, v: float, r: float, t: float = 12.25) -> SimpleNamespace:
    pose = message(position=message(x=x, y=y, z=0.0), orientation=quaternion(psi))
    twist = message(linear=message(x=v, y=0.1, z=0.0), angular=message(x=0.0, y=0.0, z=r))
    return message(header=message(stamp=stamp(t)), pose=message(pose=pose), twist=message(twist=twist))


@pytest.mark.parametrize("psi", np.linspace(-3.1, 3.1, 9).tolist())
def test_heading_of_quaternion(conversions: ModuleType, psi: float) -> None:
    assert conversions.heading(quaternion(psi)) == pytest.approx(psi)


def test_odometry_of_rear_axle_is_moved_to_center_of_gravity(conversions: ModuleType) -> None:
    state = conversions.to_state(
        odometry(10.0, 5.0, math.pi / 2, 8.0, 0.2), CAR, base_to_cg=CAR.l_r, a_x=-1.0
    )
    assert (state.x, state.y) == pytest.approx((10.0, 5.0 + CAR.l_r))
    assert state.v_y == pytest.approx(0.1 + 0.2 * CAR.l_r)
    assert (state.v_x, state.r, state.a_x, state.t) == (8.0, 0.2, -1.0, 12.25)


def test_reverse_and_large_angle_are_limited(conversions: ModuleType) -> None:
    state = conversions.to_state(odometry(0.0, 0.0, 0.0, -3.0, 0.0), CAR, delta=5.0)
    assert (state.v_x, state.delta) == (-0.5, CAR.delta_max)


def test_tracked_objects_are_moved_on_to_now(conversions: ModuleType) -> None:
    kinematics = message(
        pose_with_covariance=message(pose=odometry(3.0, 4.0, 0.0, 0.0, 0.0).pose.pose),
        twist_with_covariance=message(twist=odometry(0.0, 0.0, 0.0, 10.0, 0.1).twist.twist),
    )
    shape = message(dimensions=message(x=4.2, y=1.7, z=1.5))
    one = message(object_id=message(uuid=[1] * 16), kinematics=kinematics, shape=shape)
    (remote,) = conversions.to_remotes(message(header=message(stamp=stamp(5.0)), objects=[one]), 5.2)
    assert isinstance(remote, RemoteVehicle)
    assert remote.invalid_reason is None
    assert (remote.x, remote.age) == pytest.approx((5.0, 0.2), abs=1e-3)
    assert remote.psi == pytest.approx(0.02)
    assert (remote.length, remote.width, remote.source) == (4.2, 1.7, "sensor")


@pytest.mark.parametrize("kind", [list, bytes, lambda data: np.frombuffer(data, np.uint8)])
def test_message_bytes_are_decoded(conversions: ModuleType, kind: Callable[[bytes], Any]) -> None:
    data = encode_bsm(Bsm(msg_count=9, id="00c0ffee"))
    assert decode_bsm(conversions.to_bytes(message(data=kind(data)))).msg_count == 9


@pytest.fixture(scope="module")
def evading() -> Any:
    """A planner that passes a stationary vehicle, and its command and state."""
    path = fit_path([(x, 0.0) for x in np.linspace(0.0, 600.0, 61)])
    planner = Planner(CAR, Road(path, lanes=[Lane(d=0.0), Lane(d=3.5)]), cruise_speed=15.0)
    remote = RemoteVehicle(id="R1", x=160.0, y=0.0, psi=0.0, v_x=0.0)
    for k in range(600):
        state = VehicleState(x=20.0 + 0.3 * k, y=0.0, psi=0.0, v_x=15.0)
        command = planner.step(0.02 * k, state, [remote])
        if command.band is not None:
            return command, state
    raise AssertionError("no maneuver")


def test_command_fills_ackermann_drive(conversions: ModuleType, evading: Any) -> None:
    command, state = evading
    drive = conversions.fill_command(message(), command, state)
    assert (drive.steering_angle, drive.acceleration) == (command.delta, command.a_x)
    assert drive.speed == pytest.approx(15.0 + 0.5 * command.a_x)


def test_band_becomes_line_and_is_deleted(conversions: ModuleType, evading: Any) -> None:
    command, _ = evading

    def marker() -> SimpleNamespace:
        return message(header=message(), scale=message(), color=message())

    line = conversions.fill_band(marker(), command.band, "EVADE_LEFT", lambda: message())
    assert len(line.points) == len(command.band.nodes)
    assert (line.type, line.action) == (4, 0)
    assert line.color.b > line.color.r
    assert conversions.fill_band(marker(), None, "KEEP", lambda: message()).action == 2


def test_diagnostics_name_faults(conversions: ModuleType, evading: Any) -> None:
    command, _ = evading
    level, text, values = conversions.diagnostics(command, "", 1.5)
    assert (level, text) == (0, command.decision.reason)
    assert ("cycle [ms]", "1.50") in values
    level, _, values = conversions.diagnostics(command, "more senders than tracks", 1.5)
    assert level == 1
    assert ("fault 1", "more senders than tracks") in values
    assert {type(value) for _, value in values} == {str}
