"""Bags: odometry and message bytes written by `rosbags`, read back, and used as from the vehicle."""

import math
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from cca_core import LocalFrame, RemoteVehicle, VehicleParams
from cca_core.v2x import Sender, SenderSettings, Tracker

PACKAGE = Path(__file__).resolve().parents[2] / "ros2"
CAR, FRAME, BEGIN = VehicleParams.bmw_320i(), LocalFrame(41.3, -105.6), 1_700_000_040.0
pytestmark = [
    pytest.mark.requires("rosbags"), pytest.mark.skipif(not PACKAGE.is_dir(), reason="needs the folder ros2")
]  # fmt: skip


@pytest.fixture(scope="module")
def package() -> Iterator[ModuleType]:
    sys.path.insert(0, str(PACKAGE))
    yield import_module("cca_core_ros.bags")
    sys.path.remove(str(PACKAGE))


def sent_messages() -> list[tuple[float, bytes]]:
    """Messages of a vehicle at 12 m/s, with their times of reception."""
    sender = Sender("000000a1", FRAME, SenderSettings(), np.random.default_rng(1))
    found = []
    for k in range(100):
        t = BEGIN + 0.02 * k
        data = sender.poll(t, RemoteVehicle(id=sender.id, x=80.0 + 0.24 * k, y=3.5, psi=0.0, v_x=12.0))
        if data is not None:
            found.append((t + 0.004, data))
    return found


def write_bag(folder: Path, storage: str) -> None:
    """Odometry of a drive at 10 m/s, messages, and a topic that is not read."""
    rosbag2, typesys = import_module("rosbags.rosbag2"), import_module("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    make = store.types

    def vector(kind: str, *values: float) -> Any:
        return make[f"geometry_msgs/msg/{kind}"](*values)

    def odometry(t: float, x: float) -> Any:
        stamp = make["builtin_interfaces/msg/Time"](int(t), round(t % 1.0 * 1e9))
        header = make["std_msgs/msg/Header"](stamp, "map")
        still = vector("Quaternion", 0.0, 0.0, 0.0, 1.0)
        pose = make["geometry_msgs/msg/Pose"](vector("Point", x, 1.0, 0.0), still)
        turn = vector("Vector3", 0.0, 0.0, 0.02)
        twist = make["geometry_msgs/msg/Twist"](vector("Vector3", 10.0, 0.1, 0.0), turn)
        return make["nav_msgs/msg/Odometry"](
            header, "base_link", make["geometry_msgs/msg/PoseWithCovariance"](pose, np.zeros(36)),
            make["geometry_msgs/msg/TwistWithCovariance"](twist, np.zeros(36)),
        )  # fmt: skip

    rows: list[tuple[float, str, str, Any]] = [
        (BEGIN + 0.02 * k, "odometry", "nav_msgs/msg/Odometry", odometry(BEGIN + 0.02 * k, 0.2 * k))
        for k in range(100)
    ]
    layout = make["std_msgs/msg/MultiArrayLayout"]([], 0)
    for t, data in sent_messages():
        array = make["std_msgs/msg/UInt8MultiArray"](layout, np.frombuffer(data, np.uint8))
        rows.append((t, "bsm", "std_msgs/msg/UInt8MultiArray", array))
    rows.append((BEGIN, "name", "std_msgs/msg/String", make["std_msgs/msg/String"]("drive")))
    with rosbag2.Writer(folder, version=9, storage_plugin=rosbag2.StoragePlugin[storage]) as writer:
        connections = {
            topic: writer.add_connection(topic, kind, typestore=store)
            for topic, kind in {(topic, kind) for _, topic, kind, _ in rows}
        }
        for t, topic, kind, message in sorted(rows, key=lambda row: row[0]):
            writer.write(connections[topic], round(1e9 * t), store.serialize_cdr(message, kind))


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_bag_gives_states_and_vehicles(tmp_path: Path, package: ModuleType, storage: str) -> None:
    conversions = import_module("cca_core_ros.conversions")
    write_bag(tmp_path / "bag", storage)
    tracker, states = Tracker(FRAME), []
    for t, topic, message in package.read_bag(tmp_path / "bag"):
        if topic == "odometry":
            states.append(conversions.to_state(message, CAR, base_to_cg=CAR.l_r))
        else:
            assert tracker.update(conversions.to_bytes(message), t).accepted
    assert [state.x for state in states] == pytest.approx(CAR.l_r + 0.2 * np.arange(100))
    assert states[-1].t == pytest.approx(BEGIN + 0.02 * 99, abs=1e-6)
    assert math.isclose(states[0].v_y, 0.1 + 0.02 * CAR.l_r)
    (vehicle,) = tracker.vehicles(BEGIN + 2.0)
    assert (vehicle.id, vehicle.v_x) == ("000000a1", pytest.approx(12.0))
    assert vehicle.x == pytest.approx(80.0 + 24.0, abs=0.3)


def test_topics_can_be_chosen(tmp_path: Path, package: ModuleType) -> None:
    write_bag(tmp_path / "bag", "MCAP")
    found = [(t, topic) for t, topic, _ in package.read_bag(tmp_path / "bag", "bsm")]
    assert found == [(pytest.approx(t, abs=1e-6), "bsm") for t, _ in sent_messages()]
    assert list(package.read_bag(tmp_path / "bag", "name")) == []
