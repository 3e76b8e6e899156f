"""Policies that are trained on the simulator: the environment, and the file of a policy."""
