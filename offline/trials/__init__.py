"""Trials in space: trajectories run in lockstep on plants like and unlike the model, with what came of them."""
