"""Conversion between ROS messages and the records of cca_core.

Messages are read and written by their fields alone, so nothing of ROS is imported here.
"""

import math
from collections.abc import Iterable, Sequence
from types import SimpleNamespace
from typing import Any

from cca_core import Band, Command, RemoteVehicle, VehicleParams, VehicleState

COLORS = {
    "KEEP": (0.3, 0.3, 0.3), "FOLLOW": (0.9, 0.8, 0.1), "EVADE_LEFT": (0.0, 0.45, 0.7),
    "EVADE_RIGHT": (0.5, 0.4, 0.8), "BRAKE": (0.85, 0.3, 0.1),
}  # fmt: skip
"""Red, green and blue of the band by action."""


def seconds(stamp: Any) -> float:
    """Return the time of a builtin_interfaces/Time [s]."""
    return float(stamp.sec) + 1e-9 * float(stamp.nanosec)


def heading(orientation: Any) -> float:
    """Return the heading of a geometry_msgs/Quaternion [rad], counter-clockwise from x."""
    q = orientation
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def to_state(
    odometry: Any, vehicle: VehicleParams, *, delta: float = 0.0, a_x: float = 0.0, base_to_cg: float = 0.0
) -> VehicleState:
    """Return the ego's motion from a nav_msgs/Odometry; twist in the frame of the vehicle (REP 105).

    `base_to_cg` is the distance from base_link forward to the center of gravity [m], such as `vehicle.l_r` if
    base_link is at the rear axle. `delta` [rad] and `a_x` [m/s^2] come from other topics.
    """
    pose, twist = odometry.pose.pose, odometry.twist.twist
    psi, r = heading(pose.orientation), float(twist.angular.z)
    return VehicleState(
        x=pose.position.x + base_to_cg * math.cos(psi), y=pose.position.y + base_to_cg * math.sin(psi),
        psi=psi, v_x=max(float(twist.linear.x), -0.5), v_y=float(twist.linear.y) + base_to_cg * r, r=r,
        delta=min(max(delta, -vehicle.delta_max), vehicle.delta_max), a_x=a_x,
        t=seconds(odometry.header.stamp),
    )  # fmt: skip


def to_remotes(objects: Any, now: float) -> list[RemoteVehicle]:
    """Return vehicles from tracked objects with pose, twist and box (as autoware's TrackedObjects), at `now`.

    Positions are moved on by the age of the message at constant speed and yaw rate.
    """
    age = max(now - seconds(objects.header.stamp), 0.0)
    remotes = []
    for each in objects.objects:
        pose = each.kinematics.pose_with_covariance.pose
        twist = each.kinematics.twist_with_covariance.twist
        psi, v, r = heading(pose.orientation), float(twist.linear.x), float(twist.angular.z)
        middle = psi + 0.5 * r * age
        remotes.append(RemoteVehicle(
            id=bytes(each.object_id.uuid).hex(), x=pose.position.x + v * age * math.cos(middle),
            y=pose.position.y + v * age * math.sin(middle), psi=psi + r * age, v_x=v, r=r,
            length=float(each.shape.dimensions.x), width=float(each.shape.dimensions.y), age=age,
            source="sensor",
        ))  # fmt: skip
    return remotes


def to_bytes(message: Any) -> bytes:
    """Return the bytes of a std_msgs/UInt8MultiArray, such as a BSM from an on-board unit."""
    return bytes(message.data)


def fill_command(message: Any, command: Command, state: VehicleState, horizon: float = 0.5) -> Any:
    """Write a command into an ackermann_msgs/AckermannDrive; its speed is that after `horizon` [s]."""
    message.steering_angle = float(command.delta)
    message.acceleration = float(command.a_x)
    message.speed = max(state.v_x + horizon * command.a_x, 0.0)
    return message


def to_numbers(command: Command, state: VehicleState) -> list[float]:
    """Return steering angle [rad], acceleration [m/s^2] and speed [m/s], as `fill_command` writes them."""
    drive = fill_command(SimpleNamespace(), command, state)
    return [drive.steering_angle, drive.acceleration, drive.speed]


def fill_band(marker: Any, band: Band | None, action: str, new_point: Any, frame: str = "map") -> Any:
    """Write the band into a visualization_msgs/Marker as a line; without a band the marker is deleted."""
    marker.header.frame_id, marker.ns, marker.id = frame, "band", 0
    marker.type, marker.action = 4, 0 if band is not None else 2  # LINE_STRIP; ADD or DELETE
    marker.scale.x = 0.2
    marker.color.r, marker.color.g, marker.color.b = COLORS.get(action, COLORS["KEEP"])
    marker.color.a = 1.0
    marker.points = []
    for x, y in band.nodes.tolist() if band is not None else ():
        point = new_point()
        point.x, point.y, point.z = x, y, 0.0
        marker.points.append(point)
    return marker


def diagnostics(
    command: Command, radio_reason: str, cycle_ms: float
) -> tuple[int, str, list[tuple[str, str]]]:
    """Return level, message and values for a diagnostic_msgs/DiagnosticStatus."""
    faults: Sequence[str] = [*command.input_faults, *filter(None, (radio_reason,))]
    level = 2 if command.status.name == "INVALID_INPUT" else 1 if faults else 0
    values = [
        ("action", command.decision.action.value), ("status", command.status.name),
        ("cycle [ms]", f"{cycle_ms:.2f}"), *_numbered("fault", faults),
        *_numbered("dropped", (f"{name}: {reason}" for name, reason in command.dropped)),
    ]  # fmt: skip
    return level, command.decision.reason, values


def _numbered(name: str, texts: Iterable[str]) -> list[tuple[str, str]]:
    return [(f"{name} {i}", text) for i, text in enumerate(texts, 1)]
