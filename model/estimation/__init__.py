"""Estimation: the observer of the tip, and the margin of the sampled loop with it."""
