"""References: trajectories in the bending plane and in space, their planning, and their timing."""
