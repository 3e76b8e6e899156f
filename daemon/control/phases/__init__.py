"""Phases of a cycle: admit, advance the mode, estimate, refer, decide, limit, predict. Each returns a new state."""
