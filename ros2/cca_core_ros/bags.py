"""Odometry and message bytes of a recorded drive, read from a bag without ROS (package ``rosbags``)."""

from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import Any

from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

TYPES = ("nav_msgs/msg/Odometry", "std_msgs/msg/UInt8MultiArray")


def read_bag(folder: FilePath, *topics: str) -> Iterator[tuple[float, str, Any]]:
    """Yield time of reception [s], topic and message of odometry and bytes, in the order of reception.

    Without `topics` all topics of these types are read. `to_state` and `to_bytes` convert the messages.
    """
    with AnyReader([folder], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        chosen = [each for each in reader.connections if each.msgtype in TYPES]
        chosen = [each for each in chosen if not topics or each.topic in topics]
        for connection, t, data in reader.messages(chosen) if chosen else ():
            yield 1e-9 * t, connection.topic, reader.deserialize(data, connection.msgtype)
