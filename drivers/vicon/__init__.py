"""Vicon Tracker to tip poses: packets in, one pose of the tip in the base's frame out for each frame."""
