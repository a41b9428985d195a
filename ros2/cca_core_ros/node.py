"""ROS 2 node: the planner at 50 Hz."""

import time
from pathlib import Path as FilePath

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Float64MultiArray, UInt8MultiArray
from visualization_msgs.msg import Marker

from cca_core import LocalFrame, Planner, Road, VehicleParams
from cca_core.v2x import Tracker
from cca_core_ros.conversions import diagnostics, fill_band, fill_command, to_bytes, to_numbers, to_state

try:  # not a part of every installation
    from ackermann_msgs.msg import AckermannDriveStamped
except ImportError:
    AckermannDriveStamped = None


class PlannerNode(Node):
    """Odometry and Basic Safety Messages in; command, band and diagnostics out."""

    def __init__(self) -> None:
        super().__init__("cca_core")
        for name, value in (
            ("route", ""),
            ("latitude", 0.0),
            ("longitude", 0.0),
            ("cruise_speed", 10.0),
            ("base_to_cg", 0.0),
        ):
            self.declare_parameter(name, value)
        origin = self._value("latitude"), self._value("longitude")
        frame, self._vehicle = LocalFrame(*origin), VehicleParams.bmw_320i()
        road = Road.from_file(FilePath(self._value("route")), origin=origin)
        self._planner = Planner(self._vehicle, road, cruise_speed=self._value("cruise_speed"))
        self._tracker, self._odometry, self._delta, self._a_x = Tracker(frame), None, 0.0, 0.0
        self.create_subscription(Odometry, "odometry", self._take_odometry, 1)
        self.create_subscription(UInt8MultiArray, "bsm", self._take_bsm, 100)
        self._commands = self.create_publisher(AckermannDriveStamped or Float64MultiArray, "command", 1)
        self._markers = self.create_publisher(Marker, "band", 1)
        self._status = self.create_publisher(DiagnosticArray, "/diagnostics", 1)
        self.create_timer(0.02, self._cycle)

    def _value(self, name: str):
        return self.get_parameter(name).value

    def _take_odometry(self, message: Odometry) -> None:
        self._odometry = message

    def _take_bsm(self, message: UInt8MultiArray) -> None:
        self._tracker.update(to_bytes(message), time.time())

    def _cycle(self) -> None:
        if self._odometry is None:
            return
        begin, utc = time.perf_counter(), time.time()
        t = 1e-9 * self.get_clock().now().nanoseconds
        state = to_state(
            self._odometry, self._vehicle, delta=self._delta, a_x=self._a_x,
            base_to_cg=self._value("base_to_cg"),
        )  # fmt: skip
        health = self._tracker.health(utc)
        command = self._planner.step(t, state, self._tracker.vehicles(utc, state), radio=health)
        self._delta, self._a_x = command.delta, command.a_x
        stamp = self.get_clock().now().to_msg()
        if AckermannDriveStamped is None:
            self._commands.publish(Float64MultiArray(data=to_numbers(command, state)))
        else:
            stamped = AckermannDriveStamped()
            stamped.header.stamp = stamp
            fill_command(stamped.drive, command, state)
            self._commands.publish(stamped)
        self._markers.publish(fill_band(Marker(), command.band, command.decision.action.value, Point))
        level, text, values = diagnostics(command, health.reason, 1e3 * (time.perf_counter() - begin))
        status = DiagnosticStatus(
            level=bytes([level]), name="cca_core", message=text,
            values=[KeyValue(key=key, value=value) for key, value in values],
        )  # fmt: skip
        array = DiagnosticArray(status=[status])
        array.header.stamp = stamp
        self._status.publish(array)


def main() -> None:
    """Run the node."""
    rclpy.init()
    node = PlannerNode()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
