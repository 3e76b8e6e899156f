"""A robot's shape, motion and strength: modes, frames, strain and stress, equilibria, energy."""
