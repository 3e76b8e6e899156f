"""Learning on the simulator."""
