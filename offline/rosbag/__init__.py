"""Logs as rosbag2 folders, for the tools of ROS 2."""
