"""Points along the body of a robot: where they are, how they move in the time to come, and how far from surfaces."""
