"""Drivers against emulated devices on real wires: UDP packets and a pseudo-terminal."""
