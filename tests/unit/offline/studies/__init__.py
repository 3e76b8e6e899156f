"""Studies on simulated robots, in short."""
