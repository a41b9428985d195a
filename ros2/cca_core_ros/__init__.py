"""cca_core as a ROS 2 node: odometry and messages in, commands, markers and diagnostics out."""
