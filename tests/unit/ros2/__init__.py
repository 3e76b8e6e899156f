"""ROS 2: names, types, bags."""
