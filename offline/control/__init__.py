"""Laws beside each other: the same tasks, plants, seeds and estimator, in lockstep."""
