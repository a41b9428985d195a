"""The node of ROS 2 on rclpy: odometry and messages in, commands, markers and diagnostics out."""

import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[2] / "ros2"
PROGRAM = Path(__file__).resolve().parents[1] / "support" / "ros_drive.py"
MODULES = ("rclpy", "nav_msgs", "std_msgs", "geometry_msgs", "visualization_msgs", "diagnostic_msgs")
pytestmark = [
    *(pytest.mark.requires(name) for name in MODULES),
    pytest.mark.skipif(not PACKAGE.is_dir(), reason="needs the folder ros2"),
]


@pytest.mark.slow
def test_node_stops_behind_reported_vehicle(tmp_path: Path) -> None:
    """A process of its own, so that nothing of ROS stays in this one."""
    route = tmp_path / "route.csv"
    rows = (f"41.3000000,{-105.6 + 1.2e-4 * k:.7f}" for k in range(60))
    route.write_text("lat,lon\n" + "\n".join(rows) + "\n", encoding="utf-8")
    done = subprocess.run(
        [sys.executable, str(PROGRAM), str(PACKAGE), str(route)],
        capture_output=True,
        text=True,
        timeout=300.0,
    )
    assert done.returncode == 0, done.stdout + done.stderr
