"""Drive the node of ROS 2 towards a stationary vehicle; `tests/ros2/test_node.py` runs this as a program.

Arguments: the folder of the ROS 2 package, and a route with latitude and longitude.
"""

import math
import os
import sys
import time
from typing import Any

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import Float64MultiArray, UInt8MultiArray
from visualization_msgs.msg import Marker

from cca_core import LocalFrame, RemoteVehicle, VehicleParams, VehicleState
from cca_core.sim import SingleTrackPlant
from cca_core.v2x import Sender, SenderSettings

CAR, FRAME = VehicleParams.bmw_320i(), LocalFrame(41.3, -105.6)
LIMIT = 200.0  # of the whole drive [s]


class Drive:
    """The vehicle, and what the node has sent."""

    def __init__(self, node: Any) -> None:
        self.plant = SingleTrackPlant(CAR, VehicleState(x=5.0, y=0.0, psi=0.0, v_x=10.0))
        self.sender = Sender("000000a1", FRAME, SenderSettings(), np.random.default_rng(1))
        self.node, self.commands, self.markers, self.texts = node, 0, 0, list[str]()
        self.last = time.time()
        self.odometry = node.create_publisher(Odometry, "odometry", 1)
        self.bsm = node.create_publisher(UInt8MultiArray, "bsm", 100)
        node.create_subscription(Float64MultiArray, "command", self.take_command, 1)
        node.create_subscription(Marker, "band", self.take_marker, 1)
        node.create_subscription(DiagnosticArray, "/diagnostics", self.take_diagnostics, 1)
        node.create_timer(0.02, self.report)

    def report(self) -> None:
        """Send the motion, and a message of the stationary vehicle if one is due."""
        state, message = self.plant.state, Odometry()
        pose, twist = message.pose.pose, message.twist.twist
        message.header.stamp = self.node.get_clock().now().to_msg()
        pose.position.x, pose.position.y = state.x, state.y
        pose.orientation.z, pose.orientation.w = math.sin(0.5 * state.psi), math.cos(0.5 * state.psi)
        twist.linear.x, twist.linear.y, twist.angular.z = state.v_x, state.v_y, state.r
        self.odometry.publish(message)
        parked = RemoteVehicle(id=self.sender.id, x=200.0, y=0.0, psi=0.0, v_x=0.0)
        data = self.sender.poll(time.time(), parked)
        if data is not None:
            self.bsm.publish(UInt8MultiArray(data=list(data)))

    def take_command(self, message: Any) -> None:
        """Drive on."""
        delta, a_x, _ = message.data
        self.commands += 1
        now = time.time()
        self.plant.step(delta, a_x, min(max(now - self.last, 1e-3), 0.1))
        self.last = now

    def take_marker(self, message: Any) -> None:
        """Count the bands."""
        self.markers += 1

    def take_diagnostics(self, message: Any) -> None:
        """Keep the reasons."""
        self.texts.append(message.status[0].message)


def main(package: str, route: str) -> int:
    """Run both nodes until the vehicle stands; return the exit code."""
    sys.path.insert(0, package)
    from cca_core_ros.node import PlannerNode

    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    parameters = (f"route:={route}", "latitude:=41.3", "longitude:=-105.6")
    rclpy.init(args=["--ros-args", *(part for each in parameters for part in ("-p", each))])
    planner, own = PlannerNode(), rclpy.create_node("drive")
    drive, executor = Drive(own), SingleThreadedExecutor()
    for node in (planner, own):
        executor.add_node(node)
    end = time.monotonic() + LIMIT
    while time.monotonic() < end and not (drive.plant.state.v_x <= 0.05 and drive.plant.state.x > 20.0):
        executor.spin_once(timeout_sec=1.0)
    state = drive.plant.state
    sys.stdout.write(
        f"x {state.x:.1f} m, y {state.y:.2f} m, {state.v_x:.2f} m/s, {drive.commands} commands, "
        f"{drive.markers} markers, {drive.texts[-1:]}\n"
    )
    is_good = (
        state.v_x <= 0.05 and 150.0 < state.x + CAR.front < 197.0 and abs(state.y) < 1.0
        and min(drive.commands, drive.markers) > 50 and any("a1" in text for text in drive.texts)
    )  # fmt: skip
    for node in (planner, own):
        node.destroy_node()
    rclpy.shutdown()
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
