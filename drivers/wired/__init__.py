"""The simulated rig on wires: what the real drivers meet, a serial bus and UDP packets, with the rod behind both."""
