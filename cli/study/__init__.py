"""Commands that run studies in simulation."""
