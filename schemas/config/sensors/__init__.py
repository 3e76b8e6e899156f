"""[[sensors]]: sensors beside the pose of the tip."""
