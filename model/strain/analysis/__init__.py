"""What a robot's shape, motion and strength are: modes, frames, strain and stress, equilibria, energy."""
