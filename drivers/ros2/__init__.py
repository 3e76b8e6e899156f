"""ROS 2: its messages, its names on Zenoh, and a bridge that speaks to its nodes."""
